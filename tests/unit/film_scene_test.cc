// SPDX-License-Identifier: Apache-2.0
// From a scene's options to film and output settings.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "renderer/film/scene_film.h"

namespace patina {
namespace {

TEST(SceneFilm, TakesWhatTheOptionsSay) {
  Options options;
  options.xResolution = 320;
  options.yResolution = 200;
  options.crop = {0.5f, 1, 0, 0.25f};
  options.filter = "catmull-rom";
  options.filterWidthX = 4;
  options.filterWidthY = 3;
  options.bucketSize = {32, 8};
  ErrorHandler errors([](Severity, std::string_view) {});
  const FilmSettings film = filmSettings(options, errors);
  EXPECT_EQ(Film::problem(film), "");
  EXPECT_EQ(Film(film).pixels(), (PixelRect{160, 0, 320, 50}));
  EXPECT_EQ(film.filter.kind, PixelFilter::Kind::CatmullRom);
  EXPECT_EQ(film.filter.xWidth, 4);
  EXPECT_EQ(film.filter.yWidth, 3);
  EXPECT_EQ(film.bucketWidth, 32);
  EXPECT_EQ(film.bucketHeight, 8);
  EXPECT_EQ(errors.count(Severity::Warning), 0u);
}

TEST(SceneFilm, AnUnknownFilterIsReportedAndReplaced) {
  Options options;
  options.filter = "lanczos";
  options.filterWidthX = 8;
  std::string message;
  ErrorHandler errors([&](Severity, std::string_view text) { message = text; });
  const FilmSettings film = filmSettings(options, errors);
  EXPECT_EQ(film.filter.kind, PixelFilter::Kind::Gaussian);
  EXPECT_EQ(film.filter.xWidth, 2);
  EXPECT_THAT(message, testing::HasSubstr("unknown pixel filter \"lanczos\""));
}

TEST(SceneFilm, OneOutputPerDisplay) {
  Scene scene;
  scene.options.exposureGain = 2;
  scene.options.exposureGamma = 1.8f;
  scene.options.colorQuantization = Quantization{1023, 0, 1000, 0.25f};
  scene.options.displays.push_back({"a.exr", "openexr", "rgba", {{"exrcompression", "piz"}}, {}, {}});
  scene.options.displays.push_back({"+b.tif", "file", "z", {}, {}, {}});
  scene.camera.worldToCamera[3][2] = 5;
  const std::vector<OutputSettings> outputs = outputSettings(scene);
  ASSERT_EQ(outputs.size(), 2u);
  EXPECT_EQ(outputPath(outputs[0]), "a.exr");
  EXPECT_EQ(outputs[0].parameters[0].second, "piz");
  EXPECT_EQ(outputs[1].mode, "z");
  EXPECT_EQ(outputs[1].gain, 2);
  EXPECT_EQ(outputs[1].gamma, 1.8f);
  EXPECT_EQ(outputs[1].colour.one, 1023);
  EXPECT_EQ(outputs[1].colour.max, 1000);
  EXPECT_EQ(outputs[1].colour.dither, 0.25f);
  EXPECT_EQ(outputs[1].depth.one, 0) << "RI's default for depth: floats";
  EXPECT_EQ(outputs[1].worldToCamera->at(14), 5);
}

}  // namespace
}  // namespace patina
