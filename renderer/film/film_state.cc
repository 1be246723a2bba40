// SPDX-License-Identifier: Apache-2.0
// The film's sums to a file and back.
#include <algorithm>
#include <cmath>

#include "renderer/film/film.h"

namespace patina {
namespace {

template <class T>
bool allFinite(const std::vector<T>& values) {
  return std::ranges::all_of(values, [](T v) { return std::isfinite(v); });
}

bool sound(const std::vector<PixelMoments>& moments) {
  return std::ranges::all_of(moments, [](const PixelMoments& m) {
    return std::isfinite(m.count) && m.count >= 0 && std::isfinite(m.mean) && std::isfinite(m.sumSquares);
  });
}

}  // namespace

void Film::saveTile(const FilmTile& tile, ByteWriter& to) const {
  to.put(tile.samples_), to.put(tile.refused_);
  to.putArray(std::span(tile.sums_));
  to.putArray(std::span(tile.nearest_));
  to.putArray(std::span(tile.moments_));
  to.put(uint64_t{tile.kept_.size()});
  to.putArray(std::span(tile.kept_));
}

bool Film::restoreTile(FilmTile& tile, ByteReader& from) const {
  std::uint64_t kept = 0;
  const bool read = from.get(tile.samples_) && from.get(tile.refused_) &&
                    from.getArray(std::span(tile.sums_)) && from.getArray(std::span(tile.nearest_)) &&
                    from.getArray(std::span(tile.moments_)) && from.get(kept) &&
                    from.getVector(tile.kept_, kept);
  const bool fits = kept == 0 || (settings_.adaptiveFrom > 0 && kept % (combine_.size() + 2) == 0);
  const auto isDepth = [](float v) { return v > -kFarDepth; };  // also refuses NaN
  return read && fits && allFinite(tile.sums_) && allFinite(tile.kept_) && sound(tile.moments_) &&
         std::ranges::all_of(tile.nearest_, isDepth);
}

void Film::save(ByteWriter& to) const {
  to.put(samples_), to.put(refused_);
  to.putArray(std::span(states_));
  to.putArray(std::span(sums_));
  to.putArray(std::span(moments_));
  for (const std::unique_ptr<FilmTile>& tile : waiting_)
    if (tile) saveTile(*tile, to);
}

bool Film::restore(ByteReader& from) {
  if (!(from.get(samples_) && from.get(refused_) && from.getArray(std::span(states_)) &&
        from.getArray(std::span(sums_)) && from.getArray(std::span(moments_))))
    return false;
  if (!allFinite(sums_) || !sound(moments_)) return false;
  for (std::size_t k = 0; k < states_.size(); ++k) {
    if (states_[k] > TileState::Merged) return false;
    if (states_[k] == TileState::Merged) ++mergedTiles_;
    if (states_[k] != TileState::Waiting) continue;
    waiting_[k] = std::make_unique<FilmTile>(begin(static_cast<int>(k)));
    if (!restoreTile(*waiting_[k], from)) return false;
  }
  return true;
}

}  // namespace patina
