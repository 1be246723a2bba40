// SPDX-License-Identifier: Apache-2.0
// Rendering for the programs of this folder.
#include "tests/stress/pictures.h"

#include <fstream>
#include <numeric>
#include <stdexcept>

#include "renderer/scene/origin.h"
#include "renderer/scene/scene_builder.h"

namespace patina::stress {

double Picture::mean() const {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

Picture render(const std::string& rib, const RenderSettings& given, const Adjust& adjust) {
  std::string trouble;
  ErrorHandler errors([&](Severity, std::string_view message) { trouble += std::string(message) + "\n"; });
  RenderSettings settings = given;
  settings.shaderPath = PATINA_BINARY_DIR "/lib/patina/shaders";
  Picture picture;
  SceneBuilder builder({}, errors, [&](Scene& scene) {
    if (adjust) adjust(scene);
    if (const auto origin = betterOrigin(scene)) moveOrigin(scene, *origin);  // as patina does
    const auto film = renderFrame(scene, settings, errors);
    if (!film) return;
    const PixelRect& r = film->pixels();
    picture.width = r.x1 - r.x0, picture.height = r.y1 - r.y0;
    for (int y = r.y0; y < r.y1; ++y)
      for (int x = r.x0; x < r.x1; ++x) picture.values.push_back(static_cast<double>(film->value(x, y, 0)));
  });
  builder.readText(rib, "scene.rib");
  if (picture.values.empty()) trouble += "there is no picture\n";
  if (!trouble.empty()) throw std::runtime_error(trouble + rib);
  return picture;
}

std::vector<double> blockMeans(const std::vector<double>& values, int width, int height, int size) {
  std::vector<double> means;
  for (int y0 = 0; y0 < height; y0 += size)
    for (int x0 = 0; x0 < width; x0 += size) {
      double sum = 0;
      int count = 0;
      for (int y = y0; y < std::min(y0 + size, height); ++y)
        for (int x = x0; x < std::min(x0 + size, width); ++x, ++count)
          sum += values[static_cast<size_t>(y * width + x)];
      means.push_back(sum / count);
    }
  return means;
}

std::string contents(const std::string& file) {
  std::ifstream in(file);
  if (!in) throw std::runtime_error(file + " cannot be read");
  return {std::istreambuf_iterator<char>(in), {}};
}

void replaceSection(const std::string& file, const std::string& name, const std::string& text) {
  std::string whole = contents(file);
  const std::string begin = "<!-- " + name + " -->\n", end = "<!-- end of " + name + " -->";
  const size_t from = whole.find(begin), to = whole.find(end);
  if (from == std::string::npos || to == std::string::npos || to < from)
    throw std::runtime_error(file + " has no place for '" + name + "'");
  whole.replace(from + begin.size(), to - from - begin.size(), text);
  std::ofstream(file) << whole;
}

}  // namespace patina::stress
