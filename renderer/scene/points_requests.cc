// SPDX-License-Identifier: Apache-2.0
// Points.
#include "renderer/scene/scene_builder.h"

namespace patina {

void SceneBuilder::points(const ParamList& params, const Location& at) {
  if (!mayDraw(at)) return;
  // As many as "P" or "Pw" has.
  PointSet points;
  for (const Param& param : params) {
    if (param.name() == "P")
      points.count = param.floats.size() / static_cast<size_t>(param.declaration.components());
    if (param.name() == "Pw" && points.count == 0) points.count = param.floats.size() / 4;
  }
  if (points.count == 0)
    return error(RiError::BadArgument, at, "Points are left out: they need \"P\"", "points without P");
  addPrimitive(points, params, at);
}

}  // namespace patina
