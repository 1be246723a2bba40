// SPDX-License-Identifier: Apache-2.0
// The program patina-shader: what --check prints, and its exit status.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdio.h>
#include <sys/wait.h>

#include <nlohmann/json.hpp>
#include <string>

namespace patina {
namespace {

using testing::HasSubstr;

struct Outcome {
  int status;
  std::string output;
};

Outcome run(const std::string& arguments) {
  FILE* pipe = popen((PATINA_BINARY_DIR "/bin/patina-shader " + arguments + " 2>&1").c_str(), "r");
  Outcome result{-1, {}};
  char buffer[4096];
  for (size_t size; (size = fread(buffer, 1, sizeof buffer, pipe)) > 0;) result.output.append(buffer, size);
  result.status = WEXITSTATUS(pclose(pipe));
  return result;
}

const std::string kPlugins = PATINA_BINARY_DIR "/tests/plugins/";

TEST(PatinaShader, ChecksShadersByNameAndFile) {
  const Outcome good = run("--check matte " + kPlugins + "wrong_nothing.so");
  EXPECT_EQ(good.output, "matte: 16 checks, 0 faults\nwrong_nothing: 16 checks, 0 faults\n");
  EXPECT_EQ(good.status, 0);
}

TEST(PatinaShader, SaysWhatIsWrongAndFails) {
  const Outcome bad = run("--check " + kPlugins + "wrong_exceeds_bound.so");
  EXPECT_THAT(bad.output, HasSubstr("displacement moves P further than its displacement_bound"));
  EXPECT_THAT(bad.output, HasSubstr("\nwrong_exceeds_bound: 16 checks, 1 fault\n"));
  EXPECT_EQ(bad.status, 1);
}

TEST(PatinaShader, ChecksAsJson) {
  const Outcome bad = run("--check --json " + kPlugins + "wrong_exceeds_bound.so");
  EXPECT_EQ(bad.status, 1);
  const auto report = nlohmann::json::parse(bad.output);
  ASSERT_EQ(report.size(), 1u);
  EXPECT_EQ(report[0]["shader"], "wrong_exceeds_bound");
  EXPECT_EQ(report[0]["checks"], 16);
  ASSERT_EQ(report[0]["faults"].size(), 1u);
  EXPECT_EQ(report[0]["faults"][0]["entry"], "displacement");
  EXPECT_EQ(report[0]["faults"][0]["check"], "displacement");
}

TEST(PatinaShader, RefusesWrongUsage) {
  EXPECT_EQ(run("--check").status, 2);
  EXPECT_EQ(run("--json matte").status, 2);
  EXPECT_EQ(run("--check --rib matte").status, 2);
}

TEST(PatinaShader, FailsForWhatIsNoPlugin) {
  const Outcome missing = run("--check nosuchshader");
  EXPECT_EQ(missing.status, 1);
  EXPECT_THAT(missing.output, HasSubstr("shader \"nosuchshader\" is not found"));
}

}  // namespace
}  // namespace patina
