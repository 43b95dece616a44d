#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/server/scene/scenes.h"

namespace lucerna::testing {
namespace {

/// A window of 1 m in the plane x = 0, whose light comes from -x, and a floor from `x0` to 3 m.
std::shared_ptr<const Scene> room_from(double x0) {
  SceneDescription d = description();
  d.shapes = {patch({x0, -2, 0}, {3, -2, 0}, {x0, 2, 0}, {3, 2, 0})};
  PortalLightParams portal;
  portal.radiance_cd_m2 = Rgb(1000);
  portal.corners_m = {Vec3{0, 0, 1}, {0, 1, 1}, {0, 1, 2}, {0, 0, 2}};
  d.lights = {{portal, {"test.pbrt", 9, 1}}};
  return build(std::move(d));
}

TEST(PortalRemarks, CountShapesOutdoorsAndTheIlluminanceTheyLose) {
  EXPECT_TRUE(room_from(0)->report().remarks.empty());
  EXPECT_TRUE(room_from(-0.2)->report().remarks.empty());  // the sill
  const auto scene = room_from(-4);
  ASSERT_EQ(scene->report().remarks.size(), 1U);
  const Remark& remark = scene->report().remarks[0];
  EXPECT_EQ(remark.where.line, 9);
  EXPECT_THAT(remark.what, ::testing::HasSubstr("1 of 1 shapes reach outdoors"));
  // pi times the luminance.
  EXPECT_THAT(remark.instead, ::testing::HasSubstr("3142 lx"));
}

}  // namespace
}  // namespace lucerna::testing
