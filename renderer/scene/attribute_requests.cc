// SPDX-License-Identifier: Apache-2.0
// Attributes: Color to Sides, and the name spaces of Attribute.
#include <fmt/format.h>

#include <algorithm>

#include "renderer/scene/camera.h"
#include "renderer/scene/hash.h"
#include "renderer/scene/matrices.h"
#include "renderer/scene/scene_builder.h"

namespace patina {
namespace {

size_t hashOf(const Attributes& attributes) {
  Hasher hasher;
  hasher.add(attributes.color).add(attributes.opacity).add(attributes.textureCoordinates);
  hasher.add(attributes.surface)
      .add(attributes.displacement)
      .add(attributes.atmosphere)
      .add(attributes.areaLight)
      .add(attributes.lights);
  hasher.add(attributes.shadingRate)
      .add(attributes.visibility)
      .add(attributes.displacementBound)
      .add(attributes.name)
      .add(attributes.user.hash());
  hasher.add(attributes.diceLength);
  hasher.add(attributes.maxDiffuseDepth).add(attributes.maxSpecularDepth);
  return hasher.value();
}

std::optional<Rgb> rgbOf(Floats values) {
  if (values.size() == 3) return Rgb(values[0], values[1], values[2]);
  if (values.size() == 1) return Rgb(values[0]);
  return std::nullopt;
}

/// "on", "1", 1 ... of a parameter that exporters write as a number or a word.
bool truth(const ParamList& params, std::string_view token, bool fallback) {
  const Param* param = params.find(token);
  if (!param) return fallback;
  if (!param->strings.empty()) {
    const std::string_view word = param->strings.front();
    return !(word == "off" || word == "0" || word == "no" || word == "none" || word == "false");
  }
  return params.floatValue(token, fallback ? 1.0f : 0.0f) != 0;
}

/// Name spaces that no picture depends on: how other renderers cut surfaces up and what they leave out
/// unseen.
constexpr std::string_view kHintAttributes[] = {"grouping", "cull",   "procedural",
                                                "shade",    "stitch", "stochastic"};

void markAllUsed(const ParamList& params) {
  for (const Param& param : params) param.used = true;
}

}  // namespace

Attributes& SceneBuilder::changeAttributes() {
  state_.stored = kNone;
  state_.touched = true;
  return state_.attributes;
}

uint32_t SceneBuilder::storeAttributes() {
  if (inObject() && !state_.touched) return kNone;
  if (state_.stored != kNone) return state_.stored;
  Attributes attributes = state_.attributes;
  if (state_.bxdfColor) attributes.color = *state_.bxdfColor;
  const size_t hash = hashOf(attributes);
  const auto [begin, end] = attributesByHash_.equal_range(hash);
  const auto same =
      std::find_if(begin, end, [&](const auto& e) { return scene_.attributes[e.second] == attributes; });
  if (same != end) return state_.stored = same->second;
  state_.stored = static_cast<uint32_t>(scene_.attributes.size());
  attributesByHash_.emplace(hash, state_.stored);
  scene_.attributes.push_back(std::move(attributes));
  return state_.stored;
}

void SceneBuilder::color(Floats values, const Location& at) {
  const auto rgb = rgbOf(values);
  if (!rgb)
    return error(RiError::BadColor, at, fmt::format("Color has {} values, expected 3", values.size()),
                 "color");
  changeAttributes().color = *rgb;
}

void SceneBuilder::opacity(Floats values, const Location& at) {
  const auto rgb = rgbOf(values);
  if (!rgb)
    return error(RiError::BadColor, at, fmt::format("Opacity has {} values, expected 3", values.size()),
                 "opacity");
  changeAttributes().opacity = *rgb;
}

void SceneBuilder::textureCoordinates(const std::array<float, 8>& st, const Location&) {
  changeAttributes().textureCoordinates = st;
}

void SceneBuilder::shadingRate(float size, const Location& at) {
  if (!(size > 0))
    return error(RiError::Range, at, fmt::format("ShadingRate {} is not positive", size), "shading rate");
  changeAttributes().shadingRate = std::max(size, 1e-4f);
}

void SceneBuilder::shadingInterpolation(std::string_view type, const Location& at) {
  if (type != "constant" && type != "smooth") {
    return error(RiError::BadToken, at,
                 fmt::format("ShadingInterpolation \"{}\": expected constant or smooth", type));
  }
  changeAttributes().smoothShading = type == "smooth";
}

void SceneBuilder::matte(bool on, const Location&) { changeAttributes().matte = on; }

void SceneBuilder::sides(int sides, const Location& at) {
  if (sides != 1 && sides != 2)
    return error(RiError::Range, at, fmt::format("Sides {}: expected 1 or 2", sides));
  changeAttributes().oneSided = sides == 1;
}

// ---- Orientation ------------------------------------------------------------------------------------------

void SceneBuilder::orientation(std::string_view orientation, const Location& at) {
  // Camera space is left-handed; inside a world block the current transformation leads to it by way of the
  // world.
  double determinant = determinant3(state_.ctm);
  if (inWorld() && !inObject()) determinant *= determinant3(scene_.camera.worldToCamera);
  const bool systemIsLeftHanded = determinant > 0;
  if (orientation == "outside") {
    state_.inside = false;
  } else if (orientation == "inside") {
    state_.inside = true;
  } else if (orientation == "lh") {
    state_.inside = !systemIsLeftHanded;
  } else if (orientation == "rh") {
    state_.inside = systemIsLeftHanded;
  } else {
    error(RiError::BadToken, at,
          fmt::format("Orientation \"{}\": expected outside, inside, lh or rh", orientation));
  }
}

void SceneBuilder::reverseOrientation(const Location&) { state_.inside = !state_.inside; }

// ---- Level of detail --------------------------------------------------------------------------------------

void SceneBuilder::detail(const Bounds6& bound, const Location& at) {
  if (!(bound[0] <= bound[1] && bound[2] <= bound[3] && bound[4] <= bound[5])) {
    return error(RiError::Range, at, "Detail: expected xmin <= xmax and the same for y and z");
  }
  // Where an object will stand is not known in its definition: it keeps its highest level.
  if (!inWorld() || inObject()) return;
  state_.detail = rasterArea(bound, state_.ctm, scene_.options, scene_.camera) * options_.relativeDetail;
}

void SceneBuilder::detailRange(float minVisible, float lowerTransition, float upperTransition,
                               float maxVisible, const Location& at) {
  if (!(minVisible <= lowerTransition && lowerTransition <= upperTransition &&
        upperTransition <= maxVisible)) {
    return error(RiError::Range, at, "DetailRange: expected four values in rising order");
  }
  constexpr float kRiInfinity = 1e37f;
  const auto limit = [](float value) { return value >= kRiInfinity ? kInfinity : value; };
  state_.detailRange = {minVisible, lowerTransition, limit(upperTransition), limit(maxVisible)};
}

void SceneBuilder::geometricRepresentation(std::string_view type, const Location& at) {
  if (type == "points" || type == "lines") unhandled(fmt::format("GeometricRepresentation \"{}\"", type), at);
}

// ---- Attribute --------------------------------------------------------------------------------------------

void SceneBuilder::attribute(std::string_view name, const ParamList& params, const Location& at) {
  setUserValues("attribute", name, params);
  if (name == "user") {
    userAttribute(params);
  } else if (name == "identifier") {
    if (const Param* id = params.find("name"); id && !id->strings.empty())
      changeAttributes().name = id->strings.front();
  } else if (name == "trace") {
    Attributes& attributes = changeAttributes();
    const auto depth = [&](std::string_view token, int value) {
      return std::clamp(params.intValue(token, value), 0, 1000);
    };
    attributes.maxDiffuseDepth = depth("maxdiffusedepth", attributes.maxDiffuseDepth);
    attributes.maxSpecularDepth = depth("maxspeculardepth", attributes.maxSpecularDepth);
    attributes.sampleMotion = truth(params, "samplemotion", attributes.sampleMotion);
    // Rays begin as near to a surface as rounding lets them: there is no bias to be set.
    for (const std::string_view token :
         {"bias", "autobias", "displacements", "maxspecularsamples", "maxdiffusesamples", "decimationrate"}) {
      params.find(token);
    }
    for (const std::string_view token : {"intersectpriority", "holdout"})
      if (params.find(token)) noEffect("Attribute", name, token, at);
    params.reportUnread(
        errors_, "Attribute \"trace\"",
        std::array<std::string_view, 3>{"maxdiffusedepth", "maxspeculardepth", "samplemotion"});
  } else if (name == "visibility") {
    visibilityAttribute(params, at);
  } else if (name == "light") {
    state_.lightsCastShadows = truth(params, "shadows", state_.lightsCastShadows);
    params.find("nsamples");
    params.find("samples");
    params.reportUnread(errors_, "Attribute \"light\"",
                        std::array<std::string_view, 2>{"shadows", "nsamples"});
  } else if (name == "render") {
    if (const Param* casts = params.find("casts_shadows")) {
      const bool none = !casts->strings.empty() && casts->strings.front() == "none";
      Attributes& attributes = changeAttributes();
      attributes.castsShadows = !none;
      attributes.visibility =
          none ? attributes.visibility & ~kTransmissionRay : attributes.visibility | kTransmissionRay;
    }
    markAllUsed(params);
  } else if (name == "dice") {
    diceAttribute(params, at);
  } else if (name == "displacementbound") {
    displacementBound(params);
  } else if (name == "trimcurve") {
    if (const Param* sense = params.find("sense"); sense && !sense->strings.empty()) {
      const std::string_view word = sense->strings.front();
      if (word == "inside" || word == "outside")
        state_.trimOutside = word == "outside";
      else
        error(RiError::BadToken, sense->location,
              fmt::format("Attribute \"trimcurve\" \"sense\" \"{}\": expected inside or outside", word));
    }
    params.reportUnread(errors_, "Attribute \"trimcurve\"", std::array<std::string_view, 1>{"sense"});
  } else if (name == "Ri") {
    riAttribute(params, at);
  } else if (std::ranges::find(kHintAttributes, name) == std::end(kHintAttributes)) {
    noEffect("Attribute", name, {}, at);
  }
}

/// Values of any name and type, for shaders (PATINA_EXTENSION_ATTRIBUTES) and conditions.
void SceneBuilder::userAttribute(const ParamList& params) {
  UserAttributes user = state_.attributes.user;
  for (const Param& param : params) {
    param.used = true;
    ShaderArgument value;
    if (!takeArgument(param, "Attribute \"user\"", value)) continue;
    if (!user.set(std::move(value)))
      error(RiError::LimitCheck, param.location,
            fmt::format("Attribute \"user\" \"{}\": there are {} others already", param.name(),
                        UserAttributes::kMost),
            "user attributes");
  }
  if (user == state_.attributes.user) return;
  // Alone it does not make an object's primitives leave the attributes of their instances.
  state_.stored = kNone;
  state_.attributes.user = std::move(user);
}

void SceneBuilder::visibilityAttribute(const ParamList& params, const Location& at) {
  Attributes& attributes = changeAttributes();
  const auto set = [&](std::string_view token, uint32_t rays) {
    const Param* param = params.find(token);
    if (!param) return;
    bool on = params.floatValue(token, 1) != 0;
    if (!param->strings.empty()) {  // before PRMan 13.5: how opaque the primitive is to shadow rays
      const std::string_view word = param->strings.front();
      on = word != "transparent" && word != "none" && word != "off" && word != "0";
    }
    attributes.visibility = on ? attributes.visibility | rays : attributes.visibility & ~rays;
  };
  set("camera", kCameraRay);
  set("diffuse", kDiffuseRay);
  set("specular", kSpecularRay);
  set("indirect", kDiffuseRay | kSpecularRay);
  set("trace", kDiffuseRay | kSpecularRay);
  set("transmission", kTransmissionRay);
  attributes.castsShadows = (attributes.visibility & kTransmissionRay) != 0;
  for (const std::string_view token : {"photon", "midpoint", "subsurface"}) params.find(token);
  static constexpr std::string_view kKnown[] = {"camera",       "diffuse", "specular",
                                                "transmission", "trace",   "indirect"};
  params.reportUnread(errors_, "Attribute \"visibility\"", kKnown);
  if (attributes.visibility == 0) {
    errors_.report(Severity::Info, RiError::Range, at, "nothing sees primitives of this visibility");
  }
}

/// How surfaces are cut into micropolygons (PRMan's dicing attributes): by pixels as RI's ShadingRate has it,
/// or by lengths in space, whatever the camera sees.
void SceneBuilder::diceAttribute(const ParamList& params, const Location& at) {
  state_.roundCurves = truth(params, "roundcurve", state_.roundCurves);
  const auto length = [&](std::string_view token) -> std::optional<float> {
    const Param* param = params.find(token);
    if (!param || param->floats.empty()) return std::nullopt;
    const float value = param->floats.front();
    if (std::isfinite(value)) return value;
    error(RiError::Range, param->location,
          fmt::format("Attribute \"dice\" \"{}\": expected a length", token));
    return std::nullopt;
  };
  Attributes attributes = state_.attributes;
  attributes.foreshorten = truth(params, "rasterorient", attributes.foreshorten);
  // What is not positive stands for nothing said.
  if (const auto pixels = length("micropolygonlength"); pixels && *pixels > 0)
    attributes.shadingRate = std::max(*pixels * *pixels, 1e-4f);
  const auto units = length("worlddistancelength");
  if (const Param* param = params.find("strategy"); param && !param->strings.empty()) {
    const std::string_view strategy = param->strings.front();
    if (strategy == "worlddistance" || strategy == "objectdistance") {
      attributes.diceInObjectSpace = strategy == "objectdistance";
      // Without a length of its own the micropolygon's in pixels is one in space.
      attributes.diceLength =
          units && *units > 0 ? std::max(*units, 1e-30f) : std::sqrt(attributes.shadingRate);
    } else {
      attributes.diceLength = 0;
      if (strategy != "instanceprojection" && strategy != "planarprojection" &&
          strategy != "sphericalprojection")
        error(RiError::BadToken, param->location,
              fmt::format("Attribute \"dice\" \"strategy\" \"{}\": expected instanceprojection, "
                          "planarprojection, sphericalprojection, worlddistance or objectdistance",
                          strategy));
    }
  } else if (units && *units > 0 && attributes.diceLength > 0) {
    attributes.diceLength = std::max(*units, 1e-30f);
  }
  if (attributes != state_.attributes) changeAttributes() = attributes;
  // The numbers of micropolygons are powers of two in any case, and derivatives along hair are exact.
  for (const std::string_view token : {"binary", "hair"}) params.find(token);
  for (const Param& param : params) {
    if (param.used) continue;
    noEffect("Attribute", "dice", param.name(), at);
    param.used = true;
  }
}

void SceneBuilder::geometricApproximation(std::string_view type, float value, const Location& at) {
  // Facets stay within an eightieth of a pixel of their surface.
  if (type != "flatness")
    return countNotice(fmt::format("GeometricApproximation \"{}\" has no effect", type), at);
  if (!(value >= 0))
    error(RiError::Range, at, fmt::format("GeometricApproximation \"flatness\" {} is negative", value));
}

void SceneBuilder::displacementBound(const ParamList& params) {
  const float sphere = params.floatValue("sphere", 0);
  const std::string_view system = params.stringValue("coordinatesystem", "current");
  double scale = 1;
  // Given in another space, the radius grows by the most that the way from there to the object stretches.
  if (system != "current" && system != "object" && system != "shader") {
    const M44d toSystem =
        state_.ctm * objectBase_ * inverted(namedTransform(system).value_or(M44d())).value_or(M44d());
    if (const auto toObject = inverted(toSystem)) scale = largestStretch(*toObject);
  }
  if (sphere >= 0) changeAttributes().displacementBound = static_cast<float>(sphere * scale);
  static constexpr std::string_view kKnown[] = {"sphere", "coordinatesystem"};
  params.reportUnread(errors_, "Attribute \"displacementbound\"", kKnown);
}

/// The modern dialect's name space for what RI has requests for.
void SceneBuilder::riAttribute(const ParamList& params, const Location& at) {
  if (params.find("Sides")) sides(params.intValue("Sides", 2), at);
  if (params.find("Matte")) matte(params.intValue("Matte", 0) != 0, at);
  if (params.find("ShadingRate")) shadingRate(params.floatValue("ShadingRate", 1), at);
  if (params.find("Orientation")) orientation(params.stringValue("Orientation", "outside"), at);
  if (params.intValue("ReverseOrientation", 0) != 0) reverseOrientation(at);
  params.reportUnread(errors_, "Attribute \"Ri\"");
}

}  // namespace patina
