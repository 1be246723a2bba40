// SPDX-License-Identifier: Apache-2.0
// Typed parameter lists of RIB requests, and the dictionary of declarations that gives them their types.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "rib/error.h"

namespace patina {

enum class StorageClass : uint8_t { Constant, Uniform, Varying, Vertex, FaceVarying, FaceVertex };
enum class ValueType : uint8_t {
  Float,
  Integer,
  String,
  Color,
  Point,
  Vector,
  Normal,
  HPoint,
  Matrix,
  MPoint
};

std::string_view name(StorageClass storage);  // "uniform", ...
std::string_view name(ValueType type);        // "float", "int", "mpoint", ...

// Numbers in one element of a type: 1, 3, 4 or 16 (Color: 3, unless ColorSamples says otherwise; String: 1).
int componentCount(ValueType type);

struct Declaration {
  StorageClass storage = StorageClass::Uniform;
  ValueType type = ValueType::Float;
  uint32_t arrayLength = 1;  // n of "type[n]"
  bool reference =
      false;             // modern "reference color x": the values are strings "node:output" whatever the type
  bool declared = true;  // false: the name was unknown and the type guessed from the values
  std::string_view name;

  int components() const { return componentCount(type) * static_cast<int>(arrayLength); }
};

// "[storage] [reference] type[n] name", e.g. "facevarying float[2] st"; without the name when `text` has
// none. nullopt: not a declaration (unknown type or storage class, bad array length, stray words).
std::optional<Declaration> parseDeclaration(std::string_view text);
std::string toString(const Declaration& declaration);  // the inline form: "uniform float[2] st"

// One "token" value pair. Exactly one of floats, ints, strings may be non-empty: ints for Integer, strings
// for String and references, floats else. An empty array in the file gives three empty spans. How many values
// there must be is for the reader to check. The views are valid as long as the list's owner says.
struct Param {
  Declaration declaration;
  std::span<const float> floats;
  std::span<const int> ints;
  std::span<const std::string_view> strings;
  Location location;          // of the token
  mutable bool used = false;  // set by ParamList's look-ups

  std::string_view name() const { return declaration.name; }
};

// A view of a request's parameters. A parser's list is valid only during the handler's call; keep an
// OwnedParamList.
class ParamList {
 public:
  ParamList() = default;
  explicit ParamList(std::span<const Param> params) : params_(params) {}

  auto begin() const { return params_.begin(); }
  auto end() const { return params_.end(); }
  size_t size() const { return params_.size(); }
  bool empty() const { return params_.empty(); }

  // The last parameter of that name, marked as used; null = absent (or of another type).
  const Param* find(std::string_view name) const;
  const Param* find(std::string_view name, ValueType type) const;

  // First value, or the fallback when the parameter is absent or of the wrong kind (then it stays unread).
  // Numbers convert: floatValue takes ints and intValue takes integral floats.
  float floatValue(std::string_view name, float fallback) const;
  int intValue(std::string_view name, int fallback) const;
  std::string_view stringValue(std::string_view name, std::string_view fallback) const;
  // Any type of three floats, or one float for all three.
  std::array<float, 3> tripleValue(std::string_view name, std::array<float, 3> fallback) const;

  // Warns, once per request word and name, of every parameter that nothing looked up; `known` feeds "did you
  // mean".
  void reportUnread(ErrorHandler& errors, std::string_view request,
                    std::span<const std::string_view> known = {}) const;

 private:
  std::span<const Param> params_;
};

// A deep copy of a list: cheap to move, shared when copied, immutable but for the used marks.
class OwnedParamList {
 public:
  OwnedParamList() = default;
  explicit OwnedParamList(const ParamList& source);
  ParamList list() const { return storage_ ? ParamList(storage_->params) : ParamList(); }

 private:
  struct Storage {
    std::vector<Param> params;
    std::vector<float> floats;
    std::vector<int> ints;
    std::vector<std::string_view> strings;
    std::string text;
  };
  std::shared_ptr<const Storage> storage_;
};

// Types of parameter names: RI 3.2's and Patina's predeclared ones, and what Declare added (global, as RI has
// it).
class Dictionary {
 public:
  // Declare "name" "text". False: `text` is no declaration, as in "varying double"; the name is refused from
  // now on.
  bool declare(std::string_view name, std::string_view text);
  bool refused(std::string_view name) const;
  // The declaration of a token: inline ("float x") or by name; its `name` is a view into `token`. nullopt:
  // unknown.
  std::optional<Declaration> find(std::string_view token) const;
  // The known name nearest to `name`, or empty if none is near.
  std::string_view nearest(std::string_view name) const;

 private:
  struct Hash {
    using is_transparent = void;
    size_t operator()(std::string_view s) const { return std::hash<std::string_view>{}(s); }
  };
  template <typename T>
  using Names = std::unordered_map<std::string, T, Hash, std::equal_to<>>;
  static const Names<Declaration>& predeclared();

  Names<std::optional<Declaration>> declared_;  // what Declare said; nullopt: refused
  struct Inline {
    Declaration declaration;  // without the name, which is the token's last `nameLength` bytes
    size_t nameLength;
  };
  mutable Names<Inline> inline_;  // memo of parsed tokens
};

// The candidate with the least edit distance to `name` (letter case counts half), or empty if all differ in
// more than about a third of their letters.
std::string_view nearestName(std::string_view name, std::span<const std::string_view> candidates);

}  // namespace patina
