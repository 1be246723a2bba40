// SPDX-License-Identifier: Apache-2.0
// Finds shaders by the names that RIB files give, on the search path, and loads the plugins that hold them.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "patina/shader.h"
#include "renderer/shading/plugin_file.h"
#include "rib/error.h"

namespace patina {

/// Splits a path in RI syntax: folders separated by ':', where an item '&' or '@' stands for `defaults`.
/// Empty items are left out, and so are repetitions.
std::vector<std::string> splitSearchPath(std::string_view path, std::span<const std::string> defaults);

/// Folders that belong to this build or installation, found from where the running program is:
/// `<bin>/../lib/patina/ <kind>`, and the place of `cmake --install`. `kind` is "shaders" or "modules". Those
/// that exist, best first.
std::vector<std::string> installFolders(std::string_view kind);

/// Where plugins may come from.
struct ShaderPaths {
  std::vector<std::string> commandLine;  ///< --shader-path, each in RI syntax; searched first
  std::string option;                    ///< Option "searchpath" "shader", in RI syntax
  bool allowPaths = false;               ///< --allow-shader-paths: names may be absolute or contain ".."
};

/// Loads each plugin once and keeps it open as long as it lives. [any thread]
class PluginLoader {
 public:
  /// What came of a name. Exactly one of `shader` and `error` is set.
  struct Result {
    const PatinaShader* shader = nullptr;
    std::string error;     ///< names every path that was tried, and the reason for each
    bool refused = false;  ///< a file of that name is there, but is no plugin that may be used
    std::string note;      ///< how the name had to be bent to be found; "" = not at all
    bool strange = false;  ///< the note deserves a warning
  };

  /// $PATINA_SHADER_PATH and the install's folders are searched after the given ones.
  explicit PluginLoader(const ShaderPaths& paths);

  const Result& find(std::string_view name);

  /// find(), reported: an unknown name is a warning, a refused plugin an error, both with code NoShader and
  /// `what`
  /// ("Surface", "LightSource" ...) in front. nullptr = no such shader: take another in its place.
  const PatinaShader* load(std::string_view name, std::string_view what, ErrorHandler& errors,
                           const Location& where);

  const std::vector<std::string>& folders() const { return folders_; }

 private:
  struct Attempt {
    std::string path, reason;
  };

  Result search(std::string_view name);
  const PatinaShader* tryFile(const std::string& path, std::string_view shader,
                              std::vector<Attempt>& attempts, bool& refused);
  std::string nearestShader(std::string_view name) const;

  std::vector<std::string> folders_;
  bool allowPaths_;
  std::mutex mutex_;
  std::map<std::string, Result, std::less<>> results_;                     // by name as given
  std::map<std::string, std::unique_ptr<PluginFile>, std::less<>> files_;  // by path
};

}  // namespace patina
