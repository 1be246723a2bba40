// SPDX-License-Identifier: Apache-2.0
// What the plugin loader finds, and what it refuses: each refusal says which file and why.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cfenv>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <thread>

#include "renderer/shading/plugin_loader.h"

#ifdef __SSE__
#include <xmmintrin.h>
#endif

namespace patina {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

const std::string kTestPlugins = PATINA_BINARY_DIR "/tests/plugins";
const std::string kStandard = PATINA_BINARY_DIR "/lib/patina/shaders";

PluginLoader makeLoader(const std::string& option = kTestPlugins) {
  return PluginLoader({{}, option, false});
}

std::string reasonFor(const std::string& name) {
  PluginLoader loader = makeLoader();
  const PluginLoader::Result& result = loader.find(name);
  EXPECT_EQ(result.shader, nullptr);
  EXPECT_TRUE(result.refused);
  EXPECT_THAT(result.error, HasSubstr("shader \"" + name + "\" cannot be used"));
  EXPECT_THAT(result.error, HasSubstr(kTestPlugins + "/" + name + ".so: "));
  return result.error;
}

// A folder of its own, emptied at the end.
class Folder {
 public:
  Folder() {
    std::string name = testing::TempDir() + "patina-plugins-XXXXXX";
    path_ = mkdtemp(name.data());
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  std::string file(const std::string& name, const std::string& content) const {
    std::ofstream(path_ + "/" + name, std::ios::binary) << content;
    return path_ + "/" + name;
  }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

std::string contentOf(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(PluginLoader, FindsAndCachesAPlugin) {
  PluginLoader loader = makeLoader();
  const PluginLoader::Result& result = loader.find("good");
  ASSERT_NE(result.shader, nullptr) << result.error;
  EXPECT_STREQ(result.shader->name, "good");
  EXPECT_EQ(result.error, "");
  EXPECT_EQ(result.note, "");
  EXPECT_EQ(&loader.find("good"), &result);
}

class LacksEntry : public testing::TestWithParam<const char*> {};

TEST_P(LacksEntry, IsRefusedByName) {
  const std::string name = std::string("lacks_") + GetParam();
  EXPECT_THAT(reasonFor(name),
              HasSubstr("shader \"" + name + "\" lacks the entry point \"" + GetParam() + "\" (it is NULL"));
}
INSTANTIATE_TEST_SUITE_P(EachOne, LacksEntry,
                         testing::Values("displacement", "light", "radiosity", "view", "prepare"));

TEST(PluginLoader, RefusesAnotherAbiVersion) {
  EXPECT_THAT(
      reasonFor("version_2"),
      HasSubstr("it was built for version 2 of the shader ABI, and this is version 1: compile it again"));
}

TEST(PluginLoader, RefusesASharedObjectWithoutShaders) {
  EXPECT_THAT(reasonFor("symbol_missing"),
              HasSubstr("it is not a plugin: it exports no symbol patina_shaders_v1"));
  EXPECT_THAT(reasonFor("empty_table"), HasSubstr("its table patina_shaders_v1 is empty"));
  EXPECT_THAT(reasonFor("endless_table"), HasSubstr("its table patina_shaders_v1 does not end with NULL"));
}

TEST(PluginLoader, RefusesUndeclaredDependencies) {
  EXPECT_THAT(reasonFor("undefined_function"), AllOf(HasSubstr("it cannot be loaded, the loader says: "),
                                                     HasSubstr("patina_no_such_function")));
  EXPECT_THAT(reasonFor("missing_library"),
              AllOf(HasSubstr("it cannot be loaded, the loader says: "), HasSubstr("libpatina_gone.so")));
}

TEST(PluginLoader, RefusesFilesThatAreNoSharedObjects) {
  const Folder folder;
  folder.file("text.so", "Surface \"matte\"\n");
  folder.file("empty.so", "");
  folder.file("object.so",
              contentOf(kTestPlugins + "/good.so").substr(0, 16) + '\1' + std::string(100, '\0'));
  const std::string whole = contentOf(kTestPlugins + "/good.so");
  for (const size_t part : {size_t(40), whole.size() / 8, whole.size() / 2})
    folder.file("cut" + std::to_string(part) + ".so", whole.substr(0, part));

  PluginLoader loader = makeLoader(folder.path());
  EXPECT_THAT(loader.find("text").error,
              HasSubstr(folder.path() + "/text.so: it is not a plugin: not a shared object (no ELF header)"));
  EXPECT_THAT(loader.find("empty").error,
              HasSubstr("it is not a plugin: not a shared object (no ELF header)"));
  EXPECT_THAT(loader.find("object").error, HasSubstr("it is not a plugin: "));
  for (const size_t part : {size_t(40), whole.size() / 8, whole.size() / 2})
    EXPECT_THAT(loader.find("cut" + std::to_string(part)).error,
                HasSubstr("it is not a plugin: the file is cut off"));
}

TEST(PluginLoader, RefusesBadTables) {
  EXPECT_THAT(reasonFor("small_struct"), HasSubstr("its descriptor has struct_size 16, less than 88"));
  EXPECT_THAT(reasonFor("other_name"), HasSubstr("it holds no shader of that name, but \"another\""));
  EXPECT_THAT(reasonFor("unnamed_parameter"), HasSubstr("bad parameter table: parameter 0 has no name"));
  EXPECT_THAT(reasonFor("unknown_type"), HasSubstr("parameter \"tint\" has the unknown type 77"));
  EXPECT_THAT(reasonFor("default_missing"),
              HasSubstr("parameter \"tint\" lacks a default of its type color"));
  EXPECT_THAT(reasonFor("parameter_twice"), HasSubstr("parameter \"gain\" is there twice"));
}

TEST(PluginLoader, ListsEveryPathTriedAndANearName) {
  PluginLoader loader = makeLoader("/no/such/place:" + kTestPlugins);
  const PluginLoader::Result& result = loader.find("matt");
  EXPECT_EQ(result.shader, nullptr);
  EXPECT_FALSE(result.refused);
  EXPECT_THAT(result.error, AllOf(HasSubstr("shader \"matt\" is not found (did you mean \"matte\"?); tried:"),
                                  HasSubstr("\n  /no/such/place/matt.so: no such file"),
                                  HasSubstr("\n  " + kTestPlugins + "/matt.so: no such file"),
                                  HasSubstr("\n  " + kStandard + "/matt.so: no such file")));
}

TEST(PluginLoader, AnUnknownShaderIsAWarningAndARefusedOneAnError) {
  std::vector<std::pair<Severity, std::string>> messages;
  ErrorHandler errors([&](Severity s, std::string_view text) { messages.emplace_back(s, text); });
  PluginLoader loader = makeLoader();
  const Location where{internFileName("a.rib"), 3, 7};
  EXPECT_EQ(loader.load("nowhere", "Surface", errors, where), nullptr);
  EXPECT_EQ(loader.load("lacks_view", "Surface", errors, where), nullptr);
  EXPECT_EQ(loader.load("lacks_view", "Surface", errors, where), nullptr);
  ASSERT_EQ(messages.size(), 2u);
  EXPECT_EQ(messages[0].first, Severity::Warning);
  EXPECT_THAT(messages[0].second,
              HasSubstr("a.rib:3:7: warning: noshader: Surface: shader \"nowhere\" is not found"));
  EXPECT_EQ(messages[1].first, Severity::Error);
  EXPECT_THAT(messages[1].second, HasSubstr("lacks the entry point \"view\""));
}

TEST(PluginLoader, TakesTheStemOfNamesOfOtherRenderers) {
  PluginLoader loader = makeLoader();
  for (const char* name :
       {"shaders/matte", "matte.sl", "matte.slo", "some/where/matte.sdl", "matte.oso", "matte.so"}) {
    const PluginLoader::Result& result = loader.find(name);
    ASSERT_NE(result.shader, nullptr) << result.error;
    EXPECT_STREQ(result.shader->name, "matte");
    EXPECT_FALSE(result.strange);
    EXPECT_EQ(result.note, std::string("shader \"") + name + "\": \"matte\" is taken");
  }
}

TEST(PluginLoader, StandardShadersStandInForGeomviewsOwn) {
  PluginLoader loader = makeLoader();
  const PluginLoader::Result& result = loader.find("GVmodulateplastic");
  ASSERT_NE(result.shader, nullptr) << result.error;
  EXPECT_STREQ(result.shader->name, "paintedplastic");
  EXPECT_TRUE(result.strange);
  EXPECT_EQ(result.note, "shader \"GVmodulateplastic\" is not found; \"paintedplastic\" stands in for it");
}

TEST(PluginLoader, RefusesPathsOutOfTheSearchPath) {
  PluginLoader loader = makeLoader("");
  for (const std::string& name : {kTestPlugins + "/good", std::string("../tests/plugins/good"),
                                  std::string("a/../good"), std::string("C:/good"), std::string("~/good")}) {
    const PluginLoader::Result& result = loader.find(name);
    EXPECT_EQ(result.shader, nullptr);
    EXPECT_TRUE(result.refused);
    EXPECT_THAT(result.error, HasSubstr("shader \"" + name +
                                        "\" is refused: a RIB may not name a plugin by absolute "
                                        "path or with \"..\" unless --allow-shader-paths is given"));
  }
  // The same name within the search path is harmless.
  const PluginLoader::Result& taken = loader.find("/elsewhere/shaders/plastic.sl");
  ASSERT_NE(taken.shader, nullptr) << taken.error;
  EXPECT_STREQ(taken.shader->name, "plastic");
  EXPECT_TRUE(taken.strange);

  PluginLoader trusting({{}, "", true});
  EXPECT_NE(trusting.find(kTestPlugins + "/good").shader, nullptr);
}

TEST(PluginLoader, RefusesHostileNames) {
  PluginLoader loader = makeLoader();
  using namespace std::string_literals;
  for (const std::string& name :
       {""s, std::string(100000, 'a'), "a\0b"s, "/"s, ".."s, "."s, "%s%n"s, ".so"s}) {
    const PluginLoader::Result& result = loader.find(name);
    EXPECT_EQ(result.shader, nullptr);
    EXPECT_NE(result.error, "");
  }
}

TEST(PluginLoader, PassesOverARefusedFileAndSaysSo) {
  const Folder folder;
  folder.file("matte.so", "no plugin");
  PluginLoader loader = makeLoader(folder.path());
  const PluginLoader::Result& result = loader.find("matte");
  ASSERT_NE(result.shader, nullptr);
  EXPECT_TRUE(result.strange);
  EXPECT_THAT(result.note, HasSubstr(folder.path() + "/matte.so: it is not a plugin"));
}

TEST(PluginLoader, SearchesTheCommandLineFirstThenTheOptionThenTheEnvironment) {
  setenv("PATINA_SHADER_PATH", "/from/environment", 1);
  PluginLoader loader({{"/from/commandline"}, "/from/option:&", false});
  unsetenv("PATINA_SHADER_PATH");
  EXPECT_THAT(loader.folders(),
              testing::ElementsAre("/from/commandline", "/from/option", "/from/environment", kStandard));
}

TEST(PluginLoader, SplitsPathsAsRiDoes) {
  const std::vector<std::string> defaults{"x", "y"};
  EXPECT_THAT(splitSearchPath("a:&:b/", defaults), testing::ElementsAre("a", "x", "y", "b"));
  EXPECT_THAT(splitSearchPath("@:a", defaults), testing::ElementsAre("x", "y", "a"));
  EXPECT_THAT(splitSearchPath("::a:a:", defaults), testing::ElementsAre("a"));
  EXPECT_THAT(splitSearchPath("", defaults), testing::ElementsAre());
}

TEST(PluginLoader, LeavesTheFloatingPointStateAlone) {
#ifdef __SSE__
  const unsigned before = _mm_getcsr() & 0xffc0u;
  PluginLoader loader = makeLoader();
  ASSERT_NE(loader.find("changes_rounding").shader, nullptr);
  EXPECT_EQ(_mm_getcsr() & 0xffc0u, before);
#endif
  volatile float denormal = 1e-39f;
  EXPECT_GT(denormal * 0.5f, 0.0f);
}

TEST(PluginLoader, LoadsFromSeveralThreads) {
  PluginLoader loader = makeLoader();
  std::vector<std::thread> threads;
  std::array<const PatinaShader*, 8> found{};
  for (size_t i = 0; i < found.size(); ++i)
    threads.emplace_back([&, i] { found[i] = loader.find(i % 2 ? "good" : "matte").shader; });
  for (std::thread& thread : threads) thread.join();
  for (size_t i = 2; i < found.size(); ++i) EXPECT_EQ(found[i], found[i - 2]);
  EXPECT_NE(found[0], nullptr);
}

TEST(PluginLoader, EveryStandardShaderIsThereAndDocumented) {
  PluginLoader loader = makeLoader("");
  for (const char* name :
       {"constant", "matte", "metal", "shinymetal", "plastic", "paintedplastic", "defaultsurface",
        "conductor", "dielectric", "leaf", "null", "showst", "ambientlight", "distantlight", "pointlight",
        "spotlight", "arealight", "envlight"}) {
    const PluginLoader::Result& result = loader.find(name);
    ASSERT_NE(result.shader, nullptr) << result.error;
    EXPECT_STRNE(result.shader->doc, "");
    for (uint32_t i = 0; i < result.shader->parameter_count; ++i)
      EXPECT_STRNE(parameterOf(*result.shader, i).doc, "") << name;
  }
}

}  // namespace
}  // namespace patina
