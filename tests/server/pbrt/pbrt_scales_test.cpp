// Errors of lights under transforms that stretch.
#include "server/pbrt/pbrt_scales.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/server/pbrt/pbrt_fixture.h"

namespace lucerna {
namespace {

using testing::world_error_of;

/// x' = x + y.  Its singular values are those of ((1, 1), (0, 1)), the golden ratio and its
/// inverse.
const std::string kShear = "ConcatTransform [1 0 0 0  1 1 0 0  0 0 1 0  0 0 0 1]";

TEST(PbrtScales, AreSingularValues) {
  const auto of = [](const Transform& t) { return pbrt::scales_text(t); };
  EXPECT_EQ(of(Transform()), "scales 1, 1 and 1");
  EXPECT_EQ(of(*Transform::scale({3, -0.5, 2})), "scales 0.5, 2 and 3");
  EXPECT_EQ(of(*Transform::from_matrix({{{1, 1, 0, 7}, {0, 1, 0, 8}, {0, 0, 1, 9}}})),
            "scales 0.61803399, 1 and 1.618034");
  // Rotations before and after it change nothing, and no column has the length of a singular value.
  EXPECT_EQ(of(*Transform::rotate(0.7, {1, 2, 3}) * *Transform::scale({3, 0.5, 2}) *
               *Transform::rotate(1.1, {3, -2, 1})),
            "scales 0.5, 2 and 3");
  EXPECT_EQ(of(*Transform::scale({1e200, 1e-100, 1})), "scales 1e-100, 1 and 1e+200");
}

TEST(PbrtScales, AreInTheErrorOfALightThatNeedsEqualOnes) {
  const std::pair<std::string, std::string> kLights[] = {
      {"LightSource \"infinite\" \"string filename\" \"sky.pfm\" \"string filter\" \"bilinear\" "
       "\"point3 portal\" [0 0 3 0 1 3 2 1 3 2 0 3]",
       "2:1: a filtered or latitude-longitude picture behind a portal"},
      {"LightSource \"distant\" \"float angulardiameter\" 1", "2:23: \"float angulardiameter\""},
  };
  for (const auto& [light, what] : kLights) {
    const auto error = [&](const std::string& transform) {
      return world_error_of(transform + "\n" + light);
    };
    const auto expected = [&](const std::string& scales) {
      return "scene.pbrt:" + what + " under a transform of unequal scales " + scales +
             ", allowed: equal scale on all axes";
    };
    EXPECT_EQ(error("Scale 1 -1 2.5"), expected("1, 1 and 2.5"));
    EXPECT_EQ(error("Scale 1 1 1.00001"), expected("1, 1 and 1.00001"));
    EXPECT_EQ(error(kShear), expected("0.61803399, 1 and 1.618034"));
  }
}

TEST(PbrtScales, AreInTheErrorOfAShearedProjection) {
  const std::string beam = "LightSource \"projection\" \"string projection\" \"orthographic\"";
  EXPECT_EQ(world_error_of(kShear + "\n" + beam),
            "scene.pbrt:2:1: an orthographic projection under a transform that shears, scales "
            "0.61803399, 1 and "
            "1.618034 along other axes than the light's own, allowed: rotations, mirrors, and "
            "scale along these");
  EXPECT_EQ(world_error_of("Rotate 30 1 2 3 Scale 3 1 2\nLightSource \"projection\""), "");
}

}  // namespace
}  // namespace lucerna
