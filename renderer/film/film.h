// SPDX-License-Identifier: Apache-2.0
// The film: samples in, filtered pixels out, the same bits for any number of threads and any order of
// buckets.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "renderer/film/byte_stream.h"
#include "renderer/film/filter.h"

namespace patina {

// Half-open rectangle of pixels: x0 <= x < x1, y0 <= y < y1; y grows downwards.
struct PixelRect {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;

  int width() const { return x1 - x0; }
  int height() const { return y1 - y0; }
  bool empty() const { return x1 <= x0 || y1 <= y0; }
  bool contains(int x, int y) const { return x >= x0 && x < x1 && y >= y0 && y < y1; }
  bool operator==(const PixelRect&) const = default;
};

// RI's crop rule (RI 3.2, CropWindow): `crop` is xmin xmax ymin ymax as fractions of the raster. Windows that
// share an edge share no pixel and leave none out. The result may be empty.
PixelRect cropPixels(int width, int height, const std::array<float, 4>& crop);

// How the samples of a pixel become its value.
enum class Combine : std::uint8_t {
  Filter,  // weighted mean under the pixel filter
  Nearest  // least value among the samples that lie within the pixel itself: depth
};

struct FilmChannel {
  std::string name;
  Combine combine = Combine::Filter;
};

// Depth of a sample that hit nothing (RI_INFINITY), and of a pixel without samples.
inline constexpr float kFarDepth = 1e38f;
// A filtered sample value beyond this is refused as absurd: sums of such values would overflow.
inline constexpr float kLargestSample = 1e20f;

struct FilmSettings {
  int width = 640;  // full raster, before cropping
  int height = 480;
  std::array<float, 4> crop = {0, 1, 0, 1};  // xmin xmax ymin ymax
  PixelFilter filter;
  std::vector<FilmChannel> channels = {{"r"}, {"g"}, {"b"}, {"a"}, {"z", Combine::Nearest}};
  int bucketWidth = 16;  // pixels
  int bucketHeight = 16;
  bool variance = false;  // keep moments of the luminance of channels 0..2 per pixel
  // Above 0: pixels have that many samples or more, each another number. Whatever that is, a pixel's samples
  // weigh together as much as another's, so that filters see none of it; moments are kept. Tiles keep their
  // samples until they are finished.
  int adaptiveFrom = 0;
};

// Running mean and spread of one pixel's own, unfiltered samples (Welford). Doubles: floats stop counting at
// 2^24 samples, after which a mean drifts to the last of them.
struct PixelMoments {
  double count = 0;
  double mean = 0;
  double sumSquares = 0;  // of deviations from the mean

  void add(float value);
  // Estimated variance of the mean of the samples; infinite below two samples.
  float meanVariance() const;
};

// The samples of one bucket, gathered by one thread and handed back with Film::finish().
class FilmTile {
 public:
  int index() const { return index_; }
  // Pixels whose samples this tile must be given. They may lie outside the raster (even at negative
  // coordinates) by the reach of the filter.
  const PixelRect& samplePixels() const { return samplePixels_; }

  // Adds one sample at raster position (x, y); pixel (i, j) covers [i, i+1) x [j, j+1), and the sample must
  // lie in one of samplePixels(). `values` holds one float per film channel, colours premultiplied by alpha.
  // Returns false, and changes nothing but the count of refusals, if any value is NaN, infinite or beyond
  // kLargestSample (depth: negative infinity or NaN): the caller reports it and may add a replacement.
  // The order of the calls must depend on the tile only, never on time or threads.
  bool addSample(double x, double y, std::span<const float> values);

  // Moments of a pixel of samplePixels(); all zero unless FilmSettings::variance or adaptiveFrom.
  const PixelMoments& moments(int x, int y) const;

  // Whether a pixel of samplePixels() wants more samples. All do until keepWanting() says otherwise.
  bool wants(int x, int y) const;
  // Of the pixels that want samples, those still do whose mean has a variance above `bound`, or that have
  // such a pixel among the eight around them in this tile: what one has missed the next may have met. Of
  // pixels brighter than `white` the variance counts relative to the mean: bound * (mean / white)^2. Returns
  // how many do.
  int keepWanting(float bound, float white);

 private:
  friend class Film;
  bool acceptable(std::span<const float> values) const;
  void splat(double x, double y, std::span<const float> values, double scale);
  void settle();

