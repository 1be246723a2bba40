// SPDX-License-Identifier: Apache-2.0
// Degenerate input, case by case: each RIB of a folder says in its first lines what it is, what Patina is to
// say of it and what becomes of the picture. Every case is rendered in every mode.
//
//   # Sphere of radius 0.
//   # says: error: badargument: Sphere: has no area       a part of what is printed; "nothing" = not a word
//   # picture: unaffected                                  the bits of nothing.rib | seen: others | any:
//   whatever is finite
//
//   stress_degenerate [--patina PROGRAM] [--only NAME] [--table] FOLDER      --table prints Markdown
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <map>
#include <sstream>

#include "tests/stress/judged_render.h"

namespace fs = std::filesystem;
using namespace patina::stress;

namespace {

struct Case {
  fs::path rib;
  std::string what, says, picture;
};

Case readCase(const fs::path& rib) {
  Case c{rib, "", "", ""};
  std::istringstream text(contentsOf(rib));
  const auto line = [&](const std::string& begin) {
    std::string all;
    std::getline(text, all);
    if (!all.starts_with(begin))
      throw std::runtime_error(rib.string() + ": a line must begin with \"" + begin + "\"");
    return all.substr(begin.size());
  };
  c.what = line("# "), c.says = line("# says: "), c.picture = line("# picture: ");
  if (c.what.ends_with('.')) c.what.pop_back();
  if (c.picture != "unaffected" && c.picture != "seen" && c.picture != "any")
    throw std::runtime_error(rib.string() + ": no such picture: " + c.picture);
  return c;
}

/// What is not as the case says; "" = all is.
std::string problem(const Case& c, const Judged& judged, const patina::ImageData& nothing) {
  if (!judged.wrong.empty()) return judged.wrong;
  const bool isSilent =
      judged.said.find("error: ") == std::string::npos && judged.said.find("warning: ") == std::string::npos;
  if (c.says == "nothing") {
    if (!isSilent) return "says something: " + judged.said.substr(0, 200);
  } else if (judged.said.find(c.says) == std::string::npos) {
    return "does not say \"" + c.says + "\" but: " + judged.said.substr(0, 200);
  }
  if (judged.picture.pixels.empty())
    return c.picture == "any" && judged.status == 1 ? "" : "there is no picture";
  const bool isSame = judged.picture.pixels == nothing.pixels;
  if (c.picture == "unaffected" && !isSame) return "the picture is another one";
  if (c.picture == "seen" && isSame) return "the picture does not show it";
  return "";
}

}  // namespace

int main(int argc, char** argv) {
  RenderSettings settings;
  settings.patina = fs::read_symlink("/proc/self/exe").parent_path() / "patina";
  CLI::App app("Degenerate input, case by case, in every mode.");
  std::string patina, only, folder;
  bool table = false;
  std::vector<std::string> modes = {"radiosity", "distribution", "path", "points", "direct"};
  app.add_option("--patina", patina, "The program");
  app.add_option("--only", only, "One case");
  app.add_option("--seconds", settings.seconds, "Limit of one render");
  app.add_option("--modes", modes, "Modes")->delimiter(',');
  app.add_flag("--table", table, "Print the cases as Markdown");
  app.add_option("folder", folder, "RIBs")->required();
  CLI11_PARSE(app, argc, argv);
  if (!patina.empty()) settings.patina = fs::absolute(patina);
  std::string pattern = (fs::temp_directory_path() / "patina-degenerate-XXXXXX").string();
  settings.work = mkdtemp(pattern.data());
  int bad = 0;
  try {
    std::vector<fs::path> ribs;
    for (const auto& entry : fs::directory_iterator(fs::absolute(folder)))
      if (entry.path().extension() == ".rib" && (only.empty() || entry.path().stem() == only))
        ribs.push_back(entry.path());
    std::ranges::sort(ribs);
    if (ribs.empty()) throw std::runtime_error("there are no cases in " + folder);
    const auto renderIn = [&](const std::string& mode, const fs::path& rib) {
      return judgedRender(settings, rib, mode,
                          {"--rays", "8", "--archive-path", rib.parent_path(), "--threads", "1"});
    };
    std::map<std::string, patina::ImageData> nothing;
    for (const std::string& mode : modes)
      nothing[mode] = renderIn(mode, fs::absolute(folder) / "nothing.rib").picture;
    if (table) std::cout << "| case | what | what Patina says | picture |\n| --- | --- | --- | --- |\n";
    for (const fs::path& rib : ribs) {
      const Case c = readCase(rib);
      std::string wrong;
      for (const std::string& mode : modes)
        if (const std::string p = problem(c, renderIn(mode, rib), nothing[mode]); !p.empty())
          wrong += fmt::format("{}{}: {}", wrong.empty() ? "" : "; ", mode, p);
      bad += !wrong.empty();
      const std::string name = rib.stem();
      if (table)
        std::cout << fmt::format("| {} | {} | {} | {}{} |\n", name, c.what, c.says, c.picture,
                                 wrong.empty() ? "" : " **fails**");
      if (!wrong.empty()) std::cerr << name << ": " << wrong << "\n";
    }
    std::cerr << ribs.size() << " cases, " << bad << " wrong\n";
  } catch (const std::exception& error) {
    std::cerr << error.what() << "\n";
    bad = 1;
  }
  fs::remove_all(settings.work);
  return bad > 0;
}
