// SPDX-License-Identifier: Apache-2.0
// Descriptions of scenes and settings, from JSON.
#include "tools/patina-bench/scenes.h"

#include <fmt/format.h>
#include <fnmatch.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "renderer/film/atomic_file.h"
#include "tools/patina-bench/child.h"

namespace patina::bench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::vector<std::string> words(const json& value, const std::string& where) {
  std::vector<std::string> result;
  if (!value.is_array()) throw std::runtime_error(where + ": expected a list of texts");
  for (const json& word : value) {
    if (!word.is_string()) throw std::runtime_error(where + ": expected a list of texts");
    result.push_back(word);
  }
  return result;
}

// A script's scene is written anew each time, so that its files are those of this script.
fs::path make(const fs::path& script, const fs::path& folder) {
  fs::remove_all(folder);
  fs::create_directories(folder);
  const fs::path log = folder.parent_path() / (folder.filename().string() + ".log");
  const ChildUsage usage =
      runChild({"/usr/bin/env", "python3", "-B", script.string(), folder.string()}, {"", log.string(), 600});
  if (!usage.failure.empty()) throw std::runtime_error(script.string() + " " + usage.failure);
  const fs::path rib = folder / "scene.rib";
  if (!fs::exists(rib)) throw std::runtime_error(script.string() + " has not written scene.rib");
  return rib;
}

// The RIB and the files in its folder, by name; of a RIB alone in a folder of others, itself.
uint64_t hashOfScene(const Scene& scene, bool folder) {
  uint64_t hash = hashBytes(readFile(scene.rib));
  for (const std::string& word : scene.args) hash = hashBytes(word + '\n', hash);
  if (!folder) return hash;
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(scene.rib.parent_path()))
    if (entry.is_regular_file() && entry.path().extension() != ".json" && entry.path() != scene.rib)
      files.push_back(entry.path());
  std::ranges::sort(files);
  for (const fs::path& file : files)
    hash = hashBytes(readFile(file), hashBytes(file.filename().string(), hash));
  return hash;
}

}  // namespace

uint64_t hashBytes(std::string_view bytes, uint64_t state) {
  for (const char c : bytes) state = (state ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  return state;
}

std::string readFile(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(in), {}};
  if (!in.is_open() || in.bad()) throw std::runtime_error(path.string() + " cannot be read");
  return bytes;
}

void writeText(const fs::path& path, const std::string& bytes) {
  AtomicFile file(path.string());
  std::string problem = file.write(bytes);
  if (problem.empty()) problem = file.commit();
  if (!problem.empty()) throw std::runtime_error(problem);
}

std::vector<Setting> defaultSettings() {
  std::vector<Setting> all = {
      {"radiosity", "quick", {"--samples", "4", "--rays", "32", "--light-samples", "4"}},
      {"radiosity", "default", {}},
      {"radiosity", "fine", {"--samples", "64"}},
      {"radiosity", "high", {"--samples", "64", "--rays", "512", "--light-samples", "32"}},
      {"radiosity", "best", {"--samples", "256", "--rays", "2048", "--light-samples", "64"}},
      {"distribution", "4", {"--samples", "4", "--rays", "4", "--light-samples", "1"}},
      {"distribution", "16", {"--samples", "4", "--rays", "16", "--light-samples", "4"}},
      {"distribution", "64", {"--samples", "8", "--rays", "64", "--light-samples", "8"}},
      {"points",
       "quick",
       {"--samples", "4", "--light-samples", "4", "--points-maxsolidangle", "0.15", "--points-resolution",
        "8"}},
      {"points", "default", {}},
      {"points",
       "high",
       {"--light-samples", "32", "--points-maxsolidangle", "0.02", "--points-resolution", "32",
        "--points-bounces", "8", "--points-memory", "1024"}}};
  for (int samples = 4; samples <= 1024; samples *= 4) {
    const std::string text = std::to_string(samples);
    all.push_back({"path", text, {"--samples", text}});
  }
  return all;
}

