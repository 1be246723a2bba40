// SPDX-License-Identifier: Apache-2.0
// Primitive variables: types, counts, homogeneous and height-field points.
#include "renderer/scene/primvars.h"

#include <fmt/format.h>

#include <algorithm>

#include "renderer/scene/value_count.h"

namespace patina {
namespace {

bool allFinite(std::span<const float> values) {
  float sum = 0;  // one product per value: infinities and NaN stay visible in it
  for (const float value : values) sum += value * 0;
  return sum == 0;
}

PrimVar toVariable(const Param& param) {
  PrimVar variable;
  variable.name = param.name();
  variable.storage = param.declaration.storage;
  variable.type = param.declaration.type;
  variable.arrayLength = static_cast<int>(param.declaration.arrayLength);
  variable.components = param.declaration.components();
  variable.floats.assign(param.floats.begin(), param.floats.end());
  variable.ints.assign(param.ints.begin(), param.ints.end());
  variable.strings.assign(param.strings.begin(), param.strings.end());
  return variable;
}

PrimVar pointVariable(std::vector<float> floats) {
  PrimVar variable;
  variable.name = "P";
  variable.storage = StorageClass::Vertex;
  variable.type = ValueType::Point;
  variable.components = 3;
  variable.floats = std::move(floats);
  return variable;
}

/// P out of "P", "Pw" or "Pz", as far as the list has them.
class PointReader {
 public:
  PointReader(const Shape& shape, const ParamList& params) : shape_(shape), params_(params) {}

  std::optional<std::vector<float>> read() {
    const Param* points = params_.find("P");
    const bool homogeneous = points && points->declaration.type == ValueType::HPoint;
    if (points && !homogeneous && !points->floats.empty()) {
      return std::vector<float>(points->floats.begin(), points->floats.end());
    }
    if (!homogeneous) points = params_.find("Pw");
    if (points) return divide(points->floats);
    if (const Param* heights = params_.find("Pz")) return lift(heights->floats);
    return std::nullopt;
  }
  bool rational() const { return rational_; }

 private:
  std::optional<std::vector<float>> divide(std::span<const float> points) {
    std::vector<float> result;
    result.reserve(points.size() / 4 * 3);
    for (size_t i = 0; i + 3 < points.size(); i += 4) {
      float w = points[i + 3];
      if (w == 0 && !std::holds_alternative<NurbsPatch>(shape_)) return std::nullopt;
      rational_ |= w != 1;
      if (w == 0) w = kInfinity;  // a direction, which only "Pw" tells
      for (size_t k = 0; k < 3; ++k) result.push_back(points[i + k] / w);
    }
    return result;
  }

  // RI: x and y of a height field are the patch's own parameters.
  std::optional<std::vector<float>> lift(std::span<const float> heights) const {
    const auto* mesh = std::get_if<ParametricMesh>(&shape_);
    if (!mesh) return std::nullopt;
    const auto nu = static_cast<size_t>(mesh->nu), nv = static_cast<size_t>(mesh->nv);
    if (heights.size() != nu * nv) return std::nullopt;
    std::vector<float> result;
    result.reserve(heights.size() * 3);
    for (size_t i = 0; i < heights.size(); ++i) {
      const float u = static_cast<float>(i % nu) / static_cast<float>(std::max<size_t>(nu - 1, 1));
      const float v = static_cast<float>(i / nu) / static_cast<float>(std::max<size_t>(nv - 1, 1));
      result.insert(result.end(), {u, v, heights[i]});
    }
    return result;
  }

