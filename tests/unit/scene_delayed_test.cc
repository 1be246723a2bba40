// SPDX-License-Identifier: Apache-2.0
// Delayed archives: when they are read, what they find, and what they may not do.
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "renderer/base/statistics.h"
#include "scene_fixture.h"

namespace patina {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using testing::StartsWith;

constexpr std::string_view kRequest = "Procedural \"DelayedReadArchive\" [\"d.rib\"] [-1 1 -1 1 -1 1]\n";

class Delayed : public testing::Test {
 protected:
  Delayed() : folder_(fs::temp_directory_path() / ("patina_delayed_" + std::to_string(getpid()))) {
    fs::create_directories(folder_);
  }
  ~Delayed() override { fs::remove_all(folder_); }

  std::string write(const std::string& name, std::string_view text) {
    std::ofstream(folder_ / name) << text;
    return (folder_ / name).string();
  }
  /// Reads main.rib with that text in its world, and shows its scene to `look` while its builder lives.
  void build(const std::string& text, const std::function<void(const Scene&)>& look,
             SceneBuilderSettings settings = {}, const std::string& options = {}) {
    main_ = write("main.rib", options + "WorldBegin\n" + text + "\nWorldEnd");
    messages_.clear();
    int worlds = 0;
    SceneBuilder builder(std::move(settings), errors_, [&](Scene& scene) { look(scene), ++worlds; });
    EXPECT_TRUE(builder.readFile(main_));
    EXPECT_EQ(worlds, 1);
  }
  /// The scene of the first delayed archive.
  std::shared_ptr<const Scene> load(const Scene& scene) {
    EXPECT_THAT(scene.delayed, SizeIs(1));
    return scene.readDelayed(scene.delayed.at(0), errors_);
  }

