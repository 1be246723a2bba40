// SPDX-License-Identifier: Apache-2.0
// Luminous intensities of luminaires by direction, from files of IES LM-63 (1986 to 2002), type C.
#pragma once

#include <sys/stat.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace patina::shaders {

/// Candela over the angle from the nadir (the way that the luminaire shines) and around it. Immutable once
/// read.
class IesProfile {
 public:
  /// Throws std::runtime_error, "FILE:LINE: what is wrong", of what is no such file; it may be hostile.
  static IesProfile read(const std::string& path) {
    constexpr size_t kLargest = size_t{4} << 20;
    struct stat status {};
    if (stat(path.c_str(), &status) != 0) throw std::runtime_error(path + ": there is no such file");
    if (!S_ISREG(status.st_mode)) throw std::runtime_error(path + ": this is no file");
    if (static_cast<size_t>(status.st_size) > kLargest)
      throw std::runtime_error(path + ": an IES profile of more than 4 MB");
    std::ifstream file(path, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    if (!file) throw std::runtime_error(path + ": cannot be read");
    return parse(text, path);
  }
  static IesProfile parse(std::string_view text, const std::string& name) {
    IesProfile profile;
    Reader in(text, name);
    in.skipKeywords();
    profile.readTable(in);
    return profile;
  }

  float most() const { return most_; }  ///< candela, the largest
  /// Candela, linear between the file's angles; `vertical` from the nadir, 0 to 180, `horizontal` around, any
  /// angle, both in degrees. 0 beyond the file's vertical angles.
  float at(float vertical, float horizontal) const {
    if (!(vertical >= vertical_.front() && vertical <= vertical_.back())) return 0;
    const auto [row, rowShare] = place(horizontal_, folded(horizontal));
    const auto [column, columnShare] = place(vertical_, vertical);
    const auto along = [&](size_t r) {
      const float* c = &candela_[r * vertical_.size() + column];
      return c[0] + (c[1] - c[0]) * columnShare;
    };
    return rowShare > 0 ? along(row) + (along(row + 1) - along(row)) * rowShare : along(row);
  }
  /// Integral over all directions, lumens, by the trapezoidal rule in the cosine of the vertical angle.
  float flux() const {
    constexpr int kAround = 72, kDown = 360;
    constexpr double kPi = 3.14159265358979323846;
    double sum = 0;
    for (int j = 0; j < kDown; ++j)
      for (int i = 0; i < kAround; ++i)
        sum += double(at(float(180 * (j + 0.5) / kDown), float(360 * (i + 0.5) / kAround))) *
               std::sin(kPi * (j + 0.5) / kDown);
    return float(sum * (2 * kPi / kAround) * (kPi / kDown));
  }

 private:
  class Reader {
   public:
    Reader(std::string_view text, const std::string& name) : text_(text), name_(name) {}

    [[noreturn]] void fail(const std::string& what) const {
      throw std::runtime_error(name_ + ":" + std::to_string(line_) + ": " + what);
    }
    /// All up to the line TILT=, and the tilt's own numbers.
    void skipKeywords() {
      for (;;) {
        if (text_.empty()) fail("no line TILT=: this is no IES profile (LM-63)");
        const std::string_view line = nextLine();
        if (!line.starts_with("TILT=")) continue;
        const std::string_view tilt = line.substr(5);
        if (tilt.starts_with("NONE")) return;
        if (!tilt.starts_with("INCLUDE")) fail("TILT is to be NONE or INCLUDE: other files are not read");
        number("the lamp's geometry");
        const size_t pairs = count("the number of tilt angles", 0);
        for (size_t k = 0; k < 2 * pairs; ++k) number("a tilt angle or factor");
        return;
      }
    }
    double number(const char* what) {
      while (!text_.empty() && isSpace(text_.front())) {
        line_ += text_.front() == '\n';
        text_.remove_prefix(1);
      }
      if (text_.empty()) fail(std::string("the file ends before ") + what);
      if (text_.front() == '+') text_.remove_prefix(1);
      double value = 0;
      const auto [end, error] = std::from_chars(text_.data(), text_.data() + text_.size(), value);
      const auto length = static_cast<size_t>(end - text_.data());
      const bool ends = length == text_.size() || isSpace(text_[length]);
      if (error != std::errc() || !ends || !std::isfinite(value) || std::abs(value) > 1e12)
        fail(std::string(what) + " is not a number that makes sense");
      text_.remove_prefix(length);
      return value;
    }
    size_t count(const char* what, size_t least) {
      constexpr double kMost = 10000;
      const double value = number(what);
      if (value != std::floor(value) || value < double(least) || value > kMost)
        fail(std::string(what) + " is to be " + std::to_string(least) + " to 10000");
      return static_cast<size_t>(value);
    }
    size_t left() const { return text_.size(); }

   private:
    static bool isSpace(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == ','; }
    std::string_view nextLine() {
      const size_t end = std::min(text_.find('\n'), text_.size());
      const std::string_view line = text_.substr(0, end);
      text_.remove_prefix(std::min(end + 1, text_.size()));
      ++line_;
      return line;
    }
    std::string_view text_;
    const std::string& name_;
    int line_ = 1;
  };

  void readTable(Reader& in) {
    in.number("the number of lamps"), in.number("lumens per lamp");
    const double multiplier = in.number("the candela multiplier");
    const size_t verticals = in.count("the number of vertical angles", 2),
                 horizontals = in.count("the number of horizontal angles", 1);
    if (in.number("the photometric type") != 1)
      in.fail("only profiles of the photometric type 1 (C) are read");
    for (const char* what : {"the type of units", "the width", "the length", "the height"}) in.number(what);
    const double ballast = in.number("the ballast factor");
    in.number("the ballast-lamp factor"), in.number("the watts");
    const double scale = multiplier * ballast;
    if (!(scale >= 0)) in.fail("candela multiplier and ballast factor are to be 0 or more");
    // Each number takes two bytes at least: no more memory than the file has room for.
    if (verticals * horizontals > in.left()) in.fail("the file is too short for its number of angles");
    const auto angles = [&](size_t n, const char* what, double least, double most, std::vector<float>& to) {
      for (size_t k = 0; k < n; ++k) {
        const double angle = in.number(what);
        if (!(angle >= least && angle <= most)) in.fail(std::string(what) + " is out of its range");
        if (k > 0 && !(float(angle) > to.back())) in.fail(std::string(what) + " is not above the one before");
        to.push_back(float(angle));
      }
    };
    angles(verticals, "a vertical angle", 0, 180, vertical_);
    angles(horizontals, "a horizontal angle", 0, 360, horizontal_);
    const float last = horizontal_.back();
    const bool half = horizontal_.front() == 90 && last == 270;
    if (horizontals == 1 ? horizontal_.front() != 0
                         : !half && (horizontal_.front() != 0 || (last != 90 && last != 180 && last < 270)))
      in.fail("horizontal angles are to be 0 alone, 0 to 90, 180 or 360, or 90 to 270");
    for (size_t k = 0; k < verticals * horizontals; ++k) {
      const double candela = in.number("a candela value") * scale;
      if (!(candela >= 0)) in.fail("a candela value is negative");
      candela_.push_back(float(std::min(candela, 1e12)));
      most_ = std::max(most_, candela_.back());
    }
    if (horizontals > 1 && !half && last > 180 && last < 360) {  // 360 may be left out: it is 0 again
      horizontal_.push_back(360);
      candela_.insert(candela_.end(), candela_.begin(),
                      candela_.begin() + static_cast<std::ptrdiff_t>(verticals));
    }
  }

  /// Into the range that the file has, by its symmetry.
  float folded(float angle) const {
    if (horizontal_.size() == 1) return 0;
    float a = std::fmod(angle, 360.0f);
    if (a < 0) a += 360;
    const float last = horizontal_.back();
    if (horizontal_.front() == 90) return a < 90 ? 180 - a : a > 270 ? 540 - a : a;
    if (last == 360) return a;
    if (a > 180) a = 360 - a;
    return last == 90 && a > 90 ? 180 - a : a;
  }
  struct Place {
    size_t index;
    float share;
  };
  static Place place(const std::vector<float>& angles, float angle) {
    if (angles.size() == 1) return {0, 0};
    const auto next = std::upper_bound(angles.begin() + 1, angles.end() - 1, angle);
    const float low = *(next - 1);
    return {static_cast<size_t>(next - angles.begin()) - 1,
            std::clamp((angle - low) / (*next - low), 0.0f, 1.0f)};
  }

  std::vector<float> vertical_, horizontal_;  // degrees, ascending
  std::vector<float> candela_;                // for each horizontal angle the vertical ones
  float most_ = 0;
};

}  // namespace patina::shaders
