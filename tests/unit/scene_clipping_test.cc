// SPDX-License-Identifier: Apache-2.0
// ClippingPlane: planes in camera space, checked.
#include "renderer/scene/matrices.h"
#include "scene_fixture.h"

namespace patina {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

TEST(ClippingPlane, IsTakenToCameraSpace) {
  // Current space is (x, 2y, z + 5) of the camera's: the plane y + z = 1 there, whose normal keeps
  // perpendicular.
  const Built built = buildClean(
      "ClippingPlane 0 0 3 0 0 7 Translate 0 0 5 Scale 1 2 1 ClippingPlane 0 1 0 0 1 1 WorldBegin WorldEnd");
  const auto& planes = built.world().camera.clippingPlanes;
  ASSERT_THAT(planes, SizeIs(2));
  EXPECT_NEAR((planes[0].normal - V3d(0, 0, 1)).length(), 0, 1e-12);
  EXPECT_NEAR(planes[0].offset, 3, 1e-12);
  const V3d normal = V3d(0, 0.5, 1).normalized();
  EXPECT_NEAR((planes[1].normal - normal).length(), 0, 1e-12);
  for (const V3d& on : {V3d(0, 2, 5), V3d(0, 0, 6), V3d(-3, 4, 4)})
    EXPECT_NEAR(planes[1].normal.dot(on), planes[1].offset, 1e-12);
}

TEST(ClippingPlane, WrongOnesAreNotTaken) {
  const Built built = build(
      "ClippingPlane 0 0 0 0 0 0\nFrameBegin 1 ClippingPlane 0 0 1 1 0 0 FrameEnd\nConcatTransform [1 0 0 0 "
      "0 1 0 0 0 0 1 1 0 0 0 1] ClippingPlane "
      "0 0 0 0 0 1\n"
      "Identity WorldBegin\nClippingPlane 0 0 0 0 0 1\nWorldEnd");
  EXPECT_THAT(
      built.messages,
      ElementsAre("t.rib:1:1: error: range: ClippingPlane: expected a point and a normal that is not 0, both "
                  "finite",
                  testing::HasSubstr("error: math: ClippingPlane under a transformation"),
                  "t.rib:5:1: error: illstate: ClippingPlane inside the world block is ignored"));
  EXPECT_THAT(built.world().camera.clippingPlanes, IsEmpty()) << "a frame's end with it";
}

}  // namespace
}  // namespace patina
