// SPDX-License-Identifier: Apache-2.0
// Binary RIB: each code of RI 3.2's table C.1, mixed with ASCII, and wrong in every way.
#include <gtest/gtest.h>

#include <cmath>
#include <initializer_list>

#include "rib_recorder.h"

namespace patina::test {
namespace {

std::string bytes(std::initializer_list<int> values) {
  std::string result;
  for (int v : values) result += static_cast<char>(v);
  return result;
}

void expectNumber(const std::string& token, float expected) {
  const Parsed parsed("ShadingRate " + token);
  EXPECT_EQ(parsed.recorder.lines, Lines{"ShadingRate " + text(expected)});
  EXPECT_EQ(parsed.messages, Lines{});
}

TEST(RibBinary, IntegersAreSignedAndFixedPointHasFractions) {
  expectNumber(bytes({0200, 5}), 5);
  expectNumber(bytes({0200, 0xff}), -1);
  expectNumber(bytes({0201, 0x01, 0xe0}), 480);
  expectNumber(bytes({0201, 0xff, 0xfe}), -2);
  expectNumber(bytes({0202, 0x01, 0x00, 0x00}), 65536);
  expectNumber(bytes({0203, 0xff, 0xff, 0xff, 0xff}), -1);
  expectNumber(bytes({0203, 0x01, 0x00, 0x00, 0x00}), 16777216);
  expectNumber(bytes({0204, 0x80}), -0.5f);       // one byte, all fraction
  expectNumber(bytes({0205, 0x01, 0x80}), 1.5f);  // two bytes, one of them fraction
  expectNumber(bytes({0205, 0xfe, 0x80}), -1.5f);
  expectNumber(bytes({0212, 0x01, 0x40, 0x00}), 1.25f);    // three bytes, two of them fraction
  expectNumber(bytes({0217, 0x01, 0x00, 0x00, 0x00}), 1);  // four bytes, three of them fraction
}

TEST(RibBinary, Floats) {
  expectNumber(bytes({0244, 0x3f, 0x80, 0, 0}), 1);
  expectNumber(bytes({0244, 0xc0, 0x40, 0, 0}), -3);
  expectNumber(bytes({0245, 0x3f, 0xf8, 0, 0, 0, 0, 0, 0}), 1.5f);
  EXPECT_EQ(
      messages("ShadingRate " + bytes({0244, 0x7f, 0xc0, 0, 0})),
      Lines{
          "t.rib:1:13: error: range: ShadingRate: binary number that is infinite, not a number, or too large "
          "for a float"});
  EXPECT_EQ(messages("ShadingRate " + bytes({0245, 0x7f, 0xe0, 0, 0, 0, 0, 0, 0})).size(), 1u);
}

TEST(RibBinary, LargeIntegersStayExact) {
  EXPECT_EQ(requests("Sides " + bytes({0203, 0x01, 0x00, 0x00, 0x01})), Lines{"Sides 16777217"});
}

TEST(RibBinary, FloatArraysAreArrays) {
  const std::string array = bytes({0310, 3, 0x3f, 0x80, 0, 0, 0, 0, 0, 0, 0x40, 0, 0, 0});
  EXPECT_EQ(requests("Color " + array), Lines{"Color [1 0 2]"});
  EXPECT_EQ(requests("Color [" + array + " 4]"), Lines{"Color [1 0 2 4]"});
  EXPECT_EQ(requests("Polygon \"P\" " + array + " \"N\" [1]"),
            Lines{"Polygon {vertex point P=[1 0 2], varying normal N=[1]}"});
  EXPECT_EQ(requests("Color " + bytes({0311, 0, 1, 0x3f, 0x80, 0, 0})), Lines{"Color [1]"});
  EXPECT_EQ(requests("Color " + bytes({0312, 0, 0, 1, 0x3f, 0x80, 0, 0})), Lines{"Color [1]"});
  EXPECT_EQ(requests("Color " + bytes({0313, 0, 0, 0, 1, 0x3f, 0x80, 0, 0})), Lines{"Color [1]"});
  EXPECT_EQ(messages("Color " + bytes({0310, 1, 0x7f, 0x80, 0, 0})).size(), 1u);
}

TEST(RibBinary, Strings) {
  EXPECT_EQ(requests("System " + bytes({0223}) + "abc"), Lines{"System \"abc\""});
  EXPECT_EQ(requests("System " + bytes({0220})), Lines{"System \"\""});
  EXPECT_EQ(requests("System " + bytes({0240, 2}) + "\"\n"), Lines{"System \"\"\n\""});
  EXPECT_EQ(requests("System " + bytes({0241, 1, 0}) + std::string(256, 'x')),
            Lines{"System \"" + std::string(256, 'x') + "\""});
  EXPECT_EQ(requests("System " + bytes({0243, 0, 0, 0, 1}) + "x"), Lines{"System \"x\""});
}

TEST(RibBinary, DefinedRequestsAndStrings) {
  const std::string defineSphere = bytes({0314, 7, 0226}) + "Sphere";
  EXPECT_EQ(requests(defineSphere + bytes({0246, 7}) + "1 -1 1 360"), Lines{"Sphere 1 -1 1 360 {}"});
  const std::string defineName = bytes({0315, 9, 0225}) + "matte" + bytes({0316, 1, 2}) + "\"Kd\"";
  EXPECT_EQ(requests(defineName + "Surface " + bytes({0317, 9, 0320, 1, 2}) + "[1]"),
            Lines{"Surface \"matte\" {uniform float Kd=[1]}"});
  // A string may be defined anew between two uses in one request.
  EXPECT_EQ(requests(bytes({0315, 1, 0221}) + "a" + "MakeShadow " + bytes({0317, 1, 0315, 1, 0221}) + "b" +
                     bytes({0317, 1})),
            Lines{"MakeShadow \"a\" \"b\" {}"});
}

TEST(RibBinary, EndOfBlockIsABlank) {
  EXPECT_EQ(requests("Sides 1" + bytes({0377}) + "Identity").size(), 2u);
}

TEST(RibBinary, RecordedArchivesKeepWhatWasDefinedBefore) {
  struct Archiver : Recorder {
    std::vector<InlineArchive> archives;
    bool archiveBegin(std::string_view, const ParamList&, const Location&) override { return true; }
    void archive(std::string_view, InlineArchive a, const Location&) override {
      archives.push_back(std::move(a));
    }
  } handler;
  ErrorHandler errors;
  RibParser parser(handler, errors);
  parser.parseMemory(bytes({0314, 7, 0225}) + "Sides" + bytes({0315, 1, 0221}) + "a" + "ArchiveBegin \"x\"" +
                         bytes({0246, 7}) + "1 System" + bytes({0317, 1}) + "ArchiveEnd" +
                         bytes({0314, 7, 0225}) + "Matte" + bytes({0315, 1, 0221}) + "b",
                     "t.rib");
  ASSERT_EQ(handler.archives.size(), 1u);
  parser.parseArchive(handler.archives[0]);
  EXPECT_EQ(handler.lines, (Lines{"Sides 1", "System \"a\""}));
}

TEST(RibBinary, MessagesForWrongCodes) {
  EXPECT_EQ(messages("System " + bytes({0317, 3})),
            Lines{"t.rib:1:8: error: badstringtoken: System: string code 3 is not defined"});
  EXPECT_EQ(messages(bytes({0246, 3}) + " 1"),
            Lines{"t.rib:1:1: error: badripcode: request code is not defined"});
  EXPECT_EQ(messages(bytes({0314, 3}) + "x"),
            (Lines{"t.rib:1:1: error: badripcode: a definition of binary RIB must hold a string",
                   "t.rib:1:3: error: unregistered: unknown request x"}));
  for (const std::string& cut :
       {bytes({0201, 1}), bytes({0244, 1, 2}), bytes({0245, 1, 2}), bytes({0310}),
        bytes({0310, 2, 0, 0, 0, 0}), bytes({0313, 0xff, 0xff, 0xff, 0xff}), bytes({0225}) + "abc",
        bytes({0241, 1}), bytes({0243, 0xff, 0xff, 0xff, 0xff}), bytes({0317}), bytes({0314}),
        bytes({0316, 1})}) {
    const Lines printed = messages("System " + cut);
    ASSERT_EQ(printed.size(), 1u);
    EXPECT_TRUE(
        printed[0].starts_with("t.rib:1:8: error: syntaxerror: System: the input ends within a binary"))
        << printed[0];
  }
}

TEST(RibBinary, RequestCodeCutOff) {
  EXPECT_EQ(messages("Identity " + bytes({0246})),
            Lines{"t.rib:1:10: error: syntaxerror: the input ends within a binary request code"});
}

// The same scene written both ways, by an encoder that uses every code.
TEST(RibBinary, SameRequestsAsAscii) {
  const std::string ascii =
      "version 3.03 Declare \"k\" \"uniform color\" Format 640 480 -1 Surface \"plastic\" \"k\" [1 0.5 0.25] "
      "\"Kd\" [0.5]"
      " Translate -1.5 2 300 Sphere 1 -1 1 360";
  const std::string binary =
      "version" + bytes({0205, 3, 8, 0314, 1, 0227}) + "Declare" + bytes({0246, 1, 0221}) + "k" +
      bytes({0235}) + "uniform color" + "Format" + bytes({0201, 2, 0x80, 0201, 1, 0xe0, 0200, 0xff}) +
      "Surface" + bytes({0240, 7}) + "plastic" + bytes({0221}) + "k" +
      bytes({0310, 3, 0x3f, 0x80, 0, 0, 0x3f, 0, 0, 0, 0x3e, 0x80, 0, 0}) + "\"Kd\"[" +
      bytes({0205, 0, 0x80}) + "]" + "Translate" + bytes({0244, 0xbf, 0xc0, 0, 0, 0200, 2, 0201, 1, 0x2c}) +
      "Sphere 1" + bytes({0200, 0xff}) + "1" + bytes({0201, 1, 0x68});
  Lines expected = requests(ascii);
  expected[0] = "version 3.03125";  // 3 + 8/256
  EXPECT_EQ(requests(binary), expected);
  EXPECT_EQ(messages(binary), Lines{});
}

}  // namespace
}  // namespace patina::test
