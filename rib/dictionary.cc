// SPDX-License-Identifier: Apache-2.0
// Declarations: parsing them, the predeclared names, and the nearest known name to a misspelt one.
#include <algorithm>
#include <cctype>
#include <charconv>

#include <fmt/format.h>

#include "rib/params.h"

namespace patina {
namespace {

constexpr uint32_t kMaxArrayLength = 1u << 20;
constexpr size_t kMaxInlineMemo =
    4096;  // a hostile file may hold any number of different inline declarations

bool isBlank(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

std::optional<StorageClass> storageClass(std::string_view word) {
  for (auto s : {StorageClass::Constant, StorageClass::Uniform, StorageClass::Varying, StorageClass::Vertex,
                 StorageClass::FaceVarying, StorageClass::FaceVertex}) {
    if (word == name(s)) return s;
  }
  return std::nullopt;
}

std::optional<ValueType> valueType(std::string_view word) {
  if (word == "integer" || word == "bool") return ValueType::Integer;
  for (auto t :
       {ValueType::Float, ValueType::Integer, ValueType::String, ValueType::Color, ValueType::Point,
        ValueType::Vector, ValueType::Normal, ValueType::HPoint, ValueType::Matrix, ValueType::MPoint}) {
    if (word == name(t)) return t;
  }
  return std::nullopt;
}

// The next word of a declaration; words end at blanks and brackets, and "[n]" is a word by itself.
std::string_view nextWord(std::string_view& text) {
  while (!text.empty() && isBlank(text.front())) text.remove_prefix(1);
  size_t n = 0;
  if (!text.empty() && text.front() == '[') {
    n = std::min(text.find(']'), text.size() - 1) + 1;
  } else {
    while (n < text.size() && !isBlank(text[n]) && text[n] != '[') ++n;
  }
  const std::string_view word = text.substr(0, n);
  text.remove_prefix(n);
  return word;
}

// "[n]" -> n; 0 when it is anything else.
uint32_t arrayLength(std::string_view word) {
  if (word.size() < 3 || word.front() != '[' || word.back() != ']') return 0;
  word = word.substr(1, word.size() - 2);
  while (!word.empty() && isBlank(word.front())) word.remove_prefix(1);
  while (!word.empty() && isBlank(word.back())) word.remove_suffix(1);
  uint32_t n = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), n);
  return error == std::errc() && end == word.data() + word.size() && n <= kMaxArrayLength ? n : 0;
}

struct Predeclared {
  std::string_view declaration, names;
};

// RI 3.2's names (the tables of Aqsis and RiCPP agree on them), the parameters of the standard shaders, and
// the option and attribute names that files write without a declaration.
constexpr Predeclared kPredeclared[] = {
    {"vertex point", "P"},
    {"vertex float", "Pz"},
    {"vertex hpoint", "Pw"},
    {"varying normal", "N"},
    {"uniform normal", "Np"},
    {"varying color", "Cs Os"},
    {"varying float", "s t width"},
    {"varying float[2]", "st"},
    {"constant float", "constantwidth"},
    {"constant normal", "constantnormal"},
    {"uniform float",
     "Ka Kd Ks Kr Km roughness intensity coneangle conedeltaangle beamdistribution mindistance maxdistance "
     "distance fov sphere bias bias0 bias1"},
    {"uniform string",
     "texturename shader archive texture display procedural resource name shadinggroup coordinatesystem "
     "sense "
     "shadows shadowname"},
    {"uniform color", "specularcolor lightcolor background bgcolor color emission zthreshold othreshold"},
    {"uniform point", "from to"},
    {"uniform int",
     "gridsize texturememory eyesplits endofframe jitter maxdepth maxdiffusedepth maxspeculardepth "
     "minsamples "
     "maxsamples incremental geocachememory radiositycachememory opacitycachememory"},
    {"uniform int[2]", "bucketsize origin"},
};

}  // namespace

std::string_view name(StorageClass storage) {
  constexpr std::string_view names[] = {"constant", "uniform",     "varying",
                                        "vertex",   "facevarying", "facevertex"};
  return names[static_cast<size_t>(storage)];
}

std::string_view name(ValueType type) {
  constexpr std::string_view names[] = {"float",  "int",    "string", "color",  "point",
                                        "vector", "normal", "hpoint", "matrix", "mpoint"};
  return names[static_cast<size_t>(type)];
}

int componentCount(ValueType type) {
  constexpr int counts[] = {1, 1, 1, 3, 3, 3, 3, 4, 16, 16};
  return counts[static_cast<size_t>(type)];
}

