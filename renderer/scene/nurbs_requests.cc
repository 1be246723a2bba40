// SPDX-License-Identifier: Apache-2.0
// NuPatch and TrimCurve.
#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "renderer/scene/scene_builder.h"
#include "renderer/scene/spline_knots.h"
#include "renderer/scene/trim_region.h"

namespace patina {
namespace {

std::vector<float> copied(Floats values) { return {values.begin(), values.end()}; }

/// The sum of counts that a request gives; nullopt if one is negative.
std::optional<size_t> total(Ints counts) {
  if (std::ranges::any_of(counts, [](int n) { return n < 0; })) return std::nullopt;
  return std::accumulate(counts.begin(), counts.end(), size_t{0},
                         [](size_t sum, int n) { return sum + static_cast<size_t>(n); });
}

/// The index of a control point whose weight is none, nor zero; nullopt: all are usable.
std::optional<size_t> unusableWeight(const ParamList& params) {
  for (const Param& param : params) {
    if (param.declaration.type != ValueType::HPoint || (param.name() != "P" && param.name() != "Pw"))
      continue;
    for (size_t k = 3; k < param.floats.size(); k += 4)
      if (param.floats[k] != 0 && !usableWeight(param.floats[k])) return k / 4;
  }
  return std::nullopt;
}

}  // namespace

void SceneBuilder::nuPatch(int nu, int uOrder, Floats uKnots, float uMin, float uMax, int nv, int vOrder,
                           Floats vKnots, float vMin, float vMax, const ParamList& params,
                           const Location& at) {
  if (!mayDraw(at)) return;
  NurbsPatch patch;
  patch.u = {nu, uOrder, copied(uKnots), uMin, uMax};
  patch.v = {nv, vOrder, copied(vKnots), vMin, vMax};
  const auto check = [&](char side, SplineKnots& spline) {
    bool cut = false;
    cutToDomain(spline, cut);
    if (cut)
      warning(RiError::Range, at,
              fmt::format("NuPatch: {0}min and {0}max are cut to {1} and {2}, between which the knots define "
                          "something",
                          side, spline.min, spline.max),
              "NuPatch range");
    const auto problem = splineProblem(spline);
    if (problem)
      error(problem->code, at, fmt::format("NuPatch is left out: along {}, {}", side, problem->text),
            fmt::format("NuPatch {}", name(problem->code)));
    return !problem;
  };
  if (!check('u', patch.u) || !check('v', patch.v)) return;
  if (const auto bad = unusableWeight(params))
    return error(RiError::Range, at,
                 fmt::format("NuPatch is left out: the weight of point {} is not 0, or between {:g} and {:g}",
                             *bad, kSmallestWeight, kLargestWeight),
                 "NuPatch weight");
  patch.trim = state_.trim;
  patch.keepInside = state_.trimOutside;
  addPrimitive(std::move(patch), params, at);
}

// RI 3.2: an attribute, like Basis; without loops, patches are whole again.
void SceneBuilder::trimCurve(Ints curvesPerLoop, Ints orders, Floats knots, Floats mins, Floats maxs,
                             Ints counts, Floats u, Floats v, Floats w, const Location& at) {
  const auto refuse = [&](RiError code, const std::string& why) {
    error(code, at, "TrimCurve is left out: " + why, fmt::format("TrimCurve {}", name(code)));
  };
  const auto curveCount = total(curvesPerLoop), pointCount = total(counts), orderSum = total(orders);
  if (!curveCount || !pointCount || !orderSum || std::ranges::find(curvesPerLoop, 0) != curvesPerLoop.end())
    return refuse(RiError::Consistency, "an order or a number of points is negative, or a loop has no curve");
  for (const size_t given : {orders.size(), mins.size(), maxs.size(), counts.size()})
    if (given != *curveCount)
      return refuse(RiError::Consistency,
                    fmt::format("{} orders, {} min, {} max and {} n, expected {} (curves)", orders.size(),
                                mins.size(), maxs.size(), counts.size(), *curveCount));
  if (knots.size() != *pointCount + *orderSum)
    return refuse(RiError::Consistency,
                  fmt::format("{} knots, expected {} (points plus orders of all curves)", knots.size(),
                              *pointCount + *orderSum));
  if (u.size() != *pointCount || v.size() != *pointCount || w.size() != *pointCount)
    return refuse(RiError::Consistency, fmt::format("{} u, {} v and {} w, expected {} (points of all curves)",
                                                    u.size(), v.size(), w.size(), *pointCount));
  for (size_t k = 0; k < *pointCount; ++k) {
    if (!std::isfinite(u[k]) || !std::isfinite(v[k]))
      return refuse(RiError::Range, fmt::format("point {} is not finite", k));
    if (!usableWeight(w[k]))
      return refuse(RiError::Range, fmt::format("the weight of point {} is {}, expected {:g} to {:g}", k,
                                                w[k], kSmallestWeight, kLargestWeight));
  }

  std::vector<TrimLoop> loops;
  size_t curve = 0, point = 0, knot = 0;
  bool cut = false;
  for (const int inLoop : curvesPerLoop) {
    TrimLoop& loop = loops.emplace_back();
    for (int k = 0; k < inLoop; ++k, ++curve) {
      const auto n = static_cast<size_t>(counts[curve]), order = static_cast<size_t>(orders[curve]);
      TrimCurve& c = loop.emplace_back();
      c.spline = {counts[curve], orders[curve], copied(knots.subspan(knot, n + order)), mins[curve],
                  maxs[curve]};
      c.u = copied(u.subspan(point, n)), c.v = copied(v.subspan(point, n)), c.w = copied(w.subspan(point, n));
      point += n, knot += n + order;
      cutToDomain(c.spline, cut);
      if (const auto problem = splineProblem(c.spline))
        return refuse(problem->code, fmt::format("curve {}: {}", curve, problem->text));
    }
  }
  if (cut)
    warning(RiError::Range, at, "TrimCurve: min and max are cut to where the knots define something",
            "TrimCurve range");
  state_.trim = loops.empty() ? nullptr : std::make_shared<const TrimRegion>(loops);
  if (state_.trim && state_.trim->openLoops() > 0)
    errors_.reportOnce(Severity::Warning, RiError::Consistency, at, "TrimCurve open",
                       "TrimCurve: loops must be closed; a straight line joins the ends of this one");
}

}  // namespace patina
