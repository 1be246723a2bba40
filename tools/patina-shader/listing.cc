// SPDX-License-Identifier: Apache-2.0
// Writes a shader's table as Declare lines and as Markdown.
#include "tools/patina-shader/listing.h"

#include <fmt/format.h>

#include <algorithm>

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

}  // namespace patina
