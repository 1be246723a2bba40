// SPDX-License-Identifier: Apache-2.0
// Channels and parameters of a batch.
#include "renderer/shading/surface_batch.h"

#include <algorithm>
#include <array>

#include "renderer/shading/shader_argument.h"

namespace patina {

SurfaceVariables::SurfaceVariables(const Primitive& primitive) {
  for (const PrimVar& variable : primitive.variables) {
    if (variable.name == "N" || variable.name == "Np") {
      if (variable.components == 3) N = &variable;
    } else if (variable.name == "Cs") {
      if (variable.components == 3) Cs = &variable;
    } else if (variable.name == "Os") {
      if (variable.components == 3) Os = &variable;
    } else if (variable.name == "s") {
      if (variable.components == 1) s = &variable;
    } else if (variable.name == "t") {
      if (variable.components == 1) t = &variable;
    } else if (variable.name == "st") {
      if (variable.components >= 2) st = &variable;
    } else if (variable.name != "P" && variable.name != "Pw") {
      others = true;
    }
  }
}

namespace {

/// s and t at (u, v) of the point's face.
V2f textureCoordinates(const BatchPoint& p, float u, float v) {
  const SurfaceVariables& variables = *p.variables;
  const std::array<float, 8>& c = p.attributes->textureCoordinates;
  const auto [a, b] = p.surface->textureParameters(p.face, u, v);
  V2f st = V2f(c[0], c[1]) * ((1 - a) * (1 - b)) + V2f(c[2], c[3]) * (a * (1 - b)) +
           V2f(c[4], c[5]) * ((1 - a) * b) + V2f(c[6], c[7]) * (a * b);
  if (variables.st && variables.st->components <= 16) {
    float value[16];
    p.surface->interpolate(*variables.st, p.face, u, v, value);
    st = {value[0], value[1]};
  }
  if (variables.s) p.surface->interpolate(*variables.s, p.face, u, v, &st.x);
  if (variables.t) p.surface->interpolate(*variables.t, p.face, u, v, &st.y);
  return st;
}

/// Turns derivatives of P by the face's u and v into those by two functions of them, of which `at(u, v)`
/// gives the values: the inverse of their Jacobian, by differences, which are exact where they are linear.
/// False: they do not span the surface.
template <class At>
bool changeParameters(const BatchPoint& p, const At& at, V3f& du, V3f& dv) {
  constexpr float kStep = 1.0f / 128;
  // From a little inside of the face, be it a triangle.
  const float u = p.u + 4 * kStep * (1.0f / 3 - p.u), v = p.v + 4 * kStep * (1.0f / 3 - p.v);
  const V2f here = at(u, v), byU = (at(u + kStep, v) - here) / kStep, byV = (at(u, v + kStep) - here) / kStep;
  const float determinant = byU.x * byV.y - byU.y * byV.x;
  const float scale = byU.length() * byV.length();
  if (!(std::abs(determinant) > 1e-5f * scale) || !(scale < 1e30f) || !(scale > 1e-30f)) return false;
  const V3f first = (du * byV.y - dv * byU.y) / determinant;
  dv = (dv * byU.x - du * byV.x) / determinant;
  du = first;
  return true;
}

}  // namespace

void SurfaceBatch::fillDerivatives(uint64_t reads, const Derivatives& derivatives, PatinaPoints& in) {
  const size_t n = points_.size();
  const bool byTexture =
                 (reads & (PATINA_CHANNEL_FOOTPRINT | PATINA_CHANNEL_DPDS | PATINA_CHANNEL_DPDT)) != 0,
             byParameters = (reads & (PATINA_CHANNEL_DPDU | PATINA_CHANNEL_DPDV)) != 0;
  du_.resize(n), dv_.resize(n), ds_.resize(n), dt_.resize(n);
  for (size_t i = 0; i < n; ++i) {
    const BatchPoint& p = points_[i];
    V3f &du = du_[i], &dv = dv_[i], &ds = ds_[i], &dt = dt_[i];
    derivatives(i, du, dv);
    ds = du, dt = dv;
    const bool spans =
        byTexture && changeParameters(
                         p, [&](float u, float v) { return textureCoordinates(p, u, v); }, ds, dt);
    if (byParameters || (byTexture && !spans))
      changeParameters(
          p, [&](float u, float v) { return p.surface->surfaceParameters(p.face, u, v); }, du, dv);
    if (!spans) ds = du, dt = dv;
  }
  const auto vectors = [&](const std::vector<V3f>& from) {
    return planes_.fill3(n, [&](size_t i) { return from[i]; });
  };
  if (reads & PATINA_CHANNEL_DPDU) in.dPdu = vectors(du_);
  if (reads & PATINA_CHANNEL_DPDV) in.dPdv = vectors(dv_);
  if (reads & PATINA_CHANNEL_DPDS) in.dPds = vectors(ds_);
  if (reads & PATINA_CHANNEL_DPDT) in.dPdt = vectors(dt_);
  if (reads & PATINA_CHANNEL_FOOTPRINT)
    in.footprint_st = planes_.fill(n, [&](size_t i) {
      // How fast s and t grow at most: the lengths of their gradients.
      const float area = std::max(ds_[i].cross(dt_[i]).length(), 1e-30f);
      return std::min(points_[i].footprint * (std::max(ds_[i].length(), dt_[i].length()) / area), 1.0f);
    });
}

void SurfaceBatch::fillTextureCoordinates(PatinaPoints& in) {
  const size_t n = points_.size();
  uv_.resize(n), st_.resize(n);
  for (size_t i = 0; i < n; ++i) {
    const BatchPoint& p = points_[i];
    uv_[i] = p.surface->surfaceParameters(p.face, p.u, p.v);
    st_[i] = textureCoordinates(p, p.u, p.v);
  }
  in.u = planes_.fill(n, [&](size_t i) { return uv_[i].x; });
  in.v = planes_.fill(n, [&](size_t i) { return uv_[i].y; });
  in.s = planes_.fill(n, [&](size_t i) { return st_[i].x; });
  in.t = planes_.fill(n, [&](size_t i) { return st_[i].y; });
}

namespace {

/// The value of a parameter at a point: of a primitive variable of its name, or else of the user attribute
/// that stands for it.
class ReplacedValue {
 public:
  ReplacedValue(const BatchPoint& point, const ShaderInstance::VaryingParameter& parameter) : point_(point) {
    const auto fits = [&](size_t count) { return count == parameter.components; };
    if (point.variables->others) {
      const PrimVar* found = findVariable(*point.primitive, parameter.name);
      if (found && found->floats.size() && fits(static_cast<size_t>(found->components))) variable_ = found;
    }
    if (variable_ || parameter.attribute.empty()) return;
    const ShaderArgument* found = point.attributes->user.find(parameter.attribute);
    const uint32_t type = found ? typeOf(found->type) : 0;
    if ((type == parameter.type && fits(found->floats.size())) ||
        (type == PATINA_INT && parameter.type == PATINA_FLOAT && fits(found->ints.size())))
      attribute_ = found;
  }
  explicit operator bool() const { return variable_ || attribute_; }
  void get(std::span<float> value) const {
    if (variable_)
      point_.surface->interpolate(*variable_, point_.face, point_.u, point_.v, value.data());
    else if (attribute_->floats.empty())
      std::copy(attribute_->ints.begin(), attribute_->ints.end(), value.begin());
    else
      std::copy(attribute_->floats.begin(), attribute_->floats.end(), value.begin());
  }

