// SPDX-License-Identifier: Apache-2.0
// Declarations, the dictionary, parameter lists and their copies.
#include <gtest/gtest.h>

#include "rib/params.h"
#include "rib_recorder.h"

namespace patina::test {
namespace {

TEST(RibDeclaration, FormsThatFilesUse) {
  const char* forms[][2] = {{"float", "uniform float"},
                            {"int", "uniform int"},
                            {"integer[3]", "uniform int[3]"},
                            {"  varying   point[3] ", "varying point[3]"},
                            {"facevarying float[2] st", "facevarying float[2] st"},
                            {"float st[2]", "uniform float[2] st"},
                            {"constant string primtype", "constant string primtype"},
                            {"facevertex float s", "facevertex float s"},
                            {"vertex hpoint __Pref", "vertex hpoint __Pref"},
                            {"vertex mpoint Pref", "vertex mpoint Pref"},
                            {"reference color diffuseColor", "uniform reference color diffuseColor"},
                            {"varying reference float x", "varying reference float x"},
                            {"reference bxdf b", "uniform reference string b"},
                            {"string hider:type", "uniform string hider:type"},
                            {"uniform matrix", "uniform matrix"}};
  for (const auto& [text, canonical] : forms) {
    const auto declaration = parseDeclaration(text);
    ASSERT_TRUE(declaration) << text;
    EXPECT_EQ(toString(*declaration), canonical) << text;
  }
}

TEST(RibDeclaration, NonsenseIsRefused) {
  for (const char* text :
       {"", "varying", "varying double", "A declaration with", "float[0] x", "float[-1] x", "float[2 x",
        "float[99999999999] x", "float x y", "float[2] x[3]", "uniform", "[3]", "reference", "float [] x"}) {
    EXPECT_FALSE(parseDeclaration(text)) << text;
  }
}

TEST(RibDeclaration, ComponentsOfATypeAndItsArrays) {
  EXPECT_EQ(parseDeclaration("float")->components(), 1);
  EXPECT_EQ(parseDeclaration("color[2]")->components(), 6);
  EXPECT_EQ(parseDeclaration("hpoint")->components(), 4);
  EXPECT_EQ(parseDeclaration("matrix")->components(), 16);
}

TEST(RibDictionary, KnowsTheNamesOfRI) {
  const Dictionary dictionary;
  const char* names[][2] = {{"P", "vertex point P"},
                            {"Pw", "vertex hpoint Pw"},
                            {"N", "varying normal N"},
                            {"Cs", "varying color Cs"},
                            {"st", "varying float[2] st"},
                            {"constantwidth", "constant float constantwidth"},
                            {"Kd", "uniform float Kd"},
                            {"lightcolor", "uniform color lightcolor"},
                            {"from", "uniform point from"},
                            {"texturename", "uniform string texturename"},
                            {"bucketsize", "uniform int[2] bucketsize"}};
  for (const auto& [name, canonical] : names) EXPECT_EQ(toString(dictionary.find(name).value()), canonical);
  EXPECT_FALSE(dictionary.find("Kq"));
  EXPECT_EQ(dictionary.nearest("Kq").size(), 2u);
  EXPECT_EQ(dictionary.nearest("specularcolour"), "specularcolor");
  EXPECT_EQ(dictionary.nearest("completelydifferent"), "");
}

TEST(RibDictionary, InlineDeclarationsAreRememberedWithTheRightName) {
  const Dictionary dictionary;
  for (int i = 0; i < 2; ++i) {  // parsed, then from the memo
    const std::string token = "varying float[3] myN";
    const auto found = dictionary.find(token);
    ASSERT_TRUE(found);
    EXPECT_EQ(toString(*found), token);
    EXPECT_EQ(found->name.data(), token.data() + 17);
    EXPECT_EQ(dictionary.find("float st[2]")->name, "st");
    EXPECT_EQ(dictionary.find("float tail ")->name, "tail");
  }
  for (int i = 0; i < 10000; ++i) EXPECT_TRUE(dictionary.find("float x" + std::to_string(i)));
}

TEST(RibDictionary, DeclareReplacesAndRefuses) {
  Dictionary dictionary;
  EXPECT_TRUE(dictionary.declare("Ka", "varying color"));
  EXPECT_EQ(toString(*dictionary.find("Ka")), "varying color Ka");
  EXPECT_FALSE(dictionary.declare("Ka", "varying double"));
  EXPECT_FALSE(dictionary.find("Ka"));
  EXPECT_TRUE(dictionary.refused("Ka"));
  EXPECT_TRUE(dictionary.declare("Ka", "float"));
  EXPECT_FALSE(dictionary.refused("Ka"));
  EXPECT_FALSE(dictionary.declare("a b", "float"));
  EXPECT_FALSE(dictionary.declare("", "float"));
  EXPECT_FALSE(dictionary.declare("a", "float b"));
}

TEST(RibNearestName, CountsEdits) {
  const std::string_view names[] = {"TransformBegin", "Translate", "Sphere", "Surface", "Sides"};
  EXPECT_EQ(nearestName("TransforBegin", names), "TransformBegin");
  EXPECT_EQ(nearestName("sphere", names), "Sphere");
  EXPECT_EQ(nearestName("Sufrace", names), "Surface");
  EXPECT_EQ(nearestName("Xyzzy", names), "");
  EXPECT_EQ(nearestName("", names), "");
  EXPECT_EQ(nearestName(std::string(5000, 'a'), names), "");
}

class RibParamList : public testing::Test {
 protected:
  struct Keep : RibHandler {
    OwnedParamList params;
    void surface(std::string_view, const ParamList& p, const Location&) override {
      params = OwnedParamList(p);
    }
  };
  ParamList parse(const std::string& text) {
    std::string rib = "Surface \"x\" " + text;
    RibParser(handler_, errors_).parseMemory(rib, "t.rib");
    rib.assign(rib.size(), '?');  // what was kept must not look into the text
    return handler_.params.list();
  }
  std::vector<std::string> messages;
  ErrorHandler errors_{[this](Severity, std::string_view m) { messages.emplace_back(m); }};
  Keep handler_;
};

TEST_F(RibParamList, GettersConvertAndFallBack) {
  const ParamList list = parse(
      "\"float f\" [2.5] \"int i\" [7] \"float whole\" [3] \"string s\" [\"text\"] \"color c\" [.1 .2 .3] "
      "\"float one\" "
      "[4] \"float empty\" []");
  EXPECT_EQ(list.size(), 7u);
  EXPECT_EQ(list.floatValue("f", 0), 2.5f);
  EXPECT_EQ(list.floatValue("i", 0), 7.0f);
  EXPECT_EQ(list.intValue("i", 0), 7);
  EXPECT_EQ(list.intValue("whole", 0), 3);
  EXPECT_EQ(list.intValue("f", -1), -1);
  EXPECT_EQ(list.floatValue("none", 9), 9.0f);
  EXPECT_EQ(list.floatValue("s", 9), 9.0f);
  EXPECT_EQ(list.floatValue("empty", 9), 9.0f);
  EXPECT_EQ(list.stringValue("s", ""), "text");
  EXPECT_EQ(list.stringValue("f", "no"), "no");
  EXPECT_EQ(list.tripleValue("c", {}), (std::array{.1f, .2f, .3f}));
  EXPECT_EQ(list.tripleValue("one", {}), (std::array{4.f, 4.f, 4.f}));
  EXPECT_NE(list.find("c", ValueType::Color), nullptr);
  EXPECT_EQ(list.find("c", ValueType::Point), nullptr);
}

TEST_F(RibParamList, TheLastOfEqualNamesCounts) {
  EXPECT_EQ(parse("\"float a\" 1 \"float a\" 2").floatValue("a", 0), 2.0f);
}

TEST_F(RibParamList, UnreadParametersAreReportedOnceWithTheNearestName) {
  for (int i = 0; i < 3; ++i) {
    const ParamList list = parse("\"float Kd\" 1 \"float rougness\" 2");
    EXPECT_EQ(list.floatValue("Kd", 0), 1.0f);
    const std::string_view known[] = {"Kd", "roughness"};
    list.reportUnread(errors_, "Surface \"x\"", known);
  }
  EXPECT_EQ(messages,
            Lines{"t.rib:1:26: warning: badtoken: Surface \"x\": parameter \"rougness\" is not used (did "
                  "you mean \"roughness\"?)"});
  EXPECT_EQ(errors_.count(Severity::Warning), 3u);
}

TEST_F(RibParamList, CopiesShareNothingWithTheParser) {
  const ParamList list =
      parse("\"float[2] a\" [1 2] \"string[2] b\" [\"x\" \"y\\\"z\"] \"int c\" [16777217]");
  EXPECT_EQ(text(list),
            "{uniform float[2] a=[1 2], uniform string[2] b=[\"x\" \"y\"z\"], uniform int c=[16777217]}");
  EXPECT_EQ(OwnedParamList().list().size(), 0u);
}

}  // namespace
}  // namespace patina::test