  const Shape& shape_;
  const ParamList& params_;
  bool rational_ = false;
};

/// What a shape's own indices ask of its number of points; 0 where the shape fixes the number itself.
size_t pointsNeeded(const Shape& shape) {
  if (const auto* mesh = std::get_if<PolygonMesh>(&shape)) return highestIndex(mesh->vertices);
  if (const auto* mesh = std::get_if<SubdivisionMesh>(&shape)) return highestIndex(mesh->vertices);
  return 0;
}

}  // namespace

std::optional<std::vector<PrimVar>> readVariables(const Shape& shape, const ParamList& params,
                                                  std::string_view request, const Location& at,
                                                  ErrorHandler& errors) {
  const auto refuse = [&](RiError code, const Location& where, std::string_view why) {
    errors.report(Severity::Error, code, where, fmt::format("{} is left out: {}", request, why),
                  fmt::format("{} {}", request, why));
    return std::nullopt;
  };
  constexpr size_t kMostVariables = 1000;
  if (params.size() > kMostVariables)
    return refuse(RiError::LimitCheck, at, "it has more than 1000 variables");
  for (const Param& param : params) {
    param.used = true;
    if (!allFinite(param.floats))
      return refuse(RiError::Range, param.location,
                    fmt::format("\"{}\" holds a value that is not finite", param.name()));
  }

  std::vector<PrimVar> variables;
  const bool hasPoints = !std::holds_alternative<Quadric>(shape) && !std::holds_alternative<Blobby>(shape);
  const size_t indexed = pointsNeeded(shape);
  size_t given =
      0;  // points in the file: those that no face names are dropped, and so are the values that go with them
  ValueCounts counts = valueCounts(shape, indexed);
  bool rational = false;
  if (hasPoints) {
    PointReader reader(shape, params);
    auto points = reader.read();
    if (!points)
      return refuse(RiError::BadArgument, at,
                    "it needs \"P\" (or \"Pw\" without zero weights, or \"Pz\" on patches)");
    if (!allFinite(*points)) return refuse(RiError::Range, at, "its points are not finite");
    rational = reader.rational();
    given = points->size() / 3;
    if (points->size() % 3 != 0 || given < counts.vertex || (indexed == 0 && given != counts.vertex)) {
      return refuse(RiError::BadArgument, at,
                    fmt::format("\"P\" has {} numbers, expected {} ({} points)", points->size(),
                                counts.vertex * 3, counts.vertex));
    }
    points->resize(counts.vertex * 3);
    points->shrink_to_fit();
    variables.push_back(pointVariable(std::move(*points)));
  }

  for (const Param& param : params) {
    const std::string_view name = param.name();
    if (params.find(name) != &param) continue;  // given again: the last one holds
    PrimVar variable = toVariable(param);
    if (hasPoints && name == "P" && rational && variable.type == ValueType::HPoint) variable.name = "Pw";
    if (hasPoints && (variable.name == "P" || name == "Pz" || (name == "Pw" && !rational))) continue;
    if (variable.components < 1) continue;
    const size_t expected = counts.of(variable.storage);
    const size_t perValue =
        static_cast<size_t>(variable.floats.empty() ? variable.arrayLength : variable.components);
    const bool perPoint =
        variable.storage == StorageClass::Vertex || variable.storage == StorageClass::Varying;
    const size_t count = variable.floats.size() + variable.ints.size() + variable.strings.size();
    if (perPoint && indexed > 0 && given > expected && count == given * perValue) {
      variable.floats.resize(std::min(variable.floats.size(), expected * perValue));
      variable.ints.resize(std::min(variable.ints.size(), expected * perValue));
      variable.strings.resize(std::min(variable.strings.size(), expected * perValue));
    } else if (count != expected * perValue) {
      if (!param.declaration.declared) continue;  // its type was a guess, and the parser has said so
      errors.report(Severity::Warning, RiError::BadParamList, param.location,
                    fmt::format("{}: \"{}\" has {} values, expected {} ({}): variable left out", request,
                                name, count, expected * perValue, toString(param.declaration)),
                    fmt::format("{} {} count", request, name));
      continue;
    }
    variables.push_back(std::move(variable));
  }
  return variables;
}

bool projectVariables(const M44d& m, std::vector<PrimVar>& variables) {
  std::erase_if(variables,
                [](const PrimVar& v) { return v.name == "N" || v.name == "Np" || v.name == "Pw"; });
  for (PrimVar& variable : variables) {
    if (variable.name != "P") continue;
    for (size_t i = 0; i + 2 < variable.floats.size(); i += 3) {
      float* p = &variable.floats[i];
      const double x = p[0], y = p[1], z = p[2];
      const double w = x * m[0][3] + y * m[1][3] + z * m[2][3] + m[3][3];
      for (int k = 0; k < 3; ++k) {
        p[k] = static_cast<float>((x * m[0][k] + y * m[1][k] + z * m[2][k] + m[3][k]) / w);
        if (!std::isfinite(p[k])) return false;
      }
    }
  }
  return true;
}

}  // namespace patina