std::vector<Setting> parseSettings(const json& object, const std::string& where) {
  if (!object.is_object()) throw std::runtime_error(where + ": expected lists of settings by mode");
  std::vector<Setting> settings;
  for (const auto& [mode, list] : object.items()) {
    if (!list.is_array()) throw std::runtime_error(fmt::format("{}: {}: expected a list", where, mode));
    for (const json& one : list) {
      const std::string place = fmt::format("{}: {}[{}]", where, mode, &one - &list[0]);
      if (!one.is_object() || !one.contains("name") || !one["name"].is_string())
        throw std::runtime_error(place + ": expected {\"name\": text, \"args\": list of texts}");
      for (const auto& [key, value] : one.items())
        if (key != "name" && key != "args") throw std::runtime_error(place + ": unknown key " + key);
      Setting setting{mode, one["name"], {}};
      if (one.contains("args")) setting.args = words(one["args"], place + ": args");
      const auto same = [&](const Setting& s) { return s.mode == mode && s.name == setting.name; };
      if (setting.name.empty() || setting.name.find('/') != std::string::npos ||
          std::ranges::any_of(settings, same))
        throw std::runtime_error(place + ": names are unique within a mode, not empty and without /");
      settings.push_back(std::move(setting));
    }
  }
  return settings;
}

Scene loadScene(const fs::path& path, const fs::path& work) {
  Scene scene;
  if (!fs::exists(path)) throw std::runtime_error(path.string() + " does not exist");
  const fs::path full = fs::weakly_canonical(path);
  if (!fs::is_directory(full) && full.extension() != ".json") {
    scene.rib = full, scene.name = full.stem().string();
    scene.hash = hashOfScene(scene, false);
    return scene;
  }
  const fs::path file = fs::is_directory(full) ? full / "bench.json" : full, folder = file.parent_path();
  scene.name = file.filename() == "bench.json" ? folder.filename().string() : file.stem().string();
  const std::string where = file.string();
  json description;
  try {
    description = json::parse(readFile(file));
  } catch (const json::exception& problem) {
    throw std::runtime_error(where + ": " + problem.what());
  }
  if (!description.is_object()) throw std::runtime_error(where + ": expected an object");
  for (const auto& [key, value] : description.items()) {
    if (key == "rib" || key == "make" || key == "why") {
      if (!value.is_string()) throw std::runtime_error(where + ": " + key + ": expected a text");
    } else if (key == "args") {
      scene.args = words(value, where + ": args");
    } else if (key == "settings") {
      scene.settings = parseSettings(value, where + ": settings");
    } else if (key == "reference") {
      const bool known = value.is_object() && value.contains("file") && value["file"].is_string() &&
                         (!value.contains("relmse") || value["relmse"].is_number()) &&
                         value.size() == 1 + value.count("relmse");
      if (!known)
        throw std::runtime_error(where + ": reference: expected {\"file\": text, \"relmse\": number}");
      scene.reference = fs::weakly_canonical(folder / value["file"].get<std::string>());
      scene.referenceRelMse = value.value("relmse", 0.0);
    } else {
      throw std::runtime_error(fmt::format(
          "{}: unknown key {}: expected rib, make, args, settings, reference or why", where, key));
    }
  }
  if (description.contains("rib") == description.contains("make"))
    throw std::runtime_error(where + ": expected either rib or make");
  if (description.contains("rib")) {
    scene.rib = fs::weakly_canonical(folder / description["rib"].get<std::string>());
  } else {
    scene.rib = make(folder / description["make"].get<std::string>(), fs::absolute(work) / scene.name);
  }
  scene.hash = hashOfScene(scene, true);
  return scene;
}

std::vector<fs::path> findScenes(const fs::path& path) {
  if (!fs::is_directory(path) || fs::exists(path / "bench.json")) return {path};
  std::vector<fs::path> found;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(path))
    if (entry.is_regular_file() && entry.path().filename() == "bench.json")
      found.push_back(entry.path().parent_path());
  if (found.empty()) throw std::runtime_error(path.string() + " has no bench.json in it or below it");
  std::ranges::sort(found);
  return found;
}

bool isWanted(const std::vector<std::string>& patterns, const std::string& scene, const Setting& setting) {
  const std::string whole = scene + "/" + setting.mode + "/" + setting.name;
  return patterns.empty() || std::ranges::any_of(patterns, [&](std::string pattern) {
           for (auto slashes = std::ranges::count(pattern, '/'); slashes < 2; ++slashes) pattern += "/*";
           return fnmatch(pattern.c_str(), whole.c_str(), FNM_PATHNAME) == 0;
         });
}

bool isWanted(const std::vector<std::string>& patterns, const std::string& scene,
              const std::vector<Setting>& settings) {
  return std::ranges::any_of(settings, [&](const Setting& s) { return isWanted(patterns, scene, s); });
}

}  // namespace patina::bench