std::optional<Declaration> parseDeclaration(std::string_view text) {
  Declaration result;
  std::string_view word = nextWord(text);
  if (const auto storage = storageClass(word)) {
    result.storage = *storage;
    word = nextWord(text);
  }
  if (word == "reference") {
    result.reference = true;
    word = nextWord(text);
  }
  const auto type = valueType(word);
  // What a reference refers to need not be a value: "reference bxdf x", "reference lightfilter x".
  if (!type && !(result.reference && !word.empty() && word.front() != '[')) return std::nullopt;
  result.type = type.value_or(ValueType::String);

  word = nextWord(text);
  const auto takeLength = [&] {
    if (word.empty() || word.front() != '[') return true;
    result.arrayLength = arrayLength(word);
    word = nextWord(text);
    return result.arrayLength != 0;
  };
  if (!takeLength()) return std::nullopt;
  if (!word.empty() && word.front() != '[') {
    result.name = word;
    word = nextWord(text);
    if (result.arrayLength == 1 && !takeLength()) return std::nullopt;  // "float st[2]", as shaders write it
  }
  return word.empty() ? std::optional(result) : std::nullopt;
}

std::string toString(const Declaration& d) {
  const std::string length = d.arrayLength == 1 ? std::string() : fmt::format("[{}]", d.arrayLength);
  return fmt::format("{} {}{}{}{}{}", name(d.storage), d.reference ? "reference " : "", name(d.type), length,
                     d.name.empty() ? "" : " ", d.name);
}

// Made once for all dictionaries.
const Dictionary::Names<Declaration>& Dictionary::predeclared() {
  static const Names<Declaration> all = [] {
    Names<Declaration> result;
    for (auto [text, names] : kPredeclared) {
      const std::optional<Declaration> declaration = parseDeclaration(text);
      for (std::string_view word = nextWord(names); !word.empty(); word = nextWord(names))
        result.emplace(word, *declaration);
    }
    return result;
  }();
  return all;
}

bool Dictionary::declare(std::string_view name, std::string_view text) {
  std::optional<Declaration> declaration = parseDeclaration(text);
  // A name with blanks in it could never be found: tokens with blanks are inline declarations.
  if (declaration &&
      (!declaration->name.empty() || name.empty() || std::any_of(name.begin(), name.end(), isBlank)))
    declaration.reset();
  declared_.insert_or_assign(std::string(name), declaration);
  return declaration.has_value();
}

bool Dictionary::refused(std::string_view name) const {
  const auto found = declared_.find(name);
  return found != declared_.end() && !found->second;
}

std::optional<Declaration> Dictionary::find(std::string_view token) const {
  const auto named = [&](Declaration declaration) {
    declaration.name = token;
    return declaration;
  };
  if (const auto known = declared_.find(token); known != declared_.end())
    return known->second ? std::optional(named(*known->second)) : std::nullopt;
  if (const auto known = predeclared().find(token); known != predeclared().end()) return named(known->second);
  if (token.find_first_of(" \t\n\r\f\v") == std::string_view::npos) return std::nullopt;
  if (const auto known = inline_.find(token); known != inline_.end()) {
    Declaration result = known->second.declaration;
    result.name = token.substr(token.size() - known->second.nameLength);
    return result;
  }
  std::optional<Declaration> parsed = parseDeclaration(token);
  if (!parsed || parsed->name.empty()) return std::nullopt;
  if (inline_.size() < kMaxInlineMemo && token.ends_with(parsed->name)) {
    Declaration nameless = *parsed;
    nameless.name = {};
    inline_.emplace(token, Inline{nameless, parsed->name.size()});
  }
  return parsed;
}

std::string_view Dictionary::nearest(std::string_view name) const {
  std::vector<std::string_view> candidates;
  for (const auto& [known, declaration] : predeclared())
    if (!declared_.contains(known)) candidates.push_back(known);
  for (const auto& [known, declaration] : declared_)
    if (declaration) candidates.push_back(known);
  std::sort(candidates.begin(), candidates.end());  // the same answer in every run
  return nearestName(name, candidates);
}

std::string_view nearestName(std::string_view name, std::span<const std::string_view> candidates) {
  constexpr size_t kLongest = 64;
  if (name.empty() || name.size() > kLongest) return {};

  // Levenshtein's distance, in halves: a change of letter case costs 1, any other edit 2.
  const auto lower = [](char c) { return std::tolower(static_cast<unsigned char>(c)); };
  size_t best = 2 * ((name.size() + 2) / 3) + 1;
  std::string_view result;
  std::array<size_t, kLongest + 1> row;
  for (std::string_view candidate : candidates) {
    const size_t longer = std::max(candidate.size(), name.size());
    if (2 * (longer - std::min(candidate.size(), name.size())) >= best) continue;
    for (size_t j = 0; j <= name.size(); ++j) row[j] = 2 * j;
    for (size_t i = 1; i <= candidate.size(); ++i) {
      size_t diagonal = row[0];
      row[0] = 2 * i;
      for (size_t j = 1; j <= name.size(); ++j) {
        const char a = candidate[i - 1], b = name[j - 1];
        const size_t change = diagonal + (a == b ? 0u : lower(a) == lower(b) ? 1u : 2u);
        diagonal = row[j];
        row[j] = std::min({change, row[j] + 2, row[j - 1] + 2});
      }
    }
    if (row[name.size()] < best && row[name.size()] < 2 * longer) {
      best = row[name.size()];
      result = candidate;
    }
  }
  return result;
}

}  // namespace patina
