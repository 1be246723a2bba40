// SPDX-License-Identifier: Apache-2.0
// The vector whose elements stay where they are.
#include <gtest/gtest.h>

#include <atomic>
#include <string>
#include <thread>

#include "renderer/base/stable_vector.h"

namespace patina {
namespace {

TEST(StableVector, ElementsStayWhereTheyAre) {
  StableVector<std::string> v;
  v.makeRoom();
  v.push_back("a text that is too long to be kept within the object");
  const std::string* const first = &v[0];
  for (int k = 1; k < 200000; ++k) v.push_back(std::to_string(k));
  EXPECT_EQ(&v[0], first);
  EXPECT_EQ(v.size(), 200000u);
  EXPECT_EQ(v[0].substr(0, 6), "a text");
  EXPECT_EQ(v[199999], "199999");
}

TEST(StableVector, WithoutRoomItMovesThem) {
  StableVector<std::string> v;
  for (int k = 0; k < 200000; ++k) v.push_back(std::to_string(k) + " is a text that is rather long");
  for (size_t k = 0; k < v.size(); ++k) ASSERT_EQ(v[k], std::to_string(k) + " is a text that is rather long");
}

TEST(StableVector, WhatCannotMoveComesAtOnce) {
  StableVector<std::atomic<int>> v;
  v.growTo(100000);
  EXPECT_EQ(v[99999], 0);
  EXPECT_THROW(v.growTo(10'000'000), std::length_error);
}

TEST(StableVector, IsReadWhileItGrows) {
  StableVector<size_t> v;
  v.makeRoom();
  std::atomic<size_t> known = 0;
  std::thread reader([&] {
    for (size_t n = 0; n < 300000;) {
      n = known.load(std::memory_order_acquire);
      for (size_t k = n > 100 ? n - 100 : 0; k < n; ++k) ASSERT_EQ(v[k], k * k);
    }
  });
  for (size_t k = 0; k < 300000; ++k) v.push_back(k * k), known.store(k + 1, std::memory_order_release);
  reader.join();
}

}  // namespace
}  // namespace patina
