// SPDX-License-Identifier: Apache-2.0
// Traditional spellings of the command line, as exporters and modellers use them.
#include <algorithm>
#include <array>
#include <filesystem>

#include "tools/patina/command_line.h"

namespace patina {
namespace {

bool isNumber(const std::string& text) {
  return !text.empty() && std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; });
}

/// Options of several letters that may also be written with one dash.
constexpr std::array<std::string_view, 24> kLongNames = {
    "mode",        "crop",         "samples",      "rays",         "variance",     "stats",
    "strict",      "check",        "classic",      "shading",      "quiet",        "version",
    "help",        "threads",      "output",       "display-view", "cache-memory", "light-samples",
    "shader-path", "texture-path", "archive-path", "seed",         "progressive",  "no-progressive"};

}  // namespace

std::vector<std::string> normalizedArguments(std::span<const std::string> arguments) {
  std::vector<std::string> result;
  for (size_t i = 0; i < arguments.size(); ++i) {
    const std::string& argument = arguments[i];
    const auto has = [&](size_t count) { return i + count < arguments.size(); };
    if (argument == "--") {
      result.insert(result.end(), arguments.begin() + static_cast<std::ptrdiff_t>(i), arguments.end());
      break;
    }
    if (argument == "-Progress" || argument == "-progress" || argument == "-p") {
      result.emplace_back("--progress");
    } else if (argument.starts_with("-t:") || argument.starts_with("-p:")) {
      result.insert(result.end(), {"--threads", argument.substr(3)});
    } else if (argument == "-d") {
      // A window, with its number: there is none. The number is no file's name.
      if (has(1) && isNumber(arguments[i + 1]) && !std::filesystem::exists(arguments[i + 1])) ++i;
    } else if (argument == "-fb") {
      continue;  // a window again
    } else if (argument == "-silent") {
      result.emplace_back("--quiet");
    } else if (argument == "-res" && has(2)) {
      result.insert(result.end(), {"--res", arguments[i + 1] + "x" + arguments[i + 2]});
      i += 2;
    } else if (argument == "-frames" && has(2)) {
      result.insert(result.end(), {"--frames", arguments[i + 1] + "-" + arguments[i + 2]});
      i += 2;
    } else if (argument.size() > 2 && argument[0] == '-' &&
               std::ranges::find(kLongNames, std::string_view(argument).substr(1)) != kLongNames.end()) {
      result.push_back("-" + argument);
    } else {
      result.push_back(argument);
    }
  }
  return result;
}

std::string replayArguments(std::span<const std::string> arguments) {
  const std::vector<std::string> all = normalizedArguments(arguments);
  std::string text;
  for (size_t i = 0; i < all.size(); ++i) {
    const std::string& argument = all[i];
    if (argument == "--crop") {
      i += 4;
    } else if (argument == "-o" || argument == "--output") {
      ++i;
    } else if (!argument.starts_with("--output=")) {
      if (!text.empty()) text += ' ';
      const bool plain = !argument.empty() && std::ranges::all_of(argument, [](char c) {
        return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
               std::string_view("-_./:,=+%@").find(c) != std::string_view::npos;
      });
      if (plain) {
        text += argument;
        continue;
      }
      text += '\'';
      for (const char c : argument) text += c == '\'' ? "'\\''" : std::string(1, c);
      text += '\'';
    }
  }
  return text;
}

}  // namespace patina
