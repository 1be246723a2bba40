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
  EXPECT_EQ(good.output, "matte: 18 checks, 0 faults\nwrong_nothing: 18 checks, 0 faults\n");
  EXPECT_EQ(good.status, 0);
}

TEST(PatinaShader, SaysWhatIsWrongAndFails) {
  const Outcome bad = run("--check " + kPlugins + "wrong_exceeds_bound.so");
  EXPECT_THAT(bad.output, HasSubstr("displacement moves P further than its displacement_bound"));
  EXPECT_THAT(bad.output, HasSubstr("\nwrong_exceeds_bound: 18 checks, 1 fault\n"));
  EXPECT_EQ(bad.status, 1);
}

TEST(PatinaShader, ChecksAsJson) {
  const Outcome bad = run("--check --json " + kPlugins + "wrong_exceeds_bound.so");
  EXPECT_EQ(bad.status, 1);
  const auto report = nlohmann::json::parse(bad.output);
  ASSERT_EQ(report.size(), 1u);
  EXPECT_EQ(report[0]["shader"], "wrong_exceeds_bound");
  EXPECT_EQ(report[0]["checks"], 18);
  ASSERT_EQ(report[0]["faults"].size(), 1u);
  EXPECT_EQ(report[0]["faults"][0]["entry"], "displacement");
  EXPECT_EQ(report[0]["faults"][0]["check"], "displacement");
}

TEST(PatinaShader, ListsAsJson) {
  const Outcome listed = run("--json spotlight displace");
  EXPECT_EQ(listed.status, 0);
  const auto all = nlohmann::json::parse(listed.output);
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0]["shader"], "spotlight");
  EXPECT_FALSE(all[0].contains("entries"));  // nothing was run
  EXPECT_EQ(all[1]["parameters"][0]["name"], "Km");
  EXPECT_EQ(all[1]["parameters"][0]["type"], "float");
  EXPECT_EQ(all[1]["parameters"][0]["storage"], "uniform");
  EXPECT_EQ(all[1]["parameters"][0]["default"], nlohmann::json({0.1f}));
  EXPECT_FALSE(all[1]["parameters"][0].contains("minimum"));
  EXPECT_EQ(all[1]["parameters"][4]["default"], nlohmann::json({""}));
}

// Also those that do something for some parameters only: displace does nothing without a texture.
TEST(PatinaShader, SaysWhatShadersCanBeBoundAs) {
  const Outcome listed = run("--json --entries spotlight displace plastic fog");
  EXPECT_EQ(listed.status, 0);
  const auto all = nlohmann::json::parse(listed.output);
  ASSERT_EQ(all.size(), 4u);
  EXPECT_EQ(all[0]["entries"], nlohmann::json({"light"}));
  EXPECT_EQ(all[0]["light"], nlohmann::json({"delta"}));
  EXPECT_EQ(all[0]["from_point"], true);
  EXPECT_EQ(all[1]["entries"], nlohmann::json({"displacement"}));
  EXPECT_EQ(all[1]["light"], nlohmann::json::array());
  EXPECT_EQ(all[2]["entries"], nlohmann::json({"radiosity", "view"}));
  EXPECT_EQ(all[3]["entries"], nlohmann::json({"atmosphere"}));
}

TEST(PatinaShader, RefusesWrongUsage) {
  EXPECT_EQ(run("--check").status, 2);
  EXPECT_EQ(run("--json --rib matte").status, 2);
  EXPECT_EQ(run("--entries matte").status, 2);
  EXPECT_EQ(run("--check --json --entries matte").status, 2);
  EXPECT_EQ(run("--check --rib matte").status, 2);
}

TEST(PatinaShader, FailsForWhatIsNoPlugin) {
  const Outcome missing = run("--check nosuchshader");
  EXPECT_EQ(missing.status, 1);
  EXPECT_THAT(missing.output, HasSubstr("shader \"nosuchshader\" is not found"));
}

}  // namespace
}  // namespace patina
