// SPDX-License-Identifier: Apache-2.0
// The same scene at other scales, far from the origin, and with the very small beside the very large.
//
//   stress_scale [--mode M] [--pictures FOLDER] [--report FILE]        exit status 0 = all agree
//
// All numbers of a scene grow alike, lights by what keeps the picture the same, so that pictures differ by
// rounding and by what rounding decides. `--pictures` writes them as PFM. `--report` writes the table into
// the file.
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <cmath>
#include <fstream>
#include <iostream>

#include "tests/stress/pictures.h"

namespace patina::stress {
namespace {

constexpr int kSize = 48, kBlock = 8;
constexpr double kTolerance = 5e-3;  // largest relative difference of block means
// Of scenes whose own numbers are so far from the origin that floats hold them to 1 / 256 of the scene:
// surfaces are evaluated from them in floats.
constexpr double kCoarse = 3e-2;
constexpr double kBead = 2e-2;  // of a bead on a plane that is 1e7 times as large

/// How a scene is made larger and moved.
struct Place {
  std::string name;
  double scale = 1;
  V3d offset{0, 0, 0};     ///< in lengths of the scene at scale 1
  bool inNumbers = false;  ///< by the numbers of the primitives, else by the current transformation
  double tolerance = kTolerance;
};

/// Writes points and lengths of a scene.
class Writer {
 public:
  explicit Writer(const Place& place) : place_(place) {}

  /// From "Projection" to "WorldBegin", with what moves primitives.
  std::string begin(const V3d& eye, double turn, double fov) const {
    const double s = place_.scale;
    const V3d o = place_.offset * s, e = eye * s;
    std::string text = fmt::format(
        "Format {0} {0} 1 PixelFilter \"box\" 1 1\nProjection \"perspective\" \"fov\" [{1}]\n"
        "Rotate {2} 1 0 0\nTranslate {3:.9g} {4:.9g} {5:.9g}\nTranslate {6:.9g} {7:.9g} "
        "{8:.9g}\nWorldBegin\n",
        kSize, fov, turn, -e.x, -e.y, -e.z, -o.x, -o.y, -o.z);
    if (!place_.inNumbers)
      text +=
          fmt::format("Translate {0:.9g} {1:.9g} {2:.9g} Scale {3:.9g} {3:.9g} {3:.9g}\n", o.x, o.y, o.z, s);
    return text;
  }
  std::string point(const V3d& p) const {
    const V3d q = place_.inNumbers ? (p + place_.offset) * place_.scale : p;
    return fmt::format("{:.9g} {:.9g} {:.9g} ", q.x, q.y, q.z);
  }
  std::string length(double l) const {
    return fmt::format("{:.9g}", place_.inNumbers ? l * place_.scale : l);
  }
  /// An intensity of what falls off with the square of the distance.
  std::string intensity(double i) const { return fmt::format("{:.9g}", i * place_.scale * place_.scale); }
  std::string polygon(const std::vector<V3d>& corners) const {
    std::string text = "Polygon \"P\" [";
    for (const V3d& c : corners) text += point(c);
    return text + "]\n";
  }
  std::string sphere(const V3d& center, double radius) const {
    return "TransformBegin Translate " + point(center) + "Sphere " + length(radius) + " -" + length(radius) +
           " " + length(radius) + " 360 TransformEnd\n";
  }
  std::string mesh(const char* request, const std::vector<V3d>& points) const {
    std::string text = std::string(request) + " \"P\" [";
    for (const V3d& p : points) text += point(p);
    return text + "]\n";
  }

