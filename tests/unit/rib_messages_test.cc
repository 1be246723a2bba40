// SPDX-License-Identifier: Apache-2.0
// Every message of the parser: its text, its line and column, and what of the file still comes through.
#include <gtest/gtest.h>

#include "rib_recorder.h"

namespace patina::test {
namespace {

struct Case {
  const char* rib;
  Lines messages;
  Lines lines;
};

void check(const std::vector<Case>& cases) {
  for (const Case& c : cases) {
    const Parsed parsed(c.rib);
    EXPECT_EQ(parsed.messages, c.messages) << c.rib;
    EXPECT_EQ(parsed.recorder.lines, c.lines) << c.rib;
  }
}

TEST(RibMessages, UnknownRequests) {
  check(
      {{"Sides 1\n  TransforBegin 1 [2]\nSides 2",
        {"t.rib:2:3: error: unregistered: unknown request TransforBegin (did you mean TransformBegin?)"},
        {"Sides 1", "Sides 2"}},
       {"set -x\n# teapot\nSides 2", {"t.rib:1:1: error: unregistered: unknown request set"}, {"Sides 2"}},
       {"This is no RIB at all. Sides 2",
        {"t.rib:1:1: error: unregistered: unknown request This"},
        {"Sides 2"}},
       {"\xa6\x05 1 2 Sides 2", {"t.rib:1:1: error: badripcode: request code is not defined"}, {"Sides 2"}}});
}

TEST(RibMessages, WrongArguments) {
  check({{"ShadingRate SR\nPixelSamples\nSides 2",
          {"t.rib:1:1: error: badargument: ShadingRate: expected a number, found nothing more (usage: "
           "ShadingRate "
           "size)",
           "t.rib:1:13: error: unregistered: unknown request SR",
           "t.rib:2:1: error: badargument: PixelSamples: expected a number, found nothing more (usage: "
           "PixelSamples x "
           "y)"},
          {"Sides 2"}},
         {"Sphere 1 \"P\"",
          {"t.rib:1:10: error: badargument: Sphere: expected a number, found \"P\" (usage: Sphere radius "
           "zmin zmax "
           "thetamax ...)"},
          {}},
         {"Surface 1",
          {"t.rib:1:9: error: badargument: Surface: expected a string, found a number (usage: Surface name "
           "...)"},
          {}},
         {"Surface [1 2]",
          {"t.rib:1:9: error: badargument: Surface: expected a string, found an array of numbers (usage: "
           "Surface name "
           "...)"},
          {}},
         {"Color [\"red\"]",
          {"t.rib:1:7: error: badargument: Color: expected an array of numbers, found an array of strings "
           "(usage: Color "
           "color)"},
          {}},
         {"Color [1 \"red\"]",
          {"t.rib:1:7: error: badarray: Color: expected an array of numbers, found an array of numbers and "
           "strings "
           "(usage: Color color)"},
          {}},
         {"Scale []",
          {"t.rib:1:7: error: badargument: Scale: expected a number, found an empty array (usage: Scale x y "
           "z)"},
          {}},
         {"Format 640.5 480 1",
          {"t.rib:1:8: error: badargument: Format: expected an integer, found a fraction or a number beyond "
           "32 bits"},
          {}},
         {"PointsPolygons [3] [0 1 3000000000]",
          {"t.rib:1:20: error: badargument: PointsPolygons: expected integers, found a fraction or a number "
           "beyond 32 "
           "bits"},
          {}},
         {"Illuminate [] 1",
          {"t.rib:1:12: error: badargument: Illuminate: expected a handle (an integer or a string), found an "
           "empty array "
           "(usage: Illuminate handle onoff)"},
          {}}});
}

TEST(RibMessages, TooManyArguments) {
  check({{"Translate [1 0 0 0 0 1 0 0 0 0 1 0 2 3 4 1]",
          {"t.rib:1:11: error: badargument: Translate: more arguments than expected, 16 numbers in all: is "
           "ConcatTransform meant? (usage: Translate dx dy dz)"},
          {}},
         {"Sides 1 2",
          {"t.rib:1:7: error: badargument: Sides: more arguments than expected (usage: Sides sides)"},
          {}},
         {"Sphere 1 -1 1 360 5",
          {"t.rib:1:8: error: badargument: Sphere: more arguments than expected (usage: Sphere radius zmin "
           "zmax thetamax "
           "...)"},
          {}},
         {"WorldBegin 5",
          {"t.rib:1:12: warning: badargument: WorldBegin: a number behind a request without arguments is "
           "ignored"},
          {"WorldBegin"}}});
}

TEST(RibMessages, BlocksOpenEvenIfTheirArgumentIsMissing) {
  check({{"ObjectBegin Sphere 1 -1 1 360 ObjectEnd",
          {"t.rib:1:1: warning: badhandle: ObjectBegin: no handle; the empty name is used"},
          {"ObjectBegin <> {}", "Sphere 1 -1 1 360 {}", "ObjectEnd"}},
         {"FrameBegin FrameEnd",
          {"t.rib:1:1: warning: badargument: FrameBegin: no frame number; 0 is used"},
          {"FrameBegin 0", "FrameEnd"}},
         {"AttributeBegin ] AttributeEnd",
          {"t.rib:1:16: error: syntaxerror: AttributeBegin: ']' without '['"},
          {"AttributeBegin", "AttributeEnd"}}});
}

TEST(RibMessages, Numbers) {
  check({{"Rotate NaN 0 1 0 Sides 2",
          {"t.rib:1:8: error: range: Rotate: \"NaN\" is not a finite number"},
          {"Sides 2"}},
         {"Scale 1 -inf 1", {"t.rib:1:9: error: range: Scale: \"-inf\" is not a finite number"}, {}},
         {"Scale 1 01a3 1", {"t.rib:1:9: error: syntaxerror: Scale: \"01a3\" is not a number"}, {}},
         {"Clipping 1 1e99",
          {"t.rib:1:12: warning: range: Clipping: 1e99 is too large for a float; 3.4028235e+38 is used"},
          {"Clipping 1 3.4028235e+38"}},
         {"Polygon \"P\" [1 nan 2] \"Cs\" [1 0 0]",
          {"t.rib:1:16: error: range: Polygon: \"nan\" is not a finite number"},
          {"Polygon {varying color Cs=[1 0 0]}"}}});
}

TEST(RibMessages, Tokens) {
  check({{"System \"a\" Sides 1\nSystem \"never\nends Sides 2",
          {"t.rib:2:8: error: syntaxerror: System: unterminated string, begun here"},
          {"System \"a\"", "Sides 1"}},
         {"System \"ends in \\",
          {"t.rib:1:8: error: syntaxerror: System: unterminated string, begun here"},
          {}},
         {"\"abc\" 1 2 [3] Sides 2",
          {"t.rib:1:1: error: syntaxerror: a request is expected here"},
          {"Sides 2"}},
         {"Color [1 0 0\nSides 2",
          {"t.rib:1:7: error: syntaxerror: Color: array begun here is not closed by ']'"},
          {"Sides 2"}},
         {"Color [1 0", {"t.rib:1:7: error: syntaxerror: Color: array begun here is not closed by ']'"}, {}},
         {"Color [1 [0 0] 2] Sides 2",
          {"t.rib:1:10: error: badarray: Color: an array within an array"},
          {"Sides 2"}},
         {"Color [1 red 0] Sides 2",
          {"t.rib:1:10: error: syntaxerror: Color: word red in an array (strings are written in quotes)"},
          {"Sides 2"}},
         {"Sides 1 } Sides 2", {"t.rib:1:9: error: syntaxerror: Sides: unexpected '}'"}, {"Sides 2"}},
         {"Sides 1 ] Sides 2", {"t.rib:1:9: error: syntaxerror: Sides: ']' without '['"}, {"Sides 2"}},
         {"Color [1 ; 0] Sides 2", {"t.rib:1:10: error: syntaxerror: Color: unexpected ';'"}, {"Sides 2"}},
         {"Sides 1 \xff Sides \xfe 2",
          {"t.rib:1:17: error: badripcode: Sides: byte 0376 begins no token"},
          {"Sides 1"}}});
}

TEST(RibMessages, OneErrorPerRequest) {
  EXPECT_EQ(messages("Sphere nan } ] 1a 2b [[ \"x\" ]] Sides 2").size(), 1u);
  EXPECT_EQ(messages("} ] 1a 2b [[ \"x\" ]] Sides 2").size(), 1u);
}

TEST(RibMessages, Parameters) {
  check({{"Surface \"plastic\" \"Kdd\" .5 \"s\" [\"x\"]",
          {"t.rib:1:19: warning: badtoken: Surface: parameter \"Kdd\" is not declared (did you mean "
           "\"Kd\"?); taken as "
           "float",
           "t.rib:1:28: warning: badargument: Surface: parameter \"s\" is declared \"varying float s\" but "
           "its value is "
           "an array of strings; it is ignored"},
          {"Surface \"plastic\" {uniform float Kdd?=[0.5]}"}},
         {"Surface \"x\" \"varying double y\" [1] \"Ka\" 1",
          {"t.rib:1:13: warning: badtoken: Surface: \"varying double y\" is not a declaration; the parameter "
           "is ignored"},
          {"Surface \"x\" {uniform float Ka=[1]}"}},
         {"Surface \"x\" \"int a\" [1.5]",
          {"t.rib:1:13: warning: badargument: Surface: parameter \"int a\" is declared \"uniform int a\" but "
           "its value "
           "is not integral; it is ignored"},
          {"Surface \"x\" {}"}},
         {"Surface \"x\" \"float a\" [1 \"b\"] \"Ka\" 1",
          {"t.rib:1:13: warning: badarray: Surface: the value of parameter \"float a\" mixes numbers and "
           "strings and is "
           "ignored"},
          {"Surface \"x\" {uniform float Ka=[1]}"}},
         {"Surface \"x\" \"Ka\" \"Kd\" 1 \"Ks\"",
          {"t.rib:1:13: warning: badparamlist: Surface: parameter \"Ka\" has no value and is ignored",
           "t.rib:1:25: warning: badparamlist: Surface: parameter \"Ks\" has no value and is ignored"},
          {"Surface \"x\" {uniform float Kd=[1]}"}},
         {"Surface \"x\" \"Ka\" 1 [2 3] \"Kd\" 1",
          {"t.rib:1:20: warning: badparamlist: Surface: an array of numbers where a parameter's name is "
           "expected is "
           "ignored"},
          {"Surface \"x\" {uniform float Ka=[1], uniform float Kd=[1]}"}},
         {"Declare \"n\" \"varying double\" Polygon \"n\" [1] \"P\" []",
          {"t.rib:1:1: warning: badtoken: Declare: \"n\" \"varying double\" is not a declaration ([class] "
           "type[n]) and is "
           "ignored"},
          {"Polygon {vertex point P=[]}"}}});
}

TEST(RibMessages, UndeclaredParametersAreNamedOnceAndForOptionsOnlyOnRequest) {
  EXPECT_EQ(messages("Surface \"a\" \"foo\" 1 Surface \"b\" \"foo\" 1 Surface \"a\" \"bar\" 1").size(), 2u);
  EXPECT_EQ(messages("Option \"user\" \"foo\" 1 Attribute \"x\" \"bar\" [\"y\"]"), Lines{});
}

TEST(RibMessages, SingleRequests) {
  check({{"Basis \"bezeir\" 3 \"bezier\" 3",
          {"t.rib:1:1: error: badbasis: Basis: unknown basis \"bezeir\" (bezier, b-spline, catmull-rom, "
           "hermite, power)"},
          {}},
         {"ErrorHandler \"shout\"",
          {"t.rib:1:1: error: badargument: ErrorHandler: unknown style \"shout\" (ignore, print or abort)"},
          {}},
         {"SubdivisionMesh \"catmull-clark\" [4] [0 1 2 3] [\"crease\"] [2 1] [0] [3]",
          {"t.rib:1:1: warning: consistency: SubdivisionMesh: the tags' values do not match their counts; "
           "the tags are "
           "ignored"},
          {"SubdivisionMesh \"catmull-clark\" [4] [0 1 2 3] tags([][][][][]) {}"}},
         {"SubdivisionMesh \"catmull-clark\" [4] [0 1 2 3] [\"crease\"] [-1 1] [] []",
          {"t.rib:1:1: warning: consistency: SubdivisionMesh: the tags' values do not match their counts; "
           "the tags are "
           "ignored"},
          {"SubdivisionMesh \"catmull-clark\" [4] [0 1 2 3] tags([][][][][]) {}"}}});
}

TEST(RibMessages, Nesting) {
  check({{"IfEnd Else ElseIf \"x\" Sides 2",
          {"t.rib:1:1: error: nesting: IfEnd: no IfBegin is open",
           "t.rib:1:7: error: nesting: Else: no IfBegin is open",
           "t.rib:1:12: error: nesting: ElseIf: no IfBegin is open"},
          {"Sides 2"}},
         {"Sides 2 IfBegin \"x\" Sides 1",
          {"t.rib:1:9: error: nesting: IfBegin has no IfEnd"},
          {"Sides 2", "IfBegin \"x\" {}", "Sides 1"}}});
  struct Archiver : Recorder {
    bool archiveBegin(std::string_view, const ParamList&, const Location&) override { return true; }
  } handler;
  Lines printed;
  ErrorHandler errors([&](Severity, std::string_view m) { printed.emplace_back(m); });
  RibParser(handler, errors).parseMemory("Sides 1 ArchiveBegin \"a\" Sides 2", "t.rib");
  EXPECT_EQ(printed, Lines{"t.rib:1:9: error: nesting: ArchiveBegin \"a\" has no ArchiveEnd"});
}

TEST(RibMessages, AbortStopsAtTheFirstError) {
  const Parsed parsed("ErrorHandler \"abort\" Sides 1 Nonsense Sides 2");
  EXPECT_EQ(parsed.recorder.lines, (Lines{"ErrorHandler \"abort\"", "Sides 1"}));
  EXPECT_FALSE(parsed.complete);
}

TEST(RibMessages, FilesThatCannotBeRead) {
  Recorder handler;
  Lines printed;
  ErrorHandler errors([&](Severity, std::string_view m) { printed.emplace_back(m); });
  RibParser parser(handler, errors);
  EXPECT_FALSE(parser.parseFile("no/such/file.rib"));
  EXPECT_FALSE(parser.parseFile("."));
  EXPECT_EQ(printed, (Lines{"no/such/file.rib: error: nofile: cannot open: No such file or directory",
                            ".: error: badfile: cannot read: Is a directory"}));
}

TEST(RibMessages, ArchivesThatReadThemselves) {
  struct Reader : Recorder {
    RibParser* parser = nullptr;
    int reads = 0;
    void readArchive(std::string_view, const ParamList&, const Location&) override {
      ++reads;
      parser->parseMemory("ReadArchive \"me\"", "me.rib");
    }
  } handler;
  Lines printed;
  ErrorHandler errors([&](Severity, std::string_view m) { printed.emplace_back(m); });
  RibParser parser(handler, errors, {.depth = 5});
  handler.parser = &parser;
  parser.parseMemory("ReadArchive \"me\"", "t.rib");
  EXPECT_EQ(handler.reads, 5);
  EXPECT_EQ(printed, Lines{"me.rib:1:1: error: limitcheck: archives are nested more than 5 deep"});
}

TEST(RibMessages, TheLineIsShownWithACaretWhereItIsAtHand) {
  std::vector<std::string> messages;
  ErrorHandler errors([&](Severity, std::string_view message) { messages.emplace_back(message); });
  errors.setShowLines(true);
  Recorder recorder;
  RibParser parser(recorder, errors);
  parser.parseMemory("Sides 1\r\n\tSphere 1 -1 1 \"x\" # why\r\nSides 2", "a.rib");
  ASSERT_EQ(messages.size(), 1u);
  EXPECT_TRUE(messages[0].ends_with("\n   Sphere 1 -1 1 \"x\" # why\n                 ^")) << messages[0];
  // Of a long line the part around the place.
  messages.clear();
  parser.parseMemory("Polygon \"P\" [" + std::string(500, ' ') + "x" + std::string(500, ' ') + "0 0 0]",
                     "b.rib");
  ASSERT_GE(messages.size(), 1u);
  EXPECT_LT(messages[0].size(), 400u);
  EXPECT_TRUE(messages[0].ends_with("^"));
  // Binary bytes are not shown, nor is a place without a line.
  messages.clear();
  parser.parseMemory("\001\002\003\004\005 Sphree", "c.rib");
  errors.report(Severity::Error, RiError::Bug, {internFileName("a.rib"), 1, 1}, "later");
  ASSERT_EQ(messages.size(), 2u);
  EXPECT_EQ(messages[0].find('\n'), std::string::npos);
  EXPECT_EQ(messages[1].find('\n'), std::string::npos);
}

}  // namespace
}  // namespace patina::test
