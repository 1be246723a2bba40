// SPDX-License-Identifier: Apache-2.0
// Time against error, as SVG.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/patina-bench/axis.h"
#include "tools/patina-bench/report.h"

namespace patina::bench {
namespace {

constexpr double kWidth = 720, kHeight = 460, kLeft = 72, kRight = 190, kTop = 40, kBottom = 52;
// Told apart without red and green (Okabe and Ito, 2008), and by their marks without any colour.
constexpr const char* kColours[] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"};
// A mode has the same colour and mark in all plots of a report, whatever else is in them.
constexpr std::string_view kModes[] = {"radiosity", "path", "distribution", "points", "direct"};
constexpr double kMark = 4.5;  // half a mark's size

size_t styleOf(const std::string& mode) {
  return static_cast<size_t>(std::ranges::find(kModes, mode) - std::begin(kModes));
}
const char* colourOf(const std::string& mode) { return kColours[styleOf(mode) % std::size(kColours)]; }

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

std::string lineOf(double x0, double y0, double x1, double y1, const std::string& style) {
  return fmt::format("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" {}/>\n", x0, y0, x1, y1,
                     style);
}

std::string textAt(double x, double y, const std::string& text, const std::string& style = "") {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" {}>{}</text>\n", x, y, style, text);
}

// Circle, square, triangle, diamond, by turns; `inner` goes between its tags.
std::string markAt(double x, double y, size_t kind, const char* colour, bool filled,
                   const std::string& inner = "") {
  const std::string style =
      fmt::format("fill=\"{}\" stroke=\"{}\" stroke-width=\"1.5\"", filled ? colour : "white", colour);
  const auto polygon = [&](std::initializer_list<std::pair<double, double>> corners) {
    std::string points;
    for (const auto& [dx, dy] : corners) points += fmt::format("{:.1f},{:.1f} ", x + dx, y + dy);
    return fmt::format("<polygon points=\"{}\" {}>{}</polygon>\n", points, style, inner);
  };
  constexpr double a = kMark, b = kMark * 1.25;
  switch (kind % 4) {
    case 1:
      return polygon({{-a, -a}, {a, -a}, {a, a}, {-a, a}});
    case 2:
      return polygon({{0, -b}, {b, a}, {-b, a}});
    case 3:
      return polygon({{0, -b}, {b, 0}, {0, b}, {-b, 0}});
    default:
      return fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:g}\" {}>{}</circle>\n", x, y, kMark,
                         style, inner);
  }
}

void addGrid(std::string& svg, const LogAxis& x, const LogAxis& y) {
  for (const bool decade : {false, true})  // decades lie above the others
    for (const bool vertical : {true, false})
      for (const LogAxis::Tick& tick : (vertical ? x : y).ticks()) {
        if (tick.decade != decade) continue;
        const std::string style = fmt::format("stroke=\"{}\"", decade ? "#ccc" : "#eee");
        if (vertical) {
          const double at = x.at(tick.value);
          svg += lineOf(at, y.pageFrom(), at, y.pageTo(), style);
          if (tick.labelled)
            svg += textAt(at, kHeight - kBottom + 18, svgNumber(tick.value), "text-anchor=\"middle\"");
        } else {
          const double at = y.at(tick.value);
          svg += lineOf(x.pageFrom(), at, x.pageTo(), at, style);
          if (tick.labelled) svg += textAt(kLeft - 7, at + 4, svgNumber(tick.value), "text-anchor=\"end\"");
        }
      }
  svg += fmt::format(
      "<rect x=\"{:g}\" y=\"{:g}\" width=\"{:g}\" height=\"{:g}\" fill=\"none\" stroke=\"#444\"/>\n", kLeft,
      kTop, kWidth - kLeft - kRight, kHeight - kTop - kBottom);
}

// Noise alone falls as 1 / time: a dashed line through a point, as far as the plot goes.
void addSlope(std::string& svg, const LogAxis& x, const LogAxis& y, double seconds, double error) {
  const double product = seconds * error;
  const double from = std::max(x.low(), product / y.high()), to = std::min(x.high(), product / y.low());
  if (from < to)
    svg += lineOf(x.at(from), y.at(product / from), x.at(to), y.at(product / to),
                  "stroke=\"#888\" stroke-dasharray=\"6 4\"");
}

// A standard error to both sides; what would reach 0 ends at the edge of the plot.
void addErrorBars(std::string& svg, const LogAxis& x, const LogAxis& y, const Point& p, const char* colour) {
  if (p.runs.size() < 2) return;
  const std::string style = fmt::format("stroke=\"{}\"", colour);
  const auto ends = [](const Summary& s, const LogAxis& axis) {
    const double e = s.standardError();
    return std::pair(axis.at(std::max(s.mean - e, axis.low())), axis.at(std::min(s.mean + e, axis.high())));
  };
  const double px = x.at(p.wall.mean), py = y.at(p.relMse.mean);
  const auto [left, right] = ends(p.wall, x);
  const auto [lower, upper] = ends(p.relMse, y);
  svg += lineOf(left, py, right, py, style) + lineOf(px, lower, px, upper, style);
  for (const double at : {left, right}) svg += lineOf(at, py - 3, at, py + 3, style);
  for (const double at : {lower, upper}) svg += lineOf(px - 3, at, px + 3, at, style);
}