 private:
  const Place& place_;
};

std::vector<V3d> cube(const V3d& low, const V3d& high) {
  std::vector<V3d> points;
  for (int k = 0; k < 8; ++k)
    points.emplace_back((k & 1 ? high : low).x, (k & 2 ? high : low).y, (k & 4 ? high : low).z);
  return points;
}
const char* const kCube = "[4 4 4 4 4 4] [0 2 3 1 4 5 7 6 0 1 5 4 2 6 7 3 0 4 6 2 1 3 7 5]";

/// A room with what stands in it, some of it in contact, under a lamp and a point light. All coordinates are
/// multiples of 1/64, so that floats hold them 1e5 away.
std::string room(const Place& place) {
  const Writer w(place);
  std::string text = w.begin({0, 1.25, -3}, -12, 50);
  text +=
      "Attribute \"trace\" \"int maxdiffusedepth\" [2] Attribute \"trace\" \"int maxspeculardepth\" [4]\n"
      "AttributeBegin AreaLightSource \"arealight\" 1 \"float intensity\" [6] \"int sides\" [2]\n" +
      w.polygon({{-0.5, 2.46875, 0}, {0.5, 2.46875, 0}, {0.5, 2.46875, 1}, {-0.5, 2.46875, 1}}) +
      "AttributeEnd Illuminate 1 1\n"
      "LightSource \"pointlight\" 2 \"from\" [" +
      w.point({-1, 1.5, -1}) + "] \"intensity\" [" + w.intensity(1) + "]\n" +
      "Surface \"matte\" \"Kd\" [1] Color [.7 .7 .7]\n" +
      w.polygon({{-2, 0, -4}, {2, 0, -4}, {2, 0, 2}, {-2, 0, 2}}) +
      w.polygon({{-2, 0, 2}, {2, 0, 2}, {2, 2.5, 2}, {-2, 2.5, 2}}) +
      w.polygon({{-2, 0, -4}, {-2, 0, 2}, {-2, 2.5, 2}, {-2, 2.5, -4}}) +
      w.polygon({{2, 0, -4}, {2, 0, 2}, {2, 2.5, 2}, {2, 2.5, -4}}) +
      w.polygon({{-2, 2.5, -4}, {2, 2.5, -4}, {2, 2.5, 2}, {-2, 2.5, 2}}) + "Color [.5 .5 .5]\n" +
      w.mesh((std::string("PointsPolygons ") + kCube).c_str(), cube({-1.5, 0, 0.5}, {-0.75, 1, 1.25})) +
      w.sphere({0, 0.5, 0.5}, 0.5) + "Color [.8 .8 .8]\n" +
      w.mesh((std::string("SubdivisionMesh \"catmull-clark\" ") + kCube + " [] [] [] []").c_str(),
             cube({-0.75, 0, -0.75}, {0, 0.75, 0})) +
      "Surface \"conductor\" \"float alpha\" [0] \"color reflectance\" [.8 .8 .8]\n" +
      w.sphere({1, 0.375, 0}, 0.375) + "Surface \"dielectric\"\n" + w.sphere({0.5, 0.25, -0.75}, 0.25) +
      "WorldEnd\n";
  return text;
}

/// Inside of a closed box: light outside does not get in.
std::string dark(const Place& place) {
  const Writer w(place);
  return w.begin({0, 1.25, -0.75}, 0, 90) +
         "Attribute \"trace\" \"int maxdiffusedepth\" [2]\nLightSource \"envlight\" 1 \"int camera\" [0]\n"
         "LightSource \"pointlight\" 2 \"from\" [" +
         w.point({0, 3, 0}) + "] \"intensity\" [" + w.intensity(100) + "]\nSurface \"matte\" \"Kd\" [1]\n" +
         w.mesh((std::string("PointsPolygons ") + kCube).c_str(), cube({-1, 0.25, -1}, {1, 2.25, 1})) +
         "TransformBegin " + w.sphere({0, 1, 0}, 0.5) + "TransformEnd WorldEnd\n";
}

/// A bead on a plane under a distant light from the side: the plane's size changes nothing.
std::string bead(double plane) {
  return fmt::format(
      "Format {0} {0} 1 PixelFilter \"box\" 1 1\nProjection \"perspective\" \"fov\" [40]\nRotate -50 1 0 0\n"
      "Translate 0 -0.006 0.005\nWorldBegin\nAttribute \"trace\" \"int maxdiffusedepth\" [2]\n"
      "LightSource \"distantlight\" 1 \"from\" [2 3 -1] \"to\" [0 0 0]\nLightSource \"envlight\" 2 "
      "\"intensity\" [.3]\n"
      "Surface \"matte\" \"Kd\" [1] Color [.6 .6 .6]\n"
      "Polygon \"P\" [-{1} 0 -{1}  {1} 0 -{1}  {1} 0 {1}  -{1} 0 {1}]\n"
      "Translate 0 0.0005 0 Sphere 0.0005 -0.0005 0.0005 360\nWorldEnd\n",
      kSize, plane);
}

RenderSettings settingsOf(const std::string& mode) {
  RenderSettings settings;
  settings.mode = mode, settings.samples = 16, settings.threads = 2;
  return settings;
}

void writePfm(const Picture& picture, const std::string& file) {
  std::ofstream out(file, std::ios::binary);
  out << "Pf\n" << picture.width << " " << picture.height << "\n-1.0\n";
  for (int y = picture.height - 1; y >= 0; --y)
    for (int x = 0; x < picture.width; ++x) {
      const auto v = static_cast<float>(picture.values[static_cast<size_t>(y * picture.width + x)]);
      out.write(reinterpret_cast<const char*>(&v), sizeof v);
    }
}

class Judge {
 public:
  Judge(std::string mode, std::string folder) : mode_(std::move(mode)), folder_(std::move(folder)) {}

