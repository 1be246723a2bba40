// SPDX-License-Identifier: Apache-2.0
// What the cases are made of.
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "tests/stress/closed_forms.h"

namespace patina::stress {

std::string format(int width, int height) {
  return fmt::format("Format {} {} 1 PixelFilter \"box\" 1 1\n", width, height);
}

std::string lookDown(double x, double above, double z, double half, double halfHeight) {
  // Camera x = x - x0, y = z - z0, z = above - y.
  return fmt::format(
      "Projection \"orthographic\" ScreenWindow {} {} {} {}\n"
      "ConcatTransform [1 0 0 0  0 0 -1 0  0 1 0 0  {} {} {} 1]\n",
      -half, half, -halfHeight, halfHeight, -x, -z, above);
}

std::vector<double> overWindow(const std::function<double(double, double)>& f, int width, int height,
                               double x, double z, double half, double halfHeight, int grid) {
  std::vector<double> out;
  for (int j = 0; j < height; ++j)
    for (int i = 0; i < width; ++i) {
      double sum = 0;
      for (int k = 0; k < grid * grid; ++k)
        sum += f(x + half * (2 * (i + (k % grid + 0.5) / grid) / width - 1),
                 z + halfHeight * (1 - 2 * (j + (k / grid + 0.5) / grid) / height));
      out.push_back(sum / (grid * grid));
    }
  return out;
}

std::string polygon(const std::vector<V3d>& corners) {
  std::string text = "Polygon \"P\" [";
  for (const V3d& c : corners) text += fmt::format("{} {} {}  ", c.x, c.y, c.z);
  return text + "]\n";
}

double polygonIrradiance(const V3d& P, const V3d& N, std::vector<V3d> corners) {
  // What is above the horizon.
  std::vector<V3d> above;
  for (size_t k = 0; k < corners.size(); ++k) {
    const V3d a = corners[k] - P, b = corners[(k + 1) % corners.size()] - P;
    const double ha = a.dot(N), hb = b.dot(N);
    if (ha >= 0) above.push_back(a);
    if ((ha > 0 && hb < 0) || (ha < 0 && hb > 0)) above.push_back(a + (b - a) * (ha / (ha - hb)));
  }
  // The angle of each edge, times the cosine of its plane's normal.
  double sum = 0;
  for (size_t k = 0; k < above.size(); ++k) {
    const V3d a = above[k].normalized(), b = above[(k + 1) % above.size()].normalized();
    const V3d across = a.cross(b);
    const double sine = across.length();
    if (sine > 0) sum += std::atan2(sine, a.dot(b)) * across.dot(N) / sine;
  }
  return std::abs(sum) / 2;
}

}  // namespace patina::stress
