// SPDX-License-Identifier: Apache-2.0
// Time against error, as SVG.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/patina-bench/report.h"

namespace patina::bench {
namespace {

constexpr double kWidth = 720, kHeight = 480, kLeft = 70, kRight = 110, kTop = 40, kBottom = 50;
// Told apart without red and green (Okabe and Ito, 2008).
constexpr const char* kColours[] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"};

// A logarithmic axis over whole decades.
struct Axis {
  double low = 0, high = 1;  // powers of ten
  double from = 0, to = 1;   // on the page
  Axis(double least, double most, double pageFrom, double pageTo)
      : low(std::floor(std::log10(least))), high(std::ceil(std::log10(most))), from(pageFrom), to(pageTo) {
    if (high <= low) high = low + 1;
  }
  double at(double value) const { return from + (std::log10(value) - low) / (high - low) * (to - from); }
};

std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '<') {
      result += "&lt;";
    } else if (c == '&') {
      result += "&amp;";
    } else {
      result += c;
    }
  }
  return result;
}

void addGrid(std::string& svg, const Axis& x, const Axis& y) {
  const auto line = [&](double x0, double y0, double x1, double y1, bool decade) {
    svg += fmt::format("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"{}\"/>\n", x0,
                       y0, x1, y1, decade ? "#bbb" : "#eee");
  };
  for (const bool decade : {false, true})  // decades lie above the others
    for (const bool vertical : {true, false}) {
      const Axis& axis = vertical ? x : y;
      for (double power = axis.low; power <= axis.high; ++power)
        for (int k = decade ? 1 : 2; k < (decade ? 2 : 10); ++k) {
          const double value = k * std::pow(10, power), place = axis.at(value);
          if (std::log10(value) > axis.high + 1e-9) break;
          if (vertical) {
            line(place, y.from, place, y.to, decade);
            if (decade)
              svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{:g}</text>\n",
                                 place, kHeight - kBottom + 18, value);
          } else {
            line(x.from, place, x.to, place, decade);
            if (decade)
              svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"end\">{:g}</text>\n",
                                 kLeft - 6, place + 4, value);
          }
        }
    }
}

}  // namespace

std::string svgPlot(const std::string& title, std::span<const Point* const> all) {
  std::vector<const Point*> points;
  std::vector<std::string> modes;
  for (const Point* p : all) {
    if (p->runs.empty() || !(p->wall.mean > 0) || !(p->relMse.mean > 0)) continue;
    points.push_back(p);
    if (std::ranges::find(modes, p->mode) == modes.end()) modes.push_back(p->mode);
  }
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" "
      "font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
      "<text x=\"{2}\" y=\"24\" font-size=\"16\">{3}</text>\n",
      kWidth, kHeight, kLeft, escaped(title));
  if (points.empty()) return svg + "<text x=\"70\" y=\"60\">nothing was measured</text>\n</svg>\n";
  const auto [quickest, slowest] =
      std::ranges::minmax(points, {}, [](const Point* p) { return p->wall.mean; });
  const auto [best, worst] = std::ranges::minmax(points, {}, [](const Point* p) { return p->relMse.mean; });
  const Axis x(quickest->wall.mean, slowest->wall.mean, kLeft, kWidth - kRight);
  const Axis y(best->relMse.mean, worst->relMse.mean, kHeight - kBottom, kTop);
  addGrid(svg, x, y);
  svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">wall seconds</text>\n",
                     (kLeft + kWidth - kRight) / 2, kHeight - 10);
  svg += fmt::format(
      "<text transform=\"translate(16 {:.1f}) rotate(-90)\" text-anchor=\"middle\">relMSE</text>\n",
      (kTop + kHeight - kBottom) / 2);

  std::vector<double> labels;  // places of labels, which keep clear of one another
  for (size_t m = 0; m < modes.size(); ++m) {
    const char* colour = kColours[m % std::size(kColours)];
    const std::vector<CurvePoint> line = lowerEnvelope(curveOf(points, modes[m]));
    std::string path;
    for (const CurvePoint& p : line) path += fmt::format("{:.1f},{:.1f} ", x.at(p.seconds), y.at(p.error));
    svg += fmt::format("<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"2\"/>\n", path,
                       colour);
    for (const Point* p : points) {
      if (p->mode != modes[m]) continue;
      const bool counts = std::ranges::any_of(
          line, [&](const CurvePoint& c) { return c.seconds == p->wall.mean && c.error == p->relMse.mean; });
      svg += fmt::format(
          "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"4\" fill=\"{}\" stroke=\"{}\"><title>{} {}: {:.3g} s, "
          "relMSE {:.3g}</title></circle>\n",
          x.at(p->wall.mean), y.at(p->relMse.mean), counts ? colour : "white", colour, escaped(p->mode),
          escaped(p->setting), p->wall.mean, p->relMse.mean);
    }
    double place = y.at(line.back().error) + 4;
    while (std::ranges::any_of(labels, [&](double l) { return std::abs(l - place) < 13; })) place += 2;
    labels.push_back(place);
    svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" fill=\"{}\">{}</text>\n",
                       x.at(line.back().seconds) + 9, place, colour, escaped(modes[m]));
  }
  return svg + "</svg>\n";
}

}  // namespace patina::bench
