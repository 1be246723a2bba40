// SPDX-License-Identifier: Apache-2.0
// Geometry "teapot".
#pragma once

#include <vector>

#include "renderer/scene/scene.h"

namespace patina {

struct TeapotPart {
  ParametricMesh mesh;        ///< bicubic, Bezier; outside along dPdu x dPdv
  std::vector<float> points;  ///< mesh.nu x mesh.nv
};

/// Body with rim, lid, handle and spout of Martin Newell's teapot (1975), without a bottom; it stands on z =
/// 0 and is 3 high.
std::vector<TeapotPart> teapot();

}  // namespace patina
