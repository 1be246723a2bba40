// SPDX-License-Identifier: Apache-2.0
// Shares of time, axes, captions, and what is known of the machine.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tools/patina-bench/axis.h"
#include "tools/patina-bench/environment.h"
#include "tools/patina-bench/font.h"
#include "tools/patina-bench/schedule.h"

namespace patina::bench {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const std::vector<Setting> kTwoModes = {{"path", "4", {}},
                                        {"path", "16", {}},
                                        {"path", "64", {}},
                                        {"radiosity", "low", {}},
                                        {"radiosity", "high", {}}};

TEST(BenchSchedule, TakesModesByTurns) {
  std::vector<std::string> order;
  for (const Setting& s : byTurns(kTwoModes)) order.push_back(s.name);
  EXPECT_THAT(order, ElementsAre("4", "low", "16", "high", "64"));
}

TEST(BenchSchedule, SharesWhatIsLeftAmongModes) {
  Shares shares(kTwoModes);
  EXPECT_EQ(shares.allow("path", 100), 50);
  shares.took("path", 10, false), shares.pass("path");
  EXPECT_EQ(shares.allow("radiosity", 90), 45);
  shares.took("radiosity", 45, true), shares.pass("radiosity");  // its time was up
  EXPECT_EQ(shares.allow("path", 45), 45);                       // which leaves all to the other one
  EXPECT_EQ(shares.allow("radiosity", 1000), 0);                 // nothing slower is tried
}

TEST(BenchSchedule, BeginsNothingThatHasNoRoom) {
  Shares shares(kTwoModes);
  shares.took("path", 30, false), shares.pass("path");
  EXPECT_EQ(shares.allow("path", 100), 0);  // 60 s at least, and its share is 50
  EXPECT_EQ(shares.allow("path", 1000), 0);
  EXPECT_EQ(shares.allow("radiosity", 100), 100);
}

TEST(BenchSchedule, ModesThatAreThroughLeaveTheirShare) {
  Shares shares(kTwoModes);
  for (int k = 0; k < 2; ++k) shares.took("radiosity", 1, false), shares.pass("radiosity");
  EXPECT_EQ(shares.allow("path", 100), 100);
}

TEST(BenchSchedule, ABudgetOfNothingIsNoLimit) {
  EXPECT_FALSE(Budget(0).limited());
  EXPECT_TRUE(Budget(1).limited());
  EXPECT_LE(Budget(1).left(), 1);
  EXPECT_EQ(Budget(1e-9).left(), 0);
}

TEST(BenchAxis, EndsAtOneTwoOrFive) {
  const LogAxis axis(0.03, 7, 0, 300);
  EXPECT_NEAR(axis.low(), 0.02, 1e-12);
  EXPECT_NEAR(axis.high(), 10, 1e-9);
  EXPECT_NEAR(axis.at(axis.low()), 0, 1e-9);
  EXPECT_NEAR(axis.at(axis.high()), 300, 1e-9);
  EXPECT_NEAR(axis.at(std::sqrt(0.2)), 150, 1e-6);
  const auto ticks = axis.ticks();
  EXPECT_EQ(std::ranges::count_if(ticks, [](const auto& t) { return t.decade; }), 3);  // 0.1, 1, 10
  const LogAxis narrow(1, 1.01, 0, 1);
  EXPECT_GE(narrow.high() / narrow.low(), 9.9);
  for (const auto& tick : narrow.ticks()) {
    const double digit = tick.value / std::pow(10, std::floor(std::log10(tick.value) + 1e-9));
    EXPECT_EQ(tick.labelled,
              std::abs(digit - 1) < 1e-6 || std::abs(digit - 2) < 1e-6 || std::abs(digit - 5) < 1e-6);
  }
}

TEST(BenchAxis, NumbersAreShort) {
  EXPECT_EQ(svgNumber(0.005), "0.005");
  EXPECT_EQ(svgNumber(200), "200");
  EXPECT_EQ(svgNumber(1e-4), "10<tspan dy=\"-4\" font-size=\"9\">−4</tspan>");
  EXPECT_THAT(svgNumber(2e-5), HasSubstr("2·10<tspan"));
}

TEST(BenchCaptions, AreDrawnAndCutOff) {
  const int width = 20, height = 9;
  std::vector<uint8_t> bytes(3 * width * height);
  drawText(bytes, width, 0, 0, width, "l");
  // Its dots: two at the top, five of the stem, three of the foot.
  EXPECT_EQ(std::ranges::count(bytes, 235), 3 * (2 + 5 + 3));
  std::vector<uint8_t> longer(bytes.size());
  drawText(longer, width, 0, 0, 7, "lllllll");  // room for one
  EXPECT_EQ(longer, bytes);
  drawText(longer, width, 0, 100, width, "below the picture");
  EXPECT_EQ(longer, bytes);
}

TEST(BenchEnvironment, TellsMachineProgramAndCommand) {
  const Environment here = describeMachine();
  EXPECT_GT(here.processors, 0);
  EXPECT_GT(here.memoryGb, 0.1);
  EXPECT_THAT(here.system, HasSubstr("Linux"));
  EXPECT_EQ(here.date.size(), std::string("2000-01-01T00:00:00Z").size());
  const std::string version = versionOf(PATINA_BINARY_DIR "/bin/patina");
  EXPECT_THAT(version, HasSubstr("patina "));
  EXPECT_THAT(version, HasSubstr("; commit "));
  EXPECT_EQ(versionOf("/no/such/program"), "");
  const char* words[] = {"/usr/bin/patina-bench", "--only", "*/path", "it's"};
  EXPECT_EQ(commandLine(4, words), "patina-bench --only '*/path' 'it'\\''s'");
}

}  // namespace
}  // namespace patina::bench
