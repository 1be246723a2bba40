// SPDX-License-Identifier: Apache-2.0
// variation: one material for many objects, no two of which have the same colour.
#include <patina/sdk.h>
#include <patina/sdk/cells.h>
#include <patina/sdk/color.h>

using namespace patina::sdk;

namespace {

struct Variation {
  struct Parameters {
    float Ka = 1, Kd = 1, seed = 0, hue = 0.04f, saturation = 0.3f, value = 0.3f;
    const char* attribute = "variation";
  };
  static constexpr auto kInfo = describe(
      "variation",
      "Ideal diffuse reflection by a colour near Cs that depends on a number of the object: Ci = Os * C * "
      "(Ka * "
      "ambient() + Kd * diffuse(N)); whole numbers give colours that have nothing to do with each other",
      uniform("Ka", &Parameters::Ka, "weight of ambient lights", kUnitRange),
      uniform("Kd", &Parameters::Kd, "weight of diffuse reflection", kUnitRange),
      varying("seed", &Parameters::seed, "which of the colours"),
      uniform("attribute", &Parameters::attribute,
              "user attribute of the object that takes the place of seed: Attribute \"user\" \"float "
              "variation\" [7]"),
      uniform("hue", &Parameters::hue, "how far hues differ from that of Cs at most; 0.5 = any hue",
              {0, 0.5}),
      uniform("saturation", &Parameters::saturation, "the same of saturation, relative to it", kUnitRange),
      uniform("value", &Parameters::value, "the same of value (how bright the colour is)", kUnitRange));
  static constexpr uint64_t kTraits = PATINA_TRAIT_OPACITY_IS_OS;

  PatinaStatus prepare(const Parameters& p, Prepare& context) {
    context.bindAttribute(p.attribute, "seed");
    return PATINA_OK;
  }

  Radiosity radiosity(const Parameters& p, const Surface<kCs | kOs>& at) const {
    // From the middle of cells: whole numbers that were interpolated are still in theirs.
    const Vector random = vcellnoise(p.seed + 0.5f);
    const auto around = [](float r) PATINA_INLINE_LAMBDA { return 2 * r - 1; };
    const Color hsv = rgbToHsv(at.Cs);
    const Color varied = hsvToRgb({hsv.r + p.hue * around(random.x),
                                   clamp(hsv.g * (1 + p.saturation * around(random.y)), 0, 1),
                                   clamp(hsv.b * (1 + p.value * around(random.z)), 0, 1)});
    return diffuseSurface(varied, at.Os, p.Ka, p.Kd);
  }
};

}  // namespace

PATINA_SHADERS(Variation)
