// SPDX-License-Identifier: Apache-2.0
// What a parser must accept: the odd constructs that were counted in 666 real files, read without a word.
#include <gtest/gtest.h>

#include "rib_recorder.h"

namespace patina::test {
namespace {

void expectQuietly(std::string_view rib, const Lines& lines) {
  const Parsed parsed(rib);
  EXPECT_EQ(parsed.recorder.lines, lines) << rib;
  EXPECT_EQ(parsed.messages, Lines{}) << rib;
  EXPECT_TRUE(parsed.complete);
}

TEST(RibSyntax, NothingAtAll) {
  expectQuietly("", {});
  expectQuietly(" \t\r\n\f", {});
  expectQuietly(std::string_view("\0\0\n", 3), {});
  expectQuietly("# only a comment", {});
}

TEST(RibSyntax, BareParameterValues) {
  expectQuietly("Projection \"perspective\" \"fov\" 40",
                {"Projection \"perspective\" {uniform float fov=[40]}"});
  expectQuietly(
      "Surface \"a\" \"Kd\" .5 \"texturename\" \"t\" \"from\" 1 2 3 \"Ka\" 1",
      {"Surface \"a\" {uniform float Kd=[0.5], uniform string texturename=[\"t\"], uniform point from=[1 2 "
       "3], uniform float Ka=[1]}"});
  expectQuietly("Attribute \"light\" \"shadows\" \"on\"",
                {"Attribute \"light\" {uniform string shadows=[\"on\"]}"});
}

TEST(RibSyntax, TokensGluedTogether) {
  expectQuietly(
      "LightSource\"spotlight\"1\"from\"[0 0 0]\"to\"[0 0 1]\"float Ks\"  0.7",
      {"LightSource \"spotlight\" <1> {uniform point from=[0 0 0], uniform point to=[0 0 1], uniform float "
       "Ks=[0.7]}"});
  expectQuietly("Color[1 1 1]Sphere 1 -1 1 360#end", {"Color [1 1 1]", "Sphere 1 -1 1 360 {}"});
}

TEST(RibSyntax, LineEndsAndBlanks) {
  expectQuietly("Sides\r\n2\r\nMatte\t1\fIdentity\vIdentity",
                {"Sides 2", "Matte true", "Identity", "Identity"});
  expectQuietly("# old Macintosh\rSides 2\r# more\rIdentity", {"Sides 2", "Identity"});
  expectQuietly(std::string_view("Sides\0 2\0\0Identity\x1a", 19), {"Sides 2", "Identity"});
  expectQuietly("\xef\xbb\xbfSides 2", {"Sides 2"});
}

TEST(RibSyntax, CommentsAnywhere) {
  expectQuietly("Color # red\n[1 # one\n0 0] # end\nSphere 1 # r\n -1 1 360 \"Kd\" #c\n [#d\n1]",
                {"Color [1 0 0]", "Sphere 1 -1 1 360 {uniform float Kd=[1]}"});
}

TEST(RibSyntax, HintsAndComments) {
  Parsed parsed("");
  parsed.recorder.comments = true;
  RibParser(parsed.recorder, parsed.errors)
      .parseMemory("##RenderMan RIB\n#a\nSides 2\n #b\n##Frames 2\nIdentity", "t");
  EXPECT_EQ(parsed.recorder.lines,
            (Lines{"## \"RenderMan RIB\"", "# \"a\"", "Sides 2", "# \"b\"", "## \"Frames 2\"", "Identity"}));
  EXPECT_EQ(toString(parsed.recorder.places[3]), "t:4:2");
  EXPECT_EQ(requests("#x\n##y\nIdentity"), (Lines{"## \"y\"", "Identity"}));
}

TEST(RibSyntax, Strings) {
  expectQuietly(R"(System "a\"b\\c\nd\te\101\1x\l")", {"System \"a\"b\\c\nd\teA\001xl\""});
  expectQuietly("System \"one\\\ntwo\\\r\nthree\"", {"System \"onetwothree\""});
  expectQuietly("System \"line 1\nline 2 # no comment [ ]\"", {"System \"line 1\nline 2 # no comment [ ]\""});
  expectQuietly("System \"\"", {"System \"\""});
  expectQuietly("System \"\xc3\xa9\xff\"", {"System \"\xc3\xa9\xff\""});
  expectQuietly(R"(System "\r\b\f")", {"System \"\r\b\f\""});
}

