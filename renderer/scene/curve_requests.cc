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
  curves.round = state_.roundCurves;
  if (!curves.cubic && type != "linear")
    return error(RiError::BadToken, at, fmt::format("Curves \"{}\": expected linear or cubic", type));
  if (!curves.periodic && wrap != "nonperiodic")
    return error(RiError::BadToken, at, fmt::format("Curves \"{}\": expected periodic or nonperiodic", wrap));
  if (vertexCounts.empty()) return;  // nothing to draw
  for (size_t k = 0; k < vertexCounts.size(); ++k)
    if (patchCount(curves.cubic, vertexCounts[k], curves.basis.step, curves.periodic) == 0)
      return error(
          RiError::Consistency, at,
          fmt::format("Curves are left out: {} points make no whole number of {} segments{} (curve {})",
                      vertexCounts[k], type,
                      curves.cubic ? fmt::format(" at the basis' step of {}", curves.basis.step) : "", k));
  curves.vertexCounts.assign(vertexCounts.begin(), vertexCounts.end());
  addPrimitive(std::move(curves), params, at);
}

}  // namespace patina
