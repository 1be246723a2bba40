// SPDX-License-Identifier: Apache-2.0
// The rule for a file's colour space, the sRGB curve, and ways through an OpenColorIO configuration.
#include "renderer/shading/texture_color_module.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string_view>
#include <vector>

namespace OCIO = OCIO_NAMESPACE;

namespace patina::textures {
namespace {

// IEC 61966-2-1; odd, so that what is below zero comes out below zero.
float linearFromSrgb(float encoded) {
  const float e = std::abs(encoded);
  return std::copysign(e <= 0.04045f ? e / 12.92f : std::pow((e + 0.055f) / 1.055f, 2.4f), encoded);
}

const ColorConversion* keep(const std::string& key, const std::function<ColorConversion()>& make) {
  static std::mutex mutex;
  static std::map<std::string, std::unique_ptr<ColorConversion>> known;
  const std::scoped_lock lock(mutex);
  std::unique_ptr<ColorConversion>& entry = known[key];
  if (!entry) entry = std::make_unique<ColorConversion>(make());
  return entry.get();
}

const ColorConversion* power(float gamma) {
  const std::string name = "gamma " + std::to_string(gamma);
  return keep(name, [&] {
    return ColorConversion{name, [gamma](float* rgb, size_t pixels) {
                             for (size_t i = 0; i < 3 * pixels; ++i)
                               rgb[i] = std::copysign(std::pow(std::abs(rgb[i]), gamma), rgb[i]);
                           }};
  });
}

// From a colour space of a configuration to linear Rec.709.
const ColorConversion* fromConfig(const OCIO::ConstConfigRcPtr& config, const char* space) {
  const std::string key = std::string("ocio ") + config->getCacheID() + ' ' + space;
  const auto make = [&] {
    const auto group = OCIO::GroupTransform::Create();
    const auto across = OCIO::ColorSpaceTransform::Create();
    across->setSrc(space);
    across->setDst(config->hasRole(OCIO::ROLE_INTERCHANGE_SCENE) ? OCIO::ROLE_INTERCHANGE_SCENE
                                                                 : OCIO::ROLE_SCENE_LINEAR);
    group->appendTransform(across);
    if (config->hasRole(OCIO::ROLE_INTERCHANGE_SCENE)) {
      const auto toAcesCg = OCIO::BuiltinTransform::Create();
      toAcesCg->setStyle("ACEScg_to_ACES2065-1");
      toAcesCg->setDirection(OCIO::TRANSFORM_DIR_INVERSE);
      group->appendTransform(toAcesCg);
      const auto toRec709 = OCIO::BuiltinTransform::Create();
      toRec709->setStyle("UTILITY - ACES-AP1_to_LINEAR-REC709_BFD");
      group->appendTransform(toRec709);
    }
    const OCIO::ConstProcessorRcPtr processor = config->getProcessor(group);
    const OCIO::ConstCPUProcessorRcPtr cpu = processor->getDefaultCPUProcessor();
    return ColorConversion{space, [cpu](float* rgb, size_t pixels) {
                             OCIO::PackedImageDesc image(rgb, static_cast<long>(pixels), 1, 3);
                             cpu->apply(image);
                           }};
  };
  const OCIO::ConstColorSpaceRcPtr data = config->getColorSpace(space);
  if (data && data->isData()) return nullptr;
  return keep(key, make);
}

std::string lower(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return result;
}

// "1012", "u3", "v12", "<udim>" and what else may stand at the end of a name and says nothing of colour.
bool isTileOrSuffix(std::string_view word) {
  static constexpr std::string_view kSuffixes[] = {"tx",  "tex", "txr", "tdl",  "tif", "tiff",
                                                   "exr", "png", "jpg", "jpeg", "hdr", "ppm",
                                                   "pgm", "tga", "bmp", "env",  "dpx", "webp"};
  if (std::ranges::find(kSuffixes, word) != std::end(kSuffixes)) return true;
  if (word.starts_with('<') || word.starts_with('%')) return true;
  if (word.starts_with('u') || word.starts_with('v')) word.remove_prefix(1);
  return !word.empty() &&
         std::ranges::all_of(word, [](char c) { return (c >= '0' && c <= '9') || c == 'v'; });
}

}  // namespace

const ColorConversion* srgb() {
  return keep("sRGB", [] {
    return ColorConversion{"sRGB", [](float* rgb, size_t pixels) {
                             for (size_t i = 0; i < 3 * pixels; ++i) rgb[i] = linearFromSrgb(rgb[i]);
                           }};
  });
}

std::string colorWord(const std::string& path) {
  const std::string name = lower(std::filesystem::path(path).filename().string());
  std::vector<std::string_view> words;
  for (size_t start = 0; start <= name.size();) {
    const size_t end = std::min(name.find_first_of("._-", start), name.size());
    words.push_back(std::string_view(name).substr(start, end - start));
    start = end + 1;
  }
  while (words.size() > 1 && isTileOrSuffix(words.back())) words.pop_back();
  if (words.size() < 2) return {};
  const std::string_view word = words.back(), before = words[words.size() - 2];
  if (word == "srgb" && (before == "lin" || before == "linear")) return "linear";  // ACES: lin_srgb
  static constexpr std::string_view kWords[] = {"raw", "data", "linear", "lin", "srgb"};
  return std::ranges::find(kWords, word) != std::end(kWords) ? std::string(word) : std::string();
}

const ColorConversion* conversionOf(const std::string& path, const OIIO::ImageSpec& spec,
                                    const OCIO::ConstConfigRcPtr& config) {
  if (const std::string word = colorWord(path); !word.empty()) return word == "srgb" ? srgb() : nullptr;
  if (config && !config->filepathOnlyMatchesDefaultRule(path.c_str()))
    return fromConfig(config, config->getColorSpaceFromFilepath(path.c_str()));
  const std::string tag(spec.get_string_attribute("oiio:ColorSpace"));
  const std::string known = lower(tag);
  if (known == "srgb" || known == "rec709") return srgb();
  if (known == "linear" || known == "lin_srgb" || known == "scene_linear" || known == "raw") return nullptr;
  if (known.starts_with("gammacorrected") || known.starts_with("gamma")) {
    const std::string_view number =
        std::string_view(known).substr(known.starts_with("gammacorrected") ? 14 : 5);
    float gamma = 0;
    const auto read = std::from_chars(number.data(), number.data() + number.size(), gamma);
    if (read.ec == std::errc() && gamma >= 0.1f && gamma <= 10) return gamma == 1 ? nullptr : power(gamma);
  } else if (!tag.empty() && config && config->getColorSpace(tag.c_str())) {
    return fromConfig(config, tag.c_str());
  }
  return spec.format.size() == 1 ? srgb() : nullptr;
}

}  // namespace patina::textures
