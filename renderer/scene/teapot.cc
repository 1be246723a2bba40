// SPDX-License-Identifier: Apache-2.0
// Newell's teapot: two profiles that turn about z, two tubes that are mirrored in y.
#include "renderer/scene/teapot.h"

#include <span>

namespace patina {
namespace {

constexpr float kGround = 0.15f;   // z of the data's lowest point
constexpr float kQuarter = 0.56f;  // Newell's handle length for a quarter of a circle
const M44f kBezier(-1, 3, -3, 1, 3, -6, 3, 0, -3, 3, 0, 0, 1, 0, 0, 0);

struct RZ {
  float r, z;
};
constexpr RZ kBody[] = {{1.5f, 0.15f},       {1.5f, 0.225f},  {2, 0.45f},   {2, 0.9f},
                        {2, 1.35f},          {1.75f, 1.875f}, {1.5f, 2.4f}, {1.4375f, 2.53125f},
                        {1.3375f, 2.53125f}, {1.4f, 2.4f}};
constexpr RZ kLid[] = {{1.3f, 2.4f}, {1.3f, 2.55f}, {0.4f, 2.55f}, {0.2f, 2.7f},
                       {0, 2.85f},   {0.8f, 3.15f}, {0, 3.15f}};

/// Half a cross-section of a tube: two points in the plane y = 0 and two at y = -depth and y = depth.
struct Section {
  float innerX, innerZ, outerX, outerZ, depth;
};
constexpr Section kHandle[] = {{-1.6f, 2.025f, -1.5f, 2.25f, 0.3f}, {-2.3f, 2.025f, -2.5f, 2.25f, 0.3f},
                               {-2.7f, 2.025f, -3, 2.25f, 0.3f},    {-2.7f, 1.8f, -3, 1.8f, 0.3f},
                               {-2.7f, 1.575f, -3, 1.35f, 0.3f},    {-2.5f, 1.125f, -2.65f, 0.9375f, 0.3f},
                               {-2, 0.9f, -1.9f, 0.6f, 0.3f}};
constexpr Section kSpout[] = {{1.7f, 1.425f, 1.7f, 0.6f, 0.66f},       {2.6f, 1.425f, 3.1f, 0.825f, 0.66f},
                              {2.3f, 2.1f, 2.4f, 2.025f, 0.25f},       {2.7f, 2.4f, 3.3f, 2.4f, 0.25f},
                              {2.8f, 2.475f, 3.525f, 2.49375f, 0.25f}, {2.9f, 2.475f, 3.45f, 2.5125f, 0.15f},
                              {2.8f, 2.4f, 3.2f, 2.4f, 0.15f}};

TeapotPart part(int nu, int nv) {
  const CubicBasis bezier{kBezier, 3};
  return {{true, nu, nv, false, false, bezier, bezier}, {}};
}

TeapotPart turned(std::span<const RZ> profile) {
  constexpr float k = kQuarter;
  constexpr float kCircle[13][2] = {{1, 0},   {1, k},   {k, 1},  {0, 1},  {-k, 1}, {-1, k}, {-1, 0},
                                    {-1, -k}, {-k, -1}, {0, -1}, {k, -1}, {1, -k}, {1, 0}};
  TeapotPart result = part(13, static_cast<int>(profile.size()));
  for (const auto& [r, z] : profile) {
    for (const auto& [x, y] : kCircle) result.points.insert(result.points.end(), {r * x, r * y, z - kGround});
  }
  return result;
}

TeapotPart tube(std::span<const Section> sections) {
  TeapotPart result = part(7, static_cast<int>(sections.size()));
  for (const Section& s : sections) {
    const auto add = [&](bool outer, float y) {
      result.points.insert(result.points.end(),
                           {outer ? s.outerX : s.innerX, y, (outer ? s.outerZ : s.innerZ) - kGround});
    };
    add(false, 0);
    add(false, -s.depth);
    add(true, -s.depth);
    add(true, 0);
    add(true, s.depth);
    add(false, s.depth);
    add(false, 0);
  }
  return result;
}

}  // namespace

std::vector<TeapotPart> teapot() { return {turned(kBody), turned(kLid), tube(kHandle), tube(kSpout)}; }

}  // namespace patina
