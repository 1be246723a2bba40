// SPDX-License-Identifier: Apache-2.0
// Emits user attributes: "tint" of each primitive, times "gain", the sum of "weights" and the length of
// "word" where the request binds it, as far as it is told to read them.
#include <patina/sdk.h>

using namespace patina::sdk;

namespace {

struct AttributesShader {
  struct Parameters {
    Color tint = 0;
    float number = 1;
    int32_t reads = 0;
  };
  static constexpr auto kInfo =
      describe("attributes", "for tests", varying("tint", &Parameters::tint, "by the attribute of this name"),
               varying("number", &Parameters::number, "by the attribute `id`"),
               uniform("reads", &Parameters::reads, "1: those of the request"));
  static constexpr uint64_t kTraits = PATINA_TRAIT_OPAQUE | PATINA_TRAIT_EMITS | PATINA_TRAIT_BLACK;

  PatinaStatus prepare(const Parameters& p, Prepare& context) {
    if (!context.bindAttribute("tint", "tint") || !context.bindAttribute("id", "number") ||
        context.bindAttribute("id", "reads") || context.bindAttribute("id", "nothing"))
      return PATINA_ERROR_INTERNAL;
    if (!p.reads) return PATINA_OK;
    float gain = 0;
    int32_t wrong = 0;
    std::array<float, 3> weights{};
    const char* word = "";
    if (context.attribute("gain", gain)) gain_ *= gain;
    if (context.attribute("weights", weights)) gain_ *= weights[0] + weights[1] + weights[2];
    if (context.attribute("word", word)) gain_ *= float(std::strlen(word));
    if (context.attribute("gain", wrong)) return PATINA_ERROR_INTERNAL;  // of another type
    return PATINA_OK;
  }
  Radiosity radiosity(const Parameters& p, const Surface<kN>&) const {
    Radiosity out;
    out.emission = p.tint * (p.number * gain_);
    return out;
  }

  float gain_ = 1;
};

}  // namespace

PATINA_SHADERS(AttributesShader)
