// SPDX-License-Identifier: Apache-2.0
// Prepares a shader with all sets of parameters, and looks at the traits.
#include "renderer/shadercheck/uses.h"

#include <memory>

#include "renderer/shadercheck/subject.h"

namespace patina::shadercheck {

Uses usesOf(const PatinaShader& shader) {
  const auto progress = std::make_unique<Progress>();
  Findings findings(-1, *progress);  // what is wrong is for the checks to say
  const std::vector<ParameterSet> sets = makeParameterSets(shader, 0);
  Uses uses;
  forEachSubject({shader, sets, findings}, [&](const Subject& subject) {
    uses.active |= subject.traits().active;
    uses.fromPoint |= subject.has(PATINA_TRAIT_FROM_POINT);
    uses.atmosphere |= subject.atmosphere() != nullptr;
    if (subject.active(PATINA_ENTRY_LIGHT)) uses.lightKinds |= 1u << (subject.traits().light_kind & 31u);
  });
  return uses;
}

}  // namespace patina::shadercheck
