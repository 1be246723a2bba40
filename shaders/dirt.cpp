// SPDX-License-Identifier: Apache-2.0
// dirt: paint that is dirty where it is hollow, and worn off where it stands out.
//
// Short rays about the outward normal tell hollows: those that meet something near. The same rays within the
// solid tell edges: near those they leave it soon. Both count what is met by how near it is, so that hollows
// fade out, and a plane has neither.
#include <patina/sdk.h>
#include <patina/sdk/fractals.h>
#include <patina/sdk/rays.h>

using namespace patina::sdk;

namespace {

struct Dirt {
  static constexpr int kRays = 16;  // on each side

  struct Parameters {
    float Ka = 1, Kd = 1, hollows = 1, edges = 0, distance = 0.2f, patchiness = 0.5f, frequency = 4;
    Color dirtcolor{0.09f, 0.065f, 0.04f}, edgecolor{0.75f, 0.72f, 0.68f};
  };
  static constexpr auto kInfo = describe(
      "dirt",
      "A diffuse surface with dirtcolor in its hollows and edgecolor along its edges: Ci = Os * C * (Ka * "
      "ambient() + Kd * diffuse(N)), where C is Cs elsewhere",
      uniform("Ka", &Parameters::Ka, "weight of ambient lights", kUnitRange),
      uniform("Kd", &Parameters::Kd, "weight of diffuse reflection", kUnitRange),
      uniform("hollows", &Parameters::hollows,
              "how much dirt there is; 1 = the bottom of a right-angled groove is covered; 0 = none",
              {0, 10}),
      uniform("edges", &Parameters::edges,
              "how worn edges are, likewise, of what is thicker than `distance`; 0 = not at all", {0, 10}),
      uniform("distance", &Parameters::distance, "how far from a hollow's or edge's middle it is seen",
              kPositive, "world units"),
      uniform("patchiness", &Parameters::patchiness, "how uneven both are, by noise", kUnitRange),
      uniform("frequency", &Parameters::frequency, "of that noise, in one unit of shader space", {0, 1e6}),
      uniform("dirtcolor", &Parameters::dirtcolor, "colour of the dirt", kUnitRange),
      uniform("edgecolor", &Parameters::edgecolor, "colour of what is below the paint", kUnitRange));
  static constexpr uint64_t kTraits = PATINA_TRAIT_OPACITY_IS_OS;

  PatinaStatus prepare(const Parameters& p, Prepare& context) {
    toShader_ = Matrix(context.worldToShader());
    rays_ = p.distance == 0 ? 0 : p.edges > 0 ? 2 * kRays : p.hollows > 0 ? kRays : 0;
    outward_ = p.hollows > 0 ? p.distance : 0;
    return PATINA_OK;
  }

  uint32_t rayCount() const { return rays_; }
  std::array<RayQuery, 2 * kRays> rays(const Parameters& p, const Surface<kN | kNg>& at) const {
    std::array<RayQuery, 2 * kRays> queries;
    unrolled<kRays>([&](auto k) PATINA_INLINE_LAMBDA {
      // By the cosine of the angle to N; what is below the facet is turned up.
      const Vector about = at.N + spherePoint(k, kRays) * 0.999f;
      const Vector outward = about - at.Ng * (2 * std::min(dot(about, at.Ng), 0.0f));
      queries[k] = {outward, outward_};
      queries[kRays + k] = {-outward, p.distance};
    });
    return queries;
  }

  Radiosity radiosity(const Parameters& p, const Surface<kP | kFootprint | kCs | kOs>& at,
                      const Distances<2 * kRays>& met) const {
    float hollow = 0, edge = 0;
    const float scale = 1 / std::max(p.distance, 1e-30f);
    unrolled<kRays>([&](auto k) PATINA_INLINE_LAMBDA {
      hollow += std::max(1 - met.ray[k] * scale, 0.0f);
      edge += std::max(1 - met.ray[kRays + k] * scale, 0.0f);
    });
    // Half of all rays meet the other wall of a groove.
    constexpr float kWhole = 2.0f / kRays;
    const Vector q = toShader_.point(at.P) * p.frequency;
    const float width = at.footprint * toShader_.scale() * p.frequency;
    const float patches = 1 + 2 * p.patchiness * fbm<4>(q, width);
    const float dirt = clamp(p.hollows * kWhole * hollow * patches, 0, 1),
                wear = clamp(p.edges * kWhole * edge * patches, 0, 1);
    return diffuseSurface(mix(mix(at.Cs, p.edgecolor, wear), p.dirtcolor, dirt), at.Os, p.Ka, p.Kd);
  }

 private:
  Matrix toShader_;
  uint32_t rays_ = 0;
  float outward_ = 0;  // how far rays go that look for hollows
};

}  // namespace

PATINA_SHADERS(Dirt)
