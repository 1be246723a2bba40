// SPDX-License-Identifier: Apache-2.0
// Checks of the parameter table and of prepare and release.
#include <fmt/format.h>
#include <malloc.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <string_view>

#include "renderer/shadercheck/checks.h"
#include "renderer/shading/plugin_file.h"
#include "renderer/shading/shader_argument.h"
#include "renderer/shading/shader_instance.h"

namespace patina::shadercheck {
namespace {

constexpr const char* kTable = "parameter table";

bool isIdentifier(std::string_view name) {
  const auto good = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; };
  return !name.empty() && !std::isdigit(static_cast<unsigned char>(name[0])) &&
         std::all_of(name.begin(), name.end(), good);
}

void checkDefaults(const Context& context, const PatinaParameter& p) {
  if (p.type == PATINA_STRING || p.minimum > p.maximum) return;
  for (uint32_t i = 0; i < valueCountOf(p); ++i) {
    const double value = p.type == PATINA_INT ? p.default_ints[i] : double(p.default_floats[i]);
    // Ranges are doubles, and defaults floats.
    const double slack = 1e-6 * std::max(std::abs(p.minimum), std::min(std::abs(p.maximum), 1e30));
    if (value < p.minimum - slack || value > p.maximum + slack)
      context.findings.fault(kTable,
                             fmt::format("has the default {} for \"{}\", outside of its range [{}, {}]",
                                         value, p.name, p.minimum, p.maximum),
                             "");
  }
}

bool sameTraits(const PatinaTraits& a, const PatinaTraits& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

// Bytes that are allocated, or 0 where the allocator does not say (as with AddressSanitizer).
size_t allocatedBytes() {
#if defined(__GLIBC__)
  return mallinfo2().uordblks;
#else
  return 0;
#endif
}

// A plugin may keep things once, but not again for each binding.
void checkRelease(const Context& context) {
  constexpr int kWarmUp = 4, kTimes = 32;
  const auto bind = [&](int times) {
    for (int k = 0; k < times; ++k) Subject subject(context, context.sets[0]);
  };
  bind(kWarmUp);
  const size_t before = allocatedBytes();
  bind(kTimes);
  const size_t after = allocatedBytes();
  if (after > before && (after - before) / kTimes >= 16)
    context.findings.fault("release",
                           fmt::format("leaves {} bytes behind of every prepare", (after - before) / kTimes),
                           context.sets[0].name());
}

}  // namespace

void checkTable(const Context& context) {
  const PatinaShader& shader = context.shader;
  const auto fault = [&](const std::string& text) { context.findings.fault(kTable, text, ""); };
  if (const std::string wrong = findDescriptorFault(shader); !wrong.empty()) fault(wrong);
  if (shader.abi_minor > PATINA_ABI_MINOR)
    fault(fmt::format("is of the minor version {}, newer than this host's {}", shader.abi_minor,
                      PATINA_ABI_MINOR));
  if (!*shader.doc) fault("has no line of documentation");
  if (!isIdentifier(shader.name)) fault("has a name that is not made of letters, digits and '_'");
  for (uint32_t i = 0; i < shader.parameter_count; ++i) {
    const PatinaParameter& p = parameterOf(shader, i);
    if (!isIdentifier(p.name))
      fault(fmt::format("names a parameter \"{}\", not of letters, digits and '_'", p.name));
    if (!*p.doc) fault(fmt::format("does not document \"{}\"", p.name));
    checkDefaults(context, p);
  }
}

void checkPrepare(const Context& context) {
  for (const ParameterSet& set : context.sets) {
    const Subject first(context, set), second(context, set);
    const auto fault = [&](const std::string& text) { context.findings.fault("prepare", text, set.name()); };
    if (first.status() != PATINA_OK)
      fault(fmt::format("returned the status {} for values within their ranges", first.status()));
    else if (const std::string wrong = findTraitsFault(first.traits()); !wrong.empty())
      fault("says nonsense: " + wrong);
    else if (second.status() != PATINA_OK || !sameTraits(first.traits(), second.traits()))
      fault("says other things the second time");
  }
  checkRelease(context);
}

}  // namespace patina::shadercheck
