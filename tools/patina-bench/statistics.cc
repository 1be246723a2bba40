// SPDX-License-Identifier: Apache-2.0
// Errors, tests and interpolation.
#include "tools/patina-bench/statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace patina::bench {

ImageErrors imageErrors(const ImageData& picture, const ImageData& reference) {
  if (picture.width != reference.width || picture.height != reference.height || picture.channels < 3 ||
      reference.channels < 3) {
    throw std::runtime_error(fmt::format(
        "a picture of {} x {} pixels and {} channels cannot be compared with a reference of {} x {} and {}",
        picture.width, picture.height, picture.channels, reference.width, reference.height,
        reference.channels));
  }
  ImageErrors errors;
  std::vector<double> relative;
  const auto pixels = static_cast<double>(picture.width) * picture.height;
  relative.reserve(static_cast<size_t>(pixels) * 3);
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x)
      for (size_t c = 0; c < 3; ++c) {
        const double v = static_cast<double>(picture.pixel(x, y)[c]),
                     r = static_cast<double>(reference.pixel(x, y)[c]);
        if (!std::isfinite(v)) throw std::runtime_error(fmt::format("pixel {},{} is not finite", x, y));
        const double squared = (v - r) * (v - r) * relMseWeight(r);
        errors.relMse += squared / (3 * pixels);
        errors.meanError[c] += (v - r) / pixels;
        errors.meanReference[c] += r / pixels;
        relative.push_back(squared);
      }
  if (relative.empty()) return errors;
  const auto at = relative.begin() + static_cast<std::ptrdiff_t>((relative.size() - 1) * 99 / 100);
  std::ranges::nth_element(relative, at);
  errors.percentile99 = std::sqrt(*at);
  return errors;
}

std::vector<double> blockMeans(const ImageData& picture, int size) {
  std::vector<double> means;
  for (int y0 = 0; y0 < picture.height; y0 += size)
    for (int x0 = 0; x0 < picture.width; x0 += size) {
      const int x1 = std::min(x0 + size, picture.width), y1 = std::min(y0 + size, picture.height);
      for (size_t c = 0; c < 3; ++c) {
        double sum = 0;
        for (int y = y0; y < y1; ++y)
          for (int x = x0; x < x1; ++x) sum += static_cast<double>(picture.pixel(x, y)[c]);
        means.push_back(sum / (static_cast<double>(x1 - x0) * (y1 - y0)));
      }
    }
  return means;
}

double Summary::standardError() const {
  return count > 0 ? std::sqrt(variance / static_cast<double>(count)) : 0;
}

Summary summarize(std::span<const double> values) {
  Summary s{values.size(), 0, 0};
  for (const double v : values) s.mean += v / static_cast<double>(s.count);
  if (s.count < 2) return s;
  for (const double v : values) s.variance += (v - s.mean) * (v - s.mean) / static_cast<double>(s.count - 1);
  return s;
}

double studentTails(double t, double freedom) {
  if (std::isinf(t)) return 0;
  return 2 * boost::math::cdf(
                 boost::math::complement(boost::math::students_t_distribution<double>(freedom), std::abs(t)));
}

TTest welchTest(const Summary& a, const Summary& b) {
  TTest test;
  if (a.count < 2 || b.count < 2) return test;
  const double va = a.variance / static_cast<double>(a.count), vb = b.variance / static_cast<double>(b.count);
  const double difference = a.mean - b.mean;
  test.freedom = static_cast<double>(a.count + b.count - 2);
  if (!(va + vb > 0)) {
    if (difference != 0)
      test.t = std::copysign(std::numeric_limits<double>::infinity(), difference), test.p = 0;
    return test;
  }
  // Shares of the variance, as its squares could underflow.
  const double sa = va / (va + vb), sb = vb / (va + vb);
  test.freedom =
      1 / (sa * sa / static_cast<double>(a.count - 1) + sb * sb / static_cast<double>(b.count - 1));
  test.t = difference / std::sqrt(va + vb);
  test.p = studentTails(test.t, test.freedom);
  return test;
}

TTest studentTest(const Summary& values) {
  TTest test;
  if (values.count < 2) return test;
  test.freedom = static_cast<double>(values.count - 1);
  if (values.variance > 0) {
    test.t = values.mean / values.standardError();
    test.p = studentTails(test.t, test.freedom);
  } else if (values.mean != 0) {
    test.t = std::copysign(std::numeric_limits<double>::infinity(), values.mean), test.p = 0;
  }
  return test;
}

double sidak(double significance, size_t count) {
  return -std::expm1(std::log1p(-significance) / static_cast<double>(std::max<size_t>(count, 1)));
}

std::vector<CurvePoint> lowerEnvelope(std::vector<CurvePoint> points) {
  std::erase_if(points, [](const CurvePoint& p) { return !(p.seconds > 0) || !(p.error > 0); });
  std::ranges::sort(points, [](const CurvePoint& a, const CurvePoint& b) {
    return a.seconds != b.seconds ? a.seconds < b.seconds : a.error < b.error;
  });
  std::vector<CurvePoint> envelope;
  for (const CurvePoint& p : points)
    if (envelope.empty() || p.error < envelope.back().error) envelope.push_back(p);
  return envelope;
}

std::optional<EqualError> secondsAtError(std::vector<CurvePoint> points, double error) {
  points = lowerEnvelope(std::move(points));
  if (points.empty() || !(error > 0)) return std::nullopt;
  if (error > points.front().error) return EqualError{EqualError::AtMost, points.front().seconds};
  const auto beyond = std::ranges::find_if(points, [&](const CurvePoint& p) { return p.error <= error; });
  const bool inside = beyond != points.end();
  const size_t last = inside ? static_cast<size_t>(beyond - points.begin()) : points.size() - 1;
  if (points[last].error == error) return EqualError{EqualError::Interpolated, points[last].seconds};
  double slope = -1;  // of log time over log error
  if (last > 0) {
    slope = std::log(points[last].seconds / points[last - 1].seconds) /
            std::log(points[last].error / points[last - 1].error);
  }
  const double factor = std::exp(slope * std::log(error / points[last].error));
  if (!(factor <= kFurthest)) return std::nullopt;
  return EqualError{inside ? EqualError::Interpolated : EqualError::Extrapolated,
                    points[last].seconds * factor};
}

}  // namespace patina::bench
