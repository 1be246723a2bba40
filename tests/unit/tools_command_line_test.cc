// SPDX-License-Identifier: Apache-2.0
// The command line: own and traditional spellings, and what is refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tools/patina/command_line.h"

namespace patina {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using Arguments = std::vector<std::string>;

CommandLine parse(const Arguments& arguments) {
  int status = -1;
  const auto line = parseCommandLine(arguments, status);
  EXPECT_TRUE(line.has_value()) << "status " << status;
  return line.value_or(CommandLine());
}

std::string refusal(const Arguments& arguments) {
  int status = -1;
  testing::internal::CaptureStderr();
  EXPECT_FALSE(parseCommandLine(arguments, status).has_value());
  EXPECT_EQ(status, 2);
  return testing::internal::GetCapturedStderr();
}

TEST(Arguments, TraditionalSpellings) {
  const auto normalized = [](const Arguments& arguments) { return normalizedArguments(arguments); };
  EXPECT_THAT(normalized({"-Progress", "a.rib"}), ElementsAre("--progress", "a.rib"));
  EXPECT_THAT(normalized({"-p", "-t:4", "a.rib"}), ElementsAre("--progress", "--threads", "4", "a.rib"));
  EXPECT_THAT(normalized({"-d", "16", "a.rib"}), ElementsAre("a.rib"));
  EXPECT_THAT(normalized({"-d", "a.rib", "-fb", "-silent"}), ElementsAre("a.rib", "--quiet"));
  EXPECT_THAT(normalized({"-res", "640", "480", "-frames", "2", "5"}),
              ElementsAre("--res", "640x480", "--frames", "2-5"));
  EXPECT_THAT(normalized({"-crop", "0", "1", "0", ".5", "-q"}),
              ElementsAre("--crop", "0", "1", "0", ".5", "-q"));
  EXPECT_THAT(normalized({"--", "-p"}), ElementsAre("--", "-p"));
}

TEST(CommandLineOptions, ReachTheirPlaces) {
  const CommandLine line = parse({"-t",
                                  "3",
                                  "--mode",
                                  "path",
                                  "--samples",
                                  "64",
                                  "--rays",
                                  "256",
                                  "--light-samples",
                                  "4",
                                  "--cache-memory",
                                  "1.5",
                                  "--shading",
                                  "hit",
                                  "--classic",
                                  "--res",
                                  "20x10",
                                  "--crop",
                                  "0",
                                  ".5",
                                  ".25",
                                  "1",
                                  "--frames",
                                  "3-7",
                                  "-o",
                                  "x.png",
                                  "--stats",
                                  "s.json",
                                  "--seed",
                                  "5",
                                  "--strict",
                                  "--check",
                                  "--archive-path",
                                  "a:b",
                                  "a.rib",
                                  "b.rib"});
  EXPECT_EQ(line.render.threads, 3);
  EXPECT_EQ(line.render.mode, "path");
  EXPECT_EQ(line.render.samples, 64);
  EXPECT_EQ(line.render.rays, 256);
  EXPECT_EQ(line.render.lightSamples, 4);
  EXPECT_EQ(line.render.cacheMemoryMb, 1.5);
  EXPECT_EQ(line.render.seed, 5);
  EXPECT_TRUE(line.render.shadeAtHits);
  EXPECT_TRUE(line.render.classic);
  EXPECT_THAT(*line.resolution, ElementsAre(20, 10));
  EXPECT_THAT(*line.crop, ElementsAre(0, .5f, .25f, 1));
  EXPECT_THAT(*line.frames, ElementsAre(3, 7));
  EXPECT_EQ(line.output, "x.png");
  EXPECT_EQ(line.statistics, "s.json");
  EXPECT_TRUE(line.strict && line.check);
  EXPECT_EQ(line.archivePath, "a:b");
  EXPECT_THAT(line.files, ElementsAre("a.rib", "b.rib"));
}

TEST(CommandLineOptions, SilentDefaultsAndTradition) {
  const CommandLine line = parse({"-Progress", "-t:2", "-crop", "0", "1", "0", "1", "-"});
  EXPECT_TRUE(line.progressLines);
  EXPECT_EQ(line.render.threads, 2);
  EXPECT_EQ(line.render.mode, "");
  EXPECT_FALSE(line.render.samples.has_value());
  EXPECT_FALSE(line.render.seed.has_value());
  EXPECT_THAT(line.files, ElementsAre("-"));
  EXPECT_THAT(*parse({"--frames", "4", "a"}).frames, ElementsAre(4, 4));
}

TEST(CommandLineOptions, ProgressiveIsSaidOrLeftToTheRib) {
  EXPECT_FALSE(parse({"a"}).render.progressive.has_value());
  EXPECT_EQ(parse({"--progressive", "a"}).render.progressive, true);
  EXPECT_EQ(parse({"-progressive", "a"}).render.progressive, true);
  EXPECT_EQ(parse({"--no-progressive", "a"}).render.progressive, false);
  EXPECT_FALSE(parse({"--progress", "a"}).render.progressive.has_value());
  EXPECT_FALSE(parse({"--progressive", "a"}).progressLines);
}

TEST(CommandLineOptions, CausticsAreSaidOrLeftToTheRib) {
  EXPECT_FALSE(parse({"a"}).render.caustics.has_value());
  EXPECT_EQ(parse({"--caustics", "a"}).render.caustics, true);
  EXPECT_EQ(parse({"--no-caustics", "a"}).render.caustics, false);
  EXPECT_TRUE(parse({"--full-hits", "a"}).render.fullHits);
}

TEST(CommandLineOptions, WrongUsageIsStatusTwo) {
  EXPECT_THAT(refusal({"--mode", "magic", "a.rib"}), HasSubstr("--mode"));
  EXPECT_THAT(refusal({"--res", "640", "a.rib"}), HasSubstr("expected WIDTHxHEIGHT"));
  EXPECT_THAT(refusal({"--res", "0x5", "a.rib"}), HasSubstr("expected WIDTHxHEIGHT"));
  EXPECT_THAT(refusal({"--crop", ".5", "0", "0", "1", "a.rib"}), HasSubstr("expected x0 <= x1"));
  EXPECT_THAT(refusal({"--frames", "5-2", "a.rib"}), HasSubstr("expected FIRST-LAST"));
  EXPECT_THAT(refusal({"--samples", "-1", "a.rib"}), HasSubstr("--samples"));
  EXPECT_THAT(refusal({"--seed", "-1", "a.rib"}), HasSubstr("--seed"));
  EXPECT_THAT(refusal({"--points-resolution", "15", "a.rib"}), HasSubstr("expected an even number"));
  EXPECT_THAT(refusal({"--points-bounces", "0", "a.rib"}), HasSubstr("--points-bounces"));
  EXPECT_THAT(refusal({"--no-such-thing", "a.rib"}), HasSubstr("--no-such-thing"));
}

TEST(CommandLineOptions, HelpAndVersionEndWell) {
  for (const char* option : {"--help", "--version", "-version"}) {
    int status = -1;
    testing::internal::CaptureStdout();
    EXPECT_FALSE(parseCommandLine(Arguments{option}, status).has_value());
    EXPECT_EQ(status, 0);
    EXPECT_THAT(testing::internal::GetCapturedStdout(),
                HasSubstr(option == std::string("--help") ? "--cache-memory" : "\ncommit "));
  }
}

TEST(CommandLine, ReplaysWithoutCropWindowAndOutput) {
  const std::vector<std::string> arguments{"-t:4", "-crop",   "0",       ".5",         "0",
                                           "1",    "-o",      "old.exr", "--output=x", "-mode",
                                           "path", "a b.rib", "it's.rib"};
  // Quoted as a shell wants it.
  EXPECT_EQ(replayArguments(arguments), "--threads 4 --mode path 'a b.rib' 'it'\\''s.rib'");
  EXPECT_EQ(replayArguments({}), "");
}

}  // namespace
}  // namespace patina
