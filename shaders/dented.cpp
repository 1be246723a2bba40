// SPDX-License-Identifier: Apache-2.0
// dented: dents of all sizes, after S. Upstill, The RenderMan Companion (1990), listing 16.17.
#include <patina/sdk.h>
#include <patina/sdk/noise.h>

#include <cmath>

using namespace patina::sdk;

namespace {

struct Dented {
  static constexpr int kOctaves = 6;

  struct Parameters {
    float Km = 1;
    float frequency = 1;
  };
  static constexpr auto kInfo = describe(
      "dented",
      "Dents of all sizes: P -= Km * turbulence^3 * N, with six octaves of noise in shader space, each with "
      "half the amplitude at twice the frequency",
      uniform("Km", &Parameters::Km, "depth of the deepest dents, world units"),
      uniform("frequency", &Parameters::frequency, "of the largest dents, per unit of shader space"));

  PatinaStatus prepare(const Parameters& p, Prepare& context) {
    const float* m = context.worldToShader();
    for (int k = 0; k < 16; ++k) toShader_[k] = m[k];
    context.traits.displacement_bound = std::fabs(p.Km);
    if (p.Km == 0) context.disable(PATINA_ENTRY_DISPLACEMENT);
    return PATINA_OK;
  }

  Displaced displacement(const Parameters& p, const Surface<kP | kN>& at) const {
    const float* m = toShader_;
    const Vector q(at.P.x * m[0] + at.P.y * m[4] + at.P.z * m[8] + m[12],
                   at.P.x * m[1] + at.P.y * m[5] + at.P.z * m[9] + m[13],
                   at.P.x * m[2] + at.P.y * m[6] + at.P.z * m[10] + m[14]);
    float size = p.frequency, amplitude = 1, turbulence = 0;
    for (int octave = 0; octave < kOctaves; ++octave) {
      turbulence += amplitude * std::fabs(0.5f - noise(q * size));
      size *= 2, amplitude *= 0.5f;
    }
    return {at.P - at.N * (p.Km * turbulence * turbulence * turbulence)};
  }

 private:
  float toShader_[16] = {};
};

}  // namespace

PATINA_SHADERS(Dented)
