// SPDX-License-Identifier: Apache-2.0
// Reading primitive variables: checked points, single values and weighted sums of values.
#include "renderer/geometry/primvar.h"

#include <algorithm>

#include "renderer/geometry/surface.h"

namespace patina {

std::optional<PointView> findPoints(const Primitive& primitive) {
  const PrimVar* points = findVariable(primitive, "P");
  if (!points || points->components != 3) return std::nullopt;
  return PointView(std::span(points->floats).first(points->floats.size() / 3 * 3));
}

void copyValue(const PrimVar& variable, size_t index, float* out) {
  const auto n = static_cast<size_t>(variable.components);
  if (index < variable.floats.size() / std::max<size_t>(n, 1))
    std::copy_n(variable.floats.begin() + static_cast<ptrdiff_t>(index * n), n, out);
  else
    std::fill_n(out, n, 0.0f);
}

void blendValues(const PrimVar& variable, std::span<const uint32_t> index, std::span<const double> weight,
                 float* out) {
  const auto n = static_cast<size_t>(variable.components);
  const size_t count = variable.floats.size() / std::max<size_t>(n, 1);
  for (size_t c = 0; c < n; ++c) {
    double sum = 0;
    for (size_t i = 0; i < index.size(); ++i)
      if (index[i] < count) sum += weight[i] * static_cast<double>(variable.floats[index[i] * n + c]);
    out[c] = static_cast<float>(sum);
  }
}

}  // namespace patina
