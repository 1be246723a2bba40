// SPDX-License-Identifier: Apache-2.0
// depthcue: the volume shader of RI 3.2 (appendix A) that fades to a colour between two depths.
#include <patina/sdk.h>

using namespace patina::sdk;

namespace {

struct DepthCue {
  struct Parameters {
    float mindistance = 0, maxdistance = 1;
    Color background = 0;
  };
  static constexpr auto kInfo = describe(
      "depthcue",
      "Air for Atmosphere: Ci = mix(Ci, background, d), Oi = mix(Oi, 1, d), d = clamp((depth(P) - "
      "mindistance) / "
      "(maxdistance - mindistance), 0, 1), depths being 0 at the near and 1 at the far plane of Clipping",
      uniform("mindistance", &Parameters::mindistance, "depth where the fading begins"),
      uniform("maxdistance", &Parameters::maxdistance, "depth where only the background is seen"),
      uniform("background", &Parameters::background, "colour that is faded to", kPositive));

  Air atmosphere(const Parameters& p, const AirQuery& at) const {
    // What has faded before the segment is not faded again.
    const float before = seenAt(p, at.depthAtOrigin);
    const float seen = before > 0 ? std::min(seenAt(p, at.depth) / before, 1.0f) : 0.0f;
    return {seen, p.background * (1 - seen)};
  }

 private:
  static float seenAt(const Parameters& p, float depth) {
    const float range = p.maxdistance - p.mindistance;
    if (range == 0) return depth < p.mindistance ? 1.0f : 0.0f;
    return 1 - clamp((depth - p.mindistance) / range, 0, 1);
  }
};

}  // namespace

PATINA_SHADERS(DepthCue)