  int index_ = 0;
  PixelFilter filter_;
  PixelRect samplePixels_;
  PixelRect pixels_;                   // the pixels within the filter's reach, inside the crop window
  std::span<const Combine> combine_;   // per channel
  std::vector<double> sums_;           // per pixel: the channels' weighted sums, then the weight
  std::vector<float> nearest_;         // per pixel: the channels' least values (only those that combine so)
  std::vector<PixelMoments> moments_;  // per sample pixel, or empty
  bool keeps_ = false;                 // samples, until settle()
  std::vector<float> kept_;            // x, y and the channels' values, sample after sample
  std::vector<std::uint8_t> wanting_;  // per sample pixel; empty: all
  std::uint64_t samples_ = 0;
  std::uint64_t refused_ = 0;
};

// The picture. begin() and finish() may be called from any thread; the rest only while no tile is being
// finished.
//
// Buckets are cut from the raster at multiples of their size, so a cropped picture has the bits of the same
// part of the full one. Where the reach of several buckets overlaps, their sums are added in the order of the
// buckets' colours in a k x k pattern in which buckets of one colour never overlap: a bucket waits for at
// most k*k-1 generations of neighbours, so few are kept waiting, and the order never depends on time.
class Film {
 public:
  // Why a film cannot be made from these settings, in words for a user; empty if it can.
  static std::string problem(const FilmSettings& settings);
  // The settings must have no problem().
  explicit Film(FilmSettings settings);

  const FilmSettings& settings() const { return settings_; }
  // The pixels of the picture: the crop window.
  const PixelRect& pixels() const { return pixels_; }

  int tileCount() const { return static_cast<int>(states_.size()); }
  // An empty tile; any tile may be begun at any time, and must be finished once.
  FilmTile begin(int index) const;
  void finish(FilmTile&& tile);
  // Merges tiles that wait for others which will not come: the end of an interrupted render.
  void flush();
  // The picture that finishing these tiles now would make, which may be given more samples after it: tiles of
  // this film, each once, in any order. [while no other thread changes them]
  std::unique_ptr<Film> preview(std::span<const FilmTile* const> tiles) const;
  // What is finished by now, while others go on finishing tiles: with those merged that wait for neighbours.
  // [any thread]
  std::unique_ptr<Film> snapshot() const;
  // Everything that tiles have been finished with, to the bit: a film of the same settings that restores it
  // goes on as this one would. restore() is for a film without tiles, and refuses what no such film can have
  // saved, also values that are not finite: the film is of no use then. [while no other thread changes them]
  void save(ByteWriter& to) const;
  bool restore(ByteReader& from);
  // Likewise a tile that is to be given more samples.
  void saveTile(const FilmTile& tile, ByteWriter& to) const;
  bool restoreTile(FilmTile& tile, ByteReader& from) const;  // `tile`: as begin() gives it
  // Whether a tile is still to be finished.
  bool isOpen(int index) const { return states_[static_cast<std::size_t>(index)] == TileState::Open; }
  // Memory that all tiles take when they are open at the same time.
  std::uint64_t openBytes() const;
  // Whether every tile has been finished.
  bool complete() const { return mergedTiles_ == tileCount(); }

  int channelCount() const { return static_cast<int>(settings_.channels.size()); }
  // -1 if there is no such channel.
  int channelIndex(std::string_view name) const;
  // Final value of a pixel of pixels(); 0 (kFarDepth for nearest) where there is no sample.
  float value(int x, int y, int channel) const;
  // Variance of the mean luminance of the pixel's own samples; see FilmSettings::variance.
  float meanVariance(int x, int y) const;

  std::uint64_t sampleCount() const { return samples_; }
  std::uint64_t refusedCount() const { return refused_; }

 private:
  enum class TileState : std::uint8_t { Open, Waiting, Merged };

  PixelRect tileSamplePixels(int index) const;
  PixelRect reach(const PixelRect& samplePixels) const;
  int colour(int index) const;
  template <class Visit>
  void forEachNeighbour(int index, Visit visit) const;
  bool mayMerge(int index) const;
  void merge(int index);
  void add(const FilmTile& tile);
  std::size_t pixelOffset(int x, int y) const;

  FilmSettings settings_;
  std::vector<Combine> combine_;  // per channel
  PixelRect pixels_;
  PixelRect samplePixels_;  // pixels_ widened by the filter's reach
  int tilesX_ = 0, tilesY_ = 0, firstTileX_ = 0, firstTileY_ = 0;
  int colourPeriodX_ = 1, colourPeriodY_ = 1;
  int neighbourReachX_ = 0, neighbourReachY_ = 0;  // tiles

  std::vector<float> sums_;  // per pixel: the channels' sums (least value for nearest), then the weight
  std::vector<PixelMoments> moments_;

  mutable std::mutex mutex_;  // guards what follows, sums_ and moments_
  std::vector<TileState> states_;
  std::vector<std::unique_ptr<FilmTile>> waiting_;
  int mergedTiles_ = 0;
  std::uint64_t samples_ = 0;
  std::uint64_t refused_ = 0;
};

}  // namespace patina
