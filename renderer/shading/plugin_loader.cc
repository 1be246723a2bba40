// SPDX-License-Identifier: Apache-2.0
// Finds shaders: bends names of other renderers into file names, walks the search path, says what was tried.
#include "renderer/shading/plugin_loader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <utility>

#include "rib/input_files.h"
#include "rib/params.h"

namespace patina {
namespace {

// Of shaders compiled or written for other renderers, and of plugins themselves.
constexpr std::string_view kSuffixes[] = {".so",  ".sl",  ".slo", ".slx", ".sdl",
                                          ".sdr", ".oso", ".osl", ".slc"};
constexpr size_t kMaxName = 512;

// Shaders that exporters bring along compiled for other renderers, and the standard ones that they vary.
constexpr std::pair<std::string_view, std::string_view> kStandIns[] = {
    {"hplastic", "plastic"},
    {"GVmodulateplastic", "paintedplastic"},
    {"GVdecalplastic", "paintedplastic"},
    {"GVblendplastic", "paintedplastic"},
    {"GVreplaceplastic", "paintedplastic"},
    {"GVmodulateconstant", "constant"},
    {"GVdecalconstant", "constant"},
    {"GVblendconstant", "constant"},
    {"GVreplaceconstant", "constant"}};

std::string_view withoutSuffix(std::string_view name) {
  for (const std::string_view suffix : kSuffixes)
    if (name.size() > suffix.size() && name.ends_with(suffix))
      return name.substr(0, name.size() - suffix.size());
  return name;
}

std::string_view lastPart(std::string_view name) {
  const size_t slash = name.find_last_of("/\\");
  return slash == std::string_view::npos ? name : name.substr(slash + 1);
}

// Absolute (also as Windows has it), or leading out of its folder.
bool leavesSearchPath(std::string_view name) {
  if (name.starts_with('/') || name.starts_with('\\') || name.starts_with('~')) return true;
  if (name.size() > 1 && name[1] == ':') return true;
  for (std::string_view rest = name; !rest.empty();) {
    const size_t end = std::min(rest.find_first_of("/\\"), rest.size());
    if (rest.substr(0, end) == "..") return true;
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return false;
}

bool exists(const std::string& path) {
  std::error_code failed;
  return std::filesystem::exists(path, failed) && !std::filesystem::is_directory(path, failed);
}

}  // namespace

PluginLoader::PluginLoader(const ShaderPaths& paths) : allowPaths_(paths.allowPaths) {
  std::vector<std::string> defaults;
  if (const char* variable = std::getenv("PATINA_SHADER_PATH")) defaults = splitSearchPath(variable, {});
  for (std::string& folder : installFolders("shaders")) defaults.push_back(std::move(folder));

  std::string whole;
  for (const std::string& path : paths.commandLine) whole += path + ':';
  folders_ = splitSearchPath(whole + paths.option + ":@", defaults);
}

const PluginLoader::Result& PluginLoader::find(std::string_view name) {
  const std::lock_guard lock(mutex_);
  auto found = results_.find(name);
  if (found == results_.end()) found = results_.emplace(std::string(name), search(name)).first;
  return found->second;
}

const PatinaShader* PluginLoader::tryFile(const std::string& path, std::string_view shader,
                                          std::vector<Attempt>& attempts, bool& refused) {
  if (std::any_of(attempts.begin(), attempts.end(), [&](const Attempt& a) { return a.path == path; }))
    return nullptr;
  if (!exists(path)) {
    attempts.push_back({path, "no such file"});
    return nullptr;
  }
  std::string reason;
  auto file = files_.find(path);
  if (file == files_.end()) {
    std::unique_ptr<PluginFile> plugin = PluginFile::open(path, reason);
    if (plugin) file = files_.emplace(path, std::move(plugin)).first;
  }
  if (file != files_.end()) {
    if (const PatinaShader* found = file->second->find(shader)) {
      noteInputFile(path);
      return found;
    }
    reason = "it holds no shader of that name, but";
    for (const PatinaShader* other : file->second->shaders()) reason += fmt::format(" \"{}\"", other->name);
  }
  attempts.push_back({path, std::move(reason)});
  refused = true;
  return nullptr;
}

PluginLoader::Result PluginLoader::search(std::string_view name) {
  Result result;
  if (name.empty() || name.size() > kMaxName || name.find('\0') != std::string_view::npos) {
    result.error =
        name.empty() ? "a shader's name is empty" : "a shader's name is too long or holds a zero byte";
    return result;
  }

  const std::string_view stem = lastPart(withoutSuffix(name));
  const bool outside = leavesSearchPath(name);
  std::vector<Attempt> attempts;
  bool refused = false;

  // The file that the name means, where it is allowed to mean one, then its last part in every folder.
  if (outside && allowPaths_)
    result.shader = tryFile(std::string(withoutSuffix(name)) + ".so", stem, attempts, refused);
  if (!outside)
    for (size_t i = 0; i < folders_.size() && !result.shader; ++i)
      result.shader =
          tryFile(fmt::format("{}/{}.so", folders_[i], withoutSuffix(name)), stem, attempts, refused);
  const bool direct = result.shader != nullptr;
  if (stem != name && !stem.empty() && stem != ".." && stem != ".")
    for (size_t i = 0; i < folders_.size() && !result.shader; ++i)
      result.shader = tryFile(fmt::format("{}/{}.so", folders_[i], stem), stem, attempts, refused);

  std::string_view standIn;
  for (const auto& [foreign, standard] : kStandIns)
    if (foreign == stem) standIn = standard;
  for (size_t i = 0; i < folders_.size() && !result.shader && !standIn.empty(); ++i)
    result.shader = tryFile(fmt::format("{}/{}.so", folders_[i], standIn), standIn, attempts, refused);

  const bool forbidden = outside && !allowPaths_;
  constexpr std::string_view kForbidden =
      "a RIB may not name a plugin by absolute path or with \"..\" unless --allow-shader-paths is given";
  std::string tried;
  for (const Attempt& a : attempts) tried += fmt::format("\n  {}: {}", a.path, a.reason);

  if (result.shader) {
    const bool stoodIn = result.shader->name == standIn;
    if (stoodIn)
      result.note = fmt::format("shader \"{}\" is not found; \"{}\" stands in for it", name, standIn);
    else if (forbidden)
      result.note =
          fmt::format("shader \"{}\": {}; \"{}\" of the search path is taken", name, kForbidden, stem);
    else if (stem != name && !(direct && withoutSuffix(name) == name))
      result.note = fmt::format("shader \"{}\": \"{}\" is taken", name, stem);
    if (refused)
      result.note += fmt::format("{}passed over on the way to it:{}", result.note.empty() ? "" : "; ", tried);
    result.strange = forbidden || refused || stoodIn;
    return result;
  }
  result.refused = refused || forbidden;
  if (forbidden)
    result.error = fmt::format("shader \"{}\" is refused: {}", name, kForbidden);
  else
    result.error = fmt::format("shader \"{}\" {}", name, refused ? "cannot be used" : "is not found");
  if (const std::string near = nearestShader(stem); !near.empty())
    result.error += fmt::format(" (did you mean \"{}\"?)", near);
  result.error += tried.empty() ? "; no folder was searched" : "; tried:" + tried;
  return result;
}

std::string PluginLoader::nearestShader(std::string_view name) const {
  std::vector<std::string> stems;
  for (const std::string& folder : folders_) {
    std::error_code failed;
    for (std::filesystem::directory_iterator entry(folder, failed), end; !failed && entry != end;
         entry.increment(failed))
      if (entry->path().extension() == ".so" && entry->path().stem() != name)
        stems.push_back(entry->path().stem());
  }
  const std::vector<std::string_view> views(stems.begin(), stems.end());
  return std::string(nearestName(name, views));
}

const PatinaShader* PluginLoader::load(std::string_view name, std::string_view what, ErrorHandler& errors,
                                       const Location& where) {
  const Result& result = find(name);
  if (!result.shader)
    errors.reportOnce(result.refused ? Severity::Error : Severity::Warning, RiError::NoShader, where,
                      result.error, fmt::format("{}: {}", what, result.error));
  else if (!result.note.empty())
    errors.reportOnce(result.strange ? Severity::Warning : Severity::Info, RiError::NoShader, where,
                      result.note, fmt::format("{}: {}", what, result.note));
  return result.shader;
}

}  // namespace patina
