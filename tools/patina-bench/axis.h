// SPDX-License-Identifier: Apache-2.0
// Logarithmic axes of plots.
#pragma once

#include <string>
#include <vector>

namespace patina::bench {

/// From the values 1, 2 or 5 times a power of ten around all that is shown, to places on the page.
class LogAxis {
 public:
  /// Both values positive; `pageFrom` is where the least is.
  LogAxis(double least, double most, double pageFrom, double pageTo);
  double at(double value) const;
  double low() const { return low_; }
  double high() const { return high_; }
  double pageFrom() const { return from_; }
  double pageTo() const { return to_; }

  struct Tick {
    double value = 0;
    bool decade = false;    ///< a power of ten
    bool labelled = false;  ///< decades, and on short axes 2 and 5 times those
  };
  std::vector<Tick> ticks() const;

 private:
  double low_, high_, from_, to_;
};

/// A number as SVG text: plain from 0.001 to 9999, else as a power of ten with a raised exponent.
std::string svgNumber(double value);

}  // namespace patina::bench
