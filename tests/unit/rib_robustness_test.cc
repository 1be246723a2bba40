// SPDX-License-Identifier: Apache-2.0
// Hostile and damaged text: cut at every byte, changed at random, nested deep; and the files of the shared
// corpus.
#include <gtest/gtest.h>

#include <sys/resource.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

#include "rib_recorder.h"

namespace patina::test {
namespace {

// A handler that reads all it is given, so that a sanitizer sees views that lead nowhere.
struct Reader : Recorder {
  RibParser* parser = nullptr;
  void readArchive(std::string_view name, const ParamList& params, const Location& at) override {
    Recorder::readArchive(name, params, at);
    parser->parseMemory("ReadArchive \"again\" Sides 2", "again.rib");
  }
};

struct Outcome {
  size_t requests = 0, messages = 0;
};

Outcome parse(std::string_view rib) {
  // A copy of exactly this size: reading behind its end is seen.
  const std::vector<char> exact(rib.begin(), rib.end());
  Reader reader;
  Outcome outcome;
  ErrorHandler errors([&](Severity, std::string_view) { ++outcome.messages; });
  RibParser parser(reader, errors, {.depth = 4});
  reader.parser = &parser;
  parser.parseMemory({exact.data(), exact.size()}, "t.rib");
  errors.summarize();
  outcome.requests = reader.lines.size();
  return outcome;
}

constexpr char kSampleText[] =
    "##RenderMan RIB\nversion 3.03\nDeclare \"k\" \"varying float[2]\" # note\n"
    "Format 64 64 -1 Projection \"perspective\" \"fov\" 40\nIfBegin \"a\" Sides 1 Else Sides 2 IfEnd\n"
    "LightSource \"spot\\\"light\" 1 \"from\" [0 0 0]\"to\"[0 .5 1e2]\nSurface \"a\" \"reference color c\" "
    "[\"t:r\"]\n"
    "SubdivisionMesh \"catmull-clark\" [4] [0 1 2 3] [\"crease\"] [2 1] [0 1] [3] \"P\" [1 2 3] \"k\" [1 2]\n"
    "ArchiveBegin \"x\" Sphere 1 -1 1 360 ArchiveEnd ReadArchive \"x\"\n"
    "\xa4\x3f\x80\0\0 \xcc\x07\x96Sphere\xa6\x07\x80\x01\x80\xff\x80\x01\x81\x01\x68\xcd\x02\x92Kd"
    "Surface\x91m\xcf\x02\xc8\x01\x3f\x80\0\0WorldEnd";
const std::string kSample(kSampleText, sizeof kSampleText - 1);  // there are NULs in it

TEST(RibRobustness, CutAtEveryByte) {
  const Outcome whole = parse(kSample);
  EXPECT_GE(whole.requests, 20u);
  for (size_t n = 0; n < kSample.size(); ++n) {
    const Outcome cut = parse(kSample.substr(0, n));
    EXPECT_LE(cut.requests, whole.requests + 1) << n;
    EXPECT_LE(cut.messages, whole.messages + 3) << n;  // the cut token, and a block left open
  }
  for (size_t n = 0; n < kSample.size(); ++n) parse(kSample.substr(n));
}

TEST(RibRobustness, ChangedAtRandom) {
  std::mt19937 random(2012);
  for (int round = 0; round < 5000; ++round) {
    std::string rib = kSample;
    for (auto changes = 1 + random() % 6; changes > 0; --changes) {
      const size_t at = random() % rib.size();
      switch (random() % 4) {
        case 0:
          rib[at] = static_cast<char>(random());
          break;
        case 1:
          rib.erase(at, random() % 9);
          break;
        case 2:
          rib.insert(at, 1, "[]\"#\\\xa6\xcf\xcd\xc8\xff 0"[random() % 12]);
          break;
        case 3:
          rib.insert(at, rib.substr(random() % rib.size(), random() % 40));
          break;
      }
      if (rib.empty()) rib = "x";
    }
    parse(rib);
  }
}

TEST(RibRobustness, RandomBytes) {
  std::mt19937 random(7);
  for (int round = 0; round < 3000; ++round) {
    std::string rib(random() % 200, '\0');
    for (char& c : rib) c = static_cast<char>(random());
    EXPECT_LE(parse(rib).messages, 2 * rib.size() + 2);
  }
}

std::string repeated(std::string_view what, size_t n) {
  std::string result;
  result.reserve(what.size() * n);
  while (n-- > 0) result += what;
  return result;
}

TEST(RibRobustness, DeepNestingNeedsNoStack) {
  constexpr size_t kDeep = 100000;
  // A stack of 512 kB would not hold one frame of recursion per level.
  EXPECT_EQ(parse(repeated("AttributeBegin ", kDeep)).requests, kDeep);
  EXPECT_EQ(parse(repeated("IfBegin \"x\" ", kDeep)).requests, kDeep);
  EXPECT_EQ(parse("Color " + repeated("[", kDeep)).messages, 1u);
  EXPECT_EQ(parse(repeated("[", kDeep)).messages, 1u);
  EXPECT_EQ(parse(repeated("]", kDeep)).messages, 1u);
  EXPECT_EQ(parse(repeated("ArchiveBegin \"x\" ", kDeep)).requests, kDeep);
}

TEST(RibRobustness, GarbageIsFolded) {
  EXPECT_EQ(parse(repeated("garbage ", 100000)).messages, 1u);
  EXPECT_LE(parse(repeated("garbage 1 ", 100000)).messages, 5u);
  EXPECT_LE(parse(repeated("Sphere ", 100000)).messages, 5u);
  EXPECT_LE(parse(repeated("\xfe", 100000)).messages, 1u);
  EXPECT_LE(parse(repeated("Sides 1 \xfe ", 100000)).messages, 5u);
}

TEST(RibRobustness, MemoryIsBoundedByTheLargestRequest) {
  struct Quiet : RibHandler {
    size_t requests = 0;
    void unhandled(std::string_view, const Location&) override { ++requests; }
  } handler;
  ErrorHandler errors;
  RibParser parser(handler, errors);
  const std::string rib = repeated("Polygon \"P\" [0 0 0 1 0 0 0 1 0] \"string s\" [\"a\\\\b\"]\n", 200000);
  const auto peak = [] {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss;  // kB
  };
  parser.parseMemory(rib.substr(0, rib.size() / 100), "t.rib");
  const long before = peak();
  parser.parseMemory(rib, "t.rib");
  EXPECT_EQ(handler.requests, 202000u);
  EXPECT_LT(peak() - before, 2000);
}

TEST(RibRobustness, TenMillionRequestsNeedNoMemory) {
  struct Counter : RibHandler {
    size_t requests = 0;
    void sides(int, const Location&) override { ++requests; }
    void identity(const Location&) override { ++requests; }
  } handler;
  ErrorHandler errors;
  RibParser parser(handler, errors);
  const std::string rib = repeated("Sides 1\nIdentity\n", 5'000'000);
  const auto peak = [] {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss;  // kB
  };
  const long before = peak();
  EXPECT_TRUE(parser.parseMemory(rib, "t.rib"));
  EXPECT_EQ(handler.requests, 10'000'000u);
  EXPECT_LT(peak() - before, 2000);
}

TEST(RibRobustness, TheSharedCorpus) {
  namespace fs = std::filesystem;
  const char* named = std::getenv("PATINA_SHARED_DIR");
  const fs::path shared = named ? fs::path(named) : fs::path(PATINA_SOURCE_DIR) / "../shared";
  if (!fs::exists(shared / "rib")) {
    std::cout << "no corpus at " << shared << ": nothing to read\n";
    return;
  }
  size_t files = 0, requests = 0;
  for (const char* folder : {"rib", "reference"}) {
    for (const auto& entry : fs::recursive_directory_iterator(shared / folder)) {
      const std::string name = entry.path().filename();
      if (name.find(".rib") == std::string::npos || !entry.is_regular_file()) continue;
      Recorder recorder;
      ErrorHandler errors([](Severity, std::string_view) {});
      EXPECT_TRUE(RibParser(recorder, errors).parseFile(entry.path())) << entry.path();
      EXPECT_FALSE(recorder.lines.empty()) << entry.path();
      ++files;
      requests += recorder.lines.size();
    }
  }
  std::cout << files << " files, " << requests << " requests\n";
  EXPECT_GT(files, 100u);
}

}  // namespace
}  // namespace patina::test
