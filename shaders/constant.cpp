// SPDX-License-Identifier: Apache-2.0
// constant: the surface of RI 3.2 that is its colour, whatever light there is.
#include <patina/sdk.h>

using namespace patina::sdk;

namespace {

struct Constant {
  static constexpr auto kInfo = describe("constant", "Constant colour: Ci = Os * Cs");
  static constexpr uint64_t kTraits = PATINA_TRAIT_OPACITY_IS_OS | PATINA_TRAIT_EMITS | PATINA_TRAIT_BLACK;

  Radiosity radiosity(const NoParameters&, const Surface<kCs | kOs>& at) const {
    Radiosity out;
    out.emission = at.Os * at.Cs;
    out.opacity = at.Os;
    return out;
  }
};

}  // namespace

PATINA_SHADERS(Constant)
