// SPDX-License-Identifier: Apache-2.0
// Finds and loads the image module; reads images of every format.
#include "renderer/film/image.h"

#include <dlfcn.h>

#include <array>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "renderer/base/statistics.h"
#include "renderer/film/exr.h"

namespace patina {

namespace fs = std::filesystem;

namespace {

STAT_COUNTER("Film/image module loads", loadCounter);

constexpr const char* kModuleFile = "patina_oiio.so";

std::atomic<bool> loaded{false};

std::vector<fs::path> moduleFolders() {
  std::vector<fs::path> folders;
  if (const char* list = std::getenv("PATINA_MODULE_PATH")) {
    std::string_view rest = list;
    while (!rest.empty()) {
      const std::size_t end = std::min(rest.find(':'), rest.size());
      if (end > 0) folders.emplace_back(rest.substr(0, end));
      rest.remove_prefix(std::min(end + 1, rest.size()));
    }
  }
  std::error_code error;
  const fs::path prefix = fs::read_symlink("/proc/self/exe", error).parent_path().parent_path();
  folders.push_back(prefix / "lib/patina/modules");
  folders.push_back(prefix / PATINA_MODULE_INSTALL_DIR);
  return folders;
}

struct LoadedModule {
  const PatinaImageModule* module = nullptr;
  std::string error;
};

LoadedModule loadModule() {
  LoadedModule result;
  for (const fs::path& folder : moduleFolders()) {
    const fs::path path = folder / kModuleFile;
    std::string reason;
    std::error_code ignored;
    if (!fs::exists(path, ignored)) {
      reason = "no such file";
    } else if (void* library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL); library == nullptr) {
      reason = dlerror();
    } else {
      const auto* module = static_cast<const PatinaImageModule*>(dlsym(library, PATINA_IMAGE_MODULE_SYMBOL));
      if (module != nullptr && module->version == PATINA_IMAGE_MODULE_VERSION) {
        result.module = module;
        loaded = true;
        ++loadCounter;
        return result;
      }
      reason = "not an image module of version " + std::to_string(PATINA_IMAGE_MODULE_VERSION);
    }
    result.error += "\n  " + path.string() + ": " + reason;
  }
  result.error = "the image module cannot be loaded; tried:" + result.error;
  return result;
}

bool isExr(const std::string& path) {
  std::array<char, 4> magic{};
  std::ifstream(path, std::ios::binary).read(magic.data(), magic.size());
  return magic == std::array<char, 4>{'\x76', '\x2f', '\x31', '\x01'};
}

}  // namespace

const PatinaImageModule* imageModule(std::string& error) {
  static const LoadedModule once = loadModule();
  if (once.module == nullptr) error = once.error;
  return once.module;
}

bool imageModuleLoaded() { return loaded; }

std::optional<ImageData> readImage(const std::string& path, std::string& error) {
  std::error_code status;
  if (!fs::is_regular_file(path, status)) {
    error = "cannot read " + path + ": " + (status ? status.message() : "not a regular file");
    return std::nullopt;
  }
  if (isExr(path)) return readExr(path, error);
  const PatinaImageModule* module = imageModule(error);
  if (module == nullptr) return std::nullopt;

  std::array<char, 1024> text{};
  PatinaImageInfo info{};
  info.structSize = sizeof info;
  const auto failed = [&](const char* why) {
    error = "cannot read " + path + ": " + why;
    return std::nullopt;
  };
  const std::unique_ptr<void, void (*)(void*)> file(
      module->open(path.c_str(), &info, text.data(), text.size()), module->close);
  if (file == nullptr) return failed(text.data());
  if (info.width < 1 || info.height < 1 || info.channels < 1) return failed("the image is empty");
  const auto width = static_cast<std::size_t>(info.width), height = static_cast<std::size_t>(info.height);
  const auto channels = static_cast<std::size_t>(info.channels);
  if (width > kLargestImage / height || width * height > kLargestImage / channels)
    return failed("the image is too large");

  ImageData image;
  image.width = info.width;
  image.height = info.height;
  image.channels = info.channels;
  image.srgb = info.srgb != 0;
  static constexpr std::array<const char*, 4> kColour = {"R", "G", "B", "A"}, kGrey = {"Y", "A", "", ""};
  for (std::size_t c = 0; c < channels; ++c) {
    const auto& names = channels < 3 ? kGrey : kColour;
    image.channelNames.push_back(c < names.size() ? names[c] : "channel" + std::to_string(c));
  }
  image.pixels.resize(width * height * channels);
  if (module->read(file.get(), image.pixels.data(), text.data(), text.size()) == 0)
    return failed(text.data());
  return image;
}

}  // namespace patina