TEST(RibSyntax, Handles) {
  expectQuietly("LightSource \"a\" 7", {"LightSource \"a\" <7> {}"});
  expectQuietly("LightSource \"a\" \"7\"", {"LightSource \"a\" <7> {}"});
  expectQuietly("LightSource \"a\" \"key\" \"intensity\" [2]",
                {"LightSource \"a\" <key> {uniform float intensity=[2]}"});
  expectQuietly("LightSource \"a\" \"intensity\" 0.2",
                {"LightSource \"a\" <> {uniform float intensity=[0.2]}"});
  expectQuietly("LightSource \"a\" \"shadows\" \"on\"",
                {"LightSource \"a\" <> {uniform string shadows=[\"on\"]}"});
  expectQuietly("LightSource \"a\" \"string s\" \"on\" \"Kd\" 1",
                {"LightSource \"a\" <> {uniform string s=[\"on\"], uniform float Kd=[1]}"});
  expectQuietly("LightSource \"a\"", {"LightSource \"a\" <> {}"});
  expectQuietly("LightSource \"a\" -2147483648", {"LightSource \"a\" <-2147483648> {}"});
  expectQuietly("ObjectBegin 16777217 ObjectEnd ObjectInstance \"16777217\"",
                {"ObjectBegin <16777217> {}", "ObjectEnd", "ObjectInstance <16777217> {}"});
  expectQuietly("Illuminate \"key\" 1", {"Illuminate <key> true"});
  expectQuietly("Illuminate 1 1", {"Illuminate <1> true"});
}

TEST(RibSyntax, SubdivisionMeshWithAndWithoutTags) {
  expectQuietly("SubdivisionMesh \"none\" [4] [0 1 2 3] \"P\" []",
                {"SubdivisionMesh \"none\" [4] [0 1 2 3] tags([][][][][]) {vertex point P=[]}"});
  expectQuietly("SubdivisionMesh \"catmull-clark\" [4] [0 1 2 3] [] [] [] [] \"P\" []",
                {"SubdivisionMesh \"catmull-clark\" [4] [0 1 2 3] tags([][][][][]) {vertex point P=[]}"});
  expectQuietly(
      "SubdivisionMesh \"catmull-clark\" [4] [0 1 2 3] [\"interpolateboundary\"] [0 0] [] []",
      {"SubdivisionMesh \"catmull-clark\" [4] [0 1 2 3] tags([\"interpolateboundary\"][0 0][][][]) {}"});
}

TEST(RibSyntax, ShortForms) {
  expectQuietly("DepthOfField", {"DepthOfField 1e+38 0 0"});
  expectQuietly("Format 640 480", {"Format 640 480 -1"});
  expectQuietly("Blobby 1 [1001 0] [1]", {"Blobby 1 [1001 0] [1] [] {}"});
  expectQuietly("Procedural \"DynamicLoad\" \"a.so\" [0 1 0 1 0 1]",
                {"Procedural \"DynamicLoad\" [\"a.so\"] [0 1 0 1 0 1]"});
}

TEST(RibSyntax, EmptyArraysAreValues) {
  expectQuietly("Attribute \"user\" \"string a\" [] \"float b\" [ ] \"int c\" [#\n]",
                {"Attribute \"user\" {uniform string a=[], uniform float b=[], uniform int c=[]}"});
}

TEST(RibSyntax, DeclarationsHoldToTheEndAndInArchives) {
  expectQuietly(
      "Declare \"k\" \"constant color[2]\" AttributeBegin AttributeEnd Surface \"a\" \"k\" [1 2 3 4 5 6]",
      {"Declare \"k\" \"constant color[2]\"", "AttributeBegin", "AttributeEnd",
       "Surface \"a\" {constant color[2] k=[1 2 3 4 5 6]}"});
}

TEST(RibSyntax, TheHandlerMayKnowUndeclaredParameters) {
  struct Knows : Recorder {
    std::optional<Declaration> declarationOf(std::string_view request, std::string_view shader,
                                             std::string_view parameter) override {
      if (request != "Surface" || shader != "conductor" || parameter != "reflectance") return std::nullopt;
      return parseDeclaration("color");
    }
  } handler;
  std::vector<std::string> messages;
  ErrorHandler errors([&](Severity, std::string_view m) { messages.emplace_back(m); });
  RibParser(handler, errors).parseMemory("Surface \"conductor\" \"reflectance\" [1 0 0]", "t.rib");
  EXPECT_EQ(handler.lines, Lines{"Surface \"conductor\" {uniform color reflectance=[1 0 0]}"});
  EXPECT_EQ(messages, Lines{});
}

TEST(RibSyntax, PlacesAreThoseOfTheRequests) {
  const Parsed parsed("\n  Sides 2 Identity\r\n\tMatte 1\n" + std::string(300, ' ') + "Identity");
  std::string places;
  for (const Location& at : parsed.recorder.places) places += toString(at) + " ";
  EXPECT_EQ(places, "t.rib:2:3 t.rib:2:11 t.rib:3:2 t.rib:4:301 ");
}