 private:
  const BatchPoint& point_;
  const PrimVar* variable_ = nullptr;
  const ShaderArgument* attribute_ = nullptr;
};

constexpr uint32_t kMostComponents = 64;

}  // namespace

/// False: nothing takes the parameter's place at any point.
bool SurfaceBatch::replaceParameter(const ShaderInstance::VaryingParameter& parameter,
                                    const PatinaValue& constant, PatinaValue& varying) {
  const size_t n = points_.size();
  if (parameter.components > kMostComponents ||
      std::none_of(points_.begin(), points_.end(),
                   [&](const BatchPoint& p) { return bool(ReplacedValue(p, parameter)); }))
    return false;
  float* block = planes_.take(parameter.components);
  std::array<float, kMostComponents> value{};
  for (size_t i = 0; i < planes_.padded(); ++i) {
    const ReplacedValue replaced(points_[std::min(i, n - 1)], parameter);
    if (replaced) replaced.get(value);
    for (uint32_t c = 0; c < parameter.components; ++c)
      block[c * planes_.padded() + i] = replaced ? value[c] : constant.floats[c * constant.plane];
  }
  varying.floats = block;
  varying.stride = 1;
  varying.plane = static_cast<uint32_t>(planes_.padded());
  return true;
}

/// The instance's values, those of primitive variables and user attributes in their place.
std::span<const PatinaValue> SurfaceBatch::fillParameters(const ShaderInstance& shader) {
  const std::span<const PatinaValue> values = shader.values();
  const auto mayReplace = [&](const BatchPoint& p) {
    return p.variables->others || (shader.bindsUserAttributes() && !p.attributes->user.empty());
  };
  if (shader.varyingParameters().empty() || std::none_of(points_.begin(), points_.end(), mayReplace))
    return values;
  changed_.assign(values.begin(), values.end());
  for (const ShaderInstance::VaryingParameter& parameter : shader.varyingParameters())
    replaceParameter(parameter, values[parameter.index], changed_[parameter.index]);
  return changed_;
}

PatinaPoints SurfaceBatch::fill(const ShaderInstance& shader, uint64_t reads,
                                const Derivatives& derivatives) {
  const size_t n = points_.size();
  PatinaPoints in{};
  in.struct_size = sizeof(in);
  in.count = static_cast<uint32_t>(n);
  in.padded = static_cast<uint32_t>(planes_.padded());
  if (reads & PATINA_CHANNEL_P) in.P = planes_.fill3(n, [&](size_t i) { return points_[i].P; });
  if (reads & PATINA_CHANNEL_N) in.N = planes_.fill3(n, [&](size_t i) { return points_[i].N; });
  if (reads & PATINA_CHANNEL_NG) in.Ng = planes_.fill3(n, [&](size_t i) { return points_[i].Ng; });
  if (reads & PATINA_CHANNEL_FOOTPRINT)
    in.footprint = planes_.fill(n, [&](size_t i) { return points_[i].footprint; });
  if (reads & PATINA_CHANNEL_TIME) in.time = planes_.uniform(0);
  if (reads & (PATINA_CHANNEL_DPDU | PATINA_CHANNEL_DPDV | PATINA_CHANNEL_FOOTPRINT | PATINA_CHANNEL_DPDS |
               PATINA_CHANNEL_DPDT))
    fillDerivatives(reads, derivatives, in);
  if (reads & (PATINA_CHANNEL_UV | PATINA_CHANNEL_ST)) fillTextureCoordinates(in);
  const auto color = [&](const PrimVar* SurfaceVariables::*variable, Rgb Attributes::*fallback) {
    return planes_.fill3(n, [&](size_t i) {
      const BatchPoint& p = points_[i];
      Rgb c = p.attributes->*fallback;
      if (const PrimVar* given = p.variables->*variable)
        p.surface->interpolate(*given, p.face, p.u, p.v, &c.x);
      return c;
    });
  };
  if (reads & PATINA_CHANNEL_CS) in.Cs = color(&SurfaceVariables::Cs, &Attributes::color);
  if (reads & PATINA_CHANNEL_OS) in.Os = color(&SurfaceVariables::Os, &Attributes::opacity);
  in.values = fillParameters(shader).data();
  in.value_stride = sizeof(PatinaValue);
  return in;
}

}  // namespace patina
