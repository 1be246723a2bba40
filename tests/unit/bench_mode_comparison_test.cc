// SPDX-License-Identifier: Apache-2.0
// Comparisons of modes: bias that is there is found, bias that is allowed and noise are not, and no more is
// rendered than that takes.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <random>
#include <thread>

#include "tests/stress/random_report.h"
#include "tests/stress/random_scene.h"

namespace patina::stress {
namespace {

/// A renderer of 12 blocks from 0.02 to 1 with relative noise of `deviation` at effort 1. Mode "radiosity"
/// has a bias in one block.
struct Renderer {
  double deviation = 0.1, bias = 0;
  double seconds = 0;                        ///< of a picture at effort 1
  std::map<std::string, int> pictures = {};  ///< rendered so far, by mode

  static double blockOf(size_t k) { return 0.02 + 0.98 * static_cast<double>(k) / 11; }

  RenderBlocks function() {
    return [this](const std::string& mode, double effort, int seed,
                  double limit) -> std::optional<std::vector<double>> {
      ++pictures[mode];
      const double needed = seconds * effort;
      std::this_thread::sleep_for(std::chrono::duration<double>(std::min(needed, limit)));
      if (needed > limit) return {};
      std::mt19937_64 random(static_cast<uint64_t>(seed));
      std::normal_distribution<double> normal(0, deviation / std::sqrt(effort));
      std::vector<double> blocks;
      for (size_t k = 0; k < 12; ++k)
        blocks.push_back(blockOf(k) * (1 + normal(random) + (mode == "radiosity" && k == 7 ? bias : 0)));
      return blocks;
    };
  }
  Agreement compared() {
    return compareModes({"radiosity"}, function(), ComparisonSettings()).agreements.at("radiosity");
  }
};

TEST(ModeComparison, FindsBiasBeyondWhatIsAllowed) {
  for (const double bias : {0.12, -0.12}) {
    Renderer renderer{.bias = bias};
    const Agreement found = renderer.compared();
    EXPECT_LT(found.chance, 1e-6) << bias;
    EXPECT_NEAR(found.reference, Renderer::blockOf(7), 0.02);
    EXPECT_NEAR(found.difference, bias * Renderer::blockOf(7), 0.02);
    EXPECT_FALSE(found.isBlack);
  }
}

TEST(ModeComparison, LeavesWhatIsAllowedAndNoiseAlone) {
  for (const double bias : {0.0, 0.04}) {
    Renderer renderer{.bias = bias};
    const Agreement found = renderer.compared();
    EXPECT_GT(found.chance, 1e-3) << bias;
    EXPECT_LE(std::hypot(found.noise, found.pathNoise), ComparisonSettings().noise);
    EXPECT_EQ(found.tests, 12u);
  }
}

TEST(ModeComparison, TakesAsManySamplesAsNoiseAsks) {
  // The brightest block: 0.01 / sqrt(12) of noise, and 0.05 * (1 + 0.2 * 0.51) are allowed.
  Renderer quiet{.deviation = 0.01}, loud{.deviation = 1};
  const ComparisonSettings settings;
  EXPECT_EQ(compareModes({"radiosity"}, quiet.function(), settings).efforts.at("path"), 1);
  EXPECT_EQ(quiet.pictures.at("path"), settings.pictures);
  const Comparison found = compareModes({"radiosity"}, loud.function(), settings);
  // 100 times as much noise: 1 / sqrt(12) / 0.05 against 0.15 / sqrt(2), about 3000 times the samples.
  EXPECT_GE(found.efforts.at("path"), 1024);
  EXPECT_LE(found.efforts.at("path"), 16384);
  EXPECT_FALSE(found.isOutOfTime);
}

TEST(ModeComparison, ABiasIsFoundTwice) {
  Renderer same{.deviation = 0.01}, other{.deviation = 0.01, .bias = 0.2};
  const ComparisonSettings settings;
  EXPECT_EQ(compareModes({"radiosity"}, same.function(), settings).efforts.at("radiosity"), 1);
  const Comparison found = compareModes({"radiosity"}, other.function(), settings);
  EXPECT_EQ(found.efforts.at("radiosity"), 4);
  EXPECT_EQ(found.efforts.at("path"), 4);
}

TEST(ModeComparison, EndsInTime) {
  ComparisonSettings settings;
  settings.seconds = 0.5;
  Renderer noisy{.deviation = 3, .seconds = 0.005};
  const Comparison late = compareModes({"radiosity"}, noisy.function(), settings);
  EXPECT_TRUE(late.isOutOfTime);
  EXPECT_LT(late.seconds, 2);
  EXPECT_EQ(late.agreements.size(), 1u);
  Renderer slow{.seconds = 10};
  const Comparison none = compareModes({"radiosity"}, slow.function(), settings);
  EXPECT_TRUE(none.isOutOfTime);
  EXPECT_TRUE(none.agreements.empty());
  EXPECT_LT(none.seconds, 2);
}

TEST(ModeComparison, BlackIsNeitherNoiseNorAgreementWithLight) {
  const Blocks black(4, std::vector<double>(6, 0.0)), lit(4, {0, 0, 0, 0, 0, 1e-3});
  const Agreement same = agreementOf(black, black, 0.05), other = agreementOf(lit, black, 0.05);
  EXPECT_TRUE(same.isBlack && other.isBlack);
  EXPECT_EQ(same.chance, 1);
  EXPECT_EQ(same.noise, 0);
  EXPECT_LT(other.chance, 1e-12);
}

TEST(RandomScenes, WithSaneLightAllCanBeCompared) {
  std::vector<LibraryShader> library = {{"matte", {{"Kd", "float", 0, 1}}}};
  for (const char* light :
       {"ambientlight", "pointlight", "distantlight", "spotlight", "envlight", "sunsky", "arealight"})
    library.push_back({light, {{"intensity", "float", 0, 100}}});
  int insane = 0, dark = 0;
  for (uint64_t number = 0; number < 100; ++number) {
    const RandomScene sane = makeRandomScene(number, library, RandomLight::Sane),
                      any = makeRandomScene(number, library);
    EXPECT_TRUE(sane.comparable) << number;
    EXPECT_NE(sane.rib.find("LightSource \""), std::string::npos) << number;
    EXPECT_EQ(sane.rib, makeRandomScene(number, library, RandomLight::Sane).rib);
    insane += !any.comparable, dark += any.rib.find("LightSource \"") == std::string::npos;
  }
  EXPECT_GT(insane, 20);
  EXPECT_GT(dark, 10);
}

TEST(RandomReport, RowsComeBackAndAreJudgedTogether) {
  const auto row = [](uint64_t number, const char* mode, double bias, double deviation) {
    Renderer renderer{.deviation = deviation, .bias = bias};
    Row r;
    r.number = number, r.ingredients = {"odd numbers"}, r.isComparable = true;
    r.seconds[mode] = 0.5;
    r.comparison.agreements[mode] = renderer.compared();
    return r;
  };
  std::vector<Row> rows = {row(3, "radiosity", 0, 0.1), row(5, "radiosity", 0.2, 0.1)};
  rows.emplace_back().number = 6;
  rows.back().isComparable = true, rows.back().wrong = {"path: ended by signal 11"};
  for (Row& r : rows) {
    const nlohmann::json json = asJson(r);
    r = rowOf(nlohmann::json::parse(json.dump()));
    EXPECT_EQ(asJson(r), json);
  }
  const std::string modes[] = {"radiosity"};
  const Summary summary = summaryOf(rows, modes, 0.05);
  EXPECT_EQ(summary.bad, 2);
  EXPECT_NE(summary.text.find("3 scenes: 1 wrong; 0 whose light is not sane; 2 compared"), std::string::npos)
      << summary.text;
  EXPECT_NE(summary.text.find("1 (5) differ by more than 5 %"), std::string::npos) << summary.text;
  EXPECT_NE(summary.text.find("1 (6) took too long"), std::string::npos) << summary.text;
  EXPECT_NE(summary.table.find("**path: ended by signal 11**"), std::string::npos);
}

}  // namespace
}  // namespace patina::stress
