// SPDX-License-Identifier: Apache-2.0
// The invariants of caches and shaders that a picture must keep, with everything in one scene: the same bits
// for any cache and any threads, no garbage beyond a shader, no I for radiosity, and hard budgets.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <thread>

#include "renderer/base/statistics.h"
#include "renderer/cache/packed_opacity.h"
#include "renderer/cache/patch_cache.h"
#include "renderer/integrators/render.h"
#include "renderer/scene/scene_builder.h"

namespace patina {
namespace {

struct Rendered {
  std::vector<float> values;  ///< of all channels but depth
  std::map<std::string, double> statistics;
  std::vector<std::string> messages;
  double of(const std::string& name) const {
    const auto found = statistics.find(name);
    return found == statistics.end() ? 0 : found->second;
  }
};

struct How {
  std::string mode = "radiosity";
  int threads = 2, samples = 2, rays = 4;
  double radiosityKb = 65536;
  int opacityKb = 65536;
  std::array<float, 4> crop{0, 1, 0, 1};
};

class Invariants : public testing::Test {
 protected:
  Invariants() {
    std::string name = testing::TempDir() + "patina-invariants-XXXXXX";
    folder_ = mkdtemp(name.data());
    writeAlpha(folder_ + "/cut.tga");
  }
  ~Invariants() override { std::filesystem::remove_all(folder_); }

  /// A red picture, 64 x 64, whose alpha is a disc in the middle (TGA: blue, green, red, alpha; top row
  /// first).
  static void writeAlpha(const std::string& path) {
    constexpr int kSize = 64;
    std::ofstream file(path, std::ios::binary);
    const unsigned char head[18] = {0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, kSize, 0, kSize, 0, 32, 0x28};
    file.write(reinterpret_cast<const char*>(head), sizeof head);
    for (int y = 0; y < kSize; ++y)
      for (int x = 0; x < kSize; ++x) {
        const int dx = 2 * x + 1 - kSize, dy = 2 * y + 1 - kSize;
        const char texel[4] = {20, static_cast<char>(x), static_cast<char>(200),
                               static_cast<char>(dx * dx + dy * dy < kSize * kSize * 3 / 4 ? 255 : 0)};
        file.write(texel, sizeof texel);
      }
  }

  Rendered render(const std::string& rib, const How& how) const {
    Rendered picture;
    ErrorHandler errors([&](Severity, std::string_view message) { picture.messages.emplace_back(message); });
    RenderSettings settings;
    settings.mode = how.mode, settings.samples = how.samples, settings.threads = how.threads;
    settings.rays = how.rays, settings.lightSamples = 4;
    settings.cacheMemoryMb = how.radiosityKb / 1024;
    settings.shaderPath = PATINA_BINARY_DIR "/lib/patina/shaders:" PATINA_BINARY_DIR "/tests/plugins";
    settings.texturePath = folder_;
    settings.replay = "scene.rib";
    SceneBuilder builder({}, errors, [&](Scene& scene) {
      scene.options.opacityCacheKb = how.opacityKb;
      scene.options.crop = how.crop;
      resetStatistics();
      const auto film = renderFrame(scene, settings, errors);
      ASSERT_TRUE(film);
      const PixelRect& r = film->pixels();
      for (int y = r.y0; y < r.y1; ++y)
        for (int x = r.x0; x < r.x1; ++x)
          for (int c = 0; c < 4; ++c) picture.values.push_back(film->value(x, y, c));
      for (const StatEntry& entry : statistics()) picture.statistics[entry.name] = entry.value;
    });
    builder.readText(rib, "scene.rib");
    return picture;
  }

