// SPDX-License-Identifier: Apache-2.0
// From film to file: which format, which channels, which values.
#include "renderer/film/output.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "renderer/base/statistics.h"
#include "renderer/film/atomic_file.h"
#include "renderer/film/exr.h"
#include "renderer/film/image.h"
#include "rib/sandbox.h"

namespace patina {

namespace {

STAT_COUNTER("Film/OpenColorIO views applied", viewsApplied);

constexpr const char* kSoftware = "Patina " PATINA_VERSION;

struct Format {
  std::string_view name;                       // OpenImageIO's, and ours as a Display type
  std::array<std::string_view, 2> extensions;  // the first is appended where there is none
  int bits;                                    // most bits of an integer; 0 = floats only
  bool floats;                                 // can hold floats
};
constexpr std::array<Format, 7> kFormats = {{{"openexr", {"exr", "exr"}, 0, true},
                                             {"tiff", {"tif", "tiff"}, 16, true},
                                             {"png", {"png", "png"}, 16, false},
                                             {"jpeg", {"jpg", "jpeg"}, 8, false},
                                             {"targa", {"tga", "tga"}, 8, false},
                                             {"bmp", {"bmp", "bmp"}, 8, false},
                                             {"hdr", {"hdr", "hdr"}, 0, true}}};
constexpr const Format& kExr = kFormats[0];
constexpr const Format& kTiff = kFormats[1];
constexpr const Format& kPng = kFormats[2];

constexpr std::string_view kWindowTypes[] = {"framebuffer", "rgbframebuffer",   "it",   "x11",     "windows",
                                             "piqsl",       "sdldisplaydriver", "fltk", "iceview", "null"};
constexpr std::string_view kDepthTypes[] = {"zfile", "shadow", "deepshad"};

template <class List>
bool holds(const List& list, std::string_view what) {
  return std::find(std::begin(list), std::end(list), what) != std::end(list);
}

std::string lowered(std::string_view text) {
  std::string result(text);
  for (char& c : result)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return result;
}

const Format* formatByExtension(std::string_view fileName) {
  const std::string extension = lowered(std::filesystem::path(fileName).extension().string());
  if (extension.empty()) return nullptr;
  for (const Format& f : kFormats)
    if (holds(f.extensions, std::string_view(extension).substr(1))) return &f;
  return nullptr;
}

const Format* formatByType(std::string_view type) {
  for (const Format& f : kFormats)
    if (f.name == type || holds(f.extensions, type)) return &f;
  return nullptr;
}

// Why no picture can be put there; empty if it can.
std::string placeProblem(const std::string& path) {
  const std::string problem = writeProblem(path);
  return problem.empty() ? AtomicFile::problem(path) : "cannot write " + path + ": " + problem;
}

// What a Display request comes down to.
struct Plan {
  const Format* format = &kTiff;
  bool letter = false;  // RI's values and nothing else; otherwise made for looking at
  std::string path;
  std::string remark;  // why the type is not taken as it is; empty if it is
};

Plan planFor(const OutputSettings& s) {
  const std::string type = lowered(s.type);
  const std::string name = s.name.substr(s.name.starts_with('+') ? 1 : 0);
  const Format* byName = formatByExtension(name);
  const bool depthOnly = s.mode == "z";
  Plan plan;
  if (type == "file") {
    plan.format = byName ? byName : &kTiff;
    plan.letter = true;
  } else if (const Format* byType = formatByType(type)) {
    plan.format = byType;
    plan.letter = byType == &kTiff;
  } else if (holds(kDepthTypes, type)) {
    plan.format = byName == &kTiff ? &kTiff : &kExr;
    plan.letter = true;
    plan.remark = "Display type \"" + s.type + "\" is not supported";
  } else {
    plan.format = depthOnly ? &kExr : &kPng;
    plan.remark = holds(kWindowTypes, type)
                      ? "Display type \"" + s.type + "\" needs a window, which Patina has not"
                      : "unknown Display type \"" + s.type + '"';
  }

  if (depthOnly && !plan.format->floats && s.depth.one == 0) {
    plan.remark = "Display type \"" + s.type + "\" cannot hold depth";
    plan.format = &kExr;
  }

  // An extension of another known format would lie.
  std::filesystem::path path(name);
  if (byName != nullptr && byName != plan.format) path.replace_extension();
  if (byName != plan.format) path += "." + std::string(plan.format->extensions[0]);
  plan.path = path.string();
  return plan;
}

struct Output {
  std::vector<int> channels;       // of the film
  std::vector<std::string> names;  // in the file
  int alpha = -1, depth = -1;      // places in `channels`
};

// Letters of a mode to the film's channels; empty if the film lacks one or the mode is no such word.
Output channelsFor(const Film& film, const std::string& mode) {
  Output output;
  const auto add = [&](std::string_view channel, std::string name) {
    if (channel == "a") output.alpha = static_cast<int>(output.channels.size());
    if (channel == "z") output.depth = static_cast<int>(output.channels.size());
    output.channels.push_back(film.channelIndex(channel));
    output.names.push_back(std::move(name));
  };
  static constexpr std::string_view kModes[] = {"rgb", "rgba", "rgbz", "rgbaz", "a", "az", "z"};
  const std::string word = mode.substr(mode.find_last_of(' ') + 1);  // "varying color name" -> "name"
  if (holds(kModes, word)) {
    for (const char c : word) {
      add(std::string_view(&c, 1), std::string(1, static_cast<char>(c - 'a' + 'A')));
    }
  } else if (film.channelIndex(word) >= 0) {
    add(word, word);
  } else {
    for (const char* part : {"r", "g", "b"})
      if (film.channelIndex(word + "." + part) >= 0) add(word + "." + part, word + "." + part);
  }
  if (std::find(output.channels.begin(), output.channels.end(), -1) != output.channels.end()) return {};
  return output;
}

std::string parameter(const OutputSettings& s, std::string_view name, std::string_view otherwise) {
  for (const auto& [key, value] : s.parameters)
    if (key == name || key == "exr" + std::string(name)) return value;
  return std::string(otherwise);
}

// Interleaved linear values of the film's channels, colour times Exposure's gain, over the background.
// `gamma` is that which will be applied to them.
ImageData gather(const Film& film, const Output& output, const OutputSettings& s, float gamma) {
  const PixelRect& r = film.pixels();
  ImageData image;
  image.width = r.width();
  image.height = r.height();
  image.channels = static_cast<int>(output.channels.size());
  image.channelNames = output.names;
  image.pixels.reserve(static_cast<std::size_t>(r.width()) * static_cast<std::size_t>(r.height()) *
                       output.channels.size());
  const int alpha = s.background ? film.channelIndex("a") : -1;
  std::vector<float> behind(output.channels.size(), 0.f);  // of each channel of the file
  for (std::size_t c = 0; alpha >= 0 && c < behind.size(); ++c) {
    constexpr std::array<std::string_view, 3> kColours = {"r", "g", "b"};
    for (std::size_t k = 0; k < 3; ++k)
      if (output.channels[c] == film.channelIndex(kColours[k]))
        behind[c] = std::pow(std::max((*s.background)[k], 0.f), gamma);
    if (output.channels[c] == alpha) behind[c] = 1;
  }
  for (int y = r.y0; y < r.y1; ++y)
    for (int x = r.x0; x < r.x1; ++x) {
      const float seen = alpha >= 0 ? std::clamp(1 - film.value(x, y, alpha), 0.f, 1.f) : 0;
      for (std::size_t c = 0; c < output.channels.size(); ++c) {
        const bool colour = static_cast<int>(c) != output.alpha && static_cast<int>(c) != output.depth;
        image.pixels.push_back(film.value(x, y, output.channels[c]) * (colour ? s.gain : 1.f) +
                               seen * behind[c]);
      }
    }
  return image;
}

// Calls change(value) for the colour values of every pixel.
template <class Change>
void forEachColour(ImageData& image, const Output& output, Change change) {
  const auto channels = static_cast<std::size_t>(image.channels);
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    const int c = static_cast<int>(i % channels);
    if (c != output.alpha && c != output.depth) change(image.pixels[i]);
  }
}

// Divides or multiplies colour by alpha; a pixel without alpha keeps its colour, which was added, not
// covering.
void unassociate(ImageData& image, const Output& output) {
  if (output.alpha < 0) return;
  const auto channels = static_cast<std::size_t>(image.channels);
  for (std::size_t i = 0; i < image.pixels.size(); i += channels) {
    const float alpha = image.pixels[i + static_cast<std::size_t>(output.alpha)];
    if (alpha <= 0 || alpha >= 1) continue;
    for (std::size_t c = 0; c < channels; ++c)
      if (static_cast<int>(c) != output.alpha && static_cast<int>(c) != output.depth)
        image.pixels[i + c] /= alpha;
  }
}

// Exposure's gamma, or the display transform that takes its place. Returns a reason, or an empty text.
std::string encodeColour(ImageData& image, const Output& output, const OutputSettings& s, bool letter) {
  if (letter || s.gamma != 1) {
    forEachColour(image, output, [&](float& v) { v = exposed(v, 1, s.gamma); });
    return {};
  }
  if (s.displayView.empty() || s.displayView == "sRGB") {
    forEachColour(image, output, [](float& v) { v = srgbEncoded(v); });
    return {};
  }
  std::string error;
  const PatinaImageModule* module = imageModule(error);
  if (module == nullptr) return error;
  std::vector<float> colours;
  forEachColour(image, output, [&](float& v) { colours.push_back(v); });
  if (colours.size() % 3 != 0) return {};
  std::array<char, 1024> text{};
  if (!module->applyView(s.displayView.c_str(), colours.data(), colours.size() / 3, text.data(), text.size()))
    return text.data();
  ++viewsApplied;
  std::size_t next = 0;
  forEachColour(image, output, [&](float& v) { v = colours[next++]; });
  return {};
}

// One file's pixels in their final type.
struct Encoded {
  int pixelType = PATINA_PIXEL_F32;
  std::vector<std::uint8_t> bytes;
};

template <class Integer>
void quantizeInto(Encoded& encoded, const ImageData& image, const Quantizer& q, const PixelRect& r) {
  encoded.bytes.resize(image.pixels.size() * sizeof(Integer));
  auto* out = reinterpret_cast<Integer*>(encoded.bytes.data());
  std::size_t i = 0;
  for (int y = r.y0; y < r.y1; ++y)
    for (int x = r.x0; x < r.x1; ++x)
      for (int c = 0; c < image.channels; ++c, ++i) {
        constexpr float kMost = std::numeric_limits<Integer>::max();
        out[i] = static_cast<Integer>(std::clamp(quantized(image.pixels[i], q, x, y, c), 0.f, kMost));
      }
}

Encoded encodePixels(const ImageData& image, const Output& output, const Format& format,
                     const OutputSettings& s, const PixelRect& r) {
  Quantizer q = output.depth >= 0 ? s.depth : s.colour;
  if (!format.floats && (q.one == 0 || q.max > static_cast<float>((1 << format.bits) - 1))) q = Quantizer{};
  // Colour and depth have different quantisers: a file that holds both holds floats.
  const bool mixed = output.depth >= 0 && output.channels.size() > 1;
  Encoded encoded;
  if (format.bits > 0 && q.one != 0 && q.max <= 65535 && !mixed) {
    encoded.pixelType = q.max <= 255 ? PATINA_PIXEL_U8 : PATINA_PIXEL_U16;
    q.max <= 255 ? quantizeInto<std::uint8_t>(encoded, image, q, r)
                 : quantizeInto<std::uint16_t>(encoded, image, q, r);
  } else {
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(image.pixels.data());
    encoded.bytes.assign(bytes, bytes + image.pixels.size() * sizeof(float));
  }
  return encoded;
}

// Everything but EXR. Returns a reason, or an empty text.
std::string writeByModule(const Film& film, const OutputSettings& s, const Plan& plan, const Output& output,
                          ImageData image) {
  const Format& format = *plan.format;
  const bool looking = !plan.letter && !(format.floats && format.bits == 0);
  const bool unassociated = format.name == "png" || format.name == "targa";
  if (unassociated) unassociate(image, output);
  std::string problem = placeProblem(plan.path);
  if (problem.empty() && (plan.letter || looking)) problem = encodeColour(image, output, s, plan.letter);
  if (!problem.empty()) return problem;
  const Encoded pixels = encodePixels(image, output, format, s, film.pixels());

  std::vector<const char*> names;
  for (const std::string& name : output.names) names.push_back(name.c_str());
  const std::array<const char*, 1> keys = {"Software"}, values = {kSoftware};
  PatinaImageToWrite out{};
  out.structSize = sizeof out;
  out.width = image.width;
  out.height = image.height;
  out.channels = image.channels;
  out.x = film.pixels().x0;
  out.y = film.pixels().y0;
  out.fullWidth = film.settings().width;
  out.fullHeight = film.settings().height;
  out.pixelType = pixels.pixelType;
  out.pixels = pixels.bytes.data();
  out.channelNames = names.data();
  out.alphaChannel = output.alpha;
  out.depthChannel = output.depth;
  out.unassociatedAlpha = unassociated ? 1 : 0;
  out.srgb = looking && s.gamma == 1 ? 1 : 0;
  out.attributeCount = static_cast<std::int32_t>(keys.size());
  out.attributeNames = keys.data();
  out.attributeValues = values.data();
  out.worldToCamera = s.worldToCamera ? s.worldToCamera->data() : nullptr;
  out.worldToScreen = s.worldToScreen ? s.worldToScreen->data() : nullptr;

  std::string error;
  const PatinaImageModule* module = imageModule(error);
  if (module == nullptr) return error;
  std::array<char, 1024> text{};
  std::string bytes;
  const auto append = [](void* to, const void* from, std::size_t size) {
    static_cast<std::string*>(to)->append(static_cast<const char*>(from), size);
  };
  if (!module->encode(std::string(format.name).c_str(), &out, append, &bytes, text.data(), text.size()))
    return "cannot write " + plan.path + ": " + text.data();
  AtomicFile file(plan.path);
  problem = file.write(bytes);
  return problem.empty() ? file.commit() : problem;
}

std::string writeByOpenExr(const Film& film, const OutputSettings& s, const Plan& plan,
                           const ImageData& image) {
  ExrSettings exr;
  exr.fullWidth = film.settings().width;
  exr.fullHeight = film.settings().height;
  exr.x = film.pixels().x0;
  exr.y = film.pixels().y0;
  exr.half = parameter(s, "pixeltype", "float") == "half";
  exr.compression = parameter(s, "compression", "zip");
  exr.attributes = {{"software", kSoftware}};
  exr.worldToCamera = s.worldToCamera;
  exr.worldToScreen = s.worldToScreen;
  if (std::string problem = placeProblem(plan.path); !problem.empty()) return problem;
  return writeExr(plan.path, image, exr);
}

// The channels of the mode; a mode that cannot be had is reported and replaced by rgba or rgb. JPEG and its
// like have no alpha, formats of integers no depth.
Output outputFor(const Film& film, const OutputSettings& s, const Plan& plan, ErrorHandler& errors) {
  std::string mode = s.mode;
  Output output = channelsFor(film, mode);
  if (output.channels.empty()) {
    mode = film.channelIndex("a") >= 0 ? "rgba" : "rgb";
    errors.reportOnce(Severity::Warning, RiError::BadArgument, s.at, "display mode " + s.mode,
                      "unknown Display mode \"" + s.mode + "\": \"" + mode +
                          "\" is written (known are rgb, rgba, rgbz, rgbaz, a, az, z)");
    output = channelsFor(film, mode);
  }
  const bool noAlpha =
      plan.format->name == "jpeg" || plan.format->name == "bmp" || plan.format->name == "hdr";
  const auto drop = [&](int place, const char* what) {
    errors.reportOnce(Severity::Warning, RiError::Incapable, s.at, "display drop " + plan.path + what,
                      plan.path + ": this format holds no " + what + ", which is left out");
    output.channels.erase(output.channels.begin() + place);
    output.names.erase(output.names.begin() + place);
    if (output.alpha > place) --output.alpha;
    if (output.depth > place) --output.depth;
  };
  if (!plan.format->floats && output.depth >= 0 && output.channels.size() > 1) {
    drop(output.depth, "depth");
    output.depth = -1;
  }
  if (noAlpha && output.alpha >= 0 && output.channels.size() > 1) {
    drop(output.alpha, "alpha");
    output.alpha = -1;
  }
  return output;
}

void remark(const OutputSettings& s, const Plan& plan, ErrorHandler& errors) {
  if (!plan.remark.empty())
    errors.reportOnce(Severity::Warning, RiError::Incapable, s.at, "display type " + s.type + " " + plan.path,
                      plan.remark + ": the file " + plan.path + " is written");
}

}  // namespace

