// SPDX-License-Identifier: Apache-2.0
// null: a surface that is not there.
#include <patina/sdk.h>

using namespace patina::sdk;

namespace {

struct Null {
  static constexpr auto kInfo = describe("null", "Fully transparent: Oi = 0, Ci = 0");
  static constexpr uint64_t kTraits = PATINA_TRAIT_TRANSPARENT | PATINA_TRAIT_BLACK;

  Radiosity radiosity(const NoParameters&, const Surface<0>&) const {
    Radiosity out;
    out.opacity = 0;
    return out;
  }
};

}  // namespace

PATINA_SHADERS(Null)