  fs::path folder_;
  std::string main_;
  std::vector<std::string> messages_;
  ErrorHandler errors_{[this](Severity, std::string_view message) { messages_.emplace_back(message); }};
};

TEST_F(Delayed, AreNotEvenLookedForBeforeSomebodyAsks) {
  build(std::string(kRequest), [&](const Scene& scene) {
    EXPECT_THAT(messages_, IsEmpty());
    EXPECT_THAT(scene.primitives, IsEmpty());
    load(scene);
  });
  EXPECT_THAT(messages_,
              ElementsAre(AllOf(StartsWith(main_ + ":2:1: error: nofile: archive \"d.rib\" is not found"),
                                HasSubstr("\n  in delayed archive \"d.rib\" of " + main_ + ":2:1"))));
}

TEST_F(Delayed, FindTheStateOfTheirRequestAndLeaveNothingBehind) {
  write("d.rib", "Sphere 1 -1 1 360 Color 0 0 1 Translate 0 5 0 Sphere 1 -1 1 360 AttributeBegin");
  for (const char* request : {kRequest.data(),
                              "Procedural2 \"DelayedReadArchive2\" \"SimpleBound\" \"string filename\" "
                              "[\"d.rib\"] \"float[6] bound\" [-1 1 -1 1 -1 1]\n"}) {
    build("AttributeBegin Color 0 1 0 ReverseOrientation Translate 3 0 0\n" + std::string(request) +
              "Color 1 0 0\nAttributeEnd\nSphere 1 -1 1 360",
          [&](const Scene& scene) {
            const DelayedArchive& record = scene.delayed.at(0);
            EXPECT_EQ(record.bound, Box3f({-1, -1, -1}, {1, 1, 1}));
            EXPECT_EQ(record.objectToWorld[3][0], 3);
            const auto inner = load(scene);
            ASSERT_THAT(inner->primitives, SizeIs(2));
            EXPECT_EQ(inner->attributes[inner->primitives[0].attributes].color, Rgb(0, 1, 0));
            EXPECT_EQ(inner->attributes[inner->primitives[1].attributes].color, Rgb(0, 0, 1));
            EXPECT_TRUE(inner->primitives[0].reversed);
            EXPECT_EQ(inner->primitives[1].objectToWorld[3][0], 3);
            EXPECT_EQ(inner->primitives[1].objectToWorld[3][1], 5);
            ASSERT_THAT(scene.primitives, SizeIs(1));
            EXPECT_EQ(scene.attributes[scene.primitives[0].attributes].color, Rgb(1, 1, 1));
          });
    EXPECT_THAT(messages_, IsEmpty());
  }
}

TEST_F(Delayed, ShareOneStateWhereOnlyTheTransformationDiffers) {
  std::string text;
  for (int k = 0; k < 5; ++k) text += "Translate 1 0 0 " + std::string(kRequest);
  build(text + "Color 1 0 0 " + std::string(kRequest), [&](const Scene& scene) {
    ASSERT_THAT(scene.delayed, SizeIs(6));
    EXPECT_EQ(scene.delayed[0].state, scene.delayed[4].state);
    EXPECT_NE(scene.delayed[0].state, scene.delayed[5].state);
  });
}

TEST_F(Delayed, NumberShadersAndObjectsBehindThoseAround) {
  write("d.rib",
        "Sphere 1 -1 1 360 Surface \"b\" Sphere 1 -1 1 360\n"
        "ObjectBegin \"in\" Sphere 2 -2 2 360 ObjectEnd ObjectInstance \"in\" ObjectInstance \"out\"");
  build("ObjectBegin \"out\" Sphere 1 -1 1 360 ObjectEnd Surface \"a\" " + std::string(kRequest),
        [&](const Scene& scene) {
          const auto inner = load(scene);
          EXPECT_EQ(inner->firstShader, 1u);
          EXPECT_EQ(inner->firstObject, 1u);
          EXPECT_EQ(inner->attributes[inner->primitives.at(0).attributes].surface, 0u);
          EXPECT_EQ(inner->attributes[inner->primitives.at(1).attributes].surface, 1u);
          EXPECT_EQ(inner->shaders.at(0).name, "b");
          EXPECT_EQ(inner->instances.at(0).object, 1u);
          EXPECT_EQ(inner->instances.at(1).object, 0u);
        });
  EXPECT_THAT(messages_, IsEmpty());
}

TEST_F(Delayed, KnowNamesOfTheSceneAround) {
  write("d.rib",
        "Illuminate \"key\" 0 CoordSysTransform \"here\" Sphere 1 -1 1 360 \"tint\" [1 2 3] "
        "ReadArchive \"inline\" IfBegin \"$user:pass == 'beauty'\" Disk 0 1 360 IfEnd");
  build(
      "Declare \"tint\" \"constant vector\" Option \"user\" \"string pass\" \"beauty\"\n"
      "ArchiveBegin \"inline\" Cone 1 1 360 ArchiveEnd LightSource \"l\" \"key\"\n"
      "TransformBegin Translate 7 0 0 CoordinateSystem \"here\" TransformEnd " +
          std::string(kRequest),
      [&](const Scene& scene) {
        const auto inner = load(scene);
        ASSERT_THAT(inner->primitives, SizeIs(3));
        EXPECT_THAT(inner->attributes[inner->primitives[0].attributes].lights, IsEmpty());
        EXPECT_EQ(inner->primitives[0].objectToWorld[3][0], 7);
        EXPECT_EQ(inner->primitives[0].variables.at(0).type, ValueType::Vector);
      });
  EXPECT_THAT(messages_, IsEmpty());
}

TEST_F(Delayed, AreReadAtOnceWhereTheyMustBeKnown) {
  write("d.rib", "Sphere 1 -1 1 360");
  const std::string request(kRequest);
  build("ObjectBegin 1 " + request + "ObjectEnd", [](const Scene& scene) {
    EXPECT_THAT(scene.delayed, IsEmpty());
    EXPECT_THAT(scene.objects.at(0).primitives, SizeIs(1));
  });
  for (const std::string& text :
       {"AreaLightSource \"arealight\" 1 " + request, "SolidBegin \"primitive\" " + request + "SolidEnd",
        std::string("Procedural \"DelayedReadArchive\" [\"d.rib\"] [-1e38 1e38 -1e38 1e38 -1e38 1e38]"),
        std::string("Procedural2 \"DelayedReadArchive2\" \"x\" \"string filename\" [\"d.rib\"]")})
    build(text, [&](const Scene& scene) {
      EXPECT_THAT(scene.delayed, IsEmpty()) << text;
      EXPECT_THAT(scene.primitives, SizeIs(1)) << text;
    });
  EXPECT_THAT(messages_, IsEmpty());
  build("Procedural \"DelayedReadArchive\" [\"d.rib\"] [1 -1 -1 1 -1 1]",
        [](const Scene& scene) { EXPECT_THAT(scene.primitives, SizeIs(1)); });
  EXPECT_THAT(messages_,
              ElementsAre(main_ + ":2:1: warning: range: the bound of delayed archive \"d.rib\" is empty "
                                  "(expected xmin <= xmax and the same for y and z): it is read at once"));
}

TEST_F(Delayed, AreReadAtOnceWhereTheirPlaceMoves) {
  write("d.rib", "Sphere 1 -1 1 360");
  const std::string movement = "MotionBegin [0 1] Translate 0 0 0 Translate 1 0 0 MotionEnd\n";
  build(movement + std::string(kRequest), [](const Scene& scene) {
    EXPECT_THAT(scene.delayed, IsEmpty());
    ASSERT_THAT(scene.primitives, SizeIs(1));
    EXPECT_TRUE(scene.primitives[0].motion);
  });
  build("TransformBegin " + movement + "TransformEnd " + std::string(kRequest),
        [](const Scene& scene) { EXPECT_THAT(scene.delayed, SizeIs(1)); });
  EXPECT_THAT(messages_, IsEmpty());
}

TEST_F(Delayed, InAMotionBlockTheFirstHolds) {
  write("d.rib", "Sphere 1 -1 1 360");
  build("MotionBegin [0 1]\n" + std::string(kRequest) +
            "Procedural \"DelayedReadArchive\" [\"e.rib\"] [-2 2 -2 2 -2 2]\nMotionEnd",
        [&](const Scene& scene) {
          EXPECT_THAT(scene.primitives, IsEmpty());
          EXPECT_THAT(load(scene)->primitives, SizeIs(1));
        });
  EXPECT_THAT(messages_,
              ElementsAre(main_ + ":3:1: warning: unimplemented: Procedural does not change over a "
                                  "motion block: its first values hold (once)"));
}

TEST_F(Delayed, HoldWhatMovesAsItIsAtTheOpening) {
  write("d.rib",
        "MotionBegin [0 1] Translate 2 0 0 Translate 4 0 0 MotionEnd Sphere 1 -1 1 360 MotionBegin [0 1] "
        "Sphere 1 -1 1 360 Sphere 3 -3 3 360 MotionEnd");
  build(
      "Translate 0 1 0 " + std::string(kRequest),
      [&](const Scene& scene) {
        const auto inner = load(scene);
        ASSERT_THAT(inner->primitives, SizeIs(2));
        EXPECT_EQ(inner->primitives[0].objectToWorld[3][0], 3);
        EXPECT_EQ(inner->primitives[0].objectToWorld[3][1], 1);
        EXPECT_FLOAT_EQ(std::get<Quadric>(inner->primitives[1].shape).values[0], 2);
      },
      {}, "Shutter .5 .6\n");
  EXPECT_THAT(messages_, IsEmpty());
}

TEST_F(Delayed, ChangeNoOptions) {
  const std::string inner = write("d.rib",
                                  "Format 8 8 1\nOption \"limits\" \"int geocachememory\" [1]\n"
                                  "ClippingPlane 0 0 1 0 0 1\nShutter 5 6\n"
                                  "Option \"searchpath\" \"string archive\" \"elsewhere\"\n"
                                  "Option \"user\" \"string pass\" \"x\" Sphere 1 -1 1 360");
  build(std::string(kRequest), [&](const Scene& scene) { EXPECT_THAT(load(scene)->primitives, SizeIs(1)); });
  const auto late = [&](int line, const char* request) {
    return StartsWith(inner + ":" + std::to_string(line) + ":1: warning: unimplemented: " + request +
                      " in a delayed archive has no effect: options are those of WorldEnd (once)");
  };
  EXPECT_THAT(
      messages_,
      testing::UnorderedElementsAre(
          late(1, "Format"), late(2, "Option"), late(4, "Shutter"),
          StartsWith(inner + ":3:1: error: illstate: ClippingPlane inside the world block is ignored")));
}

TEST_F(Delayed, HaveNoLightsBySavedStatesOrObjectsOfOthers) {
  const std::string inner =
      write("d.rib",
            "Resource \"lit\" \"attributes\" \"string operation\" \"restore\" \"string subset\" "
            "\"shading\"\nSphere 1 -1 1 360\nObjectInstance \"lamp\"\nObjectInstance \"dark\"");
  build(
      "AttributeBegin AreaLightSource \"arealight\" 1 Resource \"lit\" \"attributes\" \"string operation\" "
      "\"save\" AttributeEnd ObjectBegin \"lamp\" AreaLightSource \"arealight\" 2 Sphere 1 -1 1 360 "
      "ObjectEnd "
      "ObjectBegin \"dark\" Sphere 1 -1 1 360 ObjectEnd\n" +
          std::string(kRequest),
      [&](const Scene& scene) {
        const auto archive = load(scene);
        ASSERT_THAT(archive->primitives, SizeIs(1));
        EXPECT_EQ(archive->attributes[archive->primitives[0].attributes].areaLight, kNone);
        ASSERT_THAT(archive->instances, SizeIs(1));
        EXPECT_EQ(archive->instances[0].object, 1u);
      });
  EXPECT_THAT(messages_,
              ElementsAre(StartsWith(inner + ":1:1: warning: illstate: light \"Resource lit\" in a delayed"),
                          StartsWith(inner + ":3:1: warning: illstate: light \"object lamp\" in a delayed")));
}

TEST_F(Delayed, RunProgramsWithinTheLimitOfAll) {
  write("d.rib", "Procedural \"RunProgram\" [\"echo Sphere 1 -1 1 360\" \"\"] [-1 1 -1 1 -1 1]");
  SceneBuilderSettings settings;
  settings.allowPrograms = true, settings.programRuns = 2;
  size_t primitives = 0;
  build(
      std::string(kRequest) + std::string(kRequest) + std::string(kRequest),
      [&](const Scene& scene) {
        for (const DelayedArchive& archive : scene.delayed)
          primitives += scene.readDelayed(archive, errors_)->primitives.size();
      },
      settings);
  EXPECT_EQ(primitives, 2u);
  ASSERT_THAT(messages_, SizeIs(1));
  EXPECT_THAT(messages_[0], HasSubstr("limitcheck: more than 2 programs run"));
}

TEST_F(Delayed, HaveNoLightsAndEndNoWorld) {
  const std::string inner = write("d.rib",
                                  "LightSource \"l\" 1\nAreaLightSource \"arealight\" 2\nWorldEnd\n"
                                  "AttributeEnd\nAttributeEnd\nSphere 1 -1 1 360");
  build("Color 1 0 0 " + std::string(kRequest), [&](const Scene& scene) {
    const auto archive = load(scene);
    ASSERT_THAT(archive->primitives, SizeIs(1));
    const Attributes& attributes = archive->attributes[archive->primitives[0].attributes];
    EXPECT_EQ(attributes.color, Rgb(1, 0, 0));
    EXPECT_EQ(attributes.areaLight, kNone);
    EXPECT_THAT(attributes.lights, IsEmpty());
    EXPECT_THAT(archive->lights, IsEmpty());
  });
  const std::string left =
      " in a delayed archive is left out: lights must be known before rays are traced (ReadArchive reads at "
      "once)";
  EXPECT_THAT(messages_,
              ElementsAre(StartsWith(inner + ":1:1: warning: illstate: light \"l\"" + left),
                          StartsWith(inner + ":2:1: warning: illstate: light \"arealight\"" + left),
                          StartsWith(inner + ":3:1: error: nesting: WorldEnd in a delayed archive"),
                          StartsWith(inner + ":5:1: error: nesting: AttributeEnd without AttributeBegin")));
}

TEST_F(Delayed, WithinEachOtherAreDelayedAgain) {
  write(
      "d.rib",
      "Surface \"a\" CoordinateSystem \"mine\" ObjectBegin \"o\" Sphere 1 -1 1 360 ObjectEnd Translate 1 0 0 "
      "Procedural \"DelayedReadArchive\" [\"e.rib\"] [-1 1 -1 1 -1 1]");
  write("e.rib", "Translate 1 0 0 Sphere 1 -1 1 360 CoordSysTransform \"mine\" ObjectInstance \"o\"");
  std::shared_ptr<const Scene> outer;
  build("Translate 1 0 0 " + std::string(kRequest), [&](const Scene& scene) {
    outer = load(scene);
    const auto inner = load(*outer);
    EXPECT_THAT(outer->primitives, IsEmpty());
    ASSERT_THAT(inner->primitives, SizeIs(1));
    EXPECT_EQ(inner->primitives[0].objectToWorld[3][0], 3);
    EXPECT_EQ(inner->attributes[inner->primitives[0].attributes].surface, outer->firstShader);
    EXPECT_EQ(inner->instances.at(0).object, outer->firstObject);
    EXPECT_EQ(inner->instances.at(0).objectToWorld[3][0], 1);
  });
  EXPECT_THAT(messages_, IsEmpty());
}

TEST_F(Delayed, ThatReadThemselvesEnd) {
  const std::string loop = write("d.rib", "Sphere 1 -1 1 360\n" + std::string(kRequest));
  build(std::string(kRequest), [&](const Scene& scene) { checkDelayed(scene, errors_); });
  EXPECT_THAT(messages_, ElementsAre(AllOf(
                             StartsWith(loop + ":2:1: error: badfile: archive \"d.rib\" would read itself: " +
                                        main_ + " -> " + loop + " -> " + loop),
                             HasSubstr("of " + loop + ":2:1"))));
}

TEST_F(Delayed, AreCountedAndLimited) {
  // Each asks for the next ten times: 10^6 readings without a limit.
  const std::string bound = " [-1 1 -1 1 -1 1]\n";
  for (int i = 0; i < 6; ++i) {
    std::string text;
    for (int k = 0; k < 10; ++k)
      text += "Procedural \"DelayedReadArchive\" [\"a" + std::to_string(i + 1) + ".rib\"]" + bound;
    write("a" + std::to_string(i) + ".rib", text);
  }
  write("a6.rib", "Sphere 1 -1 1 360\n");
  resetStatistics();
  SceneBuilderSettings settings;
  settings.archiveReads = 500;
  build(
      "Procedural \"DelayedReadArchive\" [\"a0.rib\"]" + bound,
      [&](const Scene& scene) { checkDelayed(scene, errors_); }, settings);
  EXPECT_THAT(messages_.at(0), HasSubstr("limitcheck: more than 500 archives read"));
  const auto counters = statistics();
  const auto read = std::ranges::find(counters, "Delayed archives/read", &StatEntry::name);
  ASSERT_NE(read, counters.end());
  EXPECT_EQ(read->value, 500);
}

TEST_F(Delayed, AreDeepOnlyToALimit) {
  for (int i = 0; i < 80; ++i)
    write("a" + std::to_string(i) + ".rib",
          "Procedural \"DelayedReadArchive\" [\"a" + std::to_string(i + 1) + ".rib\"] [-1 1 -1 1 -1 1]");
  build("Procedural \"DelayedReadArchive\" [\"a0.rib\"] [-1 1 -1 1 -1 1]",
        [&](const Scene& scene) { checkDelayed(scene, errors_); });
  EXPECT_THAT(messages_, ElementsAre(StartsWith((folder_ / "a62.rib").string() +
                                                ":1:1: error: limitcheck: delayed archives are nested more "
                                                "than 64 deep")));
}

}  // namespace
}  // namespace patina
