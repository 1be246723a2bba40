// SPDX-License-Identifier: Apache-2.0
// Batches of one lane to the functions of a custom lobe, and back.
#include "renderer/shading/custom_lobe.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "renderer/base/statistics.h"
#include "renderer/shading/shader_instance.h"

namespace patina {
namespace {

STAT_COUNTER("Shaders/custom lobes/evaluations", evaluations);
STAT_COUNTER("Shaders/custom lobes/samples", samplesDrawn);
STAT_COUNTER("Shaders/custom lobes/values replaced", replacedValues);

constexpr uint32_t kAllFlags = PATINA_LOBE_REFLECTS | PATINA_LOBE_TRANSMITS | PATINA_LOBE_NOT_RECIPROCAL;

PatinaPlane one(const float& value) { return {&value, 0, 0}; }
PatinaPlane3 one(const V3f& v) { return {one(v.x), one(v.y), one(v.z)}; }

/// The arguments of one lane: planes of stride 0 that point to what the caller has.
struct Arguments {
  std::array<PatinaPlane, PATINA_LOBE_DATA> data;
  PatinaLobeIn in{};

  explicit Arguments(const CustomLobe::At& at) {
    in.struct_size = sizeof in;
    in.count = 1, in.padded = PATINA_LANES;
    in.data_count = at.lane.lobe->dataCount();
    for (uint32_t c = 0; c < in.data_count; ++c) data[c] = one(at.lane.data[c]);
    in.data = data.data();
    in.N = one(at.N), in.wo = one(at.wo);
    in.alpha = one(at.alpha), in.eta = one(at.eta);
  }
};

struct alignas(64) Outputs {
  float planes[7][PATINA_LANES];
  PatinaLobeOut out;
  Outputs() {
    for (auto& plane : planes) plane[0] = 0;
    out = {sizeof out, 0, {planes[0], planes[1], planes[2]}, planes[3], {planes[4], planes[5], planes[6]}};
  }
};

}  // namespace

CustomLobe::Value CustomLobe::evaluate(const At& at, const V3f& wi) const {
  ++evaluations;
  Arguments arguments(at);
  arguments.in.wi = one(wi);
  Outputs outputs;
  const PatinaStatus status = shader_->lobe("evaluate", table_->evaluate, arguments.in, outputs.out);
  const Value value{{outputs.planes[0][0], outputs.planes[1][0], outputs.planes[2][0]}, outputs.planes[3][0]};
  // Rounding below zero is no fault, as at the horizon.
  const auto good = [](float x) { return x > -1e-6f && x < 1e18f; };
  if (status == PATINA_OK && good(value.f.x) && good(value.f.y) && good(value.f.z) && good(value.pdf))
    return {{std::max(value.f.x, 0.0f), std::max(value.f.y, 0.0f), std::max(value.f.z, 0.0f)},
            std::max(value.pdf, 0.0f)};
  complain(at, "values that are not finite, negative or too large; they count as black");
  return {};
}

bool CustomLobe::sample(const At& at, const V2f& random, V3f& wi) const {
  ++samplesDrawn;
  Arguments arguments(at);
  arguments.in.random_x = one(random.x), arguments.in.random_y = one(random.y);
  Outputs outputs;
  const PatinaStatus status = shader_->lobe("sample", table_->sample, arguments.in, outputs.out);
  wi = {outputs.planes[4][0], outputs.planes[5][0], outputs.planes[6][0]};
  const float square = wi.length2();
  if (status == PATINA_OK && square == 0) return false;
  if (status == PATINA_OK && std::abs(square - 1) < 1e-2f) {
    wi.normalize();
    return true;
  }
  complain(at, "directions that are not of unit length; they count as none");
  return false;
}

void CustomLobe::complain(const At& at, const char* what) const {
  ++replacedValues;
  shader_->fault(ShaderHost::kBadLobe, 1, at.P, [&] {
    return fmt::format("its lobe \"{}\" gave {}. The first is at ({}, {}, {})", name(), what, at.P.x, at.P.y,
                       at.P.z);
  });
}

std::string findLobeFault(const PatinaCustomLobe* lobe) {
  if (!lobe) return "is NULL";
  if (lobe->struct_size < sizeof(PatinaCustomLobe)) return "has a table that is too small";
  if (!lobe->name || !*lobe->name || !lobe->doc) return "has no name or no documentation";
  if (!lobe->evaluate || !lobe->sample) return "has no evaluate() or no sample()";
  if (lobe->data_count > PATINA_LOBE_DATA)
    return fmt::format("takes {} numbers; there may be {}", lobe->data_count, PATINA_LOBE_DATA);
  if (lobe->flags & ~kAllFlags) return fmt::format("has flags that are none: {:#x}", lobe->flags);
  if (!(lobe->flags & (PATINA_LOBE_REFLECTS | PATINA_LOBE_TRANSMITS)))
    return "neither reflects nor transmits";
  return {};
}

}  // namespace patina
