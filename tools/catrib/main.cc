// SPDX-License-Identifier: Apache-2.0
// catrib: reads RIB of any encoding and writes it as ASCII, binary or gzip; expands archives; checks syntax.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <CLI/CLI.hpp>
#include <boost/iostreams/device/file_descriptor.hpp>
#include <boost/iostreams/filter/gzip.hpp>
#include <boost/iostreams/filtering_stream.hpp>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <map>

#include "rib/archives.h"
#include "rib/search_path.h"
#include "rib/writer.h"

namespace patina {
namespace {

namespace io = boost::iostreams;

struct Settings {
  std::vector<std::string> files;
  std::string output;
  std::string archivePath;
  RibWriterSettings writer;
  bool gzip = false, expand = false;
};

/// Writes the requests of archives in place of ReadArchive.
class ExpandingWriter final : public RibWriter {
 public:
  ExpandingWriter(Sink sink, const Settings& settings, ErrorHandler& errors)
      : RibWriter(std::move(sink), settings.writer),
        settings_(settings),
        parser_(*this, errors),
        archives_(parser_, errors) {}

  bool read(const std::string& file) { return archives_.readMain(file); }

  void option(std::string_view name, const ParamList& params, const Location& at) override {
    if (name == "searchpath")
      for (const Param& param : params)
        if (!param.strings.empty() && (param.name() == "archive" || param.name() == "resource")) {
          std::string& path = paths_[std::string(param.name())];
          path = expandSearchPath(fmt::format("{}", fmt::join(param.strings, ":")), path);
        }
    RibWriter::option(name, params, at);
  }
  bool archiveBegin(std::string_view name, const ParamList& params, const Location& at) override {
    return settings_.expand || RibWriter::archiveBegin(name, params, at);
  }
  void archive(std::string_view name, InlineArchive archive, const Location&) override {
    archives_.define(name, std::move(archive));
  }
  void readArchive(std::string_view name, const ParamList& params, const Location& at) override {
    if (!settings_.expand) return RibWriter::readArchive(name, params, at);
    const std::string path = settings_.archivePath + ":" + paths_["archive"] + ":" + paths_["resource"];
    // What cannot be read stays as it is.
    if (!archives_.read(name, path, at)) RibWriter::readArchive(name, params, at);
  }

 private:
  const Settings& settings_;
  RibParser parser_;
  Archives archives_;
  std::map<std::string, std::string> paths_;
};

int cat(const Settings& settings) {
  const bool toFile = !settings.output.empty() && settings.output != "-";
  // A file takes its name when it is whole: it may be one of those that are read.
  struct stat status;
  const bool replace = toFile && (stat(settings.output.c_str(), &status) != 0 || S_ISREG(status.st_mode));
  const std::string path = replace ? fmt::format("{}.{}", settings.output, getpid()) : settings.output;
  const int descriptor =
      toFile ? open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666) : STDOUT_FILENO;
  if (descriptor < 0) {
    fmt::print(stderr, "catrib: {}: {}\n", settings.output, std::strerror(errno));
    return 1;
  }
  ErrorHandler errors;
  errors.setShowLines(true);
  std::string problem;
  bool whole = true;
  {
    io::filtering_ostream out;
    if (settings.gzip) out.push(io::gzip_compressor());
    out.push(io::file_descriptor_sink(descriptor, toFile ? io::close_handle : io::never_close_handle));
    out.exceptions(std::ios::badbit | std::ios::failbit);
    const auto attempt = [&](auto action) {
      try {
        action();
        return true;
      } catch (const std::exception& failure) {
        if (problem.empty()) problem = failure.what();
        return false;
      }
    };
    const auto sink = [&](std::string_view text) {
      return attempt([&] { out.write(text.data(), static_cast<std::streamsize>(text.size())); });
    };
    {
      ExpandingWriter writer(sink, settings, errors);
      for (const std::string& file : settings.files) whole = writer.read(file) && whole;
      writer.flush();
    }
    out.exceptions(std::ios::goodbit);
    if (problem.empty()) attempt([&] { out.reset(); });
  }
  errors.summarize();
  if (replace && problem.empty() && rename(path.c_str(), settings.output.c_str()) != 0)
    problem = std::strerror(errno);
  if (!problem.empty()) {
    if (replace) unlink(path.c_str());
    fmt::print(stderr, "catrib: {}: {}\n", toFile ? settings.output : "standard output", problem);
    return 1;
  }
  return whole ? errors.exitStatus() : 1;
}

int run(int argc, char** argv) {
  CLI::App app(
      "Reads RIB of any encoding (ASCII, binary, gzip, or all of them in one file) and writes it anew.");
  app.footer(
      "Exit status: 0 all is well, 1 a request was wrong and left out or a file could not be read, 2 wrong "
      "usage.");
  Settings settings;
  bool ascii = false, binary = false, noComments = false, noStructure = false;
  app.add_option("files", settings.files, "RIB files; none or - is standard input");
  app.add_option("-o,--output", settings.output, "File to write; - is standard output");
  auto* const asciiFlag =
      app.add_flag("--ascii", ascii, "Write ASCII: one request a line, indented (default)");
  app.add_flag("--binary", binary, "Write binary RIB")->excludes(asciiFlag);
  app.add_flag("--gzip", settings.gzip, "Compress what is written");
  app.add_flag("--expand", settings.expand, "Write the requests of archives in place of ReadArchive");
  app.add_option("--archive-path", settings.archivePath, "Folders of archives, before the RIB's");
  app.add_option("--indent", settings.writer.indent, "Blanks per block")
      ->check(CLI::Range(0, 16))
      ->capture_default_str();
  app.add_option("--width", settings.writer.lineWidth, "Longest line of ASCII, where arrays can be broken")
      ->check(CLI::Range(20, 1'000'000))
      ->capture_default_str();
  app.add_flag("--no-comments", noComments, "Leave out comments (#)");
  app.add_flag("--no-structure", noStructure, "Leave out structure comments (##)");
  // The options of older programs of this name have one dash.
  std::vector<std::string> arguments;
  for (int k = argc; k-- > 1;) {
    std::string argument(argv[k]);
    if (argument == "-binary" || argument == "-ascii" || argument == "-gzip") argument.insert(0, "-");
    arguments.push_back(std::move(argument));
  }
  try {
    app.parse(std::move(arguments));
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  settings.writer.encoding = binary ? RibEncoding::Binary : RibEncoding::Ascii;
  settings.writer.comments = !noComments;
  settings.writer.structure = !noStructure;
  if (settings.files.empty()) settings.files.emplace_back("-");
  return cat(settings);
}

}  // namespace
}  // namespace patina

int main(int argc, char** argv) {
  std::signal(SIGPIPE, SIG_IGN);  // a reader that has seen enough is an error of writing
  try {
    return patina::run(argc, argv);
  } catch (const std::exception& problem) {
    fmt::print(stderr, "catrib: {}\n", problem.what());
    return 1;
  }
}
