// SPDX-License-Identifier: Apache-2.0
// noisebump: rough ground, by fractional Brownian motion.
#include <patina/sdk.h>
#include <patina/sdk/fractals.h>

using namespace patina::sdk;

namespace {

struct NoiseBump {
  static constexpr int kOctaves = 6;

  struct Parameters {
    float Km = 0.1f, frequency = 1, lacunarity = 2, gain = 0.5f;
  };
  static constexpr auto kInfo = describe(
      "noisebump",
      "Displacement by six octaves of noise in shader space: P += Km * fBm * N, where fBm lies within -1 and "
      "1 "
      "and is 0 on average",
      uniform("Km", &Parameters::Km, "height that no hill exceeds, world units"),
      uniform("frequency", &Parameters::frequency, "of the largest hills, in one unit of shader space",
              {0, 1e6}),
      uniform("lacunarity", &Parameters::lacunarity, "frequency of each octave over that of the one before",
              {1, 4}),
      uniform("gain", &Parameters::gain, "height of each octave over that of the one before", kUnitRange));

  PatinaStatus prepare(const Parameters& p, Prepare& context) {
    toShader_ = Matrix(context.worldToShader());
    gain_ = clamp(p.gain, 0, 1);
    if (p.frequency != 0) scale_ = p.Km / amplitudes<kOctaves>(gain_);
    context.traits.displacement_bound = std::abs(p.Km);
    if (scale_ == 0) context.disable(PATINA_ENTRY_DISPLACEMENT);
    return PATINA_OK;
  }

  Displaced displacement(const Parameters& p, const Surface<kP | kN | kFootprint>& at) const {
    const Vector q = toShader_.point(at.P) * p.frequency;
    const float width = at.footprint * toShader_.scale() * p.frequency;
    return {at.P + at.N * (scale_ * fbm<kOctaves>(q, width, p.lacunarity, gain_))};
  }

 private:
  Matrix toShader_;
  float gain_ = 0, scale_ = 0;
};

}  // namespace

PATINA_SHADERS(NoiseBump)
