// SPDX-License-Identifier: Apache-2.0
// A point of a surface about to be shaded, and what its shader says of it.
#pragma once

#include <cstdint>
#include <vector>

#include "patina/shader.h"
#include "renderer/accel/accel.h"
#include "renderer/base/math.h"

namespace patina {

/// World space. Ng and N are on the side that is shaded; `front` says whether that is the outside.
struct ShadingPoint {
  uint32_t placement = kNone, face = 0;
  float u = 0, v = 0;                       ///< of the face
  V3f P{0, 0, 0}, Ng{0, 0, 1}, N{0, 0, 1};  ///< facet point and normal; shading normal
  float error = 0;                          ///< see Facet
  bool front = true;
  V3f I{0, 0, 0};       ///< unit, from the viewer to P; only `view` reads it
  float footprint = 0;  ///< width of the region that the point stands for

  Facet facet() const { return {P, Ng, error}; }
};

class CustomLobe;

/// A custom lobe at one point, and what `view` wrote for it there.
struct CustomLobeLane {
  const CustomLobe* lobe = nullptr;
  float data[PATINA_LOBE_DATA] = {};
};

/// A lobe of the BSDF at one point; see PatinaLobe.
struct Lobe {
  uint32_t type = 0;  ///< PatinaLobeType
  Rgb weight{0, 0, 0}, transmission{0, 0, 0};
  float alpha = 0, eta = 1;
  const CustomLobeLane* custom = nullptr;  ///< of types from PATINA_LOBE_CUSTOM on
};

/// Terms of B = emission + ambient * Ca + reflectance * E(front)/pi + transmittance * E(back)/pi, and the
/// lobes.
struct SurfaceTerms {
  Rgb emission{0, 0, 0}, reflectance{0, 0, 0}, transmittance{0, 0, 0}, ambient{0, 0, 0};
  Rgb viewEmission{0, 0, 0};  ///< view-dependent, beside `emission`
  Rgb opacity{1, 1, 1};
  uint32_t firstLobe = 0;  ///< in ShadedPoints::lobes
  uint32_t lobeCount = 0;
};

/// Results of shading a span of points, reusable between calls. Not copied: lobes point into customLanes.
struct ShadedPoints {
  std::vector<SurfaceTerms> terms;  ///< one per point
  std::vector<Lobe> lobes;
  std::vector<std::vector<CustomLobeLane>> customLanes;  ///< by batch of a shader that has custom lobes

  ShadedPoints() = default;
  ShadedPoints(ShadedPoints&&) = default;
  ShadedPoints& operator=(ShadedPoints&&) = default;

  std::span<const Lobe> lobesOf(const SurfaceTerms& t) const {
    return {lobes.data() + t.firstLobe, t.lobeCount};
  }
};

}  // namespace patina
