// EstimateIrradiance flags receivers inside of solids.
#include "service_fixture.h"
#include "tests/server/pbrt/pbrt_fixture.h"

namespace lucerna::testing {
namespace {

// A lamp above a floor with a cube of side 1 on it, normals outwards.
constexpr char kCube[] = R"(WorldBegin
LightSource "point" "rgb I" [100 100 100] "point3 from" [0 0 3]
Shape "bilinearmesh" "point3 P" [-9 -9 0  9 -9 0  -9 9 0  9 9 0]
Shape "trianglemesh"
  "point3 P" [-.5 -.5 0  .5 -.5 0  -.5 .5 0  .5 .5 0  -.5 -.5 1  .5 -.5 1  -.5 .5 1  .5 .5 1]
  "integer indices" [0 4 6 0 6 2  1 3 7 1 7 5  0 1 5 0 5 4  2 6 7 2 7 3  0 2 3 0 3 1  4 5 7 4 7 6]
)";

class InsideSolidService : public ::testing::Test {
 protected:
  v1::EstimateIrradianceResponse estimate(v1::EstimateIrradianceRequest request) {
    files_.write("cube.pbrt", kCube);
    Service service(scenes_in(files_.path()));
    request.set_scene_id(service.load("cube.pbrt"));
    // In the cube, above it, beside it facing down, not finite.
    set(request.mutable_receivers()->mutable_offsets_m(), 0, 0, 0.5, 0, 0, 1.5, 2, 0, 0.5, NAN, 0,
        0);
    set(request.mutable_normals(), 0, 0, 1, 0, 0, 1, 0, 0, -1, 0, 0, 1);
    return service.answer(request);
  }

  SceneFiles files_;
};

TEST_F(InsideSolidService, ReceiversInsideAreFlaggedAndKeepTheirNumbers) {
  for (const bool direct : {true, false}) {
    v1::EstimateIrradianceRequest request;
    if (direct) request.set_bounces(0);
    const v1::EstimateIrradianceResponse r = estimate(request);
    ASSERT_EQ(r.status_size(), 4) << direct;
    EXPECT_EQ(r.status(0), v1::ITEM_STATUS_INSIDE_SOLID) << direct;
    EXPECT_EQ(r.status(1), v1::ITEM_STATUS_OK) << direct;
    EXPECT_EQ(r.status(2), v1::ITEM_STATUS_OK) << direct;
    EXPECT_EQ(r.status(3), v1::ITEM_STATUS_INVALID_INPUT) << direct;
    EXPECT_EQ(r.illuminance_lx(0), 0) << direct;
    EXPECT_GT(r.illuminance_lx(1), 40) << direct;  // 100 cd at 1.5 m: 44 lx
    EXPECT_EQ(r.illuminance_lx(2) == 0, direct);
  }
}

TEST_F(InsideSolidService, TheRaysOfTheTestAreNotCounted) {
  v1::EstimateIrradianceRequest request;
  request.set_bounces(0);
  // Three receivers, one lamp: one shadow ray each unless the lamp is behind.
  EXPECT_LE(estimate(request).cost().shadow_rays(), 3U);
}

}  // namespace
}  // namespace lucerna::testing
