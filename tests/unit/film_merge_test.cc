// SPDX-License-Identifier: Apache-2.0
// The film's invariants: same bits whatever the order of buckets, threads or crop; no NaN gets in.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <numeric>
#include <random>
#include <thread>

#include "renderer/film/film.h"

namespace patina {
namespace {

using Kind = PixelFilter::Kind;

// A value in [0, 1) that depends on its arguments only.
float noise(int x, int y, int sample, int channel) {
  const auto scaled = [](int n, std::uint32_t by) { return static_cast<std::uint32_t>(n) * by; };
  std::uint32_t h =
      scaled(x, 73856093) ^ scaled(y, 19349663) ^ scaled(sample, 83492791) ^ scaled(channel, 2654435);
  h = (h ^ (h >> 16)) * 0x7feb352du;
  h = (h ^ (h >> 15)) * 0x846ca68bu;
  return static_cast<float>((h ^ (h >> 16)) >> 8) * 0x1p-24f;
}

void renderTile(FilmTile& tile) {
  const PixelRect& r = tile.samplePixels();
  for (int y = r.y0; y < r.y1; ++y)
    for (int x = r.x0; x < r.x1; ++x)
      for (int s = 0; s < 3; ++s) {
        const std::array<float, 5> values = {noise(x, y, s, 0), noise(x, y, s, 1), 7 * noise(x, y, s, 2),
                                             noise(x, y, s, 3), 1 + noise(x, y, s, 4)};
        EXPECT_TRUE(tile.addSample(x + static_cast<double>(noise(x, y, s, 5)),
                                   y + static_cast<double>(noise(x, y, s, 6)), values));
      }
}

FilmSettings small(Kind kind, float xWidth, float yWidth) {
  FilmSettings s;
  s.width = 61;
  s.height = 43;
  s.filter = {kind, xWidth, yWidth};
  s.bucketWidth = 8;
  s.bucketHeight = 5;
  return s;
}

std::vector<std::uint32_t> bits(const Film& film, const PixelRect& r) {
  std::vector<std::uint32_t> result;
  for (int y = r.y0; y < r.y1; ++y)
    for (int x = r.x0; x < r.x1; ++x)
      for (int c = 0; c < film.channelCount(); ++c)
        result.push_back(std::bit_cast<std::uint32_t>(film.value(x, y, c)));
  return result;
}

std::vector<std::uint32_t> rendered(const FilmSettings& settings, std::vector<int> order) {
  Film film(settings);
  order.resize(static_cast<std::size_t>(film.tileCount()));
  for (const int index : order) {
    FilmTile tile = film.begin(index);
    renderTile(tile);
    film.finish(std::move(tile));
  }
  EXPECT_TRUE(film.complete());
  return bits(film, film.pixels());
}

std::vector<int> scanOrder(const FilmSettings& settings) {
  std::vector<int> order(static_cast<std::size_t>(Film(settings).tileCount()));
  std::iota(order.begin(), order.end(), 0);
  return order;
}

struct Case {
  Kind kind;
  float xWidth, yWidth;
};

class FilmOrder : public testing::TestWithParam<Case> {};

TEST_P(FilmOrder, AnyOrderOfBucketsGivesTheSameBits) {
  const FilmSettings settings = small(GetParam().kind, GetParam().xWidth, GetParam().yWidth);
  std::vector<int> order = scanOrder(settings);
  const auto reference = rendered(settings, order);
  std::mt19937 random(7);
  for (int i = 0; i < 8; ++i) {
    std::shuffle(order.begin(), order.end(), random);
    ASSERT_EQ(rendered(settings, order), reference);
  }
}

TEST_P(FilmOrder, ThreadsGiveTheSameBits) {
  const FilmSettings settings = small(GetParam().kind, GetParam().xWidth, GetParam().yWidth);
  const auto reference = rendered(settings, scanOrder(settings));
  Film film(settings);
  std::atomic<int> next{0};
  const auto work = [&] {
    for (int i = next++; i < film.tileCount(); i = next++) {
      FilmTile tile = film.begin(i);
      renderTile(tile);
      film.finish(std::move(tile));
    }
  };
  std::vector<std::jthread> threads;
  for (int i = 0; i < 4; ++i) threads.emplace_back(work);
  threads.clear();
  EXPECT_EQ(bits(film, film.pixels()), reference);
}

TEST_P(FilmOrder, ACropHasTheBitsOfTheWhole) {
  FilmSettings settings = small(GetParam().kind, GetParam().xWidth, GetParam().yWidth);
  Film whole(settings);
  for (int i = 0; i < whole.tileCount(); ++i) {
    FilmTile tile = whole.begin(i);
    renderTile(tile);
    whole.finish(std::move(tile));
  }
  settings.crop = {0.3f, 0.71f, 0.2f, 0.55f};
  const auto cropped = rendered(settings, scanOrder(settings));
  EXPECT_EQ(cropped, bits(whole, Film(settings).pixels()));
}

// One pixel's value straight from the definition: sum of weight times value over sum of weights.
TEST_P(FilmOrder, PixelsAreTheWeightedMeanOfAllSamplesInReach) {
  const FilmSettings settings = small(GetParam().kind, GetParam().xWidth, GetParam().yWidth);
  Film film(settings);
  for (int i = 0; i < film.tileCount(); ++i) {
    FilmTile tile = film.begin(i);
    renderTile(tile);
    film.finish(std::move(tile));
  }
  for (const auto& [px, py] : {std::pair{0, 0}, {7, 4}, {8, 5}, {15, 20}, {60, 42}, {31, 9}}) {
    double sum = 0, weights = 0, nearest = kFarDepth;
    for (int y = py - 12; y <= py + 12; ++y)
      for (int x = px - 12; x <= px + 12; ++x)
        for (int s = 0; s < 3; ++s) {
          const double dx = x + static_cast<double>(noise(x, y, s, 5)) - px - 0.5;
          const double dy = y + static_cast<double>(noise(x, y, s, 6)) - py - 0.5;
          const auto w = settings.filter.weight(static_cast<float>(dx), static_cast<float>(dy));
          sum += static_cast<double>(w) * static_cast<double>(noise(x, y, s, 0));
          weights += static_cast<double>(w);
          if (x == px && y == py) nearest = std::min(nearest, 1 + static_cast<double>(noise(x, y, s, 4)));
        }
    // A few single-precision roundings of the sums, magnified where negative lobes cancel.
    EXPECT_NEAR(film.value(px, py, 0), sum / weights, 2e-5) << px << " " << py;
    EXPECT_FLOAT_EQ(film.value(px, py, 4), static_cast<float>(nearest));
  }
}

INSTANTIATE_TEST_SUITE_P(Filters, FilmOrder,
                         testing::Values(Case{Kind::Box, 1, 1}, Case{Kind::Box, 2.5f, 3},
                                         Case{Kind::Triangle, 2, 2}, Case{Kind::CatmullRom, 4, 4},
                                         Case{Kind::Sinc, 9, 8}, Case{Kind::Gaussian, 2, 2},
                                         Case{Kind::Gaussian, 18, 21}));

TEST(Film, BoxOfOnePixelNeedsNoMargin) {
  const Film film(small(Kind::Box, 1, 1));
  for (int i = 0; i < film.tileCount(); ++i) {
    const PixelRect r = film.begin(i).samplePixels();
    EXPECT_TRUE(r.x0 >= 0 && r.y0 >= 0 && r.x1 <= 61 && r.y1 <= 43);
  }
}

// A filter's weights are divided out, so a constant stays exactly that constant.
TEST(Film, AConstantStaysExact) {
  for (const Kind kind : {Kind::Box, Kind::Triangle, Kind::CatmullRom, Kind::Sinc, Kind::Gaussian}) {
    Film film(small(kind, 3, 3));
    for (int i = 0; i < film.tileCount(); ++i) {
      FilmTile tile = film.begin(i);
      const PixelRect r = tile.samplePixels();
      for (int y = r.y0; y < r.y1; ++y)
        for (int x = r.x0; x < r.x1; ++x)
          for (const double d : {0.1, 0.6, 0.8})
            tile.addSample(x + d, y + d, std::array{1.f, 1.f, 1.f, 1.f, 2.f});
      film.finish(std::move(tile));
    }
    for (int y = 0; y < 43; ++y)
      for (int x = 0; x < 61; ++x) ASSERT_EQ(film.value(x, y, 0), 1) << static_cast<int>(kind);
  }
}

TEST(Film, RefusesWhatIsNoNumber) {
  Film film(small(Kind::Gaussian, 2, 2));
  FilmTile tile = film.begin(10);
  const double x = tile.samplePixels().x0 + 0.5, y = tile.samplePixels().y0 + 0.5;
  const float nan = std::nanf(""), infinity = std::numeric_limits<float>::infinity();
  EXPECT_FALSE(tile.addSample(x, y, std::array{nan, 0.f, 0.f, 1.f, 1.f}));
  EXPECT_FALSE(tile.addSample(x, y, std::array{0.f, infinity, 0.f, 1.f, 1.f}));
  EXPECT_FALSE(tile.addSample(x, y, std::array{0.f, 0.f, -infinity, 1.f, 1.f}));
  EXPECT_FALSE(tile.addSample(x, y, std::array{0.f, 0.f, 2e20f, 1.f, 1.f}));
  EXPECT_FALSE(tile.addSample(x, y, std::array{0.f, 0.f, 0.f, 1.f, nan}));
  EXPECT_FALSE(tile.addSample(x, y, std::array{0.f, 0.f, 0.f, 1.f, -infinity}));
  EXPECT_TRUE(tile.addSample(x, y, std::array{0.25f, 0.f, 0.f, 1.f, infinity}))
      << "infinitely far is a depth";
  film.finish(std::move(tile));
  film.flush();
  EXPECT_EQ(film.refusedCount(), 6u);
  EXPECT_EQ(film.sampleCount(), 1u);
  const int px = static_cast<int>(x), py = static_cast<int>(y);
  EXPECT_EQ(film.value(px, py, 0), 0.25f);
  EXPECT_EQ(film.value(px, py, 4), kFarDepth);
}

TEST(Film, AnInterruptedRenderKeepsWhatIsThere) {
  Film film(small(Kind::Gaussian, 4, 4));
  const int last = film.tileCount() / 2 + 3;
  FilmTile tile = film.begin(last);
  const PixelRect r = tile.samplePixels();
  renderTile(tile);
  film.finish(std::move(tile));
  film.flush();
  EXPECT_FALSE(film.complete());
  EXPECT_NE(film.value(r.x0, r.y0, 2), 0);
  EXPECT_EQ(film.value(0, 0, 2), 0) << "no sample, no value";
}

TEST(Film, APreviewIsThePictureOfTilesThatGoOn) {
  for (const FilmSettings& settings : {small(Kind::Gaussian, 4, 4), small(Kind::CatmullRom, 3, 7)}) {
    Film once(settings), twice(settings), both(settings);
    std::vector<FilmTile> tiles;
    std::vector<const FilmTile*> pointers;
    for (int i = 0; i < once.tileCount(); ++i) {
      FilmTile tile = once.begin(i);
      renderTile(tile);
      tiles.push_back(tile);
      once.finish(std::move(tile));
    }
    for (const FilmTile& tile : tiles) pointers.insert(pointers.begin(), &tile);
    const std::unique_ptr<Film> first = twice.preview(pointers);
    EXPECT_EQ(bits(*first, first->pixels()), bits(once, once.pixels()));
    EXPECT_EQ(first->sampleCount(), once.sampleCount());
    EXPECT_EQ(twice.sampleCount(), 0u);
    // What a preview was made of takes more samples.
    for (FilmTile& tile : tiles) {
      renderTile(tile);
      FilmTile same = both.begin(tile.index());
      renderTile(same);
      renderTile(same);
      both.finish(std::move(same));
      twice.finish(std::move(tile));
    }
    EXPECT_TRUE(twice.complete());
    EXPECT_EQ(twice.sampleCount(), 2 * once.sampleCount());
    EXPECT_EQ(bits(twice, twice.pixels()), bits(both, both.pixels()));
  }
}

TEST(Film, SaysWhatOpenTilesTake) {
  FilmSettings settings;
  settings.width = 40, settings.height = 20;
  settings.filter = {Kind::Box, 1, 1};
  // Five channels: a double each, one for the weight, and a float each.
  EXPECT_EQ(Film(settings).openBytes(), 40u * 20 * (6 * 8 + 5 * 4));
  settings.adaptiveFrom = 3;  // samples that are kept: five values and their place
  EXPECT_EQ(Film(settings).openBytes(), 40u * 20 * (6 * 8 + 5 * 4 + 3 * 7 * 4));
  settings.adaptiveFrom = 0;
  // Reaching one pixel: columns of 1, 17, 18 and 9 pixels, rows of 1, 17 and 5.
  settings.filter = {Kind::Gaussian, 2, 2};
  EXPECT_EQ(Film(settings).openBytes(), (1u + 17 + 18 + 9) * (1 + 17 + 5) * (6 * 8 + 5 * 4));
}

// Mean and variance of 1 2 3 4: 2.5 and 5/3; of their mean: 5/12.
TEST(Film, MomentsOfAPixel) {
  FilmSettings settings = small(Kind::Gaussian, 4, 4);
  settings.variance = true;
  Film film(settings);
  FilmTile tile = film.begin(film.tileCount() / 2 + 3);
  const int x = tile.samplePixels().x0, y = tile.samplePixels().y0;
  for (const float v : {1.f, 2.f, 3.f, 4.f}) tile.addSample(x + 0.5, y + 0.5, std::array{v, v, v, 1.f, 1.f});
  EXPECT_DOUBLE_EQ(tile.moments(x, y).mean, 2.5);
  EXPECT_EQ(tile.moments(x + 1, y).meanVariance(), std::numeric_limits<float>::infinity());
  film.finish(std::move(tile));
  film.flush();
  EXPECT_NEAR(film.meanVariance(x, y), 5.0 / 12, 1e-5);
}

// Sums hold over more samples than a float can count. Samples are 0.5 and 1.5 by turns, a thousandth of them
// 1001: a mean of 2 and a variance of 0.25 * 0.999 + 0.999 * 0.001 * 1000^2, all in exact terms of the sum of
// values and of squares.
TEST(Film, SumsHoldOverManySamples) {
  const auto valueOf = [](int k) { return k % 1000 == 999 ? 1001.f : k % 2 == 0 ? 0.5f : 1.5f; };
  double mean = 0, squares = 0;
  for (int k = 0; k < 1000; ++k) mean += static_cast<double>(valueOf(k)) / 1000;
  for (int k = 0; k < 1000; ++k) squares += std::pow(static_cast<double>(valueOf(k)) - mean, 2) / 1000;
  constexpr int kMany = 200'000'000;
  PixelMoments moments;
  for (int k = 0; k < kMany; ++k) moments.add(valueOf(k % 1000));
  EXPECT_NEAR(moments.mean, mean, 1e-9 * mean);
  EXPECT_NEAR(static_cast<double>(moments.meanVariance()) * kMany, squares, 1e-6 * squares);

  // The same through a tile, and what its pixel becomes.
  constexpr int kSamples = 40'000'000;
  FilmSettings settings;
  settings.width = settings.height = 1;
  settings.filter = {Kind::Box, 1, 1};
  settings.channels = {{"r"}, {"g"}, {"b"}};
  settings.variance = true;
  Film film(settings);
  FilmTile tile = film.begin(0);
  for (int k = 0; k < kSamples; ++k) {
    const float v = valueOf(k % 1000);
    tile.addSample(0.5, 0.5, std::array{v, v, v});
  }
  film.finish(std::move(tile));
  EXPECT_EQ(film.sampleCount(), static_cast<std::uint64_t>(kSamples));
  EXPECT_NEAR(static_cast<double>(film.value(0, 0, 0)), mean, 1e-6 * mean);
  EXPECT_NEAR(static_cast<double>(film.meanVariance(0, 0)) * kSamples, squares, 1e-5 * squares);
}

// What is finished so far, with tiles that wait for their neighbours, and later tiles change nothing of it.
TEST(Film, ASnapshotHoldsWhatIsFinished) {
  const FilmSettings settings = small(Kind::Gaussian, 4, 3);
  Film film(settings), other(settings);
  const int count = film.tileCount();
  for (int k = 0; k < count; ++k) {
    if (k % 3 == 0) continue;  // which others wait for
    for (Film* of : {&film, &other}) {
      FilmTile tile = of->begin(k);
      renderTile(tile);
      of->finish(std::move(tile));
    }
  }
  const std::unique_ptr<Film> snapshot = film.snapshot();
  EXPECT_GT(snapshot->sampleCount(), film.sampleCount()) << "some wait";
  FilmTile first = film.begin(0);
  renderTile(first);
  film.finish(std::move(first));
  other.flush();
  EXPECT_EQ(snapshot->sampleCount(), other.sampleCount());
  int seen = 0;
  for (int y = 0; y < settings.height; ++y)
    for (int x = 0; x < settings.width; ++x)
      for (int c = 0; c < film.channelCount(); ++c) {
        const float a = snapshot->value(x, y, c), b = other.value(x, y, c);
        EXPECT_NEAR(a, b, 1e-5f * std::max(1.f, std::abs(b)));
        seen += b > 0 ? 1 : 0;
      }
  EXPECT_GT(seen, 1000);
}

// Pixels of other numbers of samples: what is repeated 32 times weighs as much as if it came once, under a
// filter that reaches over pixels, in finished pictures and in previews.
TEST(Film, PixelsWeighTheSameWhateverTheirNumberOfSamples) {
  FilmSettings settings = small(Kind::Gaussian, 4, 3);
  const auto render = [&](bool repeats, bool shown) {
    Film film(settings);
    std::vector<FilmTile> tiles;
    for (int k = 0; k < film.tileCount(); ++k) {
      FilmTile& tile = tiles.emplace_back(film.begin(k));
      const PixelRect& r = tile.samplePixels();
      for (int y = r.y0; y < r.y1; ++y)
        for (int x = r.x0; x < r.x1; ++x)
          for (int s = 0; s < 2; ++s)
            for (int again = 0; again < (repeats && (x + 3 * y) % 5 == 0 ? 32 : 1); ++again)
              tile.addSample(x + static_cast<double>(noise(x, y, s, 5)),
                             y + static_cast<double>(noise(x, y, s, 6)),
                             std::array{noise(x, y, s, 0), noise(x, y, s, 1), 0.f, 1.f, 1.f});
    }
    std::vector<const FilmTile*> pointers;
    for (const FilmTile& tile : tiles) pointers.push_back(&tile);
    const auto preview = film.preview(pointers);
    for (FilmTile& tile : tiles) film.finish(std::move(tile));
    film.flush();
    const Film& which = shown ? *preview : film;
    std::vector<float> values;
    for (int y = which.pixels().y0; y < which.pixels().y1; ++y)
      for (int x = which.pixels().x0; x < which.pixels().x1; ++x)
        for (int c = 0; c < which.channelCount(); ++c) values.push_back(which.value(x, y, c));
    return values;
  };
  const std::vector<float> expected = render(false, false);
  const auto difference = [&](const std::vector<float>& values) {
    float most = 0;
    for (std::size_t k = 0; k < values.size(); ++k) most = std::max(most, std::abs(values[k] - expected[k]));
    return most;
  };
  EXPECT_GT(difference(render(true, false)), 0.05f);  // or the test shows nothing
  settings.adaptiveFrom = 2;
  EXPECT_LT(difference(render(false, false)), 1e-6f);
  EXPECT_LT(difference(render(true, false)), 2e-6f);
  EXPECT_LT(difference(render(true, true)), 2e-6f);
}

TEST(Film, PixelsWantSamplesUntilTheirVarianceIsLow) {
  FilmSettings settings = small(Kind::Box, 1, 1);
  settings.adaptiveFrom = 2;
  const Film film(settings);
  FilmTile tile = film.begin(0);
  const PixelRect r = tile.samplePixels();
  ASSERT_EQ(r.width(), 8);
  ASSERT_EQ(r.height(), 5);
  const auto add = [&](int x, int y, std::initializer_list<float> values) {
    for (const float v : values) tile.addSample(x + 0.5, y + 0.5, std::array{v, v, v, 1.f, 1.f});
  };
  for (int y = 0; y < 5; ++y)
    for (int x = 0; x < 8; ++x) {
      EXPECT_TRUE(tile.wants(x, y));
      if (x == 0 && y == 0)
        add(x, y, {0.3f, 0.5f});  // the mean's variance: 0.01
      else if (x == 6 && y == 2)
        add(x, y, {6, 10});  // 4, over 64: 0.0625
      else
        add(x, y, {0.4f, 0.4f});
    }
  EXPECT_EQ(tile.keepWanting(0.011f, 1), 9) << "one and its eight neighbours";
  for (int y = 0; y < 5; ++y)
    for (int x = 0; x < 8; ++x) EXPECT_EQ(tile.wants(x, y), x >= 5 && y >= 1 && y <= 3);
  EXPECT_EQ(tile.keepWanting(0.009f, 1), 9) << "who has stopped does not go on";
  EXPECT_EQ(tile.keepWanting(0.07f, 1), 0) << "relative beyond white";
}

TEST(Film, NamesWhatIsWrongWithItsSettings) {
  const auto problem = [](auto change) {
    FilmSettings s;
    change(s);
    return Film::problem(s);
  };
  EXPECT_EQ(problem([](FilmSettings&) {}), "");
  EXPECT_NE(problem([](FilmSettings& s) { s.width = 0; }), "");
  EXPECT_NE(problem([](FilmSettings& s) { s.height = 1 << 30; }), "");
  EXPECT_NE(problem([](FilmSettings& s) { s.width = s.height = 65536; }), "") << "26 GB are no film";
  EXPECT_NE(problem([](FilmSettings& s) { s.crop = {0.5f, 0.5f, 0, 1}; }), "");
  EXPECT_NE(problem([](FilmSettings& s) { s.crop[1] = std::nanf(""); }), "");
  EXPECT_NE(problem([](FilmSettings& s) { s.filter.xWidth = 0; }), "");
  EXPECT_NE(problem([](FilmSettings& s) { s.filter.yWidth = std::nanf(""); }), "");
  EXPECT_NE(problem([](FilmSettings& s) { s.filter.xWidth = 1e9f; }), "");
  EXPECT_NE(problem([](FilmSettings& s) { s.bucketHeight = 0; }), "");
}

}  // namespace
}  // namespace patina
