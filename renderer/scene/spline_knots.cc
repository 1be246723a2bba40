// SPDX-License-Identifier: Apache-2.0
// Checks of knots.
#include "renderer/scene/spline_knots.h"

#include <fmt/format.h>

#include "renderer/base/bspline.h"

namespace patina {
namespace {

bool consistent(const SplineKnots& s) {
  return s.order >= 2 && s.order <= kMaxSplineOrder && s.count >= s.order &&
         s.knots.size() == static_cast<size_t>(s.count) + static_cast<size_t>(s.order);
}
float domainBegin(const SplineKnots& s) { return s.knots[static_cast<size_t>(s.order) - 1]; }
float domainEnd(const SplineKnots& s) { return s.knots[static_cast<size_t>(s.count)]; }

}  // namespace

bool cutToDomain(SplineKnots& spline, bool& cut) {
  if (!consistent(spline)) return false;
  const float min = std::max(spline.min, domainBegin(spline)), max = std::min(spline.max, domainEnd(spline));
  if (!(min < max)) return false;
  cut = cut || min != spline.min || max != spline.max;
  spline.min = min, spline.max = max;
  return true;
}

std::optional<SplineProblem> splineProblem(const SplineKnots& s) {
  if (s.order < 2 || s.order > kMaxSplineOrder)
    return SplineProblem{RiError::Range, fmt::format("order {}, expected 2 to {}", s.order, kMaxSplineOrder)};
  if (s.count < s.order)
    return SplineProblem{RiError::Consistency,
                         fmt::format("{} control points, expected at least the order, {}", s.count, s.order)};
  if (!consistent(s))
    return SplineProblem{
        RiError::Consistency,
        fmt::format("{} knots, expected {} (control points plus order)", s.knots.size(),
                    size_t{0} + static_cast<size_t>(s.count) + static_cast<size_t>(s.order))};
  int same = 0;
  for (size_t k = 0; k < s.knots.size(); ++k) {
    if (!std::isfinite(s.knots[k]))
      return SplineProblem{RiError::Range, fmt::format("knot {} is not finite", k)};
    if (k > 0 && s.knots[k] < s.knots[k - 1])
      return SplineProblem{RiError::Range, fmt::format("knots must not fall; knot {} ({}) comes after {}", k,
                                                       s.knots[k], s.knots[k - 1])};
    same = k > 0 && s.knots[k] == s.knots[k - 1] ? same + 1 : 1;
    if (same > s.order)
      return SplineProblem{RiError::Range, fmt::format("the knot {} comes more than {} times (the order)",
                                                       s.knots[k], s.order)};
  }
  if (!(s.min < s.max && s.min >= domainBegin(s) && s.max <= domainEnd(s)))
    return SplineProblem{RiError::Range,
                         fmt::format("the range {} to {} is empty or outside of {} to {}, where "
                                     "the knots define something",
                                     s.min, s.max, domainBegin(s), domainEnd(s))};
  return std::nullopt;
}

}  // namespace patina
