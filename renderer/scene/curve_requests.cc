// SPDX-License-Identifier: Apache-2.0
// Curves.
#include <fmt/format.h>

#include "renderer/scene/scene_builder.h"
#include "renderer/scene/value_count.h"

namespace patina {

void SceneBuilder::curves(std::string_view type, Ints vertexCounts, std::string_view wrap,
                          const ParamList& params, const Location& at) {
  if (!mayDraw(at)) return;
  CurveSet curves;
  curves.cubic = type == "cubic";
  curves.periodic = wrap == "periodic";
  curves.basis = state_.basisV;
  if (!curves.cubic && type != "linear")
    return error(RiError::BadToken, at, fmt::format("Curves \"{}\": expected linear or cubic", type));
  if (!curves.periodic && wrap != "nonperiodic")
    return error(RiError::BadToken, at, fmt::format("Curves \"{}\": expected periodic or nonperiodic", wrap));
  for (const int count : vertexCounts)
    if (patchCount(curves.cubic, count, curves.basis.step, curves.periodic) == 0)
      return error(
          RiError::Consistency, at,
          fmt::format("Curves are left out: {} points make no whole number of {} segments", count, type));
  curves.vertexCounts.assign(vertexCounts.begin(), vertexCounts.end());
  addPrimitive(std::move(curves), params, at);
}

}  // namespace patina
