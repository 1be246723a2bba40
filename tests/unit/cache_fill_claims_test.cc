// SPDX-License-Identifier: Apache-2.0
// Claims on entries that are being made.
#include "renderer/cache/fill_claims.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

namespace patina {
namespace {

TEST(FillClaims, AreOfOneAtATime) {
  FillClaims claims;
  EXPECT_TRUE(claims.claim(7));
  EXPECT_FALSE(claims.claim(7));
  EXPECT_TRUE(claims.claim(8));
  claims.giveBack(7);
  EXPECT_TRUE(claims.claim(7));
}

TEST(FillClaims, LetEachEntryBeMadeOnce) {
  constexpr uint64_t kKeys = 20000;
  FillClaims claims;
  std::vector<std::atomic<int>> made(kKeys), makers(kKeys);
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([&] {
      for (uint64_t key = 0; key < kKeys; ++key)
        while (made[key] == 0) {
          if (!claims.claim(key << 12)) continue;
          EXPECT_EQ(makers[key].fetch_add(1), 0);
          if (made[key] == 0) ++made[key];
          --makers[key];
          claims.giveBack(key << 12);
        }
    });
  for (std::thread& thread : threads) thread.join();
  for (uint64_t key = 0; key < kKeys; ++key) ASSERT_EQ(made[key], 1);
}

}  // namespace
}  // namespace patina
