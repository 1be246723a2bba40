// SPDX-License-Identifier: Apache-2.0
// showst: texture coordinates as colours, to see how a surface is parametrised.
#include <patina/sdk.h>

#include <cmath>

using namespace patina::sdk;

namespace {

struct ShowSt {
  static constexpr auto kInfo = describe(
      "showst",
      "Texture coordinates as colours, whatever light there is: Ci = Os * (s, t, 0); outside of 0 to 1 their "
      "fractional parts");
  static constexpr uint64_t kTraits = PATINA_TRAIT_OPACITY_IS_OS | PATINA_TRAIT_EMITS | PATINA_TRAIT_BLACK;

  Radiosity radiosity(const NoParameters&, const Surface<kST | kOs>& at) const {
    const auto shown = [](float x) { return x >= 0 && x <= 1 ? x : x - std::floor(x); };
    Radiosity out;
    out.emission = at.Os * Color(shown(at.s), shown(at.t), 0);
    out.opacity = at.Os;
    return out;
  }
};

}  // namespace

PATINA_SHADERS(ShowSt)
