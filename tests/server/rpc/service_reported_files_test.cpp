// Files that people reported, with their answers by hand.
#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "service_fixture.h"

namespace lucerna::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double kPi = std::numbers::pi;

class ReportedFiles : public ::testing::Test {
 protected:
  static rpc::ServerOptions options() { return scenes_in(test_data("reported")); }

  v1::LoadSceneResponse load(const std::string& path) {
    v1::LoadSceneRequest q;
    q.set_path(path);
    return service_.answer(q);
  }

  double power_lm(const std::string& scene) {
    const auto r = service_.answer(about<v1::EstimatePowerRequest>(scene));
    return r.total().power_lm();
  }

  /// Without reflections [lx].
  double illuminance_lx(const std::string& scene, const Vec3& point, const Vec3& normal,
                        const v1::Accuracy& accuracy = {}) {
    auto q = about<v1::EstimateIrradianceRequest>(scene);
    set(q.mutable_receivers()->mutable_offsets_m(), point.x, point.y, point.z);
    set(q.mutable_normals(), normal.x, normal.y, normal.z);
    q.set_bounces(0);
    q.mutable_seed()->set_seed(1);
    *q.mutable_accuracy() = accuracy;
    const auto r = service_.answer(q);
    return r.irradiance_lx_size() == 3 ? r.irradiance_lx(1) : kNan;
  }

  Service service_{options()};
};

// A sphere of radius 1 m and 50 cd/m2 at 5 m: pi L (r / d)^2 = pi 50 / 25.
TEST_F(ReportedFiles, AnAreaLightWithoutAlphaIsInvisibleAndShines) {
  const v1::LoadSceneResponse loaded = load("alpha0_area_light.pbrt");
  EXPECT_THAT(loaded.remarks(), IsEmpty());
  EXPECT_NEAR(power_lm(loaded.scene_id()), kPi * 50 * 4 * kPi, 1e-3);
  constexpr double kLux = kPi * 50 / 25;
  EXPECT_NEAR(illuminance_lx(loaded.scene_id(), {0, 0, 0}, {0, 0, 1}), kLux, 1e-5);
  for (const v1::Combination how :
       {v1::COMBINATION_POWER_HEURISTIC, v1::COMBINATION_BALANCE_HEURISTIC, v1::COMBINATION_LIGHTS,
        v1::COMBINATION_SURFACES}) {
    v1::Accuracy accuracy;
    accuracy.set_samples(4096);
    accuracy.set_combination(how);
    accuracy.set_closed_forms(v1::CLOSED_FORMS_OFF);
    // Sampled within a cone of directions; the error of 4096 even samples is far below 0.1%.
    EXPECT_NEAR(illuminance_lx(loaded.scene_id(), {0, 0, 0}, {0, 0, 1}, accuracy), kLux,
                1e-3 * kLux)
        << how;
  }
}

TEST_F(ReportedFiles, AnInvisibleLightIsMetByNoRay) {
  const std::string scene = load("alpha0_area_light.pbrt").scene_id();
  auto le = about<v1::LeRequest>(scene);
  set(le.mutable_points()->mutable_offsets_m(), 0, 0, 0);
  set(le.mutable_directions(), 0, 0, 1);
  const auto radiance = service_.answer(le);
  EXPECT_EQ(radiance.radiance_cd_m2(1), 0);
  EXPECT_EQ(radiance.light_ids(0), 0U);
  auto through = about<v1::TestVisibilityRequest>(scene);
  set(through.mutable_segments()->mutable_from()->mutable_offsets_m(), 0, 0, 1);
  set(through.mutable_segments()->mutable_to()->mutable_offsets_m(), 0, 0, 9);
  const auto seen = service_.answer(through);
  EXPECT_EQ(seen.visible(), std::string(1, '\1'));
  const auto lights = service_.answer(about<v1::ListLightsRequest>(scene));
  EXPECT_TRUE(lights.lights(0).diffuse_area().invisible());
}

TEST_F(ReportedFiles, AnInvisibleLightThatAnEditMovesStaysInvisible) {
  const std::string scene = load("alpha0_area_light.pbrt").scene_id();
  auto edit = about<v1::EditLightsRequest>(scene);
  v1::LightChange* change = edit.add_edits()->mutable_change();
  change->set_light_id(1);
  change->set_scale(2);
  change->mutable_placement()->mutable_shift_m()->set_z(5);
  const auto edited = service_.answer(edit);
  EXPECT_NEAR(illuminance_lx(edited.scene_id(), {0, 0, 0}, {0, 0, 1}), kPi * 100 / 100, 1e-5);
  EXPECT_NEAR(illuminance_lx(edited.scene_id(), {0, 0, 20}, {0, 0, -1}), kPi * 100 / 100, 1e-5);
}

// The cone is round in the light's own space: cos = (M^-1 w) . a / |M^-1 w|.  Flux by a sum over
// 720 000 directions.
TEST_F(ReportedFiles, ASpotUnderUnequalScaleIsThatOfPbrt4) {
  const v1::LoadSceneResponse loaded = load("spot_unequal_scale.pbrt");
  EXPECT_THAT(loaded.remarks(), IsEmpty());
  const std::string& scene = loaded.scene_id();
  EXPECT_NEAR(illuminance_lx(scene, {1.3, 0, 0}, {0, 0, 1}), 1.8365472910927458, 1e-6);
  EXPECT_NEAR(illuminance_lx(scene, {0, 1.05, 0}, {0, 0, 1}),
              1.4572925233096683 * 0.8921363016407753, 1e-6);
  EXPECT_NEAR(illuminance_lx(scene, {0, -1.4, 0}, {0, 0, 1}),
              0.2942422424082923 * 0.8654295830026705, 1e-6);
  EXPECT_EQ(illuminance_lx(scene, {0, 3, 0}, {0, 0, 1}), 0);
  EXPECT_NEAR(power_lm(scene), 12.7535, 2e-3);
}

// A square of 4 m2 and 1 cd/m2, one-sided: 4 pi lm.
TEST_F(ReportedFiles, AFaceWithoutCornersIsLeftOut) {
  const v1::LoadSceneResponse loaded = load("ply_empty_face.pbrt");
  EXPECT_NEAR(power_lm(loaded.scene_id()), 4 * kPi, 1e-5);
  ASSERT_EQ(loaded.remarks_size(), 1);
  EXPECT_EQ(loaded.remarks(0).what(),
            "1 faces of mesh \"ply_empty_face.ply\" have fewer than 3 corners");
}

// A square of 4 m2 and 5 cd/m2.
TEST_F(ReportedFiles, AnEmissiveFactorAboveOneIsUsedAsGiven) {
  const v1::LoadSceneResponse loaded = load("gltf_emissive_above_1.gltf");
  EXPECT_NEAR(power_lm(loaded.scene_id()), 20 * kPi, 1e-4);
  std::string whats;
  for (const v1::Remark& remark : loaded.remarks()) whats += remark.what() + "\n";
  EXPECT_THAT(whats, HasSubstr("an emissiveFactor of 5, 5 and 5, which glTF limits to 1"));
}

}  // namespace
}  // namespace lucerna::testing
