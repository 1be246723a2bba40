// SPDX-License-Identifier: Apache-2.0
// Archives, procedurals that are archives, and conditional RIB.
#include <fmt/format.h>

#include <algorithm>

#include "renderer/scene/condition.h"
#include "renderer/scene/run_program.h"
#include "renderer/scene/scene_builder.h"
#include "rib/search_path.h"

namespace patina {

// ---- Archives ---------------------------------------------------------------------------------------------

bool SceneBuilder::readArchiveFile(std::string_view name, const Location& at) {
  std::string path = settings_.archivePath;
  for (const std::string_view kind : {"archive", "resource"}) {
    const auto option = options_.searchPaths.find(std::string(kind));
    if (option != options_.searchPaths.end()) path.append(":").append(option->second);
  }
  return archives_.read(name, path, at);
}

void SceneBuilder::readArchive(std::string_view name, const ParamList& params, const Location& at) {
  for (const Param& param : params) param.used = true;
  readArchiveFile(name, at);
}

bool SceneBuilder::archiveBegin(std::string_view, const ParamList& params, const Location&) {
  for (const Param& param : params) param.used = true;
  return true;
}

void SceneBuilder::archive(std::string_view name, InlineArchive archive, const Location&) {
  archives_.define(name, std::move(archive));
}

void SceneBuilder::procedural(std::string_view kind, Strings args, const Bounds6& bound, const Location& at) {
  const bool program = kind == "RunProgram";
  if ((kind != "DelayedReadArchive" && !program) || args.empty())
    return unhandled(fmt::format("Procedural \"{}\"", kind), at);
  if (program && !settings_.allowPrograms)
    return countNotice(
        "Procedural \"RunProgram\" is left out: programs are started with --allow-programs only", at);
  if (!program && delay(args.front(), bound, at)) return;
  inOwnScope(at, [&] {
    if (program)
      readProgram(args, at);
    else
      readArchiveFile(args.front(), at);
  });
}

void SceneBuilder::procedural2(std::string_view kind, std::string_view boundKind, const ParamList& params,
                               const Location& at) {
  for (const Param& param : params) param.used = true;
  const std::string_view file = params.stringValue("filename", "");
  if (kind != "DelayedReadArchive2" || file.empty())
    return unhandled(fmt::format("Procedural2 \"{}\"", kind), at);
  const Param* const given = boundKind == "SimpleBound" ? params.find("bound") : nullptr;
  if (given && given->floats.size() == 6) {
    Bounds6 bound;
    std::ranges::copy(given->floats, bound.begin());
    if (delay(file, bound, at)) return;
  }
  inOwnScope(at, [&] { readArchiveFile(file, at); });
}

void SceneBuilder::inOwnScope(const Location& at, const std::function<void()>& read) {
  if (!open(BlockKind::Attribute, at)) return;
  const size_t depth = blocks_.depth();
  read();
  // Blocks that the archive left open end with it; one that it closed too many is its own mistake.
  if (blocks_.depth() >= depth) {
    while (blocks_.depth() > depth) closeTop(at);
    close(BlockKind::Attribute, at);
  }
}

void SceneBuilder::readProgram(Strings args, const Location& at) {
  if (++*programsRun_ > settings_.programRuns)
    return error(RiError::LimitCheck, at, fmt::format("more than {} programs run", settings_.programRuns),
                 "programs");
  // Words of the command between blanks; no shell has a hand in it.
  std::vector<std::string> words;
  std::string_view rest = args.front();
  while (!rest.empty()) {
    const size_t end = std::min(rest.find_first_of(" \t\n"), rest.size());
    if (end > 0) words.emplace_back(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  if (words.empty()) return error(RiError::BadArgument, at, "Procedural \"RunProgram\" without a program");
  const auto option = options_.searchPaths.find("procedural");
  std::vector<std::string> tried;
  if (const auto found = findFile(
          words.front(),
          searchFolders((option == options_.searchPaths.end() ? std::string() : option->second) + ":@",
                        {archives_.mainFolder()}),
          tried))
    words.front() = found->find('/') == std::string::npos ? "./" + *found : *found;
  // The detail that RI passes is the size on the screen; nobody knows it before dicing.
  const std::string input = fmt::format("1e+08 {}\n", args.size() > 1 ? args[1] : std::string_view());
  const ProgramOutput output = runProgram(words, input, settings_.program);
  if (!output.problem.empty())
    error(RiError::System, at, fmt::format("program \"{}\": {}", args.front(), output.problem),
          fmt::format("program {}", args.front()));
  parser_.parseMemory(output.text, fmt::format("output of {}", args.front()));
}

// ---- Conditions -------------------------------------------------------------------------------------------

void SceneBuilder::setUserValues(std::string_view kind, std::string_view name, const ParamList& params) {
  if (name != "user") return;
  constexpr size_t kMostValues = 100000;
  for (const Param& param : params) {
    if (userValues_.size() >= kMostValues) return;
    std::string value;
    if (!param.strings.empty()) {
      value = param.strings.front();
    } else if (!param.ints.empty()) {
      value = std::to_string(param.ints.front());
    } else if (!param.floats.empty()) {
      value = fmt::format("{}", param.floats.front());
    }
    userValues_[fmt::format("user:{}", param.name())] = value;
    userValues_[fmt::format("{}:user:{}", kind, param.name())] = value;
  }
}

std::optional<bool> SceneBuilder::evaluate(std::string_view condition, const Location& at) {
  const auto value = evaluateCondition(condition, [&](std::string_view name) -> std::optional<std::string> {
    if (name == "Frame" || name == "frame") return std::to_string(scene_.frame);
    const std::string* const said = known(&SceneBuilder::userValues_, name);
    return said ? std::optional(*said) : std::nullopt;
  });
  if (!value) {
    error(RiError::SyntaxError, at,
          fmt::format("condition \"{}\" is not understood: its branch is skipped", condition));
  }
  return value;
}

Branch SceneBuilder::ifBegin(std::string_view condition, const ParamList& params, const Location& at) {
  for (const Param& param : params) param.used = true;
  return evaluate(condition, at).value_or(false) ? Branch::Take : Branch::Skip;
}

Branch SceneBuilder::elseIf(std::string_view condition, const ParamList& params, const Location& at) {
  return ifBegin(condition, params, at);
}

Branch SceneBuilder::else_(const Location&) { return Branch::Take; }

}  // namespace patina
