// SPDX-License-Identifier: Apache-2.0
#include "renderer/cache/cache_survey.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>

namespace patina {
namespace {

uint64_t newId() {
  static std::atomic<uint64_t> last = 0;
  return ++last;
}

}  // namespace

CacheSurvey::CacheSurvey() : id_(newId()) {}

void CacheSurvey::narrow(Part& part) {
  std::erase_if(part.watched, [&](const auto& entry) { return entry.first >> (64 - part.shift) != 0; });
}

void CacheSurvey::note(uint64_t hash, uint32_t made, uint32_t asked) {
  thread_local uint64_t owner = 0;
  thread_local Part* part = nullptr;
  if (owner != id_) {
    const std::scoped_lock lock(mutex_);
    part = parts_.emplace_back(std::make_unique<Part>()).get();
    owner = id_;
  }
  if (hash >> (64 - part->shift) != 0) return;
  Watched& watched = part->watched[hash];
  watched.made |= made, watched.asked |= asked;
  watched.count += static_cast<uint64_t>(std::popcount(made));
  if (part->watched.size() > kMostWatched && part->shift < 60) ++part->shift, narrow(*part);
}

CacheSurvey::Totals CacheSurvey::totals() const {
  const std::scoped_lock lock(mutex_);
  Part all;
  for (const auto& part : parts_) all.shift = std::max(all.shift, part->shift);
  for (const auto& part : parts_)
    for (const auto& [hash, of] : part->watched) {
      Watched& watched = all.watched[hash];
      watched.made |= of.made, watched.asked |= of.asked, watched.count += of.count;
    }
  narrow(all);
  Totals totals;
  for (const auto& [hash, of] : all.watched) {
    const int different = std::popcount(of.made);
    totals.made += static_cast<double>(of.count);
    totals.again += static_cast<double>(of.count) - different;
    totals.unwanted += std::popcount(of.made & ~of.asked);
  }
  const double scale = std::ldexp(1.0, all.shift);
  return {totals.made * scale, totals.again * scale, totals.unwanted * scale};
}

}  // namespace patina
