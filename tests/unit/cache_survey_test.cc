// SPDX-License-Identifier: Apache-2.0
#include "renderer/cache/cache_survey.h"

#include <gtest/gtest.h>

#include <thread>

namespace patina {
namespace {

/// Of `keys` entries of 25 values all are made, some by two threads; each third a second time; of each 4 are
/// asked for.
CacheSurvey::Totals surveyOf(uint64_t keys) {
  CacheSurvey survey;
  const auto work = [&](uint64_t first) {
    for (uint64_t key = first; key < keys; key += 2) {
      survey.made(key, (1u << 25) - 1);
      if (key % 3 == 0) survey.made(key, (1u << 25) - 1);
      survey.asked(key, 0b11000011u);
      survey.asked(key ^ 1u, 0b11u);  // seen by the other thread's part
    }
  };
  std::thread one(work, 0), two(work, 1);
  one.join(), two.join();
  return survey.totals();
}

TEST(CacheSurvey, EstimatesWhatIsMadeAgainAndWhatIsWasted) {
  // One key of 64 is watched: of 100 000 about 1560, and with too many keys for that 2^15 or half of it.
  for (const uint64_t keys : {uint64_t{100'000}, uint64_t{8'000'000}}) {
    const CacheSurvey::Totals totals = surveyOf(keys);
    const auto n = static_cast<double>(keys);
    EXPECT_NEAR(totals.made / (n * 25 * 4 / 3), 1, 0.1) << keys;
    EXPECT_NEAR(totals.again / (n * 25 / 3), 1, 0.2) << keys;
    EXPECT_NEAR(totals.unwanted / (n * 21), 1, 0.1) << keys;
    EXPECT_NEAR(totals.unwanted / totals.made, 21.0 / 25 / 4 * 3, 0.02) << keys;
  }
}

TEST(CacheSurvey, NothingIsMadeOfNothing) {
  const CacheSurvey survey;
  EXPECT_EQ(survey.totals().made, 0);
  EXPECT_EQ(survey.totals().unwanted, 0);
}

}  // namespace
}  // namespace patina
