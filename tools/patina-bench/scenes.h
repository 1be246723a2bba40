// SPDX-License-Identifier: Apache-2.0
// What is measured: scenes, and the settings of each mode.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace patina::bench {

/// One way to render a scene.
struct Setting {
  std::string mode, name;         ///< of patina, and of this quality
  std::vector<std::string> args;  ///< for patina, beside --mode
};

/// The built-in qualities of each mode, from quick to best; path at 4^k samples.
std::vector<Setting> defaultSettings();
/// From {"radiosity": [{"name": "default"}, {"name": "high", "args": ["--rays", "512"]}], ...}. Throws
/// std::runtime_error for anything else; `where` begins its text.
std::vector<Setting> parseSettings(const nlohmann::json& json, const std::string& where);

/// A scene that is ready to be rendered.
struct Scene {
  std::string name;
  std::filesystem::path rib;        ///< absolute
  std::vector<std::string> args;    ///< for patina in every mode, such as --res
  std::vector<Setting> settings;    ///< its own; empty = those of all scenes
  std::filesystem::path reference;  ///< EXR that is given, absolute; "" = rendered in path mode
  double referenceRelMse = 0;       ///< its share of noise, if one is given
  uint64_t hash = 0;                ///< of the RIB, of the files beside it and of args
};

/// Reads a scene's description: a folder with bench.json, such a file itself, or a RIB alone. In bench.json:
///   rib        RIB to render, from the folder of the description; or
///   make       Python script that is called with a folder and writes scene.rib and what belongs to it there
///   args       for patina, in every mode
///   settings   own settings, as of parseSettings()
///   reference  {"file": EXR, "relmse": its share of noise}
///   why        for people
/// What scripts write goes to `work`/<name>. Throws std::runtime_error with the reason.
Scene loadScene(const std::filesystem::path& path, const std::filesystem::path& work);

/// What loadScene() takes, of a folder without a description: those of its sub-folders, at any depth, that
/// have one, by name. Anything else stands for itself. Throws std::runtime_error if a folder has none.
std::vector<std::filesystem::path> findScenes(const std::filesystem::path& path);

/// Whether a run is among those asked for: a pattern is scene/mode/setting, with * and ? within each; what is
/// missing at the end stands for all. No patterns at all: every run is.
bool isWanted(const std::vector<std::string>& patterns, const std::string& scene, const Setting& setting);
/// Likewise for some setting of a scene.
bool isWanted(const std::vector<std::string>& patterns, const std::string& scene,
              const std::vector<Setting>& settings);

/// FNV-1a over bytes, going on from `state`.
uint64_t hashBytes(std::string_view bytes, uint64_t state = 0xcbf29ce484222325u);
/// All of a file, and a file whole or not at all. Both throw std::runtime_error with the reason.
std::string readFile(const std::filesystem::path& path);
void writeText(const std::filesystem::path& path, const std::string& bytes);

}  // namespace patina::bench
