// SPDX-License-Identifier: Apache-2.0
// The multiresolution cache: codes, budget, eviction, and readers against writers.
#include "renderer/cache/patch_cache.h"

#include <gtest/gtest.h>

#include <random>
#include <thread>

namespace patina {
namespace {

TEST(PackedRgb, KeepsEveryComponentWithinFourMillionthsOfTheLargest) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> exponent(-12, 12), mantissa(0, 1);
  for (int k = 0; k < 100000; ++k) {
    const float scale = std::pow(10.0f, exponent(random));
    const Rgb c(mantissa(random) * scale, mantissa(random) * scale, mantissa(random) * scale);
    const Rgb back = PackedRgb::unpack(PackedRgb::pack(c));
    for (int i = 0; i < 3; ++i) ASSERT_NEAR(back[i], c[i], maxComponent(c) * 4e-6f) << c;
  }
}

TEST(PackedRgb, ExtremesAndSpecialValues) {
  EXPECT_EQ(PackedRgb::unpack(PackedRgb::pack(Rgb(0, 0, 0))), Rgb(0, 0, 0));
  EXPECT_EQ(PackedRgb::unpack(PackedRgb::pack(Rgb(-1, 0, 0))), Rgb(0, 0, 0));
  EXPECT_EQ(PackedRgb::unpack(PackedRgb::pack(Rgb(1, 0.5f, 0.25f))), Rgb(1, 0.5f, 0.25f));
  for (const float value : {1e-30f, 1e-12f, 1e12f, 1e30f})
    EXPECT_NEAR(PackedRgb::unpack(PackedRgb::pack(Rgb(value, value / 2, 0))).x, value, value * 4e-6f);
  EXPECT_NE(PackedRgb::pack(Rgb(3e38f, 3e38f, 3e38f)), PackedRgb::kMissing);
}

/// The code that a key must have: a function of the key alone, as in the renderer.
uint64_t codeOf(const CacheKey& key, uint32_t vertex) {
  return PackedRgb::pack(Rgb(static_cast<float>(key.patch + 1), key.front ? 2.0f : 1.0f,
                             static_cast<float>(vertex + 17u * key.depth + 1)));
}

std::vector<uint64_t> codesOf(const CacheKey& key, uint32_t count) {
  std::vector<uint64_t> codes;
  for (uint32_t k = 0; k < count; ++k) codes.push_back(codeOf(key, k));
  return codes;
}

TEST(PatchCache, FindsWhatWasStoredAndNothingElse) {
  PatchCache cache(1 << 22);
  const CacheKey key{7, true, 2};
  const std::vector<uint32_t> which{0, 3, 24, 11};
  uint64_t codes[4];
  EXPECT_FALSE(cache.find(key, Level::Medium, which, codes));
  cache.store(key, Level::Medium, codesOf(key, 25));
  ASSERT_TRUE(cache.find(key, Level::Medium, which, codes));
  for (size_t k = 0; k < which.size(); ++k) EXPECT_EQ(codes[k], codeOf(key, which[k]));
  EXPECT_FALSE(cache.find({7, false, 2}, Level::Medium, which, codes));
  EXPECT_FALSE(cache.find({7, true, 3}, Level::Medium, which, codes));
  EXPECT_FALSE(cache.find({8, true, 2}, Level::Medium, which, codes));
  EXPECT_FALSE(cache.find(key, Level::Coarse, {which.data(), 2}, codes));
}

TEST(PatchCache, StoresInPartsWithoutLosingEarlierOnes) {
  PatchCache cache(1 << 22);
  const CacheKey key{3, false, 0};
  std::vector<uint64_t> first(kMaxBlockVertices, PackedRgb::kMissing), second = first;
  first[5] = codeOf(key, 5);
  second[20] = codeOf(key, 20);
  cache.store(key, Level::Fine, first);
  cache.store(key, Level::Fine, second);
  const std::vector<uint32_t> which{5, 20, 6};
  uint64_t codes[3];
  ASSERT_TRUE(cache.find(key, Level::Fine, which, codes));
  EXPECT_EQ(codes[0], codeOf(key, 5));
  EXPECT_EQ(codes[1], codeOf(key, 20));
  EXPECT_EQ(codes[2], PackedRgb::kMissing);
  EXPECT_EQ(cache.use(Level::Fine, 0).entries, 1u);
}

TEST(PatchCache, BlocksOfTheFineLevelAndTheMediumLevelAreKeptApart) {
  PatchCache cache(1 << 22);
  CacheKey key{12, true, 1};
  for (uint8_t block = 0; block < 16; ++block) {
    key.block = block;
    cache.store(key, Level::Fine, std::vector<uint64_t>(kMaxBlockVertices, 1000u + block));
  }
  cache.store(key, Level::Medium, std::vector<uint64_t>(kMaxBlockVertices, 7));
  const uint32_t vertex = 24;
  uint64_t code;
  for (uint8_t block = 0; block < 16; ++block) {
    key.block = block;
    ASSERT_TRUE(cache.find(key, Level::Fine, {&vertex, 1}, &code));
    EXPECT_EQ(code, 1000u + block);
  }
  key.block = 0;
  ASSERT_TRUE(cache.find(key, Level::Medium, {&vertex, 1}, &code));
  EXPECT_EQ(code, 7u);
  EXPECT_EQ(cache.use(Level::Fine, 1).entries, 16u);
  EXPECT_EQ(cache.use(Level::Medium, 1).entries, 1u);
}

TEST(PatchCache, NeverExceedsItsBudgetAndEvicts) {
  for (const size_t bytes : {size_t{0}, size_t{1000}, size_t{100'000}, size_t{1} << 20}) {
    PatchCache cache(bytes);
    EXPECT_LE(cache.capacity(), bytes);
    for (uint32_t patch = 0; patch < 5000; ++patch)
      cache.store({patch, true, 1}, Level::Coarse, codesOf({patch, true, 1}, 4));
    const PatchCache::Use use = cache.use(Level::Coarse, 1);
    EXPECT_LE(use.entries, cache.slots(Level::Coarse));
    EXPECT_LE(use.bytes, bytes);
    EXPECT_EQ(use.entries + use.evictions, cache.slots(Level::Coarse) == 0 ? 0u : 5000u);
    uint32_t found = 0;
    const uint32_t vertex = 1;
    uint64_t code;
    for (uint32_t patch = 0; patch < 5000; ++patch)
      if (cache.find({patch, true, 1}, Level::Coarse, {&vertex, 1}, &code)) {
        ++found;
        EXPECT_EQ(code, codeOf({patch, true, 1}, 1));
      }
    EXPECT_EQ(found, use.entries);
  }
}

TEST(PatchCache, ReadersNeverSeeAMixtureWhileWritersEvict) {
  PatchCache cache(64 << 10);  // a few hundred slots for 4000 keys
  std::atomic<bool> wrong{false};
  std::atomic<uint64_t> hits{0};
  const auto work = [&](unsigned seed) {
    std::mt19937 random(seed);
    for (int k = 0; k < 60000; ++k) {
      const CacheKey key{static_cast<uint32_t>(random() % 2000), random() % 2 == 0, 1};
      const std::vector<uint32_t> which{0, 1, 2, 3};
      uint64_t codes[4];
      if (cache.find(key, Level::Coarse, which, codes)) {
        ++hits;
        for (uint32_t v = 0; v < 4; ++v)
          if (codes[v] != codeOf(key, v)) wrong = true;
      } else {
        cache.store(key, Level::Coarse, codesOf(key, 4));
      }
    }
  };
  std::vector<std::thread> threads;
  for (unsigned t = 0; t < 4; ++t) threads.emplace_back(work, t);
  for (std::thread& thread : threads) thread.join();
  EXPECT_FALSE(wrong);
  EXPECT_GT(hits, 1000u);
}

}  // namespace
}  // namespace patina
