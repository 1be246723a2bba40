// SPDX-License-Identifier: Apache-2.0
// Binding of RIB arguments to shader parameters: types, spaces, messages, traits, host services.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "renderer/shading/plugin_loader.h"
#include "renderer/shading/shader_instance.h"

namespace patina {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class ShaderInstanceTest : public testing::Test {
 protected:
  ShaderInstanceTest()
      : loader_({{}, PATINA_BINARY_DIR "/tests/plugins", false}),
        errors_([this](Severity, std::string_view text) { messages_.emplace_back(text); }),
        host_(
            [](std::string_view name) -> std::optional<M44d> {
              if (name != "named") return std::nullopt;
              M44d matrix;
              matrix.setTranslation(V3d(1, 2, 3));
              return matrix;
            },
            nullptr) {
    errors_.setQuiet(Severity::Info);
  }

  const PatinaShader& shader(const char* name) {
    const PluginLoader::Result& result = loader_.find(name);
    EXPECT_NE(result.shader, nullptr) << result.error;
    return *result.shader;
  }

  static ShaderArgument argument(const char* name, ValueType type, std::vector<float> floats,
                                 std::vector<int> ints = {}, std::vector<std::string> strings = {},
                                 int length = 0) {
    return {name,
            type,
            length,
            std::move(floats),
            std::move(ints),
            std::move(strings),
            {internFileName("s.rib"), 5, 9}};
  }

  std::unique_ptr<ShaderInstance> bind(const char* name, std::vector<ShaderArgument> arguments = {},
                                       const M44d& matrix = M44d()) {
    const ShaderBinding binding{name, std::move(arguments), matrix, {internFileName("s.rib"), 5, 1}};
    return ShaderInstance::create(shader(name), binding, host_, errors_);
  }

  static std::vector<float> floats(const ShaderInstance& instance, const char* name) {
    for (uint32_t i = 0; i < instance.shader().parameter_count; ++i)
      if (std::string_view(parameterOf(instance.shader(), i).name) == name) {
        const PatinaValue& v = instance.values()[i];
        EXPECT_EQ(v.stride, 0u);
        EXPECT_EQ(v.plane, 1u);
        return {v.floats, v.floats + v.count};
      }
    ADD_FAILURE() << name;
    return {};
  }