  /// The blocks of what another place shows, against those of the first.
  void compare(const std::string& scene, const std::string& name, const std::string& rib,
               const std::string& reference, double tolerance = kTolerance, bool known = false) {
    const std::vector<double> a = blocks(scene + " reference", reference),
                              b = blocks(scene + " " + name, rib);
    double worst = 0;
    for (size_t k = 0; k < a.size(); ++k)
      worst = std::max(worst, std::abs(b[k] - a[k]) / std::max(a[k], 1e-12));
    add(scene + ", " + name, fmt::format("{:.2e}", worst), worst <= tolerance, known);
  }
  void isDark(const std::string& name, const std::string& rib) {
    const std::vector<double> seen = blocks("dark " + name, rib);
    const double most = *std::max_element(seen.begin(), seen.end());
    add("closed box, " + name, fmt::format("{:.2e}", most), most == 0);
  }
  const std::vector<std::pair<std::string, std::string>>& rows() const { return rows_; }
  bool allHold() const { return holds_; }

 private:
  std::vector<double> blocks(const std::string& name, const std::string& rib) {
    auto& known = pictures_[rib];
    if (known.empty()) {
      const Picture p = render(rib, settingsOf(mode_));
      if (!folder_.empty()) {
        std::string file = folder_ + "/" + mode_ + "_" + name + ".pfm";
        std::replace(file.begin(), file.end(), ' ', '_');
        writePfm(p, file);
      }
      known = blockMeans(p.values, p.width, p.height, kBlock);
    }
    return known;
  }
  /// `known`: that it does not hold is known.
  void add(const std::string& name, const std::string& value, bool holds, bool known = false) {
    rows_.emplace_back(name, value + (holds ? "" : known ? " **does not hold**" : " **fails**"));
    holds_ = holds_ && (holds || known);
    std::cout << mode_ << ": " << name << ": " << value
              << (holds   ? known ? " (known to fail, but holds now)" : ""
                  : known ? " does not hold, as is known"
                          : " FAILS")
              << "\n"
              << std::flush;
  }

  std::string mode_, folder_;
  std::map<std::string, std::vector<double>> pictures_;
  std::vector<std::pair<std::string, std::string>> rows_;
  bool holds_ = true;
};

std::vector<Place> places() {
  std::vector<Place> all;
  for (const double scale : {1e-6, 1e-3, 1e3, 1e6})
    for (const bool numbers : {false, true})
      all.push_back({fmt::format("scale {:g} by {}", scale, numbers ? "its numbers" : "Scale"),
                     scale,
                     {0, 0, 0},
                     numbers});
  for (const double scale : {1.0, 1e-3, 1e3})
    all.push_back(
        {fmt::format("scale {:g}, 1e5 scenes away by Translate", scale), scale, {1e5, -7e4, 5e4}, false});
  all.push_back({"1e5 scenes away by its numbers", 1, {1e5, -7e4, 5e4}, true, kCoarse});
  return all;
}

bool judge(const std::vector<std::string>& modes, const std::string& folder, const std::string& report) {
  std::map<std::string, std::vector<std::string>> table;
  std::vector<std::string> order;
  bool all = true;
  for (const std::string& mode : modes) {
    Judge judge(mode, folder);
    const Place here{"scale 1"};
    for (const Place& place : places())
      judge.compare("room", place.name, room(place), room(here), place.tolerance);
    for (const Place& place : places()) judge.isDark(place.name, dark(place));
    // Rays leave a facet by 1e-9 of its size, 14 micrometres here, which moves shadows.
    judge.compare("bead of 1 mm", "on a plane of 10 km in place of 1 m", bead(5000), bead(0.5), kBead,
                  mode == "points");
    for (const auto& [name, value] : judge.rows()) {
      if (!table.contains(name)) order.push_back(name);
      table[name].push_back(value);
    }
    all = all && judge.allHold();
  }
  if (report.empty()) return all;
  std::string text = "| scene |", line = "| --- |";
  for (const std::string& mode : modes) text += " " + mode + " |", line += " ---: |";
  text += "\n" + line + "\n";
  for (const std::string& name : order) {
    text += "| " + name + " |";
    for (const std::string& value : table[name]) text += " " + value + " |";
    text += "\n";
  }
  replaceSection(report, "scale", text);
  return all;
}

}  // namespace
}  // namespace patina::stress

int main(int count, char** arguments) {
  std::string mode, folder, report;
  CLI::App app("The same scene at other scales and places");
  app.add_option("--mode", mode, "this mode only");
  app.add_option("--pictures", folder, "folder for the pictures");
  app.add_option("--report", report, "Markdown file with a place for the table");
  CLI11_PARSE(app, count, arguments);
  std::vector<std::string> modes{"path", "radiosity", "distribution", "points", "direct"};
  if (!mode.empty()) modes = {mode};
  try {
    return patina::stress::judge(modes, folder, report) ? 0 : 1;
  } catch (const std::exception& error) {
    std::cout << error.what() << "\n";
    return 1;
  }
}
