// SPDX-License-Identifier: Apache-2.0
// From Format, FrameAspectRatio, ScreenWindow and Projection to the raster and the camera in force.
#pragma once

#include <array>

#include "renderer/scene/scene.h"

namespace patina {

/// Settles what options leave to each other: fits the raster into Format by FrameAspectRatio (RI 3.2: the
/// picture keeps the upper left corner) and gives the camera its screen window. May be called again after
/// options have changed.
void resolveFrame(Options& options, Camera& camera);

/// Camera space to the screen plane's coordinates and depth (near 0, far 1), homogeneous.
M44d cameraToScreen(const Camera& camera);

/// World to normalised device coordinates: x and y from -1 to 1 over the screen window. PRMan's "NP".
M44d worldToNormalizedScreen(const Camera& camera);

/// Area in pixels of the rectangle around a box's picture; infinite when the box reaches behind the eye.
float rasterArea(const std::array<float, 6>& bound, const M44d& boundToWorld, const Options& options,
                 const Camera& camera);

}  // namespace patina