  PluginLoader loader_;
  std::vector<std::string> messages_;
  ErrorHandler errors_;
  ShaderHost host_;
};

TEST_F(ShaderInstanceTest, TakesDefaultsAndArguments) {
  const auto instance = bind("plastic", {argument("Kd", ValueType::Float, {0.25f}),
                                         argument("specularcolor", ValueType::Color, {1, 0.5f, 0})});
  ASSERT_NE(instance, nullptr);
  EXPECT_THAT(messages_, ElementsAre());
  EXPECT_THAT(floats(*instance, "Kd"), ElementsAre(0.25f));
  EXPECT_THAT(floats(*instance, "Ks"), ElementsAre(0.5f));
  EXPECT_THAT(floats(*instance, "specularcolor"), ElementsAre(1, 0.5f, 0));
  EXPECT_EQ(instance->values()[0].is_set, 0u);  // Ka
  EXPECT_EQ(instance->values()[1].is_set, 1u);  // Kd
}

TEST_F(ShaderInstanceTest, NamesTheNearestParameter) {
  ASSERT_NE(bind("plastic", {argument("Specularcolour", ValueType::Color, {1, 1, 1})}), nullptr);
  EXPECT_THAT(messages_, ElementsAre("s.rib:5:9: warning: badtoken: shader \"plastic\" has no parameter "
                                     "\"Specularcolour\" (did you mean \"specularcolor\"?)"));
}

TEST_F(ShaderInstanceTest, RefusesValuesThatDoNotFit) {
  const float inf = std::numeric_limits<float>::infinity();
  const auto instance = bind(
      "arealight",
      {argument("intensity", ValueType::Color, {1, 2, 3}), argument("lightcolor", ValueType::Color, {1, 1}),
       argument("sides", ValueType::Float, {1.5f}), argument("lightcolor", ValueType::Color, {1, inf, 1}),
       argument("intensity", ValueType::String, {}, {}, {"high"})});
  ASSERT_NE(instance, nullptr);
  EXPECT_THAT(
      messages_,
      ElementsAre(
          "s.rib:5:9: error: badparamlist: parameter \"intensity\" of shader \"arealight\" is float, not "
          "color; its default is used",
          "s.rib:5:9: error: badarray: parameter \"lightcolor\" of shader \"arealight\" is color: 3 values "
          "are expected, 2 given; its default is used",
          "s.rib:5:9: error: badargument: parameter \"sides\" of shader \"arealight\" is int, and 1.5 is "
          "none; its default is used",
          "s.rib:5:9: error: badargument: parameter \"lightcolor\" of shader \"arealight\" is given a "
          "value that is not finite; its default is used",
          "s.rib:5:9: error: badparamlist: parameter \"intensity\" of shader \"arealight\" is float, not "
          "string; its default is used"));
  EXPECT_THAT(floats(*instance, "lightcolor"), ElementsAre(1, 1, 1));
}

TEST_F(ShaderInstanceTest, WarnsOfValuesOutOfRange) {
  const auto instance = bind("matte", {argument("Kd", ValueType::Float, {1.5f})});
  ASSERT_NE(instance, nullptr);
  EXPECT_THAT(
      messages_,
      ElementsAre("s.rib:5:9: warning: range: parameter \"Kd\" of shader \"matte\": 1.5 is outside of "
                  "its range [0, 1]"));
  EXPECT_THAT(floats(*instance, "Kd"), ElementsAre(1.5f));
}

TEST_F(ShaderInstanceTest, ConvertsIntsFloatsAndUndeclaredTriples) {
  const auto instance = bind("arealight", {argument("sides", ValueType::Float, {2}),
                                           argument("intensity", ValueType::Integer, {}, {3}),
                                           argument("lightcolor", ValueType::Float, {1, 2, 3}, {}, {}, 3)});
  ASSERT_NE(instance, nullptr);
  EXPECT_THAT(messages_, ElementsAre());
  EXPECT_EQ(instance->values()[2].ints[0], 2);
  EXPECT_TRUE(instance->has(PATINA_TRAIT_TWO_SIDED));
  EXPECT_THAT(floats(*instance, "intensity"), ElementsAre(3));
  EXPECT_THAT(floats(*instance, "lightcolor"), ElementsAre(1, 2, 3));
}

// Row vectors: scaled by 2, then moved. Points go through all of it, and defaults do too.
TEST_F(ShaderInstanceTest, BringsPointsFromShaderToWorldSpace) {
  M44d matrix;
  matrix.setScale(V3d(2, 2, 2));
  matrix[3][0] = 10, matrix[3][1] = 20, matrix[3][2] = 30;
  const auto instance = bind("distantlight", {argument("from", ValueType::Point, {1, 2, 3})}, matrix);
  ASSERT_NE(instance, nullptr);
  EXPECT_THAT(floats(*instance, "from"), ElementsAre(12, 24, 36));
  EXPECT_THAT(floats(*instance, "to"), ElementsAre(10, 20, 32));  // default (0, 0, 1)
  EXPECT_THAT(floats(*instance, "lightcolor"), ElementsAre(1, 1, 1));
}

TEST_F(ShaderInstanceTest, ListsVaryingParameters) {
  const auto instance = bind("good");
  ASSERT_NE(instance, nullptr);
  ASSERT_EQ(instance->varyingParameters().size(), 1u);
  EXPECT_EQ(instance->varyingParameters()[0].name, "tint");
  EXPECT_EQ(instance->varyingParameters()[0].index, 1u);
  EXPECT_EQ(instance->varyingParameters()[0].components, 3u);
}

TEST_F(ShaderInstanceTest, TraitsSayWhatIsUnused) {
  const auto on = [&](const char* name, std::vector<ShaderArgument> arguments = {}) {
    const auto instance = bind(name, std::move(arguments));
    return instance ? instance->traits().active : ~0u;
  };
  constexpr uint32_t kRadiosity = 1u << PATINA_ENTRY_RADIOSITY, kView = 1u << PATINA_ENTRY_VIEW,
                     kLight = 1u << PATINA_ENTRY_LIGHT;
  EXPECT_EQ(on("matte"), kRadiosity);
  EXPECT_EQ(on("plastic"), kRadiosity | kView);
  EXPECT_EQ(on("plastic", {argument("Ks", ValueType::Float, {0})}), kRadiosity);
  EXPECT_EQ(on("metal", {argument("Ka", ValueType::Float, {0})}), kView);
  EXPECT_EQ(on("conductor"), kView);
  EXPECT_EQ(on("defaultsurface"), kView);
  EXPECT_EQ(on("pointlight"), kLight);
  EXPECT_EQ(on("pointlight", {argument("intensity", ValueType::Float, {0})}), 0u);
  EXPECT_EQ(on("arealight", {argument("lightcolor", ValueType::Color, {0, 0, 0})}), 0u);
  const auto matte = bind("matte");
  EXPECT_EQ(matte->reads(PATINA_ENTRY_RADIOSITY), PATINA_CHANNEL_CS | PATINA_CHANNEL_OS);
  EXPECT_TRUE(matte->has(PATINA_TRAIT_OPACITY_IS_OS));
  EXPECT_FALSE(matte->has(PATINA_TRAIT_EMITS));
  EXPECT_TRUE(bind("matte", {argument("emission", ValueType::Color, {0, 1, 0})})->has(PATINA_TRAIT_EMITS));
}

TEST_F(ShaderInstanceTest, RefusesTraitsThatMakeNoSense) {
  EXPECT_EQ(bind("reads_i_in_radiosity"), nullptr);
  EXPECT_EQ(bind("unknown_light_kind"), nullptr);
  EXPECT_EQ(bind("infinite_bound"), nullptr);
  EXPECT_EQ(bind("prepare_fails"), nullptr);
  EXPECT_THAT(
      messages_,
      ElementsAre(
          "s.rib:5:1: error: noshader: shader \"reads_i_in_radiosity\": its traits say that radiosity reads "
          "I, which only view is given",
          "s.rib:5:1: error: noshader: shader \"unknown_light_kind\": its traits have the light kind 9",
          "s.rib:5:1: error: noshader: shader \"infinite_bound\": its traits have the displacement bound inf",
          "s.rib:5:1: error: noshader: shader \"prepare_fails\": prepare failed with status 2 (something it "
          "needs is not there)"));
}

TEST_F(ShaderInstanceTest, TransformsBetweenNamedSpaces) {
  M44d matrix;
  matrix.setTranslation(V3d(5, 0, 0));
  const auto instance = bind("matte", {}, matrix);
  const PatinaHost& host = instance->host();
  float m[16];
  ASSERT_EQ(host.transform(host.host, "shader", "world", m), 1);
  EXPECT_EQ(m[12], 5);
  ASSERT_EQ(host.transform(host.host, "named", "shader", m), 1);
  EXPECT_THAT(std::vector<float>(m + 12, m + 16), ElementsAre(-4, 2, 3, 1));
  EXPECT_EQ(host.transform(host.host, "world", "nowhere", m), 0);
  EXPECT_THAT(std::vector<float>(m, m + 16), ElementsAre(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1));
}

TEST_F(ShaderInstanceTest, ReportsAreCountedAndPrintedOnce) {
  const auto instance = bind("matte");
  const PatinaHost& host = instance->host();
  for (int i = 0; i < 1000; ++i) host.report(host.host, PATINA_REPORT_WARNING, 7, "too dark");
  host.report(host.host, PATINA_REPORT_ERROR, 8, "broken");
  EXPECT_THAT(messages_, ElementsAre());
  host_.summarize(errors_);
  EXPECT_THAT(messages_,
              ElementsAre("s.rib:5:1: warning: system: shader \"matte\" (code 7): too dark [1000 times]",
                          "s.rib:5:1: error: system: shader \"matte\" (code 8): broken"));
  host_.summarize(errors_);
  EXPECT_EQ(messages_.size(), 2u);
}

TEST_F(ShaderInstanceTest, ALightWithoutDirectionIsSwitchedOffWithAWarning) {
  const auto instance = bind("spotlight", {argument("to", ValueType::Point, {0, 0, 0})});
  ASSERT_NE(instance, nullptr);
  EXPECT_FALSE(instance->active(PATINA_ENTRY_LIGHT));
  host_.summarize(errors_);
  EXPECT_THAT(
      messages_,
      ElementsAre(HasSubstr("shader \"spotlight\" (code 1): from and to are the same point: no light")));
}

TEST_F(ShaderInstanceTest, SurvivesASingularTransformation) {
  M44d matrix;
  matrix.setScale(V3d(1, 0, 1));
  EXPECT_NE(bind("envlight", {}, matrix), nullptr);
  EXPECT_THAT(messages_,
              ElementsAre("s.rib:5:1: warning: math: the transformation of shader \"envlight\" cannot be "
                          "inverted"));
}

}  // namespace
}  // namespace patina