void addLegend(std::string& svg, const std::vector<std::string>& modes, bool bars, bool floor, bool hollow) {
  const double x = kWidth - kRight + 14;
  double y = kTop + 10;
  const auto entry = [&](const std::string& sample, const std::string& text) {
    svg += sample + textAt(x + 34, y + 4, text);
    y += 20;
  };
  for (const std::string& mode : modes)
    entry(lineOf(x, y, x + 26, y, fmt::format("stroke=\"{}\" stroke-width=\"2\"", colourOf(mode))) +
              markAt(x + 13, y, styleOf(mode), colourOf(mode), true),
          escaped(mode));
  if (hollow) entry(markAt(x + 13, y, 0, "#666", false), "slower and worse");
  entry(lineOf(x, y, x + 26, y, "stroke=\"#888\" stroke-dasharray=\"6 4\""), "error ∝ 1 / time");
  if (floor)
    entry(lineOf(x, y, x + 26, y, "stroke=\"#888\" stroke-dasharray=\"1 3\" stroke-width=\"1.5\""),
          "reference’s noise");
  if (bars) entry(lineOf(x + 13, y - 6, x + 13, y + 6, "stroke=\"#666\""), "± standard error");
}

}  // namespace

std::string svgPlot(const std::string& title, std::span<const Point* const> all, double referenceNoise) {
  std::vector<const Point*> points;
  std::vector<std::string> modes;
  for (const Point* p : all) {
    if (p->runs.empty() || !(p->wall.mean > 0) || !(p->relMse.mean > 0)) continue;
    points.push_back(p);
    if (std::ranges::find(modes, p->mode) == modes.end()) modes.push_back(p->mode);
  }
  std::ranges::sort(modes, {}, styleOf);
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" "
      "font-family=\"Helvetica, Arial, sans-serif\" font-size=\"12\">\n"
      "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n<text x=\"{2}\" y=\"26\" "
      "font-size=\"15\">{3}</text>\n",
      kWidth, kHeight, kLeft, escaped(title));
  if (points.empty()) return svg + "<text x=\"70\" y=\"60\">nothing was measured</text>\n</svg>\n";
  const auto [quickest, slowest] =
      std::ranges::minmax(points, {}, [](const Point* p) { return p->wall.mean; });
  const auto [best, worst] = std::ranges::minmax(points, {}, [](const Point* p) { return p->relMse.mean; });
  // Marks stay clear of the frame.
  const LogAxis x(quickest->wall.mean * 0.93, slowest->wall.mean * 1.07, kLeft, kWidth - kRight);
  const LogAxis y(best->relMse.mean * 0.9, worst->relMse.mean * 1.1, kHeight - kBottom, kTop);
  addGrid(svg, x, y);
  svg += textAt((kLeft + kWidth - kRight) / 2, kHeight - 12, "wall time (s)", "text-anchor=\"middle\"");
  svg += fmt::format(
      "<text transform=\"translate(18 {:.1f}) rotate(-90)\" text-anchor=\"middle\">relMSE, noise of the "
      "reference taken off</text>\n",
      (kTop + kHeight - kBottom) / 2);
  const bool floor = referenceNoise > y.low() && referenceNoise < y.high();
  if (floor)
    svg += lineOf(kLeft, y.at(referenceNoise), kWidth - kRight, y.at(referenceNoise),
                  "stroke=\"#888\" stroke-dasharray=\"1 3\" stroke-width=\"1.5\"");
  // Through the first point of the mode that is noise alone, or of whatever there is.
  const size_t pure = static_cast<size_t>(std::ranges::find(modes, "path") - modes.begin());
  const CurvePoint start = lowerEnvelope(curveOf(points, modes[pure % modes.size()])).front();
  addSlope(svg, x, y, start.seconds, start.error);

  bool bars = false, hollow = false;
  for (const std::string& mode : modes) {
    const char* colour = colourOf(mode);
    const std::vector<CurvePoint> line = lowerEnvelope(curveOf(points, mode));
    std::string path;
    for (const CurvePoint& p : line) path += fmt::format("{:.1f},{:.1f} ", x.at(p.seconds), y.at(p.error));
    svg += fmt::format("<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"2\"/>\n", path,
                       colour);
    for (const Point* p : points) {
      if (p->mode != mode) continue;
      addErrorBars(svg, x, y, *p, colour);
      bars |= p->runs.size() > 1;
      const bool counts = std::ranges::any_of(
          line, [&](const CurvePoint& c) { return c.seconds == p->wall.mean && c.error == p->relMse.mean; });
      hollow |= !counts;
      svg += markAt(x.at(p->wall.mean), y.at(p->relMse.mean), styleOf(mode), colour, counts,
                    fmt::format("<title>{} {}: {:.3g} s, relMSE {:.3g}</title>", escaped(p->mode),
                                escaped(p->setting), p->wall.mean, p->relMse.mean));
    }
  }
  addLegend(svg, modes, bars, floor, hollow);
  return svg + "</svg>\n";
}

}  // namespace patina::bench
