// SPDX-License-Identifier: Apache-2.0
// Options of picture and renderer: PixelSamples to Display, Hider and Option.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <limits>

#include "renderer/scene/scene_builder.h"
#include "rib/sandbox.h"
#include "rib/search_path.h"

namespace patina {
namespace {

using Names = std::span<const std::string_view>;

/// Marks parameters that other renderers know and that change nothing here.
void passOver(const ParamList& params, Names names) {
  for (const Param& param : params) {
    if (std::ranges::find(names, param.name()) != names.end()) param.used = true;
  }
}

/// Why a RIB's statistics are not written there.
std::string statisticsProblem(const std::string& file) {
  if (!isSandboxed() || file.empty() || file == "stdout") return {};
  constexpr std::array<std::string_view, 4> kEndings = {".txt", ".json", ".xml", ".html"};
  if (std::ranges::find(kEndings, std::filesystem::path(file).extension().string()) == kEndings.end())
    return "with --sandbox the name must end with .txt, .json, .xml or .html";
  return writeProblem(file);
}

constexpr std::string_view kIgnoredLimits[] = {
    "gridsize",    "geommemory",       "eyesplits",       "zthreshold",        "othreshold",
    "brickmemory", "deepshadowmemory", "deepshadowtiles", "proceduralmemory",  "octreememory",
    "pointmemory", "ptexturemaxfiles", "ptexturememory",  "hairmemory",        "threads",
    "shadesize",   "rendermemory",     "rendertime",      "matrixcachememory", "deepshadowerror",
    "texturefiles"};
constexpr std::string_view kIgnoredHider[] = {
    "jitter",           "adaptall",         "pixelfiltermode", "darkfalloff",
    "minextrasamples",  "adaptivemetric",   "bluenoise",       "samplemotion",
    "subpixel",         "extrememotiondof", "sigma",           "sigmablur",
    "depthfilter",      "decidither",       "maxvpdepth",      "mpcache",
    "mpcachedir",       "mpmemory",         "allowsurfaces",   "exposurebracket",
    "opacitythreshold", "dofaspect",        "rendermode"};
constexpr std::string_view kIgnoredTrace[] = {"decimationrate", "bvhcompression", "worldorigin",
                                              "worldoffset"};
constexpr std::string_view kIgnoredStatistics[] = {"xmlfilename",      "level",           "shaderprofile",
                                                   "stylesheet",       "maxdispwarnings", "displace_ratios",
                                                   "texturestatslevel"};
/// Name spaces that no picture depends on.
constexpr std::string_view kHintOptions[] = {"user", "rib", "bucket", "rerender", "runtime", "render"};

}  // namespace

void SceneBuilder::pixelVariance(float variance, const Location& at) {
  if (!(variance >= 0))
    return error(RiError::Range, at, fmt::format("PixelVariance {} is negative", variance));
  options_.pixelVariance = variance;
}

void SceneBuilder::pixelSamples(float x, float y, const Location& at) {
  constexpr float kMost = 4096;
  if (!(x <= kMost && y <= kMost)) {
    return error(RiError::LimitCheck, at,
                 fmt::format("PixelSamples {} {}: at most {} each way", x, y, kMost));
  }
  options_.pixelSamplesX = static_cast<int>(std::lround(std::max(x, 1.0f)));
  options_.pixelSamplesY = static_cast<int>(std::lround(std::max(y, 1.0f)));
}

void SceneBuilder::pixelFilter(std::string_view name, float xWidth, float yWidth, const Location& at) {
  static constexpr std::string_view kNames[] = {"box", "triangle", "catmull-rom", "sinc", "gaussian"};
  constexpr float kWidest = 64;
  if (name.starts_with("separable-")) name.remove_prefix(10);
  if (!(xWidth > 0 && xWidth <= kWidest && yWidth > 0 && yWidth <= kWidest)) {
    return error(
        RiError::Range, at,
        fmt::format("PixelFilter: widths {} {} are not between 0 and {} pixels", xWidth, yWidth, kWidest));
  }
  if (std::ranges::find(kNames, name) == std::end(kNames)) {
    warning(RiError::BadToken, at,
            fmt::format("PixelFilter \"{}\" is unknown (expected box, triangle, catmull-rom, sinc or "
                        "gaussian): gaussian 2 2 "
                        "takes its place",
                        name));
    name = "gaussian";
    xWidth = yWidth = 2;
  }
  options_.filter = name;
  options_.filterWidthX = xWidth;
  options_.filterWidthY = yWidth;
}

void SceneBuilder::exposure(float gain, float gamma, const Location& at) {
  if (!(gain > 0) || !(gamma > 0)) {
    return error(RiError::Range, at,
                 fmt::format("Exposure {} {}: gain and gamma must be positive", gain, gamma));
  }
  options_.exposureGain = gain;
  options_.exposureGamma = gamma;
}

void SceneBuilder::imager(std::string_view name, const ParamList& params, const Location& at) {
  options_.background.reset();
  if (name == "background" || name == "PxrBackgroundDisplayFilter") {
    Rgb color(1, 1, 1);
    for (const std::string_view token : {"color", "bgcolor", "background", "backgroundColor"}) {
      const auto value = params.tripleValue(token, {color.x, color.y, color.z});
      color = Rgb(value[0], value[1], value[2]);
    }
    options_.background = color;
    params.reportUnread(errors_, "Imager");
  } else if (!name.empty() && name != "null") {
    unhandled(fmt::format("Imager \"{}\"", name), at);
  }
}

void SceneBuilder::quantize(std::string_view type, int one, int min, int max, float dither,
                            const Location& at) {
  if (one < 0 || min > max) {
    return error(RiError::Range, at,
                 fmt::format("Quantize {} {} {}: expected one >= 0 and minimum <= maximum", one, min, max));
  }
  const Quantization quantization{one, min, max, dither};
  if (type == "z") {
    options_.depthQuantization = quantization;
  } else if (type == "rgba" || type == "rgb" || type == "a") {
    options_.colorQuantization = quantization;
  } else {
    warning(RiError::BadToken, at, fmt::format("Quantize \"{}\": expected rgba or z", type));
  }
}

void SceneBuilder::display(std::string_view name, std::string_view type, std::string_view mode,
                           const ParamList& params, const Location& at) {
  DisplayRequest request;
  request.type = type;
  request.mode = mode;
  request.where = at;
  for (const Param& param : params) {
    param.used = true;
    const std::string key(param.name());
    if (!param.strings.empty()) {
      request.strings[key] = param.strings.front();
    } else if (!param.ints.empty()) {
      request.numbers[key].assign(param.ints.begin(), param.ints.end());
    } else {
      request.numbers[key].assign(param.floats.begin(), param.floats.end());
    }
  }
  constexpr size_t kMostDisplays = 1000;
  if (name.starts_with('+')) {
    name.remove_prefix(1);
  } else {
    options_.displays.clear();
  }
  if (options_.displays.size() >= kMostDisplays) {
    return error(RiError::LimitCheck, at, fmt::format("more than {} Displays", kMostDisplays), "displays");
  }
  request.name = name;
  options_.displays.push_back(std::move(request));
}

void SceneBuilder::hider(std::string_view type, const ParamList& params, const Location& at) {
  if (type == "raytrace") {
    const auto samples = [&](std::string_view token, std::optional<int>& value) {
      const int n = params.intValue(token, 0);
      if (n > 0) value = std::min(n, 1 << 24);
    };
    samples("minsamples", options_.minSamples);
    samples("maxsamples", options_.maxSamples);
    options_.incremental = params.intValue("incremental", options_.incremental) != 0;
    const std::string_view mode = params.stringValue("integrationmode", riMode_);
    if (mode == "distribution" || mode == "path" || mode.empty()) {
      riMode_ = mode;
    } else {
      warning(RiError::BadToken, at,
              fmt::format("Hider \"raytrace\" integrationmode \"{}\": expected distribution or path", mode));
    }
  } else if (type != "hidden" && type != "null") {
    unhandled(fmt::format("Hider \"{}\"", type), at);
    return;
  }
  passOver(params, kIgnoredHider);
  params.reportUnread(
      errors_, "Hider",
      std::array<std::string_view, 4>{"minsamples", "maxsamples", "integrationmode", "incremental"});
}

void SceneBuilder::integrator(std::string_view name, Handle, const ParamList& params, const Location& at) {
  if (params.find("allowCaustics")) options_.caustics = params.intValue("allowCaustics", 1) != 0;
  if (name == "PxrPathTracer" || name == "PxrUnified" || name == "PxrVCM") {
    riMode_ = "path";
  } else if (name == "PxrDirectLighting" || name == "PxrDirectlighting") {
    riMode_ = "direct";
  } else {
    unhandled(fmt::format("Integrator \"{}\"", name), at);
  }
}

void SceneBuilder::colorSamples(Floats toRgb, Floats fromRgb, const Location& at) {
  if (toRgb.size() != 9 || fromRgb.size() != 9) {
    error(RiError::BadColor, at,
          fmt::format("ColorSamples with {} samples: colours have three here, as linear Rec.709",
                      toRgb.size() / 3));
  }
}

void SceneBuilder::relativeDetail(float scale, const Location& at) {
  if (!(scale >= 0)) return error(RiError::Range, at, fmt::format("RelativeDetail {} is negative", scale));
  options_.relativeDetail = scale;
}

void SceneBuilder::readPointOptions(const ParamList& params, const Location& at) {
  const auto refuse = [&](std::string_view token, const auto& value, std::string_view expected) {
    error(RiError::Range, at,
          fmt::format("Option \"points\" \"{}\" {}: expected {}", token, value, expected));
  };
  const auto whole = [&](std::string_view token, int least, int most, int unit, std::optional<int>& to,
                         std::string_view expected) {
    if (!params.find(token)) return;
    const int value = params.intValue(token, 0);
    if (value >= least && value <= most && value % unit == 0)
      to = value;
    else
      refuse(token, value, expected);
  };
  PointOptions& points = options_.points;
  if (params.find("maxsolidangle")) {
    const float angle = params.floatValue("maxsolidangle", 0);
    if (angle >= PointOptions::kLeastAngle && angle <= PointOptions::kMostAngle)
      points.maxSolidAngle = angle;
    else
      refuse("maxsolidangle", angle, "0.0001 to 1");
  }
  whole("resolution", PointOptions::kLeastResolution, PointOptions::kMostResolution, 2, points.resolution,
        "an even number from 4 to 128");
  whole("bounces", 1, PointOptions::kMostBounces, 1, points.bounces, "1 to 64");
  if (params.find("surfelsize")) {
    const float size = params.floatValue("surfelsize", 0);
    if (size >= 0 && size <= PointOptions::kMostSurfelSize)
      points.surfelSize = size;
    else
      refuse("surfelsize", size, "0 to 1e6");
  }
  whole("memory", 1, std::numeric_limits<int>::max(), 1, points.memoryKb, "kilobytes");
  params.reportUnread(
      errors_, "Option \"points\"",
      std::array<std::string_view, 5>{"maxsolidangle", "resolution", "bounces", "memory", "surfelsize"});
}

void SceneBuilder::option(std::string_view name, const ParamList& params, const Location& at) {
  setUserValues("option", name, params);
  if (name != "searchpath" && std::ranges::find(kHintOptions, name) == std::end(kHintOptions))
    nameLateOption("Option", at);
  if (name == "limits") {
    const auto memory = [&](std::string_view token, int& kilobytes) {
      const int value = params.intValue(token, kilobytes);
      if (value >= 0) {
        kilobytes = value;
      } else if (value != -1) {  // PRMan's "default"
        error(RiError::Range, at,
              fmt::format("Option \"limits\" \"{}\" {}: expected kilobytes", token, value));
      }
    };
    memory("radiositycachememory", options_.radiosityCacheKb);
    memory("opacitycachememory", options_.opacityCacheKb);
    memory("geocachememory", options_.geometryCacheKb);
    memory("texturememory", options_.textureKb);
    if (const Param* size = params.find("bucketsize"); size && size->ints.size() == 2) {
      if (size->ints[0] >= 1 && size->ints[1] >= 1) {
        options_.bucketSize = {std::min(size->ints[0], 1024), std::min(size->ints[1], 1024)};
      }
    }
    passOver(params, kIgnoredLimits);
    params.reportUnread(errors_, "Option \"limits\"",
                        std::array<std::string_view, 5>{"radiositycachememory", "opacitycachememory",
                                                        "geocachememory", "texturememory", "bucketsize"});
  } else if (name == "searchpath") {
    for (const Param& param : params) {
      param.used = true;
      if (param.strings.empty()) continue;
      if (isSandboxed() && param.name() == "shader") {
        warning(
            RiError::Incapable, at,
            "Option \"searchpath\" \"shader\" has no effect with --sandbox: shaders are programs, and come "
            "from the folders of the command line only",
            "shader path in sandbox");
        continue;
      }
      std::string& path = options_.searchPaths[std::string(param.name())];
      std::string joined(param.strings.front());
      for (size_t i = 1; i < param.strings.size(); ++i) joined.append(":").append(param.strings[i]);
      path = expandSearchPath(joined, path);
    }
  } else if (name == "statistics") {
    options_.statistics = params.intValue("endofframe", options_.statistics) != 0;
    options_.statisticsFile = params.stringValue("filename", options_.statisticsFile);
    if (const std::string problem = statisticsProblem(options_.statisticsFile); !problem.empty()) {
      error(RiError::System, at,
            fmt::format("Option \"statistics\" \"filename\" \"{}\": {}", options_.statisticsFile, problem));
      options_.statisticsFile.clear();
    }
    passOver(params, kIgnoredStatistics);
    params.reportUnread(errors_, "Option \"statistics\"",
                        std::array<std::string_view, 2>{"endofframe", "filename"});
  } else if (name == "patina") {
    const std::string_view mode = params.stringValue("mode", patinaMode_);
    static constexpr std::string_view kModes[] = {"radiosity", "distribution", "path", "points", "direct"};
    if (mode.empty() || std::ranges::find(kModes, mode) != std::end(kModes)) {
      patinaMode_ = mode;
    } else {
      error(RiError::BadToken, at,
            fmt::format(
                "Option \"patina\" \"mode\" \"{}\": expected radiosity, distribution, path, points or direct",
                mode));
    }
    if (const std::string_view view = params.stringValue("display", ""); !view.empty())
      options_.displayView = view;
    if (const std::string_view config = params.stringValue("ocio", ""); !config.empty() && isSandboxed()) {
      error(RiError::Incapable, at,
            "Option \"patina\" \"ocio\" has no effect with --sandbox: such a file names others to be read; "
            "$OCIO says which one is used");
    } else if (!config.empty()) {
      // Beside the RIB, or else as it is.
      const std::filesystem::path beside =
          at.file ? std::filesystem::path(*at.file).parent_path() / config : std::filesystem::path(config);
      std::error_code failed;
      options_.ocioConfig =
          std::filesystem::is_regular_file(beside, failed) ? beside.string() : std::string(config);
      options_.ocioWhere = at;
    }
    if (const int seed = params.intValue("seed", options_.seed); seed >= 0) {
      options_.seed = seed;
    } else {
      error(RiError::Range, at, fmt::format("Option \"patina\" \"seed\" {}: expected 0 or more", seed));
    }
    constexpr float kMostScale = 1000;
    const auto scale = [&](std::string_view token, float& value) {
      const float wanted = params.floatValue(token, value);
      if (wanted >= 0 && wanted <= kMostScale) {
        value = wanted;
      } else {
        error(RiError::Range, at,
              fmt::format("Option \"patina\" \"{}\" {}: expected 0 to {}", token, wanted, kMostScale));
      }
    };
    scale("levelscale", options_.levelScale);
    scale("finescale", options_.fineScale);
    params.reportUnread(
        errors_, "Option \"patina\"",
        std::array<std::string_view, 6>{"mode", "display", "ocio", "seed", "levelscale", "finescale"});
  } else if (name == "points") {
    readPointOptions(params, at);
  } else if (name == "trace") {
    passOver(params, kIgnoredTrace);
    if (params.find("allowcaustics")) options_.caustics = params.intValue("allowcaustics", 1) != 0;
    for (const std::string_view token : {"maxdepth", "specularthreshold", "continuationby"})
      if (params.find(token)) noEffect("Option", name, token, at);
    params.reportUnread(errors_, "Option \"trace\"", std::array<std::string_view, 1>{"allowcaustics"});
  } else if (std::ranges::find(kHintOptions, name) == std::end(kHintOptions)) {
    noEffect("Option", name, {}, at);
  }
}

}  // namespace patina
