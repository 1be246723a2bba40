// SPDX-License-Identifier: Apache-2.0
// leaf: a thin sheet that scatters light to both sides, cut out of its surface by a shape or a texture's
// alpha.
#include <patina/sdk.h>

#include <algorithm>
#include <cmath>

using namespace patina::sdk;

namespace {

struct Leaf {
  struct Parameters {
    float Ka = 1, Kd = 0.6f, Kt = 0.3f, width = 1;
    Color transmitcolor = 1;
    const char* texturename = "";
  };
  static constexpr auto kInfo = describe(
      "leaf",
      "A leaf from t = 0 to t = 1 that scatters light to both sides: Ci = Oi * Cs * (Ka * ambient() + Kd * "
      "diffuse(N) + Kt * transmitcolor * diffuse(-N)), Oi = Os where the leaf is; Kd and Kt are scaled down "
      "to a sum of 1 where it is more",
      uniform("Ka", &Parameters::Ka, "weight of ambient lights", kUnitRange),
      uniform("Kd", &Parameters::Kd, "share of light reflected", kUnitRange),
      uniform("Kt", &Parameters::Kt, "share of light let through, diffusely", kUnitRange),
      uniform("width", &Parameters::width, "of the leaf's broadest part along s, when there is no texture",
              kUnitRange),
      uniform("transmitcolor", &Parameters::transmitcolor, "colour of light let through", kUnitRange),
      uniform("texturename", &Parameters::texturename,
              "texture whose alpha is the leaf's shape; \"\" = two arcs"));
  static constexpr uint64_t kTraits = PATINA_TRAIT_TRANSMITS;

  PatinaStatus prepare(const Parameters& p, Prepare& context) {
    shape_ = context.openData(p.texturename);
    reflects_ = p.Kd / std::max(p.Kd + p.Kt, 1.0f), transmits_ = p.Kt / std::max(p.Kd + p.Kt, 1.0f);
    if (p.Kd == 0 && p.Kt == 0) context.set(PATINA_TRAIT_BLACK);
    if (p.Kt == 0) context.clear(PATINA_TRAIT_TRANSMITS);
    return PATINA_OK;
  }

  PatinaTexture* texture(uint32_t) const { return shape_; }
  std::array<TextureLookup, 1> lookups(const Parameters&, const Surface<kST | kFootprint>& at) const {
    return {{{at.s, at.t, at.footprint_st}}};
  }

  Radiosity radiosity(const Parameters& p, const Surface<kST | kFootprint | kCs | kOs>& at,
                      const Texels<1>& texels) const {
    Radiosity out;
    out.opacity = at.Os * (shape_ ? texels[0].alpha : covered(p.width, at.s, at.t, at.footprint_st));
    const Color color = out.opacity * at.Cs;
    out.reflectance = color * reflects_;
    out.transmittance = color * p.transmitcolor * transmits_;
    out.ambient = color * p.Ka;
    return out;
  }

 private:
  /// The share of a square of edge `size` around (s, t) that lies within |s - 1/2| < width/2 sin(pi t), 0 < t
  /// < 1: exact along s for the mean breadth over the square's part of t.
  static float covered(float width, float s, float t, float size) {
    constexpr float kPi = 3.14159265f;
    const float half = std::max(size, 1e-4f) / 2;
    const float low = std::clamp(t - half, 0.0f, 1.0f), high = std::clamp(t + half, 0.0f, 1.0f);
    const float reach = high - low;
    if (!(reach > 0)) return 0;
    const float breadth =
        width / 2 *
        (reach > 1e-3f ? (std::cos(kPi * low) - std::cos(kPi * high)) / (kPi * reach) : std::sin(kPi * t));
    const float inside = std::min(s + half, 0.5f + breadth) - std::max(s - half, 0.5f - breadth);
    // `reach` is a difference of numbers near t: its rounding is not to make more than one of a small square.
    return std::clamp(inside / (2 * half), 0.0f, 1.0f) * std::min(reach / (2 * half), 1.0f);
  }

  PatinaTexture* shape_ = nullptr;
  float reflects_ = 0, transmits_ = 0;  // shares of light, together not more than one
};

}  // namespace

PATINA_SHADERS(Leaf)
