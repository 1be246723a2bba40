// SPDX-License-Identifier: Apache-2.0
// Writes a shader's table as Declare lines, as Markdown and as JSON.
#include "tools/patina-shader/listing.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "renderer/shading/plugin_file.h"

namespace patina {
namespace {

std::string typeOf(const PatinaParameter& p) {
  const std::string type(typeName(p.type));
  return p.array_length ? fmt::format("{}[{}]", type, p.array_length) : type;
}

std::string_view storageOf(const PatinaParameter& p) {
  return p.storage == PATINA_VARYING ? "varying" : "uniform";
}

// Separated by blanks; strings quoted as RIB has them.
std::string defaultOf(const PatinaParameter& p) {
  std::string text;
  for (uint32_t i = 0; i < componentsOf(p.type) * std::max(p.array_length, 1u); ++i) {
    if (i) text += ' ';
    if (p.type == PATINA_STRING)
      text += fmt::format("\"{}\"", p.default_strings[i]);
    else if (p.type == PATINA_INT)
      text += fmt::format("{}", p.default_ints[i]);
    else
      text += fmt::format("{}", p.default_floats[i]);
  }
  return text;
}

std::string rangeOf(const PatinaParameter& p) {
  if (p.minimum > p.maximum) return "any";
  if (p.maximum >= 1e30) return fmt::format("from {:g}", p.minimum);
  return fmt::format("{:g} to {:g}", p.minimum, p.maximum);
}

// A cell of a Markdown table: no bars.
std::string cell(std::string text) {
  for (size_t i = 0; (i = text.find('|', i)) != std::string::npos; i += 2) text.insert(i, "\\");
  return text;
}

}  // namespace

std::string ribListing(const PatinaShader& shader) {
  std::string text = fmt::format("# {}: {}\n", shader.name, shader.doc);
  for (uint32_t i = 0; i < shader.parameter_count; ++i) {
    const PatinaParameter& p = parameterOf(shader, i);
    text += fmt::format("Declare \"{0}\" \"{1} {2}\"  # \"{1} {2} {0}\" [{3}]\n", p.name, storageOf(p),
                        typeOf(p), defaultOf(p));
  }
  return text;
}

std::string markdownListing(const PatinaShader& shader) {
  std::string text = fmt::format("## {}\n\n{}\n", shader.name, shader.doc);
  if (shader.parameter_count == 0) return text;
  text +=
      "\n| parameter | type | default | range | unit | meaning |\n| --- | --- | --- | --- | --- | --- |\n";
  for (uint32_t i = 0; i < shader.parameter_count; ++i) {
    const PatinaParameter& p = parameterOf(shader, i);
    text +=
        fmt::format("| {} | {} {} | {} | {} | {} | {} |\n", p.name, storageOf(p), typeOf(p),
                    cell(defaultOf(p)), p.type == PATINA_STRING ? "" : rangeOf(p), cell(p.unit), cell(p.doc));
  }
  return text;
}

nlohmann::ordered_json jsonListing(const PatinaShader& shader) {
  nlohmann::ordered_json listing = {{"shader", shader.name},
                                    {"doc", shader.doc},
                                    {"abi_minor", shader.abi_minor},
                                    {"parameters", nlohmann::ordered_json::array()}};
  for (uint32_t i = 0; i < shader.parameter_count; ++i) {
    const PatinaParameter& p = parameterOf(shader, i);
    nlohmann::ordered_json defaults = nlohmann::ordered_json::array();
    for (uint32_t k = 0; k < componentsOf(p.type) * std::max(p.array_length, 1u); ++k) {
      if (p.type == PATINA_STRING)
        defaults.push_back(p.default_strings[k]);
      else if (p.type == PATINA_INT)
        defaults.push_back(p.default_ints[k]);
      else
        defaults.push_back(p.default_floats[k]);
    }
    nlohmann::ordered_json entry = {{"name", p.name},
                                    {"type", typeName(p.type)},
                                    {"array_length", p.array_length},
                                    {"storage", storageOf(p)},
                                    {"default", defaults}};
    if (p.minimum <= p.maximum) entry["minimum"] = p.minimum, entry["maximum"] = p.maximum;
    entry["unit"] = p.unit, entry["doc"] = p.doc;
    listing["parameters"].push_back(entry);
  }
  return listing;
}

void addUses(nlohmann::ordered_json& listing, const shadercheck::Uses& uses) {
  static constexpr const char* kEntries[] = {"displacement", "light", "radiosity", "view"};
  static constexpr const char* kKinds[] = {"none", "ambient", "delta", "infinite", "area"};
  listing["entries"] = listing["light"] = nlohmann::ordered_json::array();
  for (uint32_t i = 0; i < std::size(kEntries); ++i)
    if (uses.active >> i & 1u) listing["entries"].push_back(kEntries[i]);
  if (uses.atmosphere) listing["entries"].push_back("atmosphere");
  for (uint32_t i = 0; i < std::size(kKinds); ++i)
    if (uses.lightKinds >> i & 1u) listing["light"].push_back(kKinds[i]);
  listing["from_point"] = uses.fromPoint;
}

}  // namespace patina
