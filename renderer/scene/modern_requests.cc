// SPDX-License-Identifier: Apache-2.0
// The modern dialect (RenderMan 19 and later): materials and lights by the names of other people's plugins,
// drawn with the nearest that there is here, and named once where that is not the same.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <numbers>
#include <utility>

#include "renderer/scene/scene_builder.h"

namespace patina {
namespace {

/// Arguments for one of Patina's shaders, as if they stood in a RIB.
class Arguments {
 public:
  explicit Arguments(const Location& at) : at_(at) {}
  void add(std::string_view name, float value) {
    add(name, ValueType::Float).floats =
        std::span(&floats_.emplace_back(std::array{value, 0.0f, 0.0f})[0], 1);
  }
  void add(std::string_view name, const Rgb& value) {
    add(name, ValueType::Color).floats = floats_.emplace_back(std::array{value.x, value.y, value.z});
  }
  void addVector(std::string_view name, const std::array<float, 3>& value) {
    add(name, ValueType::Vector).floats = floats_.emplace_back(value);
  }
  void add(std::string_view name, std::string_view value) {
    add(name, ValueType::String).strings = std::span(&strings_.emplace_back(value), 1);
  }
  ParamList list() const { return ParamList(params_); }

 private:
  Param& add(std::string_view name, ValueType type) {
    Param& param = params_.emplace_back();
    param.declaration = {StorageClass::Uniform, type, 1, false, true, name};
    param.location = at_;
    return param;
  }
  Location at_;
  std::vector<Param> params_;
  std::deque<std::array<float, 3>> floats_;
  std::deque<std::string_view> strings_;
};

Rgb colorOf(const ParamList& params, std::initializer_list<std::string_view> tokens, const Rgb& fallback) {
  std::array<float, 3> color{fallback.x, fallback.y, fallback.z};
  for (const std::string_view token : tokens) color = params.tripleValue(token, color);
  return {color[0], color[1], color[2]};
}

float mean(const Rgb& c) { return (c.x + c.y + c.z) / 3; }

/// The day of the year, from 1, by the Gregorian calendar; wrong numbers are brought into their range.
float dayOfYear(int year, int month, int day) {
  static constexpr int kBefore[] = {0, 31, 59, 90, 120, 151, 181, 212, 243, 273, 304, 334};
  const bool leaps = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
  month = std::clamp(month, 1, 12);
  return static_cast<float>(kBefore[month - 1] + std::clamp(day, 1, 31) + (leaps && month > 2 ? 1 : 0));
}

/// PxrEnvDayLight in the terms of sunsky. Its sun follows month, day and hour, unless the month is 0: then
/// sunDirection.
void addDaylight(const ParamList& p, Arguments& to) {
  const int month = p.intValue("month", 11);
  if (month <= 0) {
    to.addVector("sundirection", p.tripleValue("sunDirection", {0, 0, 1}));
  } else {
    to.add("day", dayOfYear(p.intValue("year", 2014), month, p.intValue("day", 20)));
    to.add("time", std::clamp(p.floatValue("hour", 14.6666f), 0.0f, 24.0f));
    to.add("zone", std::clamp(p.floatValue("zone", -8), -14.0f, 14.0f));
    to.add("latitude", std::clamp(p.floatValue("latitude", 47.602f), -90.0f, 90.0f));
    to.add("longitude", std::clamp(p.floatValue("longitude", -122.332f), -180.0f, 180.0f));
  }
  to.add("turbidity", std::clamp(p.floatValue("haziness", 2), 2.0f, 10.0f));
  to.add("sunangle", std::clamp(0.533f * p.floatValue("sunSize", 1), 0.1f, 90.0f));
  to.add("sun", std::max(mean(colorOf(p, {"sunTint"}, {1, 1, 1})), 0.0f));
  to.add("sky", std::max(mean(colorOf(p, {"skyTint"}, {1, 1, 1})), 0.0f));
}

/// What area lights and arealight have in common besides their colour. Angles are in degrees there.
void addShaping(const ParamList& p, bool isFlat, Arguments& to) {
  if (const std::string_view map = p.stringValue("lightColorMap", ""); !map.empty())
    to.add("texturename", map);
  if (!isFlat) return;
  const float focus = p.floatValue("emissionFocus", 0), cone = p.floatValue("coneAngle", 90);
  if (focus > 0) to.add("focus", std::min(focus, 1e4f));
  if (cone >= 90) return;
  const float angle = std::max(cone, 0.0f) * std::numbers::pi_v<float> / 180;
  to.add("coneangle", angle);
  to.add("conedeltaangle", angle * std::clamp(p.floatValue("coneSoftness", 0), 0.0f, 1.0f));
}

/// What a modern material comes to.
struct Material {
  enum class Kind { Matte, Plastic, Conductor, Dielectric } kind = Kind::Matte;
  bool exact = false;           ///< the same, not only the nearest
  Rgb color{0.5f, 0.5f, 0.5f};  ///< diffuse albedo, metal's reflectance, or tint of glass
  Rgb emission{0, 0, 0};
  Rgb specular{0, 0, 0};  ///< reflectance of a coat at normal incidence
  float alpha = 0;        ///< GGX roughness
  float ior = 1.5f;
  std::string_view colorToken;  ///< the parameter that `color` came from: it may be a connection
};

Material disneyMaterial(const ParamList& p) {
  Material m;
  m.colorToken = "baseColor";
  m.color = colorOf(p, {m.colorToken}, m.color);
  m.emission = colorOf(p, {"emitColor"}, m.emission);
  // Burley 2012, section 5.3: alpha = roughness^2; "specular" 0..1 is a reflectance of 0..8 %.
  const float roughness = p.floatValue("roughness", 0.5f);
  m.alpha = roughness * roughness;
  if (p.floatValue("specTrans", 0) > 0.5f || p.floatValue("trans", 0) > 0.5f) {
    m.kind = Material::Kind::Dielectric;
    m.ior = p.floatValue("ior", m.ior);
  } else if (p.floatValue("metallic", 0) > 0.5f) {
    m.kind = Material::Kind::Conductor;
  } else if (const float specular = p.floatValue("specular", 0.5f); specular > 0) {
    m.kind = Material::Kind::Plastic;
    m.specular = Rgb(1, 1, 1) * (0.08f * specular);
  }
  return m;
}

Material surfaceMaterial(const ParamList& p) {
  Material m;
  m.colorToken = "diffuseColor";
  m.color = colorOf(p, {m.colorToken}, {0.18f, 0.18f, 0.18f}) * p.floatValue("diffuseGain", 1);
  m.emission = colorOf(p, {"glowColor"}, {1, 1, 1}) * p.floatValue("glowGain", 0);
  const float roughness = p.floatValue("specularRoughness", 0.2f);
  m.alpha = roughness * roughness;
  m.specular = colorOf(p, {"specularFaceColor"}, {0, 0, 0});
  if (p.floatValue("refractionGain", 0) > 0.5f) {
    m.kind = Material::Kind::Dielectric;
    const float glass = p.floatValue("glassRoughness", 0.1f);
    m.alpha = glass * glass;
    m.ior = p.floatValue("glassIor", m.ior);
    m.color = colorOf(p, {"refractionColor"}, {1, 1, 1});
  } else if (mean(m.specular) > 2 * mean(m.color)) {
    m.kind = Material::Kind::Conductor;
    m.color = m.specular;
  } else if (mean(m.specular) > 0) {
    m.kind = Material::Kind::Plastic;
  }
  return m;
}

/// Materials of which only the sort is known: the colour by any of the usual names.
Material materialByName(std::string_view name, const ParamList& p) {
  Material m;
  const auto has = [&](std::string_view part) { return name.find(part) != std::string_view::npos; };
  m.color = colorOf(p, {"color", "frontColor", "diffuseColor", "baseColor"}, m.color);
  m.colorToken = p.find("baseColor") ? "baseColor" : "diffuseColor";
  m.emission = colorOf(p, {"emissionColor", "emitColor"}, m.emission);
  const float roughness = p.floatValue("roughness", 0);
  if (name == "PxrDiffuse" || name == "LamaDiffuse") {
    m.exact = roughness == 0;
  } else if (name == "PxrConstant" || name == "PxrBlack" || name == "LamaEmission") {
    m.exact = true;
    if (name == "PxrConstant") m.emission = colorOf(p, {"emitColor"}, {1, 1, 1});
    m.color = Rgb(0, 0, 0);
  } else if (has("Glass") || has("Dielectric")) {
    m.kind = Material::Kind::Dielectric;
    m.color = colorOf(p, {"refractionColor", "transmissionColor", "transmissionTint"}, {1, 1, 1});
    m.ior = p.floatValue("ior", m.ior);
    m.alpha = roughness * roughness;
  } else if (has("Metal") || has("Conductor")) {
    m.kind = Material::Kind::Conductor;
    m.color = colorOf(p, {"reflectionTint", "specularColor", "tint"}, m.color);
    m.alpha = roughness * roughness;
  }
  return m;
}

/// RI's roughness whose Blinn lobe is as wide as GGX's, and the weight that makes it as bright: exponent n =
/// 2 / alpha^2 - 2 (Walter et al. 2007, section 5.2), normalisation (n + 2) / 8 in units of the diffuse
/// lobe's.
struct Highlight {
  float roughness;
  Rgb weight;
};
Highlight highlight(const Rgb& reflectance, float alpha) {
  const float exponent = std::clamp(2 / std::max(alpha * alpha, 1e-6f) - 2, 1.0f, 1e4f);
  return {8 / exponent, reflectance * ((exponent + 2) / 8)};
}

/// Area in world space of a shape of unit size, for lights that keep their power whatever their size.
double worldArea(std::string_view shape, const M44d& toWorld) {
  const auto axis = [&](int k) { return V3d(toWorld[k][0], toWorld[k][1], toWorld[k][2]); };
  const V3d x = axis(0), y = axis(1), z = axis(2);
  constexpr double pi = std::numbers::pi;
  if (shape == "disklight") return pi / 4 * x.cross(y).length();
  if (shape == "spherelight") {
    // Knud Thomsen's formula for ellipsoids, within 1.1 %.
    const double a = x.length() / 2, b = y.length() / 2, c = z.length() / 2, p = 1.6075;
    const double sum = (std::pow(a * b, p) + std::pow(a * c, p) + std::pow(b * c, p)) / 3;
    return 4 * pi * std::pow(sum, 1 / p);
  }
  if (shape == "cylinderlight") return pi * x.length() * (y.length() + z.length()) / 2;
  return x.cross(y).length();
}

}  // namespace

void SceneBuilder::pattern(std::string_view name, Handle handle, const ParamList& params,
                           const Location& at) {
  const std::string_view file = name == "PxrTexture" || name == "PxrMultiTexture"
                                    ? params.stringValue("filename", params.stringValue("filename0", ""))
                                    : std::string_view();
  for (const Param& param : params) param.used = true;
  patternTextures_[std::string(handle.text)] = file;
  if (file.empty()) unhandled(fmt::format("Pattern \"{}\"", name), at);
}

void SceneBuilder::bxdf(std::string_view name, Handle, const ParamList& params, const Location& at) {
  const Material m = name == "PxrDisney" || name == "PxrDisneyBsdf" ? disneyMaterial(params)
                     : name == "PxrSurface"                         ? surfaceMaterial(params)
                                                                    : materialByName(name, params);
  // A texture that the colour is connected to.
  std::string texture;
  for (const Param& param : params) {
    param.used = true;
    if (!param.declaration.reference || param.strings.empty()) continue;
    const std::string_view source = param.strings.front().substr(0, param.strings.front().find(':'));
    const std::string* const picture = known(&SceneBuilder::patternTextures_, source);
    if (param.name() == m.colorToken && picture && !picture->empty())
      texture = *picture;
    else
      countNotice(fmt::format("shader connections are not followed: \"{}\" of \"{}\" keeps its default",
                              param.name(), name),
                  param.location);
  }
  std::string_view shader = "matte";
  Arguments arguments(at);
  state_.bxdfColor = texture.empty() ? m.color : Rgb(1, 1, 1);
  switch (m.kind) {
    case Material::Kind::Conductor:
      shader = "conductor";
      arguments.add("reflectance", m.color);
      arguments.add("alpha", m.alpha);
      break;
    case Material::Kind::Dielectric:
      shader = "dielectric";
      arguments.add("ior", m.ior);
      arguments.add("alpha", m.alpha);
      arguments.add("transmittance", m.color);
      break;
    case Material::Kind::Plastic:
    case Material::Kind::Matte: {
      const bool emits = maxComponent(m.emission) > 0;
      if (emits || (texture.empty() && m.kind == Material::Kind::Matte)) {
        arguments.add("emission", m.emission);
        break;
      }
      const Highlight h = highlight(m.specular, m.alpha);
      shader = texture.empty() ? "plastic" : "paintedplastic";
      const float weight = std::min(maxComponent(h.weight), 1.0f);
      arguments.add("Kd", 1.0f);
      arguments.add("Ks", weight);
      arguments.add("roughness", h.roughness);
      arguments.add("specularcolor", weight > 0 ? h.weight / maxComponent(h.weight) : Rgb(1, 1, 1));
      if (!texture.empty()) arguments.add("texturename", std::string_view(texture));
    }
  }
  changeAttributes().surface = addShader(shader, arguments.list(), at);
  if (!m.exact) countNotice(fmt::format("Bxdf \"{}\" is drawn as {}", name, shader), at);
}

// ---- Lights -----------------------------------------------------------------------------------------------

/// Intensity, exposure and colour in one, by the names that both generations of lights have.
Rgb SceneBuilder::modernLightColor(std::string_view name, const ParamList& params, const Location& at) {
  if (params.intValue("enableTemperature", 0) != 0)
    countNotice(fmt::format("the colour temperature of \"{}\" is left out", name), at);
  const float intensity = params.floatValue("intensity", 1) * std::exp2(params.floatValue("exposure", 0));
  return colorOf(params, {"lightColor"}, {1, 1, 1}) * intensity;
}

void SceneBuilder::light(std::string_view name, Handle handle, const ParamList& params, const Location& at) {
  if (leaveOutLight(name, at)) return;
  const auto lightsOfWorld = [&](uint32_t index) {
    // Lights of this dialect shine on all that follows, whatever block they stand in.
    if (!inWorld()) return;
    for (size_t k = firstWorldState_; k < savedStates_.size(); ++k) {
      std::vector<uint32_t>& on = savedStates_[k].attributes.lights;
      if (std::ranges::find(on, index) == on.end()) on.insert(std::ranges::upper_bound(on, index), index);
      savedStates_[k].stored = kNone;
    }
  };
  static constexpr std::pair<std::string_view, std::string_view> kShapes[] = {
      {"PxrRectLight", "rectlight"},
      {"PxrDiskLight", "disklight"},
      {"PxrSphereLight", "spherelight"},
      {"PxrCylinderLight", "cylinderlight"}};
  for (const Param& param : params) param.used = true;
  Rgb color = modernLightColor(name, params, at);
  Arguments arguments(at);
  // As Attribute "light" "shadows", of this light alone.
  const bool shadowed = state_.lightsCastShadows;
  state_.lightsCastShadows = shadowed && params.intValue("enableShadows", 1) != 0;
  const auto finish = [&](uint32_t index) {
    state_.lightsCastShadows = shadowed;
    lightsOfWorld(index);
  };
  const Rgb shadowColor = colorOf(params, {"shadowColor"}, {0, 0, 0});
  const bool hasDirection = name == "PxrDistantLight" && params.floatValue("angleExtent", 0.53f) == 0;
  if (maxComponent(shadowColor) > 0 && !hasDirection)
    countNotice(
        fmt::format("the shadowColor of \"{}\" is left out: only lights without a size have one", name), at);
  for (const auto& [light, shape] : kShapes) {
    if (name != light) continue;
    if (params.intValue("areaNormalize", 0) != 0)
      color = color / static_cast<float>(std::max(worldArea(shape, state_.ctm), 1e-30));
    arguments.add("lightcolor", color);
    addShaping(params, shape == "rectlight" || shape == "disklight", arguments);
    const uint32_t index = addLight("arealight", handle, true, arguments.list(), at);
    finish(index);
    // Its shape: black but for the light, and without a shadow.
    GraphicsState before = state_;
    Attributes& attributes = changeAttributes();
    attributes.areaLight = index;
    attributes.surface = addShader("matte", ParamList(), at);
    attributes.castsShadows = false;
    attributes.visibility &= ~static_cast<uint32_t>(kTransmissionRay);
    state_.bxdfColor = Rgb(0, 0, 0);
    lightShape(shape, at);
    state_ = std::move(before);
    return;
  }
  if (name == "PxrMeshLight") {
    arguments.add("lightcolor", color);
    addShaping(params, false, arguments);
    const uint32_t index = addLight("arealight", handle, true, arguments.list(), at);
    finish(index);
    changeAttributes().areaLight = index;
  } else if (name == "PxrDistantLight") {
    // Its intensity is the irradiance of a surface that faces it; ours is the radiance of a white matte one.
    arguments.add("lightcolor", color / std::numbers::pi_v<float>);
    arguments.add("angle", params.floatValue("angleExtent", 0.53f));
    if (hasDirection) arguments.add("shadowcolor", shadowColor);
    finish(addLight("distantlight", handle, false, arguments.list(), at));
  } else if (name == "PxrDomeLight") {
    arguments.add("lightcolor", color);
    if (const std::string_view map = params.stringValue("lightColorMap", ""); !map.empty())
      arguments.add("texturename", map);
    finish(addLight("envlight", handle, false, arguments.list(), at));
  } else if (name == "PxrEnvDayLight") {
    arguments.add("lightcolor", color);
    addDaylight(params, arguments);
    finish(addLight("sunsky", handle, false, arguments.list(), at));
    countNotice("Light \"PxrEnvDayLight\" is drawn by sunsky, as bright as that is", at);
  } else {
    state_.lightsCastShadows = shadowed;
    unhandled(fmt::format("Light \"{}\"", name), at);
  }
}

/// AreaLightSource of RenderMan 19 and 20: the geometry that follows emits.
void SceneBuilder::modernAreaLight(std::string_view name, Handle handle, const ParamList& params,
                                   const Location& at) {
  for (const Param& param : params) param.used = true;
  Arguments arguments(at);
  arguments.add("lightcolor", modernLightColor(name, params, at));
  if (name == "PxrStdAreaLight") {
    changeAttributes().areaLight = addLight("arealight", handle, true, arguments.list(), at);
  } else if (name == "PxrStdEnvMapLight") {
    if (const std::string_view map = params.stringValue("rman__EnvMap", ""); !map.empty())
      arguments.add("texturename", map);
    addLight("envlight", handle, false, arguments.list(), at);
    changeAttributes().areaLight = kNone;  // its geometry, a sphere or a cube, only stands for the sky
  } else {
    unhandled(fmt::format("AreaLightSource \"{}\"", name), at);
  }
}

/// The shape of an area light: a square, disc, sphere or cylinder of size 1 around the origin. Flat ones face
/// +z.
void SceneBuilder::lightShape(std::string_view shape, const Location& at) {
  if (!mayDraw(at)) return;
  const bool inside = std::exchange(state_.inside, false);
  const M44d ctm = state_.ctm, inner = state_.moving.inner;
  if (shape == "disklight") {
    addQuadric(Quadric::Kind::Disk, {0, 0.5f}, 360, ParamList(), at);
  } else if (shape == "spherelight") {
    addQuadric(Quadric::Kind::Sphere, {0.5f, -0.5f, 0.5f}, 360, ParamList(), at);
  } else if (shape == "cylinderlight") {  // along x
    const M44d alongX(0, 0, -1, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1);
    state_.ctm = alongX * ctm, state_.moving.inner = alongX * inner;
    addQuadric(Quadric::Kind::Cylinder, {0.5f, -0.5f, 0.5f}, 360, ParamList(), at);
  } else {
    static constexpr float kCorners[] = {-0.5f, -0.5f, 0, 0.5f, -0.5f, 0, -0.5f, 0.5f, 0, 0.5f, 0.5f, 0};
    Param points;
    points.declaration = {StorageClass::Vertex, ValueType::Point, 1, false, true, "P"};
    points.floats = kCorners;
    points.location = at;
    ParametricMesh mesh;
    mesh.nu = mesh.nv = 2;
    mesh.basisU = state_.basisU, mesh.basisV = state_.basisV;
    addPrimitive(std::move(mesh), ParamList(std::span(&points, 1)), at);
  }
  state_.ctm = ctm, state_.moving.inner = inner;
  state_.inside = inside;
}

// ---- Other requests ---------------------------------------------------------------------------------------

void SceneBuilder::camera(std::string_view name, const ParamList& params, const Location& at) {
  for (const Param& param : params) param.used = true;
  coordinateSystem(name, at);
}

void SceneBuilder::hierarchicalSubdivisionMesh(std::string_view scheme, Ints vertexCounts, Ints vertices,
                                               const SubdivisionTags& tags, const ParamList& params,
                                               const Location& at) {
  for (const std::string_view tag : tags.names)
    if (tag.ends_with("edit")) countNotice(fmt::format("subdivision tag \"{}\" is left out", tag), at);
  subdivisionMesh(scheme, vertexCounts, vertices, tags, params, at);
}

/// Resource "name" "attributes" "operation" "save" | "restore" "subset" "all" | "transform" | "shading" ...
void SceneBuilder::resource(Handle handle, std::string_view type, const ParamList& params,
                            const Location& at) {
  const std::string_view operation = params.stringValue("operation", "");
  const std::string_view subset = params.stringValue("subset", "all");
  for (const Param& param : params) param.used = true;
  if (type != "attributes" || (operation != "save" && operation != "restore"))
    return unhandled(fmt::format("Resource \"{}\" \"{}\"", type, operation), at);
  if (operation == "save") {
    resources_.insert_or_assign(std::string(handle.text), state_);
    return;
  }
  const GraphicsState* const found = known(&SceneBuilder::resources_, handle.text);
  if (!found)
    return error(RiError::BadHandle, at, fmt::format("Resource: nothing is saved as \"{}\"", handle.text));
  const GraphicsState& saved = *found;
  if (subset == "transform") {
    state_.ctm = saved.ctm, state_.moving = saved.moving;
  } else if (subset == "shading") {
    Attributes& attributes = changeAttributes();
    attributes.color = saved.attributes.color, attributes.opacity = saved.attributes.opacity;
    attributes.surface = saved.attributes.surface, attributes.displacement = saved.attributes.displacement;
    attributes.atmosphere = saved.attributes.atmosphere;
    attributes.areaLight = saved.attributes.areaLight, attributes.lights = saved.attributes.lights;
    attributes.shadingRate = saved.attributes.shadingRate;
    state_.bxdfColor = saved.bxdfColor;
  } else if (subset == "all") {
    const SolidPlace solid = state_.solid;
    state_ = saved;
    state_.solid = solid;
    changeAttributes();
  } else {
    unhandled(fmt::format("Resource \"attributes\" of subset \"{}\"", subset), at);
  }
  if (state_.attributes.areaLight != kNone && leaveOutLight(fmt::format("Resource {}", handle.text), at))
    changeAttributes().areaLight = kNone;
}

}  // namespace patina