  std::string folder_;
};

/// A textured floor, a displaced ball, one that moves, instances of cut-outs by alpha and by pattern, one
/// that moves, a delta and an area light.
std::string everything(const std::string& more = "") {
  return "Format 26 20 1 ShadingRate .2 Shutter 0 1 Projection \"perspective\" \"fov\" [40] Translate 0 -.4 "
         "5 Rotate -15 1 "
         "0 0 "
         "WorldBegin LightSource \"distantlight\" 1 \"from\" [1 3 -2] \"to\" [0 0 0] \"intensity\" [.6] "
         "AttributeBegin AreaLightSource \"arealight\" 2 \"intensity\" [6] Patch \"bilinear\" \"P\" [-1.5 "
         "2.4 -.5 "
         "-.5 2.4 -.5  -1.5 2.4 .5  -.5 2.4 .5] AttributeEnd Illuminate 2 1 "
         "Attribute \"trace\" \"int maxdiffusedepth\" [2] "
         "ObjectBegin \"card\" Patch \"bilinear\" \"P\" [-.4 0 0  .4 0 0  -.4 .8 -.2  .4 .8 .2] ObjectEnd "
         "AttributeBegin Surface \"paintedplastic\" \"string texturename\" [\"cut.tga\"] "
         "Patch \"bilinear\" \"P\" [-3 0 -3  3 0 -3  -3 0 3  3 0 3] AttributeEnd "
         "AttributeBegin Surface \"matte\" Color [.4 .6 .9] Attribute \"displacementbound\" \"float sphere\" "
         "[.1] "
         "Displacement \"dented\" \"float Km\" [.08] Translate -.8 .5 .3 Sphere .4 -.4 .4 360 AttributeEnd "
         "AttributeBegin Surface \"matte\" Color [.9 .8 .3] MotionBegin [0 1] Translate .5 .3 -.6 Translate "
         ".9 .5 -.6 "
         "MotionEnd Sphere .25 -.25 .25 360 AttributeEnd "
         "AttributeBegin Surface \"leaf\" Color [.3 .8 .2] Translate .2 .2 .4 ObjectInstance \"card\" "
         "Translate .3 .4 -.5 Rotate 60 1 0 0 ObjectInstance \"card\" AttributeEnd "
         "AttributeBegin Surface \"leaf\" \"string texturename\" [\"cut.tga\"] Opacity [.9 .6 .8] Translate "
         "-.4 .9 -.3 "
         "Rotate 80 1 .3 0 ObjectInstance \"card\" AttributeEnd "
         "AttributeBegin Surface \"leaf\" MotionBegin [0 1] Translate .9 .3 .2 Translate 1.1 .5 .2 MotionEnd "
         "Patch \"bilinear\" \"P\" [-.3 0 0  .3 0 0  -.3 .6 .2  .3 .6 0] AttributeEnd " +
         more + " WorldEnd";
}

TEST_F(Invariants, CachesAndThreadsAndRepetitionChangeNoBit) {
  const std::string rib = everything();
  const Rendered whole = render(rib, {.threads = 1});
  EXPECT_THAT(whole.messages, testing::IsEmpty());
  // Both caches are in use, at several levels, and hold everything.
  EXPECT_GT(whole.of("Radiosity cache/fine/depth 1/hits"), 100);
  EXPECT_GT(whole.of("Radiosity cache/medium/depth 2/hits"), 50);
  EXPECT_GT(whole.of("Opacity cache/coarse/hits") + whole.of("Opacity cache/medium/hits"), 100);
  EXPECT_GT(whole.of("Opacity cache/fine/hits"), 100);
  EXPECT_EQ(whole.of("Opacity cache/fine/evictions"), 0);
  EXPECT_GT(whole.of("Motion/moving placements"), 1);
  const How ways[] = {{.threads = 1},
                      {.threads = 2},
                      {.threads = 5},
                      {.threads = 5},
                      {.threads = 2, .radiosityKb = 4, .opacityKb = 4},
                      {.threads = 5, .radiosityKb = 40},
                      {.threads = 1, .opacityKb = 8},
                      {.threads = 5, .opacityKb = 0},
                      {.threads = 2, .radiosityKb = 200, .opacityKb = 8}};
  double evictions = 0;
  for (const How& how : ways) {
    const Rendered again = render(rib, how);
    EXPECT_TRUE(again.values == whole.values)
        << how.threads << " threads, " << how.radiosityKb << " and " << how.opacityKb << " kB";
    for (const auto& [cache, kilobytes] :
         {std::pair("Radiosity", how.radiosityKb), std::pair("Opacity", double(how.opacityKb))}) {
      const double reserved = again.of(fmt::format("{} cache/bytes reserved", cache));
      EXPECT_LE(reserved, kilobytes * 1024) << cache;
      // Tables begin and end within pages.
      EXPECT_LE(again.of(fmt::format("{} cache/bytes in memory", cache)), reserved + 2 * 4096) << cache;
      for (const auto& [name, value] : again.statistics)
        if (name.starts_with(cache) && name.ends_with("/evictions")) evictions += value;
    }
  }
  EXPECT_GT(evictions, 300);
}

TEST_F(Invariants, ThreadsChangeNoBitWithoutCachesEither) {
  const std::string rib = everything();
  for (const char* mode : {"path", "distribution", "direct"}) {
    const Rendered one = render(rib, {.mode = mode, .threads = 1});
    for (const int threads : {2, 5})
      EXPECT_TRUE(render(rib, {.mode = mode, .threads = threads}).values == one.values) << mode << threads;
  }
}

std::string with(const std::string& shader) {
  return everything("AttributeBegin Surface \"" + shader +
                    "\" Translate 0 .9 -.9 Patch \"bilinear\" \"P\" [-.5 0 0  .5 0 0  -.5 .7 .3  .5 .7 0] "
                    "Translate 0 -.6 1.6 Rotate 70 1 0 0 Sphere .6 -.6 .6 360 AttributeEnd");
}

/// The messages about a shader.
std::vector<std::string> about(const Rendered& picture, const std::string& shader) {
  std::vector<std::string> found;
  for (const std::string& message : picture.messages)
    if (message.find("shader \"" + shader + "\"") != std::string::npos) found.push_back(message);
  return found;
}

TEST_F(Invariants, GarbageOfAShaderReachesNeitherFilmNorCaches) {
  for (const char* mode : {"radiosity", "distribution", "direct", "path"}) {
    // What the shader should have given in place of the garbage makes the same picture, to the bit.
    const How how{.mode = mode};
    const Rendered bad = render(with("garbage"), how), mended = render(with("mended"), how);
    ASSERT_EQ(bad.values.size(), size_t{26 * 20 * 4});
    for (const float value : bad.values) ASSERT_TRUE(value >= 0 && value < 1e3f) << mode;
    EXPECT_TRUE(bad.values == mended.values) << mode;
    EXPECT_THAT(mended.messages, testing::IsEmpty()) << mode;
    // Counted by plugin and entry point, and reported once each.
    EXPECT_THAT(bad.messages, testing::SizeIs(2)) << mode;
    for (const char* entry : {"radiosity", "view"}) {
      const double count = bad.of(fmt::format("Shaders/garbage/{}/points with values replaced", entry));
      EXPECT_GT(count, 5) << mode << entry;
      EXPECT_LT(count, bad.of(fmt::format("Shaders/garbage/{}/points", entry)) / 2) << mode << entry;
      EXPECT_THAT(
          about(bad, "garbage"),
          testing::Contains(testing::AllOf(
              testing::HasSubstr(
                  fmt::format("{} gave values that are not finite, negative or too large", entry)),
              testing::HasSubstr(fmt::format("[{} times]", count)),
              testing::HasSubstr("primitive at scene.rib:1:"), testing::HasSubstr("in the patch from ("),
              testing::ContainsRegex("pixels -?[0-9]+ to -?[0-9]+ by -?[0-9]+ to -?[0-9]+ were being made"))))
          << mode;
    }
    EXPECT_EQ(bad.of("Shaders/matte/radiosity/points with values replaced"), 0);
  }
}

TEST_F(Invariants, TheCommandOfAReportMakesItAgain) {
  const Rendered bad = render(with("garbage"), {.threads = 1});
  for (const std::string& message : about(bad, "garbage")) {
    std::smatch at;
    ASSERT_TRUE(std::regex_search(
        message, at,
        std::regex("patina --crop ([0-9.e-]+) ([0-9.e-]+) ([0-9.e-]+) ([0-9.e-]+) -o replay.exr scene.rib")))
        << message;
    const Rendered again = render(
        with("garbage"),
        {.threads = 1, .crop = {std::stof(at[1]), std::stof(at[2]), std::stof(at[3]), std::stof(at[4])}});
    // The same point is the first again.
    const std::string first = message.substr(message.find("The first is at"), 60);
    EXPECT_THAT(about(again, "garbage"), testing::Contains(testing::HasSubstr(first)));
  }
}

TEST_F(Invariants, GarbageOfALightIsNoLight) {
  for (const char* mode : {"radiosity", "path"}) {
    const Rendered bad =
        render(everything("LightSource \"garbagelight\" 9 Surface \"matte\" Translate 0 .05 0 "
                          "Polygon \"P\" [-2 0 -2  -2 0 2  2 0 2  2 0 -2]"),
               {.mode = mode});
    for (const float value : bad.values) ASSERT_TRUE(value >= 0 && value < 1e3f) << mode;
    EXPECT_GT(bad.of("Shaders/garbagelight/light/points with values replaced"), 10) << mode;
    EXPECT_THAT(about(bad, "garbagelight"),
                testing::ElementsAre(testing::AllOf(testing::HasSubstr("they count as no light"),
                                                    testing::HasSubstr("patina --crop"))))
        << mode;
  }
}

TEST_F(Invariants, RadiosityIsNeverGivenI) {
  // The plugins complain when it is, or when `view` is not given it.
  for (const char* mode : {"radiosity", "distribution", "path"})
    for (const char* shader : {"mended", "misfit"}) {
      const Rendered picture = render(with(shader), {.mode = mode});
      EXPECT_GT(picture.of(fmt::format("Shaders/{}/radiosity/points", shader)), 0);
      EXPECT_GT(picture.of(fmt::format("Shaders/{}/view/points", shader)), 0);
      EXPECT_THAT(picture.messages, testing::IsEmpty()) << mode;
    }
}

TEST_F(Invariants, WhatIsNotCacheableIsShadedWhereItIsMet) {
  const std::string rib =
      "Format 24 24 1 ScreenWindow -1 1 -1 1 WorldBegin LightSource \"distantlight\" 1 \"float angle\" [12] "
      "Surface \"matte\" Attribute \"trace\" \"int maxdiffusedepth\" [0] Polygon \"P\" [-2 -2 2  -2 2 2  2 2 "
      "2  2 "
      "-2 2] Attribute \"visibility\" \"int camera\" [0] Surface \"{}\" Polygon \"P\" [-.5 -.5 1  -.5 .5 1  "
      ".5 .5 1 "
      " .5 -.5 1] WorldEnd";
  const auto replaced = [&](const std::string& shader) {
    std::string text = rib;
    return text.replace(text.find("{}"), 2, shader);
  };
  EXPECT_GT(render(replaced("mended"), {}).of("Opacity cache/look-ups answered"), 100);
  const Rendered misfit = render(replaced("misfit"), {});
  EXPECT_EQ(misfit.of("Opacity cache/look-ups answered"), 0);
  EXPECT_GT(misfit.of("Opacity cache/look-ups left to the shader"), 100);
}

TEST_F(Invariants, LightOfAnyStrengthSurvivesTheCache) {
  // Inside of a ball that glows, of albedo 1/2, three bounces: 1 + 1/2 + 1/4 + 1/8 of what it gives off.
  for (const double strength : {1e-12, 1e-6, 1.0, 1e6, 1e12}) {
    const Rendered picture = render(
        fmt::format(
            "Format 8 8 1 Projection \"perspective\" \"fov\" [60] WorldBegin Attribute \"trace\" \"int "
            "maxdiffusedepth\" [3] Surface \"matte\" \"float Kd\" [.5] \"color emission\" [{0} {1} {2}] "
            "ReverseOrientation Sphere 2 -2 2 360 WorldEnd",
            strength, strength / 3, strength / 1000),
        {.rays = 16});
    double hits = 0;
    for (const auto& [name, value] : picture.statistics)
      if (name.starts_with("Radiosity cache/") && name.ends_with("/hits")) hits += value;
    EXPECT_GT(hits, 100);
    for (size_t k = 0; k < picture.values.size(); k += 4)
      for (const auto& [channel, share] : {std::pair(0, 1.0), std::pair(1, 1.0 / 3), std::pair(2, 1e-3)})
        ASSERT_NEAR(static_cast<double>(picture.values[k + static_cast<size_t>(channel)]) /
                        (strength * share * 1.875),
                    1, channel == 2 ? 4e-3 : 1e-3)
            << strength;
  }
}

/// Writers and readers at work while the bytes in memory are watched.
template <class Word>
void watch(size_t bytes) {
  PatchCacheOf<Word> cache(bytes);
  EXPECT_LE(cache.capacity(), bytes);
  EXPECT_EQ(cache.resident(), 0u);
  std::atomic<int> working = 2;
  std::vector<std::thread> writers;
  for (uint32_t seed = 0; seed < 2; ++seed)
    writers.emplace_back([&, seed] {
      const std::vector<Word> codes(kMaxBlockVertices, Word{seed + 1});
      for (uint32_t k = 0; k < 60000; ++k) {
        const auto level = static_cast<Level>(k % 3);
        const CacheKey key{k * 2 + seed, true, static_cast<uint8_t>(k % 5), static_cast<uint8_t>(k % 16)};
        cache.store({key.patch, key.front, key.depth, level == Level::Fine ? key.block : uint8_t{0}}, level,
                    std::span(codes).first(level == Level::Coarse ? 4 : kMaxBlockVertices));
      }
      --working;
    });
  const size_t reserved = (cache.capacity() + 2 * 4095) / 4096 * 4096;
  while (working > 0) {
    const size_t now = cache.resident();
    EXPECT_LE(now, reserved);
  }
  for (std::thread& writer : writers) writer.join();
  size_t used = 0;
  for (const Level level : {Level::Coarse, Level::Medium, Level::Fine})
    for (int depth = 0; depth < 5; ++depth) used += cache.use(level, depth).bytes;
  EXPECT_LE(used, cache.capacity());
  const size_t most = cache.resident();
  EXPECT_LE(most, reserved);
  EXPECT_GT(most, bytes / 2);  // it was full
}

TEST(CacheBudget, HoldsWhileTheCacheIsInUse) {
  for (const size_t bytes : {size_t{20} << 10, size_t{300} << 10, size_t{2} << 20}) {
    watch<uint64_t>(bytes);
    watch<uint32_t>(bytes);
  }
}

}  // namespace
}  // namespace patina
