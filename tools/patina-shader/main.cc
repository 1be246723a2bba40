// SPDX-License-Identifier: Apache-2.0
// patina-shader: lists what plugins say of their shaders and parameters, and checks whether shaders keep it.
#include <CLI/CLI.hpp>

#include <cstdio>
#include <functional>
#include <nlohmann/json.hpp>

#include "renderer/shading/plugin_loader.h"
#include "tools/patina-shader/checking.h"
#include "tools/patina-shader/listing.h"

namespace {

// Calls `use` for each shader of each plugin file, and for each shader named. False: some cannot be had,
// which has been said.
bool forEachShader(patina::PluginLoader& loader, const std::vector<std::string>& names,
                   const std::function<void(const PatinaShader&)>& use) {
  bool all = true;
  for (const std::string& name : names) {
    std::string reason;
    if (name.ends_with(".so")) {
      const auto file = patina::PluginFile::open(name, reason);
      if (file)
        for (const PatinaShader* shader : file->shaders()) use(*shader);
      else
        reason = name + ": " + reason;
    } else if (const auto& found = loader.find(name); found.shader) {
      use(*found.shader);
    } else {
      reason = found.error;
    }
    if (reason.empty()) continue;
    std::fprintf(stderr, "patina-shader: %s\n", reason.c_str());
    all = false;
  }
  return all;
}

bool list(patina::PluginLoader& loader, const std::vector<std::string>& names, bool rib, bool markdown) {
  return forEachShader(loader, names, [&](const PatinaShader& shader) {
    if (!markdown) std::fputs(patina::ribListing(shader).c_str(), stdout);
    if (rib == markdown) std::fputs("\n", stdout);
    if (!rib || markdown) std::fputs((patina::markdownListing(shader) + "\n").c_str(), stdout);
  });
}

bool listAsJson(patina::PluginLoader& loader, const std::vector<std::string>& names, bool entries) {
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  const bool good = forEachShader(loader, names, [&](const PatinaShader& shader) {
    all.push_back(patina::jsonListing(shader));
    if (entries) patina::addUses(all.back(), patina::shadercheck::usesOf(shader));
  });
  std::puts(all.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace).c_str());
  return good;
}

bool check(patina::PluginLoader& loader, const std::vector<std::string>& names, bool json) {
  std::vector<patina::shadercheck::Verdict> verdicts;
  bool good = forEachShader(loader, names, [&](const PatinaShader& shader) {
    verdicts.push_back(patina::shadercheck::checkShader(shader));
    if (json) return;
    std::fputs(patina::textReport(verdicts.back()).c_str(), stdout);
    std::fflush(stdout);
  });
  if (json) std::fputs(patina::jsonReport(verdicts).c_str(), stdout);
  for (const auto& verdict : verdicts) good &= verdict.faults.empty();
  return good;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "Lists the shaders of a plugin and their parameters, as RIB and as Markdown; with --check, calls them "
      "in "
      "every way that the interface allows and says what they do wrong.");
  app.footer("Exit status: 0 = all is well, 1 = a plugin cannot be loaded or has a fault, 2 = wrong usage.");
  std::vector<std::string> names, paths;
  bool rib = false, markdown = false, checks = false, json = false, entries = false;
  app.add_option("plugin", names, "plugin files (name.so), or shaders by name")->required();
  CLI::Option* const ribOption = app.add_flag("--rib", rib, "only Declare lines");
  CLI::Option* const markdownOption = app.add_flag("--markdown", markdown, "only Markdown");
  app.add_flag(
         "--check", checks,
         "run each shader through the checks of the shader interface, in processes of their own: a line "
         "per fault, and a summary per shader")
      ->excludes(ribOption)
      ->excludes(markdownOption);
  CLI::Option* const jsonOption = app.add_flag("--json", json, "as JSON; with --check what that finds")
                                      ->excludes(ribOption)
                                      ->excludes(markdownOption);
  app.add_flag("--entries", entries,
               "with --json: also what a shader can be bound as, for which its `prepare` is run")
      ->needs(jsonOption)
      ->excludes("--check");
  app.add_option("--shader-path", paths, "folders in which shaders are looked for by name");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }

  patina::PluginLoader loader({paths, "", true});
  const bool good = checks ? check(loader, names, json)
                    : json ? listAsJson(loader, names, entries)
                           : list(loader, names, rib, markdown);
  return good ? 0 : 1;
}
