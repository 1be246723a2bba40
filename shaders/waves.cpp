// SPDX-License-Identifier: Apache-2.0
// waves: a surface displaced by sine waves along its texture coordinates.
#include <patina/sdk.h>

#include <cmath>
#include <numbers>

using namespace patina::sdk;

namespace {

struct Waves {
  struct Parameters {
    float amplitude = 0.1f;
    float sfrequency = 8, tfrequency = 8;
  };
  static constexpr auto kInfo = describe(
      "waves", "Displacement by waves: P += amplitude * cos(2 pi sfrequency s) * cos(2 pi tfrequency t) * N",
      varying("amplitude", &Parameters::amplitude, "height of the crests, world units"),
      uniform("sfrequency", &Parameters::sfrequency, "waves per unit of s; 0 = none along s"),
      uniform("tfrequency", &Parameters::tfrequency, "waves per unit of t; 0 = none along t"));

  Displaced displacement(const Parameters& p, const Surface<kP | kN | kST>& at) const {
    constexpr float kTurn = 2 * std::numbers::pi_v<float>;
    // Whole waves are dropped first, so that large frequencies stay exact.
    const auto wave = [](float x) { return std::cos(kTurn * (x - std::floor(x))); };
    return {at.P + at.N * (p.amplitude * wave(p.sfrequency * at.s) * wave(p.tfrequency * at.t))};
  }
};

}  // namespace

PATINA_SHADERS(Waves)
