// SPDX-License-Identifier: Apache-2.0
// brick: a wall of bricks in mortar along the texture coordinates, each brick of its own shade.
#include <patina/sdk.h>
#include <patina/sdk/cells.h>
#include <patina/sdk/filter.h>

using namespace patina::sdk;

namespace {

struct Brick {
  struct Parameters {
    float Ka = 1, Kd = 1, frequency = 4, aspect = 3, mortar = 0.12f, stagger = 0.5f, jitter = 0.5f;
    Color brickcolor{0.55f, 0.16f, 0.09f}, mortarcolor{0.55f, 0.52f, 0.47f};
  };
  static constexpr auto kInfo = describe(
      "brick",
      "A diffuse brick wall, courses along s: Ci = Os * Cs * C * (Ka * ambient() + Kd * diffuse(N)), where C "
      "is "
      "mortarcolor, or brickcolor darkened at random by brick",
      varying("Ka", &Parameters::Ka, "weight of ambient lights", kUnitRange),
      varying("Kd", &Parameters::Kd, "weight of diffuse reflection", kUnitRange),
      uniform("frequency", &Parameters::frequency, "bricks along one unit of s", {0, 1e6}),
      uniform("aspect", &Parameters::aspect, "length of a brick over its height, joints included",
              {0.01, 100}),
      uniform("mortar", &Parameters::mortar, "thickness of joints over the height of a course", {0, 0.5}),
      uniform("stagger", &Parameters::stagger,
              "how far each course is shifted against the one below, in bricks", kUnitRange),
      uniform("jitter", &Parameters::jitter, "how much darker than brickcolor the darkest bricks are",
              kUnitRange),
      uniform("brickcolor", &Parameters::brickcolor, "colour of the brightest bricks", kUnitRange),
      uniform("mortarcolor", &Parameters::mortarcolor, "colour of joints", kUnitRange));
  static constexpr uint64_t kTraits = PATINA_TRAIT_OPACITY_IS_OS;

  Radiosity radiosity(const Parameters& p, const Surface<kST | kFootprint | kCs | kOs>& at) const {
    // In courses and in bricks of the course in the middle; both are cut off by joints from the whole numbers
    // on.
    const float alongT = p.frequency * p.aspect, y = alongT * at.t, course = y - fraction(y);
    const float x = p.frequency * at.s + fraction(p.stagger * course);
    const float widthX = p.frequency * at.footprint_st, widthY = alongT * at.footprint_st;
    const float brick =
        filteredPulseTrain(1 - p.mortar, y, widthY) * filteredPulseTrain(1 - p.mortar / p.aspect, x, widthX);

    // Mostly brightness, a little hue; to the mean where the footprint holds several bricks.
    const Color chance = mix(Color(cellnoise(x, course + 0.5f)), ccellnoise(x, course + 0.5f), 0.3f);
    const Color shade = Color(1) - mix(Color(0.5f), chance, cellLeft(widthY)) * p.jitter;
    return diffuseSurface(at.Cs * mix(p.mortarcolor, p.brickcolor * shade, brick), at.Os, p.Ka, p.Kd);
  }
};

}  // namespace

PATINA_SHADERS(Brick)