std::string outputPath(const OutputSettings& settings) { return planFor(settings).path; }

bool checkOutput(const OutputSettings& settings, const Film& film, ErrorHandler& errors) {
  const Plan plan = planFor(settings);
  remark(settings, plan, errors);
  outputFor(film, settings, plan, errors);
  const std::string problem = placeProblem(plan.path);
  if (!problem.empty()) errors.report(Severity::Error, RiError::System, settings.at, problem);
  return problem.empty();
}

std::string writeImage(const Film& film, const OutputSettings& settings, ErrorHandler& errors) {
  const Plan plan = planFor(settings);
  remark(settings, plan, errors);
  const Output output = outputFor(film, settings, plan, errors);
  std::string problem = output.channels.empty() ? "the film has no colour channels" : "";
  if (problem.empty()) {
    ImageData image = gather(film, output, settings, plan.format == &kExr ? 1 : settings.gamma);
    problem = plan.format == &kExr ? writeByOpenExr(film, settings, plan, image)
                                   : writeByModule(film, settings, plan, output, std::move(image));
  }
  if (problem.empty()) return plan.path;
  errors.report(Severity::Error, RiError::System, settings.at, problem);
  return {};
}

std::string_view displayTypeFor(std::string_view fileName) {
  const Format* format = formatByExtension(fileName);
  return format ? format->name : std::string_view();
}

}  // namespace patina
