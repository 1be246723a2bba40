// SPDX-License-Identifier: Apache-2.0
// Numbers in ASCII against the C library's strtof, which rounds exactly, and against what RIB does not allow.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <random>
#include <string>

#include <fmt/format.h>

#include "rib/number.h"

namespace patina {
namespace {

Number scan(const std::string& text) { return scanNumber(text.data(), text.data() + text.size()); }

void expectAsStrtof(const std::string& text) {
  const float expected = std::strtof(text.c_str(), nullptr);
  // Two copies: at the very end of the input, and with more behind it (the eight-byte way).
  for (const std::string& input : {text, text + " 12345678"}) {
    const Number number = scan(input);
    ASSERT_EQ(number.end, input.data() + text.size()) << text;
    if (std::isinf(expected)) {
      EXPECT_EQ(number.status, NumberStatus::TooLarge) << text;
      EXPECT_EQ(std::abs(number.value), std::numeric_limits<float>::max()) << text;
      EXPECT_EQ(std::signbit(number.value), std::signbit(expected)) << text;
    } else {
      ASSERT_EQ(number.status, NumberStatus::Ok) << text;
      ASSERT_EQ(std::bit_cast<uint32_t>(number.value), std::bit_cast<uint32_t>(expected)) << text;
    }
  }
}

TEST(RibNumber, RandomTextsAreRoundedAsByStrtof) {
  std::mt19937 random(20120805);
  const auto upTo = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n + 1)); };
  const auto digits = [&](int n) {
    std::string result;
    while (n-- > 0) result += static_cast<char>('0' + upTo(9));
    return result;
  };
  for (int i = 0; i < 300000; ++i) {
    std::string text;
    if (upTo(2) == 0) text += upTo(1) ? "-" : "+";
    const int shape = upTo(9);
    const int before = upTo(shape == 0 ? 40 : 8), after = upTo(shape == 1 ? 40 : 9);
    text += digits(before);
    if (upTo(3) > 0) text += "." + digits(after);
    if (text.find_first_of("0123456789") == std::string::npos) text += "0";
    if (upTo(3) == 0)
      text += fmt::format("{}{}{}", upTo(1) ? "e" : "E", upTo(2) ? (upTo(1) ? "-" : "+") : "", upTo(50));
    expectAsStrtof(text);
    if (HasFatalFailure()) return;
  }
}

TEST(RibNumber, FloatsPrintedInAnyLengthComeBack) {
  std::mt19937 random(7);
  for (int i = 0; i < 50000; ++i) {
    const float value = std::bit_cast<float>(static_cast<uint32_t>(random()));
    if (!std::isfinite(value)) continue;
    expectAsStrtof(fmt::format("{}", value));
    expectAsStrtof(fmt::format("{:.9g}", value));
    expectAsStrtof(fmt::format("{:.17g}", static_cast<double>(value)));
    // Halfway to the next float, a little more and a little less: where rounding twice goes wrong.
    const double next = static_cast<double>(std::nextafter(value, std::numeric_limits<float>::infinity()));
    if (!std::isfinite(next)) continue;
    const double middle = (static_cast<double>(value) + next) / 2;
    expectAsStrtof(fmt::format("{:.25g}", middle));
    expectAsStrtof(fmt::format("{:.40g}1", middle));
    if (HasFatalFailure()) return;
  }
}

TEST(RibNumber, EdgesOfTheFormat) {
  for (const char* text : {"0",
                           "-0",
                           "+0",
                           ".5",
                           "-.5",
                           "+.5",
                           "1.",
                           "-1.",
                           "1e+05",
                           "1E5",
                           "1.e2",
                           "1e-45",
                           "7e-46",
                           "1e-400",
                           "0e999",
                           "0.0e-999",
                           "3.4028235e38",
                           "3.4028236e38",
                           "1e38",
                           "-1e38",
                           "1e39",
                           "-1e39",
                           "1e400",
                           "-1e4000000000000",
                           "16777217",
                           "16777219",
                           "33554433",
                           "4294967295",
                           "123456789012345678901234567890",
                           "00000000000000000000001",
                           "1.17549435e-38",
                           "1.1754942e-38",
                           "0.00000000000000000000000000000000000000000000001e47",
                           "100000000000000000000000000000000000000000000000e-47",
                           "9007199254740993",
                           "8388608.5",
                           "8388609.5"}) {
    expectAsStrtof(text);
  }
  const std::string manyZeros = "0." + std::string(500, '0') + "1e501";
  EXPECT_EQ(scan(manyZeros).value, 1.0f);
  EXPECT_EQ(scan("1" + std::string(400, '0') + "e-400").value, 1.0f);
  EXPECT_EQ(scan("0." + std::string(500, '0') + "1e400").status, NumberStatus::Ok);
  EXPECT_EQ(scan("0." + std::string(500, '0') + "1e400").value, 0.0f);
  EXPECT_EQ(scan(std::string(400, '0') + "1" + std::string(400, '0')).status, NumberStatus::TooLarge);
}

TEST(RibNumber, IntegersAreExactBeyondFloat) {
  for (const char* text : {"16777217", "-2147483647", "2147483647", "4503599627370497"}) {
    const Number number = scan(text);
    EXPECT_TRUE(number.integral) << text;
    EXPECT_EQ(number.exact, std::atof(text));
  }
  EXPECT_FALSE(scan("1.0").integral);
  EXPECT_FALSE(scan("1e3").integral);
}

TEST(RibNumber, WhatIsNotANumber) {
  for (const char* text : {"nan", "NaN", "inf", "-inf", "+Inf", "INFINITY", "-nan"}) {
    EXPECT_EQ(scan(text).status, NumberStatus::NotFinite) << text;
  }
  for (const char* text : {"01a3", "1.2.3", "-", "+", ".", "-.", "1e", "1e+", "--1", "1-2", "0x10", "1e5.0",
                           "-nanx", "1f", "1.0e5e5", "+-1"}) {
    const std::string word(text);
    const Number number = scan(word);
    EXPECT_EQ(number.status, NumberStatus::Malformed) << text;
    EXPECT_EQ(number.end, word.data() + word.size()) << text;
  }
  for (const char* text : {"nano", "info", "Infinite", "Interior", ",", "/"}) {
    EXPECT_EQ(scan(text).status, NumberStatus::NotANumber) << text;
  }
}

TEST(RibNumber, TokensNeedNoBlankBetweenThem) {
  for (const char* text : {"12]", "12[", "12\"a\"", "12#x", "12\n", "12\t", "12\xa4"}) {
    const Number number = scan(text);
    EXPECT_EQ(number.status, NumberStatus::Ok) << text;
    EXPECT_EQ(number.value, 12.0f) << text;
  }
}

}  // namespace
}  // namespace patina
