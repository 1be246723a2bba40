// SPDX-License-Identifier: Apache-2.0
// signal: a surface that glows in the colour of the geometry, whatever light falls on it.
#include <patina/sdk.h>

using namespace patina::sdk;

namespace {

struct Signal {
  struct Parameters {
    float gain = 1;
  };
  static constexpr auto kInfo = describe("signal", "Gives off gain * Cs",
                                         varying("gain", &Parameters::gain, "factor on Cs", kPositive));
  static constexpr uint64_t kTraits = PATINA_TRAIT_OPAQUE | PATINA_TRAIT_EMITS | PATINA_TRAIT_BLACK;

  Radiosity radiosity(const Parameters& parameters, const Surface<kCs>& at) const {
    Radiosity out;
    out.emission = at.Cs * parameters.gain;
    return out;
  }
};

}  // namespace

PATINA_SHADERS(Signal)
