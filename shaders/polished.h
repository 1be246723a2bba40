// SPDX-License-Identifier: Apache-2.0
// What polished stone and wood have in common: RI's plastic over a pattern.
#pragma once

#include <patina/sdk.h>

namespace patina::shaders {

/// Their Parameters derive from it, and their description begins with `polishParameters<Parameters>()`.
struct PolishParameters {
  float Ka = 1, Kd = 0.8f, Ks, roughness;
  sdk::Color specularcolor = 1;
  constexpr PolishParameters(float Ks_, float roughness_) : Ks(Ks_), roughness(roughness_) {}
};
template <class P>
constexpr auto polishParameters() {
  const auto own = []<class T>(const char* name, T PolishParameters::*member, const char* doc,
                               sdk::Range range) {
    return sdk::uniform(name, static_cast<T P::*>(member), doc, range);
  };
  return std::tuple{
      own("Ka", &PolishParameters::Ka, "weight of ambient lights", sdk::kUnitRange),
      own("Kd", &PolishParameters::Kd, "weight of diffuse reflection", sdk::kUnitRange),
      own("Ks", &PolishParameters::Ks, "weight of highlights", sdk::kUnitRange),
      own("roughness", &PolishParameters::roughness, "size of highlights: the exponent is 8 / roughness",
          {1e-4, 10}),
      own("specularcolor", &PolishParameters::specularcolor, "colour of highlights", sdk::kUnitRange)};
}

}  // namespace patina::shaders
