// SPDX-License-Identifier: Apache-2.0
// The error handler: what it prints, what it folds, what it counts.
#include <gtest/gtest.h>

#include <string>
#include <thread>
#include <vector>

#include "rib/error.h"

namespace patina {
namespace {

class RibError : public testing::Test {
 protected:
  std::vector<std::string> printed;
  ErrorHandler errors{[this](Severity, std::string_view text) { printed.emplace_back(text); }};
  Location at{internFileName("a.rib"), 12, 5};
};

TEST_F(RibError, SaysWhereAndWhat) {
  errors.report(Severity::Error, RiError::BadArgument, at, "Sphere: no");
  errors.report(Severity::Warning, RiError::NoShader, {internFileName("b.rib")}, "none");
  errors.report(Severity::Severe, RiError::System, {}, "disk");
  EXPECT_EQ(printed,
            (std::vector<std::string>{"a.rib:12:5: error: badargument: Sphere: no",
                                      "b.rib: warning: noshader: none", "patina: severe: system: disk"}));
}

TEST_F(RibError, FileNamesAreInterned) {
  EXPECT_EQ(internFileName("x.rib"), internFileName(std::string("x.") + "rib"));
  EXPECT_NE(internFileName("x.rib"), internFileName("y.rib"));
}

TEST_F(RibError, RepetitionsAreFoldedAndSummedUp) {
  for (int i = 0; i < 40; ++i)
    errors.report(Severity::Error, RiError::Range, at, "same " + std::to_string(i), "same");
  for (int i = 0; i < 2; ++i) errors.report(Severity::Error, RiError::Range, at, "other");
  EXPECT_EQ(printed.size(), 5u);
  errors.summarize();
  ASSERT_EQ(printed.size(), 6u);
  EXPECT_EQ(printed.back(), "... and 37 more of the same: error: range: same 0");
  errors.summarize();  // nothing new
  EXPECT_EQ(printed.size(), 6u);
  EXPECT_EQ(errors.count(Severity::Error), 42u);
}

TEST_F(RibError, OnceMeansOnce) {
  for (int i = 0; i < 5; ++i) {
    errors.reportOnce(Severity::Warning, RiError::Unimplemented, at, "Matte", "Matte is ignored");
  }
  EXPECT_EQ(printed.size(), 1u);
  errors.summarize();
  EXPECT_EQ(printed.back(), "... and 4 more of the same: warning: unimplemented: Matte is ignored");
}

TEST_F(RibError, TheSameTextWithAnotherCodeIsAnotherMessage) {
  for (int i = 0; i < 4; ++i) errors.report(Severity::Error, RiError::Range, at, "x");
  errors.report(Severity::Error, RiError::Math, at, "x");
  EXPECT_EQ(printed.size(), 4u);
}

TEST_F(RibError, PrintedLinesAndRememberedKindsAreBounded) {
  std::vector<std::string> lines;
  ErrorHandler few([&](Severity, std::string_view text) { lines.emplace_back(text); },
                   {.repeat = 3, .printed = 10, .kinds = 20});
  for (int i = 0; i < 1000; ++i) few.report(Severity::Error, RiError::Range, at, std::to_string(i));
  EXPECT_EQ(lines.size(), 10u);
  few.summarize();
  EXPECT_LE(lines.size(), 10u + 51u);
  EXPECT_EQ(few.count(Severity::Error), 1000u);
}

TEST_F(RibError, ExitStatusComesFromErrorsOnly) {
  errors.report(Severity::Warning, RiError::Range, at, "w");
  EXPECT_EQ(errors.exitStatus(), 0);
  errors.report(Severity::Error, RiError::Range, at, "e");
  EXPECT_EQ(errors.exitStatus(), 1);
}

TEST_F(RibError, StylesOfRI) {
  errors.setStyle(ErrorStyle::Ignore);
  errors.report(Severity::Error, RiError::Range, at, "e");
  EXPECT_TRUE(printed.empty());
  EXPECT_EQ(errors.count(Severity::Error), 1u);
  EXPECT_FALSE(errors.aborted());
  errors.setStyle(ErrorStyle::Abort);
  errors.report(Severity::Warning, RiError::Range, at, "w");
  EXPECT_FALSE(errors.aborted());
  errors.report(Severity::Error, RiError::Range, at, "e");
  EXPECT_TRUE(errors.aborted());
  errors.summarize();
  EXPECT_EQ(printed.size(), 2u);  // what was ignored is not summed up
}

TEST_F(RibError, InfoIsSilentUnlessAskedFor) {
  errors.report(Severity::Info, RiError::Range, at, "i");
  EXPECT_TRUE(printed.empty());
  errors.setQuiet(Severity::Info);
  errors.report(Severity::Info, RiError::Range, at, "j");
  EXPECT_EQ(printed.size(), 1u);
  errors.setQuiet(Severity::Error);
  errors.report(Severity::Warning, RiError::Range, at, "w");
  EXPECT_EQ(printed.size(), 1u);
  EXPECT_EQ(errors.count(Severity::Warning), 1u);
}

TEST_F(RibError, ThreadsMayReportTogether) {
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&] {
      for (int i = 0; i < 1000; ++i) errors.report(Severity::Error, RiError::Math, at, "t");
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(errors.count(Severity::Error), 4000u);
  EXPECT_EQ(printed.size(), 3u);
}

}  // namespace
}  // namespace patina