TEST(RibSyntax, NestedParsesShareDeclarations) {
  struct Reader : Recorder {
    RibParser* parser = nullptr;
    void readArchive(std::string_view name, const ParamList& params, const Location& at) override {
      Recorder::readArchive(name, params, at);
      if (name == "a") parser->parseMemory("Declare \"k\" \"vector\" ReadArchive \"b\"", "a");
      if (name == "b") parser->parseMemory("Sides 2", "b");
    }
  } handler;
  ErrorHandler errors;
  RibParser parser(handler, errors);
  handler.parser = &parser;
  EXPECT_TRUE(parser.parseMemory("ReadArchive \"a\" Surface \"s\" \"k\" [1 2 3]", "t.rib"));
  EXPECT_EQ(handler.lines, (Lines{"ReadArchive \"a\" {}", "Declare \"k\" \"vector\"", "ReadArchive \"b\" {}",
                                  "Sides 2", "Surface \"s\" {uniform vector k=[1 2 3]}"}));
  EXPECT_EQ(toString(handler.places[3]), "b:1:1");
}

struct Archiver : Recorder {
  std::vector<InlineArchive> archives;
  bool archiveBegin(std::string_view n, const ParamList& p, const Location& at) override {
    Recorder::archiveBegin(n, p, at);
    return true;
  }
  void archive(std::string_view name, InlineArchive archive, const Location& at) override {
    each("archive", at, name);
    archives.push_back(std::move(archive));
  }
};

TEST(RibSyntax, InlineArchivesAreReplayedWithTheirPlaces) {
  Archiver handler;
  ErrorHandler errors;
  RibParser parser(handler, errors);
  parser.parseMemory(
      "Sides 1\n ArchiveBegin \"w\" # hint\n  Sphere 1 -1 1 360\n ArchiveBegin \"in\" ArchiveEnd\nArchiveEnd "
      "Sides 2",
      "t.rib");
  EXPECT_EQ(handler.lines, (Lines{"Sides 1", "ArchiveBegin \"w\" {}", "archive \"w\"", "Sides 2"}));
  ASSERT_EQ(handler.archives.size(), 1u);
  const InlineArchive archive = handler.archives[0];
  handler.lines.clear();
  handler.places.clear();
  for (int i = 0; i < 2; ++i) EXPECT_TRUE(parser.parseArchive(archive));
  EXPECT_EQ(handler.lines[0], "Sphere 1 -1 1 360 {}");
  EXPECT_EQ(toString(handler.places[0]), "t.rib:3:3");
  EXPECT_EQ(handler.lines.size(), 6u);
}

struct Chooser : Recorder {
  std::string asked;
  Branch choose(std::string_view c) {
    asked += c;
    return c == "yes" ? Branch::Take : Branch::Skip;
  }
  Branch ifBegin(std::string_view c, const ParamList&, const Location&) override { return choose(c); }
  Branch elseIf(std::string_view c, const ParamList&, const Location&) override { return choose(c); }
  Branch else_(const Location&) override { return choose("yes"); }
  void ifEnd(const Location&) override {}
};

TEST(RibSyntax, ConditionsDeliverOneBranch) {
  const struct {
    const char *rib, *asked;
    Lines lines;
  } cases[] = {
      {"IfBegin \"yes\" Sides 1 ElseIf \"yes\" Sides 2 Else Sides 3 IfEnd", "yes", {"Sides 1"}},
      {"IfBegin \"no\" Sides 1 ElseIf \"yes\" Sides 2 Else Sides 3 IfEnd", "noyes", {"Sides 2"}},
      {"IfBegin \"no\" Sides 1 ElseIf \"no\" Sides 2 Else Sides 3 IfEnd Sides 4",
       "nonoyes",
       {"Sides 3", "Sides 4"}},
      {"IfBegin \"no\" IfBegin \"yes\" Sides 1 Else Sides 2 IfEnd Sides 3 IfEnd", "no", {}},
      {"IfBegin \"no\" Nonsense 12ab [ Sides IfEnd Sides 4", "no", {"Sides 4"}},
      {"IfBegin \"yes\" IfBegin \"no\" Sides 1 Else Sides 2 IfEnd Sides 3 IfEnd",
       "yesnoyes",
       {"Sides 2", "Sides 3"}},
  };
  for (const auto& c : cases) {
    Chooser handler;
    std::vector<std::string> messages;
    ErrorHandler errors([&](Severity, std::string_view m) { messages.emplace_back(m); });
    RibParser(handler, errors).parseMemory(c.rib, "t.rib");
    EXPECT_EQ(handler.lines, c.lines) << c.rib;
    EXPECT_EQ(handler.asked, c.asked) << c.rib;
    EXPECT_EQ(messages, Lines{}) << c.rib;
  }
}

}  // namespace
}  // namespace patina::test
