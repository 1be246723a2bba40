// SPDX-License-Identifier: Apache-2.0
// What becomes of the values that a cache is filled with: how many are made again, and how many nobody asks
// for. Watched for a part of the keys only, chosen by their hash, so that it costs next to nothing; the part
// is halved whenever a thread watches too many (Flajolet 1990, "On adaptive sampling").
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <vector>

#include "renderer/base/sampling.h"

namespace patina {

/// A thread that works for two of them by turns costs both memory: one at a time is meant.
class CacheSurvey {
 public:
  CacheSurvey();

  /// Values of an entry, as a set of up to 32, are looked up. `key` names the entry.
  /// [any thread; a lock at a thread's first call only]
  void asked(uint64_t key, uint32_t values) {
    const uint64_t hash = hashOf(key);
    if (hash >> (64 - kLeastShift) == 0) note(hash, 0, values);
  }
  /// ... are made, and stored. [likewise]
  void made(uint64_t key, uint32_t values) {
    const uint64_t hash = hashOf(key);
    if (hash >> (64 - kLeastShift) == 0) note(hash, values, 0);
  }

  /// Estimates for all keys.
  struct Totals {
    double made = 0;      ///< values, each as often as it was
    double again = 0;     ///< those of them that had been made before
    double unwanted = 0;  ///< different values that were made and never asked for
  };
  Totals totals() const;  ///< [no other thread at work]

 private:
  static constexpr int kLeastShift = 6;            // one key of 64
  static constexpr size_t kMostWatched = 1 << 15;  // by one thread
  struct Watched {
    uint32_t made = 0, asked = 0;  // sets
    uint64_t count = 0;            // of values made
  };
  /// One thread's.
  struct Part {
    int shift = kLeastShift;
    std::unordered_map<uint64_t, Watched> watched;  // by hash, of which the upper `shift` bits are 0
  };
  static void narrow(Part& part);
  void note(uint64_t hash, uint32_t made, uint32_t asked);

  const uint64_t id_;  // no other survey of the process has it
  mutable std::mutex mutex_;
  std::vector<std::unique_ptr<Part>> parts_;
};

}  // namespace patina
