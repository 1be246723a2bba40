// SPDX-License-Identifier: Apache-2.0
// What spotlight has beyond RI: a slide, and barn doors.
#include <cmath>
#include <filesystem>
#include <fstream>

#include "renderer/shading/texture_service.h"
#include "tests/unit/plugins/bound_shader.h"

namespace patina::test {
namespace {

/// Cl where the light at the origin, that shines along z, meets the plane z = 1, times the distance squared.
Triple at(const BoundShader& shader, double x, double y) {
  Batch batch = shader.batch(1);
  batch.lightIn.task = PATINA_LIGHT_SAMPLE;
  batch.lightIn.P = batch.uniform({float(x), float(y), 1});
  PatinaLightOut out = batch.lightOut();
  EXPECT_EQ(shader->light(batch.lightIn, out), PATINA_OK);
  Triple cl = get(out.radiance, 0);
  for (float& c : cl) c = float(double(c) * (x * x + y * y + 1));
  return cl;
}

TEST(SpotLight, DoorsCutTheLightOff) {
  const auto wide = [](const char* door, float angle, float softness) {
    return BoundShader("spotlight",
                       {number("coneangle", 1.2f), number("conedeltaangle", 0), number("beamdistribution", 0),
                        number(door, angle), number("doorsoftness", softness)});
  };
  struct Door {
    const char* name;
    double x, y;  // to its side
  };
  for (const Door& d :
       {Door{"doorleft", -1, 0}, Door{"doorright", 1, 0}, Door{"doortop", 0, 1}, Door{"doorbottom", 0, -1}}) {
    const BoundShader hard = wide(d.name, 0.4f, 0);
    const double edge = std::tan(0.4);
    const auto beside = [&](const BoundShader& shader, double t) { return at(shader, t * d.x, t * d.y)[1]; };
    EXPECT_NEAR(beside(hard, edge - 0.01), 1, 1e-5) << d.name;
    EXPECT_EQ(beside(hard, edge + 0.01), 0) << d.name;
    EXPECT_NEAR(beside(hard, -1), 1, 1e-5) << d.name;
    const BoundShader soft = wide(d.name, 0.4f, 0.2f);
    EXPECT_NEAR(beside(soft, (std::tan(0.2) + edge) / 2), 0.5, 1e-5) << d.name;
    // Past the axis: half of the light is cut away, and some more.
    const BoundShader shut = wide(d.name, -0.1f, 0);
    EXPECT_EQ(beside(shut, 0), 0) << d.name;
    EXPECT_NEAR(beside(shut, -0.2), 1, 1e-5) << d.name;
  }
}

TEST(SpotLight, TheSlideIsAsWideAsTheConeAndUpright) {
  std::string folder = testing::TempDir() + "patina-spotlight-XXXXXX";
  ASSERT_NE(mkdtemp(folder.data()), nullptr);
  std::ofstream(folder + "/slide_linear.ppm", std::ios::binary)
      << "P6 2 2 255\n"
      << std::string("\377\0\0\0\377\0\0\0\377\377\377\377", 12);  // red, green; blue, white
  {
    ErrorHandler errors{[](Severity, std::string_view message) { ADD_FAILURE() << message; }};
    TextureService textures({folder}, {}, size_t{16} << 20, errors);
    const BoundShader shader("spotlight",
                             {number("coneangle", 0.7f), number("conedeltaangle", 0),
                              number("beamdistribution", 0), text("texturename", "slide_linear.ppm")},
                             M44d(), &textures);
    const double middle = std::tan(0.7) / 2;  // of a pixel, from the axis
    expectNear(at(shader, -middle, middle), {1, 0, 0}, 1e-4f);
    expectNear(at(shader, middle, middle), {0, 1, 0}, 1e-4f);
    expectNear(at(shader, -middle, -middle), {0, 0, 1}, 1e-4f);
    expectNear(at(shader, middle, -middle), {1, 1, 1}, 1e-4f);
  }
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace patina::test
