// SPDX-License-Identifier: Apache-2.0
// patina-shader: lists what plugins say of their shaders and parameters.
#include <CLI/CLI.hpp>

#include <cstdio>

#include "renderer/shading/plugin_loader.h"
#include "tools/patina-shader/listing.h"

int main(int argc, char** argv) {
  CLI::App app("Lists the shaders of a plugin and their parameters, as RIB and as Markdown.");
  std::vector<std::string> names, paths;
  bool rib = false, markdown = false;
  app.add_option("plugin", names, "plugin files (name.so), or shaders by name")->required();
  app.add_flag("--rib", rib, "only Declare lines");
  app.add_flag("--markdown", markdown, "only Markdown");
  app.add_option("--shader-path", paths, "folders in which shaders are looked for by name");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }

  patina::PluginLoader loader({paths, "", true});
  const auto print = [&](const PatinaShader& shader) {
    if (!markdown) std::fputs(patina::ribListing(shader).c_str(), stdout);
    if (rib == markdown) std::fputs("\n", stdout);
    if (!rib || markdown) std::fputs((patina::markdownListing(shader) + "\n").c_str(), stdout);
  };
  int status = 0;
  for (const std::string& name : names) {
    std::string reason;
    if (name.ends_with(".so")) {
      const auto file = patina::PluginFile::open(name, reason);
      if (file)
        for (const PatinaShader* shader : file->shaders()) print(*shader);
      else
        reason = name + ": " + reason;
    } else if (const auto& found = loader.find(name); found.shader) {
      print(*found.shader);
    } else {
      reason = found.error;
    }
    if (reason.empty()) continue;
    std::fprintf(stderr, "patina-shader: %s\n", reason.c_str());
    status = 1;
  }
  return status;
}
