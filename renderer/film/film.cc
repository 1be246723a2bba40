// SPDX-License-Identifier: Apache-2.0
// Samples into tiles, tiles into the film.
#include "renderer/film/film.h"

#include <algorithm>
#include <cmath>

#include "renderer/base/math.h"
#include "renderer/base/statistics.h"

namespace patina {

namespace {

STAT_COUNTER("Film/samples", sampleCounter);
STAT_COUNTER("Film/samples refused", refusedCounter);

constexpr int kLargestRaster = 1 << 16;             // pixels per side
constexpr std::uint64_t kLargestFilm = 1ull << 32;  // floats
constexpr int kLargestFilter = 64;                  // pixels
constexpr int kLargestBucket = 1024;                // pixels per side

int floorDivide(int a, int b) { return a >= 0 ? a / b : -((-a + b - 1) / b); }

// Pixels beyond a sample's own that it can count for on one axis.
int reachOf(float width) { return std::max(0, static_cast<int>(std::ceil(width / 2 - 0.5f))); }

PixelRect intersection(const PixelRect& a, const PixelRect& b) {
  return {std::max(a.x0, b.x0), std::max(a.y0, b.y0), std::min(a.x1, b.x1), std::min(a.y1, b.y1)};
}

std::size_t area(const PixelRect& r) {
  return r.empty() ? 0 : static_cast<std::size_t>(r.width()) * static_cast<std::size_t>(r.height());
}

std::size_t indexIn(const PixelRect& r, int x, int y) {
  return static_cast<std::size_t>(y - r.y0) * static_cast<std::size_t>(r.width()) +
         static_cast<std::size_t>(x - r.x0);
}

}  // namespace

PixelRect cropPixels(int width, int height, const std::array<float, 4>& crop) {
  // ceil(n * f) in single precision, as RI's C binding computes it, so that 640 * 0.1f is 64 and not 65.
  const auto edge = [](int n, float f) { return std::ceil(static_cast<float>(n) * f); };
  const auto clamped = [](float pixel, int n) {
    return static_cast<int>(std::clamp(pixel, 0.f, static_cast<float>(n - 1)));
  };
  return {clamped(edge(width, crop[0]), width), clamped(edge(height, crop[2]), height),
          clamped(edge(width, crop[1]) - 1, width) + 1, clamped(edge(height, crop[3]) - 1, height) + 1};
}

void PixelMoments::add(float value) {
  count += 1;
  const double delta = static_cast<double>(value) - mean;
  mean += delta / count;
  sumSquares += delta * (static_cast<double>(value) - mean);
}

float PixelMoments::meanVariance() const {
  return count < 2 ? std::numeric_limits<float>::infinity()
                   : static_cast<float>(sumSquares / (count * (count - 1)));
}

// ---- FilmTile

bool FilmTile::acceptable(std::span<const float> values) const {
  bool fine = true;
  for (std::size_t c = 0; c < combine_.size(); ++c) {
    const float v = values[c];
    fine &= combine_[c] == Combine::Filter ? std::abs(v) <= kLargestSample : v > -kFarDepth;
  }
  return fine;
}

bool FilmTile::addSample(double x, double y, std::span<const float> values) {
  if (!acceptable(values)) {
    ++refused_;
    return false;
  }
  ++samples_;
  const int px = std::clamp(static_cast<int>(std::floor(x)), samplePixels_.x0, samplePixels_.x1 - 1);
  const int py = std::clamp(static_cast<int>(std::floor(y)), samplePixels_.y0, samplePixels_.y1 - 1);
  if (keeps_) {
    kept_.push_back(static_cast<float>(x)), kept_.push_back(static_cast<float>(y));
    kept_.insert(kept_.end(), values.begin(), values.begin() + static_cast<std::ptrdiff_t>(combine_.size()));
  } else {
    splat(x, y, values, 1);
  }
  if (pixels_.contains(px, py)) {
    float* nearest = &nearest_[indexIn(pixels_, px, py) * combine_.size()];
    for (std::size_t c = 0; c < combine_.size(); ++c) nearest[c] = std::min(nearest[c], values[c]);
  }
  if (!moments_.empty())
    moments_[indexIn(samplePixels_, px, py)].add(luminance({values[0], values[1], values[2]}));
  return true;
}

// Adds the samples that were kept, each by its share of those of its pixel.
void FilmTile::settle() {
  const std::size_t stride = combine_.size() + 2;
  for (std::size_t k = 0; k < kept_.size(); k += stride) {
    const float x = kept_[k], y = kept_[k + 1];
    const int px = std::clamp(static_cast<int>(std::floor(x)), samplePixels_.x0, samplePixels_.x1 - 1);
    const int py = std::clamp(static_cast<int>(std::floor(y)), samplePixels_.y0, samplePixels_.y1 - 1);
    splat(static_cast<double>(x), static_cast<double>(y), std::span(kept_).subspan(k + 2, combine_.size()),
          1 / moments(px, py).count);
  }
  kept_ = {};
}

bool FilmTile::wants(int x, int y) const {
  return wanting_.empty() || wanting_[indexIn(samplePixels_, x, y)] != 0;
}

int FilmTile::keepWanting(float bound, float white) {
  const PixelRect& all = samplePixels_;
  const auto isAbove = [&](int x, int y) {
    const PixelMoments& m = moments(x, y);
    const float times = std::max(1.f, static_cast<float>(m.mean) / white);
    return m.meanVariance() > bound * times * times;
  };
  std::vector<std::uint8_t> still(area(all));
  for (int y = all.y0; y < all.y1; ++y)
    for (int x = all.x0; x < all.x1; ++x) {
      if (!isAbove(x, y)) continue;
      for (int j = std::max(y - 1, all.y0); j <= std::min(y + 1, all.y1 - 1); ++j)
        for (int i = std::max(x - 1, all.x0); i <= std::min(x + 1, all.x1 - 1); ++i)
          still[indexIn(all, i, j)] = wants(i, j);
    }
  wanting_ = std::move(still);
  return static_cast<int>(std::count(wanting_.begin(), wanting_.end(), 1));
}

// Adds the sample to every pixel whose filter support holds it.
void FilmTile::splat(double x, double y, std::span<const float> values, double scale) {
  const auto first = [](double at, double width) {
    return static_cast<int>(std::floor(at - width / 2 - 0.5)) + 1;
  };
  const auto last = [](double at, double width) {
    return static_cast<int>(std::floor(at + width / 2 - 0.5));
  };
  const double xWidth = static_cast<double>(filter_.xWidth), yWidth = static_cast<double>(filter_.yWidth);
  const int x0 = std::max(first(x, xWidth), pixels_.x0), x1 = std::min(last(x, xWidth), pixels_.x1 - 1);
  const int y0 = std::max(first(y, yWidth), pixels_.y0), y1 = std::min(last(y, yWidth), pixels_.y1 - 1);
  if (x0 > x1) return;
  const bool separable = filter_.separable();
  std::array<float, kLargestFilter + 1> columns;
  for (int i = x0; separable && i <= x1; ++i)
    columns[static_cast<std::size_t>(i - x0)] =
        filter_.axisWeight(static_cast<float>(x - i - 0.5), filter_.xWidth);

  const std::size_t channels = combine_.size();
  for (int j = y0; j <= y1; ++j) {
    const auto dy = static_cast<float>(y - j - 0.5);
    const float row = separable ? filter_.axisWeight(dy, filter_.yWidth) : 0.f;
    double* sums = &sums_[indexIn(pixels_, x0, j) * (channels + 1)];
    for (int i = x0; i <= x1; ++i, sums += channels + 1) {
      const float weight = separable ? row * columns[static_cast<std::size_t>(i - x0)]
                                     : filter_.weight(static_cast<float>(x - i - 0.5), dy);
      const auto w = scale * static_cast<double>(weight);
      for (std::size_t c = 0; c < channels; ++c) sums[c] += w * static_cast<double>(values[c]);
      sums[channels] += w;
    }
  }
}

const PixelMoments& FilmTile::moments(int x, int y) const {
  static const PixelMoments none;
  return moments_.empty() ? none : moments_[indexIn(samplePixels_, x, y)];
}

// ---- Film

std::string Film::problem(const FilmSettings& s) {
  if (s.width < 1 || s.height < 1 || s.width > kLargestRaster || s.height > kLargestRaster)
    return "a picture must have 1 to " + std::to_string(kLargestRaster) + " pixels per side";
  for (const float f : s.crop)
    if (!(f >= 0 && f <= 1)) return "the crop window's edges must lie in 0..1";
  const PixelRect pixels = cropPixels(s.width, s.height, s.crop);
  if (pixels.empty()) return "the crop window holds no pixel";
  if (!(s.filter.xWidth > 0 && s.filter.xWidth <= static_cast<float>(kLargestFilter) && s.filter.yWidth > 0 &&
        s.filter.yWidth <= static_cast<float>(kLargestFilter)))
    return "a pixel filter's width must be more than 0 and at most 64 pixels";
  if (s.bucketWidth < 1 || s.bucketHeight < 1 || s.bucketWidth > kLargestBucket ||
      s.bucketHeight > kLargestBucket)
    return "a bucket must have 1 to " + std::to_string(kLargestBucket) + " pixels per side";
  if (s.channels.empty() || ((s.variance || s.adaptiveFrom > 0) && s.channels.size() < 3))
    return "the film has too few channels";
  if (area(pixels) * (s.channels.size() + 1) > kLargestFilm)
    return "the picture's channels would take more than 16 GB";
  return {};
}

Film::Film(FilmSettings settings)
    : settings_(std::move(settings)), pixels_(cropPixels(settings_.width, settings_.height, settings_.crop)) {
  for (const FilmChannel& channel : settings_.channels) combine_.push_back(channel.combine);
  const PixelFilter& filter = settings_.filter;
  const int reachX = reachOf(filter.xWidth), reachY = reachOf(filter.yWidth);
  const int bucketX = settings_.bucketWidth, bucketY = settings_.bucketHeight;
  samplePixels_ = reach(pixels_);

  firstTileX_ = floorDivide(samplePixels_.x0, bucketX);
  firstTileY_ = floorDivide(samplePixels_.y0, bucketY);
  tilesX_ = floorDivide(samplePixels_.x1 - 1, bucketX) - firstTileX_ + 1;
  tilesY_ = floorDivide(samplePixels_.y1 - 1, bucketY) - firstTileY_ + 1;
  neighbourReachX_ = (2 * reachX + bucketX - 1) / bucketX;
  neighbourReachY_ = (2 * reachY + bucketY - 1) / bucketY;
  colourPeriodX_ = neighbourReachX_ + 1;
  colourPeriodY_ = neighbourReachY_ + 1;

  const std::size_t tiles = static_cast<std::size_t>(tilesX_) * static_cast<std::size_t>(tilesY_);
  states_.assign(tiles, TileState::Open);
  waiting_.resize(tiles);
  sums_.assign(area(pixels_) * (settings_.channels.size() + 1), 0.f);
  for (std::size_t c = 0; c < settings_.channels.size(); ++c)
    if (settings_.channels[c].combine == Combine::Nearest)
      for (std::size_t i = c; i < sums_.size(); i += settings_.channels.size() + 1) sums_[i] = kFarDepth;
  if (settings_.variance || settings_.adaptiveFrom > 0) moments_.resize(area(pixels_));
}

PixelRect Film::reach(const PixelRect& r) const {
  const int x = reachOf(settings_.filter.xWidth), y = reachOf(settings_.filter.yWidth);
  return {r.x0 - x, r.y0 - y, r.x1 + x, r.y1 + y};
}

PixelRect Film::tileSamplePixels(int index) const {
  const int x = (firstTileX_ + index % tilesX_) * settings_.bucketWidth;
  const int y = (firstTileY_ + index / tilesX_) * settings_.bucketHeight;
  return intersection({x, y, x + settings_.bucketWidth, y + settings_.bucketHeight}, samplePixels_);
}

FilmTile Film::begin(int index) const {
  FilmTile tile;
  tile.index_ = index;
  tile.filter_ = settings_.filter;
  tile.combine_ = combine_;
  tile.samplePixels_ = tileSamplePixels(index);
  tile.pixels_ = intersection(reach(tile.samplePixels_), pixels_);
  tile.sums_.assign(area(tile.pixels_) * (settings_.channels.size() + 1), 0.);
  tile.nearest_.assign(area(tile.pixels_) * settings_.channels.size(), kFarDepth);
  if (!moments_.empty()) tile.moments_.resize(area(tile.samplePixels_));
  tile.keeps_ = settings_.adaptiveFrom > 0;
  return tile;
}

std::uint64_t Film::openBytes() const {
  // The tiles are a grid: their pixels are the product of what its columns and its rows have.
  std::uint64_t columns = 0, rows = 0;
  const auto pixelsOf = [&](int index) { return intersection(reach(tileSamplePixels(index)), pixels_); };
  for (int x = 0; x < tilesX_; ++x) columns += static_cast<std::uint64_t>(pixelsOf(x).width());
  for (int y = 0; y < tilesY_; ++y) rows += static_cast<std::uint64_t>(pixelsOf(y * tilesX_).height());
  const std::size_t channels = settings_.channels.size();
  const std::uint64_t kept = area(samplePixels_) * static_cast<std::uint64_t>(settings_.adaptiveFrom);
  return columns * rows * ((channels + 1) * sizeof(double) + channels * sizeof(float)) +
         kept * (channels + 2) * sizeof(float);
}

// The colour is taken from the raster's tile grid, not the crop window's, so that a crop adds in the same
// order.
int Film::colour(int index) const {
  const auto wrapped = [](int a, int period) { return a - floorDivide(a, period) * period; };
  return wrapped(firstTileY_ + index / tilesX_, colourPeriodY_) * colourPeriodX_ +
         wrapped(firstTileX_ + index % tilesX_, colourPeriodX_);
}

// Calls visit(tile) for each other tile whose pixels may overlap this one's.
template <class Visit>
void Film::forEachNeighbour(int index, Visit visit) const {
  const int x = index % tilesX_, y = index / tilesX_;
  for (int j = std::max(0, y - neighbourReachY_); j <= std::min(tilesY_ - 1, y + neighbourReachY_); ++j)
    for (int i = std::max(0, x - neighbourReachX_); i <= std::min(tilesX_ - 1, x + neighbourReachX_); ++i)
      if (i != x || j != y) visit(j * tilesX_ + i);
}

bool Film::mayMerge(int index) const {
  bool ready = true;
  const int own = colour(index);
  forEachNeighbour(index, [&](int other) {
    if (colour(other) < own && states_[static_cast<std::size_t>(other)] != TileState::Merged) ready = false;
  });
  return ready;
}

void Film::finish(FilmTile&& tile) {
  tile.settle();
  const std::lock_guard lock(mutex_);
  const auto at = static_cast<std::size_t>(tile.index_);
  if (states_[at] != TileState::Open) return;
  states_[at] = TileState::Waiting;
  waiting_[at] = std::make_unique<FilmTile>(std::move(tile));

  // Merging a tile may free its neighbours, and those theirs.
  std::vector<int> candidates = {static_cast<int>(at)};
  while (!candidates.empty()) {
    const int index = candidates.back();
    candidates.pop_back();
    const auto i = static_cast<std::size_t>(index);
    if (states_[i] != TileState::Waiting || !mayMerge(index)) continue;
    merge(index);
    forEachNeighbour(index, [&](int other) { candidates.push_back(other); });
  }
}

void Film::flush() {
  const std::lock_guard lock(mutex_);
  for (int index = 0; index < tileCount(); ++index)
    if (states_[static_cast<std::size_t>(index)] == TileState::Waiting) merge(index);
}

void Film::merge(int index) {
  const auto at = static_cast<std::size_t>(index);
  const std::unique_ptr<FilmTile> owned = std::move(waiting_[at]);
  states_[at] = TileState::Merged;
  ++mergedTiles_;
  add(*owned);
  sampleCounter += static_cast<std::int64_t>(owned->samples_);
  refusedCounter += static_cast<std::int64_t>(owned->refused_);
}

void Film::add(const FilmTile& tile) {
  const std::size_t channels = settings_.channels.size();
  for (int y = tile.pixels_.y0; y < tile.pixels_.y1; ++y)
    for (int x = tile.pixels_.x0; x < tile.pixels_.x1; ++x) {
      const std::size_t from = indexIn(tile.pixels_, x, y);
      const double* sums = &tile.sums_[from * (channels + 1)];
      float* to = &sums_[pixelOffset(x, y)];
      for (std::size_t c = 0; c < channels; ++c) {
        if (settings_.channels[c].combine == Combine::Nearest)
          to[c] = std::min(to[c], tile.nearest_[from * channels + c]);
        else
          to[c] += static_cast<float>(sums[c]);
      }
      to[channels] += static_cast<float>(sums[channels]);
    }
  if (!moments_.empty()) {
    const PixelRect own = intersection(tile.samplePixels_, pixels_);
    for (int y = own.y0; y < own.y1; ++y)
      for (int x = own.x0; x < own.x1; ++x) moments_[indexIn(pixels_, x, y)] = tile.moments(x, y);
  }
  samples_ += tile.samples_;
  refused_ += tile.refused_;
}

std::unique_ptr<Film> Film::preview(std::span<const FilmTile* const> tiles) const {
  auto film = std::make_unique<Film>(settings_);
  std::vector<const FilmTile*> ordered(tiles.begin(), tiles.end());
  // Tiles of one colour do not overlap, and so need no order.
  std::ranges::stable_sort(ordered, {}, [&](const FilmTile* tile) { return colour(tile->index_); });
  for (const FilmTile* tile : ordered) {
    if (tile->kept_.empty()) {
      film->add(*tile);
    } else {
      FilmTile settled = *tile;
      settled.settle();
      film->add(settled);
    }
  }
  return film;
}

std::unique_ptr<Film> Film::snapshot() const {
  auto film = std::make_unique<Film>(settings_);
  const std::lock_guard lock(mutex_);
  film->sums_ = sums_, film->moments_ = moments_, film->states_ = states_;
  film->mergedTiles_ = mergedTiles_, film->samples_ = samples_, film->refused_ = refused_;
  for (std::size_t k = 0; k < waiting_.size(); ++k) {
    if (!waiting_[k]) continue;
    film->add(*waiting_[k]);
    film->states_[k] = TileState::Merged, ++film->mergedTiles_;
  }
  return film;
}

std::size_t Film::pixelOffset(int x, int y) const {
  return indexIn(pixels_, x, y) * (settings_.channels.size() + 1);
}

int Film::channelIndex(std::string_view name) const {
  for (std::size_t c = 0; c < settings_.channels.size(); ++c)
    if (settings_.channels[c].name == name) return static_cast<int>(c);
  return -1;
}

float Film::value(int x, int y, int channel) const {
  const auto c = static_cast<std::size_t>(channel);
  const float* sums = &sums_[pixelOffset(x, y)];
  if (settings_.channels[c].combine == Combine::Nearest) return sums[c];
  // A filter with negative lobes can leave a pixel of few samples without weight: then there is nothing to
  // divide.
  const float weight = sums[settings_.channels.size()];
  return weight > 1e-6f ? sums[c] / weight : 0.f;
}

float Film::meanVariance(int x, int y) const {
  return moments_.empty() ? std::numeric_limits<float>::infinity()
                          : moments_[indexIn(pixels_, x, y)].meanVariance();
}

}  // namespace patina
