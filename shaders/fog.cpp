// SPDX-License-Identifier: Apache-2.0
// fog: the volume shader of RI 3.2 (appendix A) whose air hides what is far away.
#include <patina/sdk.h>

using namespace patina::sdk;

namespace {

struct Fog {
  struct Parameters {
    float distance = 1;
    Color background = 0;
  };
  static constexpr auto kInfo =
      describe("fog",
               "Air for Atmosphere: Ci = mix(Ci, background, d), Oi = mix(Oi, 1, d), d = 1 - exp(-length(I) "
               "/ distance)",
               uniform("distance", &Parameters::distance, "at which a share of 1 / e is still seen",
                       {1e-6, 1e30}, "world units"),
               uniform("background", &Parameters::background, "colour of the air", kPositive));

  Air atmosphere(const Parameters& p, const AirQuery& at) const {
    const float seen = p.distance > 0 ? std::exp(-at.length / p.distance) : 0.0f;
    return {seen, p.background * (1 - seen)};
  }
};

}  // namespace

PATINA_SHADERS(Fog)
