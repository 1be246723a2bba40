// SPDX-License-Identifier: Apache-2.0
// Opacity in 32 bits, and a table of such codes.
#include "renderer/cache/packed_opacity.h"

#include <gtest/gtest.h>

#include <limits>

#include "renderer/cache/patch_cache.h"

namespace patina {
namespace {

TEST(PackedOpacity, IsOffByLessThanAThousandth) {
  for (int k = 0; k <= 100000; ++k) {
    const float x = static_cast<float>(k) / 100000;
    const Rgb back = PackedOpacity::unpack(PackedOpacity::pack(Rgb(x, 1 - x, x * x)));
    // Half a step of 1/1023.
    ASSERT_NEAR(back.x, x, 0.5 / 1023 + 1e-6);
    ASSERT_NEAR(back.y, 1 - x, 0.5 / 1023 + 1e-6);
    ASSERT_NEAR(back.z, x * x, 0.5 / 1023 + 1e-6);
    ASSERT_NE(PackedOpacity::pack(Rgb(x, x, x)), PackedOpacity::kMissing);
  }
}

TEST(PackedOpacity, EndsAreExactAndNothingLiesBeyond) {
  EXPECT_EQ(PackedOpacity::unpack(PackedOpacity::pack(Rgb(0, 1, 0))), Rgb(0, 1, 0));
  EXPECT_EQ(PackedOpacity::unpack(PackedOpacity::pack(Rgb(-3, 1e30f, 1))), Rgb(0, 1, 1));
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  EXPECT_EQ(PackedOpacity::unpack(PackedOpacity::pack(Rgb(nan, inf, -inf))), Rgb(0, 1, 0));
}

TEST(PackedOpacity, TablesOfItHoldTwiceAsManyVerticesInTheSameBytes) {
  constexpr size_t kBytes = 100000;
  const PatchCacheOf<uint32_t> small(kBytes);
  const PatchCacheOf<uint64_t> large(kBytes);
  EXPECT_LE(small.capacity(), kBytes);
  // Tags are 8 bytes each: 4 + 2 bytes for each vertex, or 25 codes and a tag.
  EXPECT_EQ(small.bytesPerSlot(Level::Coarse), 8 + 4 * sizeof(uint32_t));
  EXPECT_EQ(small.bytesPerSlot(Level::Fine), 8 + 25 * sizeof(uint32_t));
  EXPECT_GT(small.slots(Level::Fine), large.slots(Level::Fine) * 19 / 10);

  PatchCacheOf<uint32_t> cache(kBytes);
  std::vector<uint32_t> codes;
  for (uint32_t k = 0; k < 25; ++k) codes.push_back(k * 7 + 1);
  cache.store({3, true, 1}, Level::Medium, codes);
  const std::array<uint32_t, 4> which{0, 24, 5, 11};
  std::array<uint32_t, 4> found{};
  ASSERT_TRUE(cache.find({3, true, 1}, Level::Medium, which, found.data()));
  for (size_t k = 0; k < 4; ++k) EXPECT_EQ(found[k], which[k] * 7 + 1);
  EXPECT_FALSE(cache.find({3, false, 1}, Level::Medium, which, found.data()));
}

}  // namespace
}  // namespace patina
