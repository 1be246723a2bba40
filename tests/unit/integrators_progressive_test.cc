// SPDX-License-Identifier: Apache-2.0
// Progressive pictures: what is shown on the way, the end, and interruptions.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <filesystem>

#include "renderer/base/statistics.h"
#include "renderer/film/exr.h"
#include "renderer/film/output.h"
#include "renderer/integrators/passes.h"
#include "renderer/integrators/render.h"
#include "renderer/scene/scene_builder.h"

namespace patina {
namespace {

using testing::ElementsAre;
using Picture = std::vector<float>;

/// A wall with a floor, a ball that shines and one that is seen through; the filter mixes neighbouring
/// pixels, and those of other buckets. The wall covers the picture.
constexpr const char* kScene =
    "Format 40 28 1 PixelFilter \"gaussian\" 2 2 Projection \"perspective\" \"fov\" [50] Translate 0 0 4 "
    "Option \"limits\" \"int[2] bucketsize\" [12 12] WorldBegin Attribute \"trace\" \"int "
    "maxdiffusedepth\" [2] LightSource \"distantlight\" 1 \"from\" [1 3 -2] \"to\" [0 0 0] "
    "AttributeBegin AreaLightSource \"arealight\" 2 \"float intensity\" [12] Translate 0 2.4 0 Rotate 90 1 0 "
    "0 "
    "Disk 0 .5 360 AttributeEnd Illuminate 2 1 Surface \"matte\" Color [.8 .8 .8] "
    "Polygon \"P\" [-9 -9 2  -9 9 2  9 9 2  9 -9 2] Color [.8 .2 .2] "
    "Polygon \"P\" [-2 -1 -2  -2 -1 2  2 -1 2  2 -1 -2] AttributeBegin Surface \"plastic\" Color [.3 .8 .3] "
    "Translate .4 -.4 0 Sphere .6 -.6 .6 360 AttributeEnd Surface \"matte\" Opacity [.5 .5 .5] "
    "Translate -.8 0 0 Sphere .5 -.5 .5 360 WorldEnd";

/// A ball of facets much smaller than pixels, which share what is shaded (see Patch::group).
std::string denseScene() {
  std::string points, faces, counts;
  constexpr int kU = 120, kV = 80;
  for (int v = 0; v <= kV; ++v)
    for (int u = 0; u < kU; ++u) {
      const double phi = 2 * M_PI * u / kU, theta = M_PI * (v + .5) / (kV + 1);
      for (const double c :
           {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)})
        points += std::to_string(c) + ' ';
    }
  for (int v = 0; v < kV; ++v)
    for (int u = 0; u < kU; ++u) {
      counts += "4 ";
      for (const int i : {v * kU + u, v * kU + (u + 1) % kU, (v + 1) * kU + (u + 1) % kU, (v + 1) * kU + u})
        faces += std::to_string(i) + ' ';
    }
  return "Format 24 24 1 Projection \"perspective\" \"fov\" [40] Translate 0 0 4 WorldBegin "
         "LightSource \"envlight\" 1 Surface \"matte\" PointsPolygons [" +
         counts + "] [" + faces + "] \"P\" [" + points + "] WorldEnd";
}

struct How {
  std::string mode = "radiosity";
  int samples = 8, threads = 2;
  std::optional<bool> progressive{};
  int seed = 0;
  int interruptAfter = -1;         ///< pictures
  int interruptAfterBuckets = -1;  ///< from the beginning
  std::string folder{};            ///< where pictures are written as they are shown; "": not
};

struct Rendered {
  std::vector<Picture> shown;
  Picture end;
  std::vector<double> progress;
  int tiles = 0;
};

Picture valuesOf(const Film& film) {
  Picture values;
  const PixelRect& r = film.pixels();
  for (int y = r.y0; y < r.y1; ++y)
    for (int x = r.x0; x < r.x1; ++x)
      for (int c = 0; c < film.channelCount(); ++c) values.push_back(film.value(x, y, c));
  return values;
}

Rendered render(const std::string& rib, const How& how) {
  Rendered result;
  ErrorHandler errors([](Severity, std::string_view message) { ADD_FAILURE() << message; });
  RenderSettings settings;
  settings.mode = how.mode, settings.samples = how.samples, settings.threads = how.threads;
  settings.rays = 8, settings.lightSamples = 2;
  settings.progressive = how.progressive, settings.seed = how.seed;
  settings.shaderPath = PATINA_BINARY_DIR "/lib/patina/shaders";
  std::atomic<int> buckets = 0, pictures = 0;
  settings.progress = [&](double fraction) { ++buckets, result.progress.push_back(fraction); };
  settings.interrupted = [&] {
    return (how.interruptAfter >= 0 && pictures >= how.interruptAfter) ||
           (how.interruptAfterBuckets >= 0 && buckets >= how.interruptAfterBuckets);
  };
  settings.showSeconds = 0;
  settings.show = [&](const Film& film) {
    EXPECT_EQ(film.sampleCount() % (1u << std::max(0, pictures - 1)), 0u);
    ++pictures;
    result.shown.push_back(valuesOf(film));
    if (how.folder.empty()) return;
    OutputSettings output;
    output.name = how.folder + "/picture.exr", output.type = "openexr", output.mode = "rgbaz";
    std::string error;
    const auto image = readExr(writeImage(film, output, errors), error);
    ASSERT_TRUE(image) << error;
    EXPECT_EQ(image->pixels, result.shown.back());
  };
  SceneBuilder builder({}, errors, [&](Scene& scene) {
    const auto film = renderFrame(scene, settings, errors);
    ASSERT_TRUE(film);
    result.end = valuesOf(*film);
    result.tiles = film->tileCount();
  });
  builder.readText(rib, "progressive.rib");
  return result;
}

/// The same but for the order in which a tile adds its samples, in double precision, before a pixel is
/// rounded to single precision: one step of that for each of a pixel's sums, and one for their quotient.
void expectSame(const Picture& a, const Picture& b, const std::string& what) {
  ASSERT_EQ(a.size(), b.size()) << what;
  for (size_t i = 0; i < a.size(); ++i)
    ASSERT_LE(std::abs(a[i] - b[i]), 3 * 0x1p-24f * std::abs(b[i])) << what << ", value " << i;
}

TEST(Passes, DoubleWhatIsThere) {
  const auto ends = [](int samples, bool progressive) {
    std::vector<uint32_t> list;
    uint32_t first = 0;
    for (const SampleRange& pass : passesOf(samples, progressive)) {
      EXPECT_EQ(pass.first, first);
      list.push_back(first = pass.end);
    }
    return list;
  };
  EXPECT_THAT(ends(1, true), ElementsAre(1));
  EXPECT_THAT(ends(2, true), ElementsAre(1, 2));
  EXPECT_THAT(ends(11, true), ElementsAre(1, 2, 4, 8, 11));
  EXPECT_THAT(ends(11, false), ElementsAre(11));
  EXPECT_THAT(ends(0, true), ElementsAre(1));
  EXPECT_EQ(ends(1 << 24, true).size(), 25u);
}

class Progressive : public testing::TestWithParam<const char*> {};

TEST_P(Progressive, ShowsCompletePicturesOfFewerSamples) {
  const std::string folder = testing::TempDir() + "patina-progressive-" + GetParam();
  std::filesystem::create_directories(folder);
  // Nothing touches, and the light is no area: points that are shaded for parts of pixels share rays among
  // all samples to come.
  const std::string scene = [] {
    std::string text = kScene;
    for (const auto& [from, to] :
         {std::pair{"-9 -9 2  -9 9 2  9 9 2  9 -9 2", "-9 -9 3  -9 9 3  9 9 3  9 -9 3"},
          std::pair{"Translate .4 -.4 0", "Translate .9 .2 0"},
          std::pair{"AreaLightSource \"arealight\" 2 \"float intensity\" [12]",
                    "LightSource \"pointlight\" 2 \"float intensity\" [3]"}})
      text.replace(text.find(from), std::string_view(from).size(), to);
    return text;
  }();
  const Rendered all = render(scene, {.mode = GetParam(), .progressive = true, .folder = folder});
  std::filesystem::remove_all(folder);
  ASSERT_EQ(all.shown.size(), 3u);  // of 1, 2 and 4 samples
  expectSame(all.shown[0], render(scene, {.mode = GetParam(), .samples = 1}).end, "1 sample");
  expectSame(all.shown[1], render(scene, {.mode = GetParam(), .samples = 2}).end, "2 samples");
  expectSame(all.shown[2], render(scene, {.mode = GetParam(), .samples = 4}).end, "4 samples");
  EXPECT_NE(all.shown[2], all.end);
}

TEST_P(Progressive, EndsWithThePictureOfOnePass) {
  // Up to 16 samples each has its own point where vertices do not serve: see RayBudget::kParts.
  for (const int samples : {1, 6, 16}) {
    const Rendered one = render(kScene, {.mode = GetParam(), .samples = samples});
    EXPECT_TRUE(one.shown.empty());
    expectSame(render(kScene, {.mode = GetParam(), .samples = samples, .progressive = true}).end, one.end,
               std::to_string(samples) + " samples");
  }
}

TEST_P(Progressive, ThreadsChangeNoBit) {
  const Rendered one = render(kScene, {.mode = GetParam(), .threads = 1, .progressive = true});
  const Rendered four = render(kScene, {.mode = GetParam(), .threads = 4, .progressive = true});
  EXPECT_TRUE(one.shown == four.shown);
  EXPECT_TRUE(one.end == four.end);
}

TEST_P(Progressive, AnInterruptionKeepsThePictureThatIsThere) {
  const Rendered whole = render(kScene, {.mode = GetParam(), .progressive = true});
  const Rendered after = render(kScene, {.mode = GetParam(), .progressive = true, .interruptAfter = 1});
  ASSERT_EQ(after.shown.size(), 1u);
  EXPECT_TRUE(after.end == whole.shown[0]);
  // In the middle of the second pass, and of the last: some buckets have more samples.
  for (const int pass : {1, 3}) {
    const Rendered part = render(kScene, {.mode = GetParam(),
                                          .threads = 1,
                                          .progressive = true,
                                          .interruptAfterBuckets = whole.tiles * pass + whole.tiles / 2});
    const Picture& before = whole.shown[static_cast<size_t>(pass) - 1];
    const Picture& behind = pass == 3 ? whole.end : whole.shown[static_cast<size_t>(pass)];
    ASSERT_EQ(part.shown.size(), static_cast<size_t>(pass));
    ASSERT_EQ(part.end.size(), before.size());
    size_t old = 0, renewed = 0;
    for (size_t i = 0; i < before.size(); ++i) {
      ASSERT_TRUE(std::isfinite(part.end[i]));
      if (i % 5 == 3) {
        ASSERT_NEAR(part.end[i], 1, 1e-6) << "alpha";
      }
      old += part.end[i] == before[i] && part.end[i] != behind[i];
      renewed += part.end[i] == behind[i] && part.end[i] != before[i];
    }
    EXPECT_GT(old, before.size() / 8);
    EXPECT_GT(renewed, before.size() / 8);
  }
}

TEST_P(Progressive, ProgressIsOfAllPasses) {
  const Rendered all = render(kScene, {.mode = GetParam(), .threads = 1, .progressive = true});
  ASSERT_EQ(all.progress.size(), static_cast<size_t>(4 * all.tiles));
  EXPECT_TRUE(std::is_sorted(all.progress.begin(), all.progress.end()));
  EXPECT_EQ(all.progress.back(), 1);
  // Passes of 1, 1, 2 and 4 of 8 samples.
  const auto after = [&](int pass) { return all.progress[static_cast<size_t>(pass * all.tiles - 1)]; };
  EXPECT_EQ(after(1), 1.0 / 8);
  EXPECT_EQ(after(2), 2.0 / 8);
  EXPECT_EQ(after(3), 4.0 / 8);
}

INSTANTIATE_TEST_SUITE_P(Modes, Progressive, testing::Values("radiosity", "distribution", "path", "direct"),
                         [](const auto& mode) { return std::string(mode.param); });

TEST(ProgressiveOption, IsTheHidersUnlessTheSettingsSayOtherwise) {
  const std::string rib = "Hider \"raytrace\" \"int incremental\" [1] " + std::string(kScene);
  EXPECT_EQ(render(rib, {.mode = "direct", .samples = 4}).shown.size(), 2u);
  EXPECT_EQ(render(rib, {.mode = "direct", .samples = 4, .progressive = false}).shown.size(), 0u);
  EXPECT_EQ(render(kScene, {.mode = "direct", .samples = 4}).shown.size(), 0u);
}

TEST(ProgressiveOption, IsLeftOutWhereItsBucketsWouldTakeTooMuchMemory) {
  // Buckets of one pixel with a filter that reaches over 65 of them: 300 x 300 x 65 x 65 pixels of 68 bytes.
  const std::string rib =
      "Format 300 300 1 PixelFilter \"box\" 64 64 Option \"limits\" \"int[2] bucketsize\" [1 1] "
      "WorldBegin WorldEnd";
  for (const int samples : {1, 2}) {
    std::vector<std::string> messages;
    ErrorHandler errors([&](Severity, std::string_view message) { messages.emplace_back(message); });
    RenderSettings settings;
    settings.mode = "path", settings.samples = samples, settings.progressive = true;
    settings.interrupted = [] { return true; };
    SceneBuilder builder({}, errors,
                         [&](Scene& scene) { EXPECT_TRUE(renderFrame(scene, settings, errors)); });
    builder.readText(rib, "large.rib");
    if (samples == 1) {
      EXPECT_THAT(messages, testing::IsEmpty());
    } else {
      EXPECT_THAT(messages,
                  ElementsAre(testing::HasSubstr("limitcheck: the picture is not progressive: between "
                                                 "passes its buckets would take 25 GB (at most 16)")));
    }
  }
}

TEST(ProgressiveDistribution, ShadesVerticesOnce) {
  const auto shaded = [](bool progressive) {
    resetStatistics();
    render(kScene, {.mode = "distribution", .samples = 16, .progressive = progressive});
    for (const StatEntry& entry : statistics())
      if (entry.name == "Radiosity/points shaded from the cache's vertices") return entry.value;
    return 0.0;
  };
  const double once = shaded(false);
  EXPECT_GT(once, 500);
  // Fewer: what is kept serves mirrored views of the same vertices, too.
  EXPECT_LE(shaded(true), once);
  EXPECT_GT(shaded(true), once / 2);
}

// What stands for others of its group is found among the samples of a pass: another picture, of the same
// mean. The mean of a picture has the spread that seeds give it.
TEST(ProgressiveGroups, HaveTheSameMean) {
  const std::string rib = denseScene();
  const auto mean = [](const Picture& picture) {
    double sum = 0;
    for (size_t i = 0; i < picture.size(); i += 5) sum += static_cast<double>(picture[i]);
    return sum / static_cast<double>(picture.size() / 5);
  };
  constexpr int kSeeds = 8;
  double sum = 0, squares = 0, progressive = 0;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const double plain = mean(render(rib, {.seed = seed}).end);
    progressive += mean(render(rib, {.progressive = true, .seed = seed}).end) / kSeeds;
    sum += plain, squares += plain * plain;
  }
  const double all = sum / kSeeds, variance = (squares - sum * all) / (kSeeds - 1);
  EXPECT_GT(all, 0.2);
  EXPECT_GT(variance, 0);
  // The difference of two means; a chance of 1 in 1000 for Student's t with 14 degrees of freedom.
  EXPECT_NEAR(progressive, all, 4.14 * std::sqrt(2 * variance / kSeeds));
  const Rendered one = render(rib, {.threads = 1, .progressive = true});
  EXPECT_TRUE(one.end == render(rib, {.threads = 4, .progressive = true}).end);
  // Points share rays among all samples to come.
  EXPECT_NEAR(mean(one.shown[0]), mean(render(rib, {.samples = 1}).end), 0.02 * all);
}

}  // namespace
}  // namespace patina
