// SPDX-License-Identifier: Apache-2.0
// Surfaces as surfels, for tests.
#pragma once

#include <vector>

#include "renderer/base/sampling.h"
#include "renderer/points/point_tree.h"

namespace patina {

/// A parallelogram cut into n x n pieces; its front is where u x v points.
inline void addQuad(std::vector<Surfel>& to, const V3f& corner, const V3f& u, const V3f& v, int n,
                    const Rgb& front, const Rgb& back = Rgb(0, 0, 0)) {
  const V3f cross = u.cross(v);
  const auto count = static_cast<float>(n);
  Surfel s;
  s.N = cross.normalized();
  s.area = cross.length() / (count * count);
  s.radius = std::max((u + v).length(), (u - v).length()) / count / 2;
  s.U = u.normalized(), s.halfU = u.length() / count / 2, s.halfV = s.area / u.length() * count / 2;
  s.front = front, s.back = back;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      s.P = corner + u * ((static_cast<float>(i) + 0.5f) / count) +
            v * ((static_cast<float>(j) + 0.5f) / count);
      to.push_back(s);
    }
}

/// A box from -1 to 1, whose front is inside.
inline std::vector<Surfel> boxFromInside(int n, const Rgb& front, const Rgb& back = Rgb(0, 0, 0)) {
  std::vector<Surfel> box;
  for (int axis = 0; axis < 3; ++axis)
    for (const float side : {-1.0f, 1.0f}) {
      V3f corner(-1), u(0), v(0);
      corner[axis] = side;
      u[(axis + 1) % 3] = 2, v[(axis + 2) % 3] = 2;
      if (side > 0) std::swap(u, v);
      addQuad(box, corner, u, v, n, front, back);
    }
  return box;
}

/// A sphere of pieces of equal area, front outside; `inside` turns it.
inline std::vector<Surfel> sphere(const V3f& center, float radius, int count, const Rgb& front,
                                  bool inside = false, bool hasBack = true) {
  std::vector<Surfel> result;
  Surfel s;
  s.area = 4 * kPi * radius * radius / static_cast<float>(count);
  s.radius = std::sqrt(s.area * 0.8f);
  s.hasBack = hasBack;
  s.inner = inside ? Surfel::Inner::Front : Surfel::Inner::Back;
  s.front = front;
  for (int k = 0; k < count; ++k) {  // a spiral
    const float z = 1 - (2 * static_cast<float>(k) + 1) / static_cast<float>(count);
    const float angle = static_cast<float>(k) * 2.3999632f, r = std::sqrt(std::max(0.0f, 1 - z * z));
    const V3f d(r * std::cos(angle), r * std::sin(angle), z);
    s.P = center + d * radius;
    s.N = inside ? -d : d;
    result.push_back(s);
  }
  return result;
}

}  // namespace patina
