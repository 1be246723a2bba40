// SPDX-License-Identifier: Apache-2.0
// Archives by path, by search path and inline; loops; conditions.
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "renderer/scene/condition.h"
#include "rib/search_path.h"
#include "scene_fixture.h"

namespace patina {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

class Archives : public testing::Test {
 protected:
  Archives() : folder_(fs::temp_directory_path() / ("patina_archives_" + std::to_string(getpid()))) {
    fs::create_directories(folder_ / "sub");
  }
  ~Archives() override { fs::remove_all(folder_); }

  std::string write(const std::string& name, std::string_view text) {
    std::ofstream(folder_ / name) << text;
    return (folder_ / name).string();
  }
  Built read(const std::string& path, SceneBuilderSettings settings = {}) {
    Built built;
    ErrorHandler errors([&](Severity, std::string_view message) { built.messages.emplace_back(message); });
    SceneBuilder builder(std::move(settings), errors, [&](Scene& scene) { built.worlds.push_back(scene); });
    EXPECT_TRUE(builder.readFile(path));
    built.status = errors.exitStatus();
    return built;
  }
  fs::path folder_;
};

TEST_F(Archives, StandBesideTheFileThatReadsThem) {
  write("sub/inner.rib", "Sphere 2 -2 2 360");
  write("sub/outer.rib", "ReadArchive \"inner.rib\"");
  const Built built = read(write("main.rib", "WorldBegin ReadArchive \"sub/outer.rib\" WorldEnd"));
  EXPECT_THAT(built.messages, IsEmpty());
  EXPECT_THAT(built.world().primitives, SizeIs(1));
}

TEST_F(Archives, BySearchPathsCommandLineFirst) {
  write("sub/a.rib", "Color 1 0 0");
  fs::create_directories(folder_ / "first");
  write("first/a.rib", "Color 0 1 0");
  const std::string main =
      write("main.rib", "Option \"searchpath\" \"archive\" \"" + (folder_ / "sub").string() +
                            ":&\" WorldBegin ReadArchive \"a.rib\" Sphere 1 -1 1 360 WorldEnd");
  EXPECT_EQ(read(main).attributesOf(0).color, Rgb(1, 0, 0));
  EXPECT_EQ(read(main, {.archivePath = (folder_ / "first").string(), .declarationOf = {}, .makeTexture = {}})
                .attributesOf(0)
                .color,
            Rgb(0, 1, 0));
}

TEST_F(Archives, TwinsWithAndWithoutGz) {
  write("plain.rib", "Sphere 1 -1 1 360");
  write("packed.rib.gz", "Sphere 1 -1 1 360");  // told by content, so plain text is fine
  const Built built =
      read(write("main.rib", "WorldBegin ReadArchive \"plain.rib.gz\" ReadArchive \"packed.rib\" WorldEnd"));
  EXPECT_THAT(built.messages, IsEmpty());
  EXPECT_THAT(built.world().primitives, SizeIs(2));
}

TEST_F(Archives, ThatAreMissingNameThePlacesTried) {
  const std::string main =
      write("main.rib", "WorldBegin\n  ReadArchive \"none.rib\"\nSphere 1 -1 1 360\nWorldEnd");
  const Built built = read(main);
  EXPECT_THAT(built.messages,
              ElementsAre(main + ":2:3: error: nofile: archive \"none.rib\" is not found; tried: " +
                          (folder_ / "none.rib").string() + ", ./none.rib"));
  EXPECT_THAT(built.world().primitives, SizeIs(1));
}

TEST_F(Archives, ThatReadThemselvesAreStoppedOnce) {
  const std::string loop = write("loop.rib", "Sphere 1 -1 1 360\nReadArchive \"sub/../loop.rib\"\n");
  const std::string main = write("main.rib", "WorldBegin ReadArchive \"loop.rib\" WorldEnd");
  const Built built = read(main);
  EXPECT_THAT(built.messages,
              ElementsAre(testing::AllOf(
                  HasSubstr(loop + ":2:1: error: badfile: archive \"sub/../loop.rib\" would read itself: "),
                  HasSubstr(main + " -> " + loop + " -> "))));
  EXPECT_THAT(built.world().primitives, SizeIs(1));
}

TEST_F(Archives, ThatMultiplyAreLimited) {
  // Each reads the next ten times: 10^8 reads without a limit.
  for (int i = 0; i < 8; ++i) {
    std::string text;
    for (int k = 0; k < 10; ++k) text += "ReadArchive \"a" + std::to_string(i + 1) + ".rib\"\n";
    write("a" + std::to_string(i) + ".rib", text);
  }
  write("a8.rib", "Color 1 1 1\n");
  SceneBuilderSettings settings;
  settings.archiveReads = 1000;
  const Built built = read(write("main.rib", "WorldBegin ReadArchive \"a0.rib\" WorldEnd"), settings);
  EXPECT_THAT(built.messages.at(0), HasSubstr("limitcheck: more than 1000 archives read"));
  EXPECT_THAT(built.worlds, SizeIs(1));
}

TEST_F(Archives, DevicesAndFoldersAreNotRead) {
  const Built built = read(write(
      "main.rib", "ReadArchive \"/dev/zero\"\nReadArchive \"sub\"\nReadArchive \"\"\nReadArchive \"-\"\n"));
  EXPECT_THAT(built.messages, SizeIs(4));
  EXPECT_EQ(built.status, 1);
}

TEST(InlineArchives, ReplayAsOftenAsTheyAreRead) {
  const Built built = build(
      "ArchiveBegin \"ball\"\nSphere 1 -1 1 360\nArchiveEnd\nWorldBegin ReadArchive \"ball\" Translate 1 0 0 "
      "ReadArchive \"ball\" WorldEnd");
  EXPECT_THAT(built.messages, IsEmpty());
  ASSERT_THAT(built.world().primitives, SizeIs(2));
  EXPECT_EQ(built.world().primitives[1].objectToWorld[3][0], 1);
  EXPECT_EQ(built.world().primitives[1].where.line, 2u);
}

TEST(InlineArchives, DoNotReadThemselves) {
  const Built built = build("ArchiveBegin \"a\"\nReadArchive \"a\"\nArchiveEnd\nReadArchive \"a\"\n");
  EXPECT_THAT(built.messages, ElementsAre("t.rib:2:1: error: badfile: archive \"a\" would read itself: "
                                          "ArchiveBegin \"a\" -> ArchiveBegin \"a\""));
}

// ---- Paths and conditions
// ------------------------------------------------------------------------------------------

TEST(SearchPath, ElementsAndTheirMarks) {
  EXPECT_EQ(expandSearchPath("a::&:b", "x:y"), "a:x:y:b");
  EXPECT_EQ(expandSearchPath("&", ""), "");
  EXPECT_THAT(searchFolders("a:@:b:a", {"s", "b"}), ElementsAre("a", "s", "b"));
  setenv("PATINA_TEST_FOLDERS", "x:y", 1);
  unsetenv("PATINA_TEST_UNSET");
  EXPECT_THAT(searchFolders("$PATINA_TEST_FOLDERS:${PATINA_TEST_FOLDERS}/z:$PATINA_TEST_UNSET/q:a$:b", {}),
              ElementsAre("x", "y", "y/z", "a$", "b"));
}

TEST(Conditions, Values) {
  const ConditionVariables variables = [](std::string_view name) -> std::optional<std::string> {
    if (name == "user:pass") return "beauty";
    if (name == "Frame") return "12";
    return std::nullopt;
  };
  const auto value = [&](std::string_view text) { return evaluateCondition(text, variables); };
  EXPECT_EQ(value("$user:pass == 'beauty'"), true);
  EXPECT_EQ(value("${user:pass} != \"beauty\""), false);
  EXPECT_EQ(value("$Frame > 9 && $Frame<=12"), true);  // as numbers: as text 12 comes before 9
  EXPECT_EQ(value("!($Frame == 1 || defined(user:none))"), true);
  EXPECT_EQ(value("defined(user:pass) && !defined($user:none)"), true);
  EXPECT_EQ(value("$user:pass =~ '*eau*'"), true);
  EXPECT_EQ(value("$user:none"), false);
  EXPECT_EQ(value("1"), true);
  EXPECT_EQ(value("1 =="), std::nullopt);
  EXPECT_EQ(value("(1"), std::nullopt);
  EXPECT_EQ(value(""), std::nullopt);
  EXPECT_EQ(value("'open"), std::nullopt);
  EXPECT_EQ(value(std::string(100000, '(')), std::nullopt);
}

TEST(Conditions, ChooseABranch) {
  const std::string text =
      "IfBegin \"$user:pass == 'beauty'\" Color 1 0 0 ElseIf \"$user:pass == 'shadow'\" Color 0 1 0 Else "
      "Color 0 0 1 IfEnd "
      "Sphere 1 -1 1 360 WorldEnd";
  const auto color = [&](std::string_view pass) {
    return buildClean("Option \"user\" \"string pass\" \"" + std::string(pass) + "\" WorldBegin " + text)
        .attributesOf(0)
        .color;
  };
  EXPECT_EQ(color("beauty"), Rgb(1, 0, 0));
  EXPECT_EQ(color("shadow"), Rgb(0, 1, 0));
  EXPECT_EQ(color("other"), Rgb(0, 0, 1));
  EXPECT_THAT(build("IfBegin \"==\"\nIfEnd").messages,
              ElementsAre(HasSubstr("t.rib:1:1: error: syntaxerror: condition \"==\" is not understood")));
}

}  // namespace
}  // namespace patina
