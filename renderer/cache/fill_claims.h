// SPDX-License-Identifier: Apache-2.0
// Which entries of a cache are being made, so that no two threads make the same one.
#pragma once

#include <array>
#include <cstdint>
#include <mutex>
#include <span>
#include <unordered_set>

namespace patina {

/// Claims on keys. Who has a claim makes the entry, stores it and gives the claim back; who has not looks
/// again later. Whoever waits must hold no claim that the owner may need.
class FillClaims {
 public:
  /// Whether the entry is the caller's to make now. [any thread]
  bool claim(uint64_t key) {
    Stripe& stripe = stripeOf(key);
    const std::scoped_lock lock(stripe.mutex);
    return stripe.keys.insert(key).second;
  }
  void giveBack(uint64_t key) {  ///< [any thread]
    Stripe& stripe = stripeOf(key);
    const std::scoped_lock lock(stripe.mutex);
    stripe.keys.erase(key);
  }

 private:
  static constexpr size_t kStripes = 256;
  struct alignas(64) Stripe {
    std::mutex mutex;
    std::unordered_set<uint64_t> keys;
  };
  Stripe& stripeOf(uint64_t key) { return stripes_[(key * 0x9e3779b97f4a7c15u) >> 56]; }

  std::array<Stripe, kStripes> stripes_;
};

}  // namespace patina
