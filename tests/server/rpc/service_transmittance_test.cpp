// Light that arrives in part, over the wire: a lamp over a tank of ink under a pane of glass.
#include <gmock/gmock.h>

#include <cmath>

#include "lights/spectra/rgb.h"
#include "service_fixture.h"
#include "tests/server/pbrt/pbrt_fixture.h"

namespace lucerna::testing {
namespace {

constexpr char kTank[] = R"(WorldBegin
MakeNamedMedium "ink" "string type" "homogeneous" "rgb sigma_a" [.5 1 2] "rgb sigma_s" [0 0 0]
LightSource "point" "rgb I" [100 100 100] "point3 from" [0 0 3]
Shape "bilinearmesh" "point3 P" [-9 -9 0  9 -9 0  -9 9 0  9 9 0]
AttributeBegin
  MediumInterface "ink" ""
  Material "interface"
  Shape "sphere" "float radius" 1
AttributeEnd
AttributeBegin
  Material "thindielectric"
  Shape "bilinearmesh" "point3 P" [-9 -9 2  0.5 -9 2  -9 9 2  0.5 9 2]
AttributeEnd
)";
constexpr double kPane = 1 - 0.08 / 1.04;  // 1 - 2 R / (1 + R), R = 0.04

class TransmittanceService : public ::testing::Test {
 protected:
  TransmittanceService() {
    files_.write("tank.pbrt", kTank);
    rpc::ServerOptions options = service_options();
    options.scenes.root = files_.path().string();
    service_.emplace(options);
    id_ = service_->load("tank.pbrt");
  }

  v1::TestVisibilityResponse see(v1::ThinGlass thin_glass) {
    v1::TestVisibilityRequest q;
    q.set_scene_id(id_);
    q.mutable_accuracy()->set_thin_glass(thin_glass);
    // Through 1 m of ink and the pane; past both; through the floor.
    set(q.mutable_segments()->mutable_from()->mutable_offsets_m(), 0, 0, 0.25, 2, 0, 1, 0, 0, 1.5);
    set(q.mutable_segments()->mutable_to()->mutable_offsets_m(), 0, 0, 2.5, 2, 0, 3, 0, 0, -1);
    v1::TestVisibilityResponse r;
    const grpc::Status s =
        status_of([&](auto* c) { return service_->lighting.TestVisibility(c, q, &r); });
    EXPECT_TRUE(s.ok()) << s.error_message();
    return r;
  }

  SceneFiles files_;
  std::optional<Service> service_;
  std::string id_;
};

TEST_F(TransmittanceService, TestVisibilityAnswersTheShareOfEachChannel) {
  const v1::TestVisibilityResponse r = see(v1::THIN_GLASS_UNSPECIFIED);
  EXPECT_EQ(r.visible(), std::string(1, '\x3'));
  ASSERT_EQ(r.transmittance_size(), 9);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(r.transmittance(c), kPane * std::exp(-0.75 * (0.5 * std::exp2(c))), 1e-6);
    EXPECT_EQ(r.transmittance(3 + c), 1);
    EXPECT_EQ(r.transmittance(6 + c), 0);
  }
  EXPECT_EQ(r.cost().through_thin_glass(), 1U);
}

TEST_F(TransmittanceService, ThinGlassBlocksIfItIsAskedTo) {
  const v1::TestVisibilityResponse r = see(v1::THIN_GLASS_BLOCKS);
  EXPECT_EQ(r.visible(), std::string(1, '\x2'));
  EXPECT_EQ(r.transmittance_size(), 9);
  EXPECT_EQ(r.cost().through_thin_glass(), 0U);
}

TEST_F(TransmittanceService, SamplesHaveTheirShareAndEstimatesCountIt) {
  v1::SampleLiRequest q;
  q.set_scene_id(id_);
  q.set_test_visibility(true);
  set(q.mutable_receivers()->mutable_offsets_m(), 0, 0, 0.25);
  set(q.mutable_normals(), 0, 0, 1);
  v1::SampleLiResponse r;
  ASSERT_TRUE(status_of([&](auto* c) { return service_->lighting.SampleLi(c, q, &r); }).ok());
  const double lx = 100 / (2.75 * 2.75);
  EXPECT_NEAR(r.value(1), lx, 1e-4);
  ASSERT_EQ(r.transmittance_size(), 3);
  EXPECT_NEAR(r.transmittance(1), kPane * std::exp(-0.75), 1e-6);

  q.mutable_accuracy()->mutable_target_error()->set_relative(0.01);
  r.Clear();
  ASSERT_TRUE(status_of([&](auto* c) { return service_->lighting.SampleLi(c, q, &r); }).ok());
  const auto left = [&](double absorption) { return lx * kPane * std::exp(-0.75 * absorption); };
  EXPECT_NEAR(r.estimates().illuminance_lx(0), luminance(Rgb(left(.5), left(1), left(2))), 1e-4);

  q.clear_accuracy();
  q.set_test_visibility(false);
  r.Clear();
  ASSERT_TRUE(status_of([&](auto* c) { return service_->lighting.SampleLi(c, q, &r); }).ok());
  EXPECT_EQ(r.transmittance_size(), 0);
}

TEST_F(TransmittanceService, WavelengthsNeedMediaWithoutColour) {
  v1::EstimateIrradianceRequest q;
  q.set_scene_id(id_);
  q.set_bounces(0);
  set(q.mutable_receivers()->mutable_offsets_m(), 0, 0, 0.25);
  set(q.mutable_normals(), 0, 0, 1);
  q.add_wavelengths_nm(555);
  v1::EstimateIrradianceResponse r;
  const grpc::Status s =
      status_of([&](auto* c) { return service_->lighting.EstimateIrradiance(c, q, &r); });
  EXPECT_EQ(s.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_THAT(s.error_message(), ::testing::HasSubstr("its media have a colour"));
}

TEST_F(TransmittanceService, UnknownWaysAreErrors) {
  v1::TestVisibilityRequest q;
  q.set_scene_id(id_);
  q.mutable_segments();
  q.mutable_accuracy()->set_thin_glass(static_cast<v1::ThinGlass>(7));
  v1::TestVisibilityResponse r;
  const grpc::Status s =
      status_of([&](auto* c) { return service_->lighting.TestVisibility(c, q, &r); });
  EXPECT_EQ(s.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_THAT(s.error_message(), ::testing::HasSubstr("accuracy.thin_glass"));
}

TEST(Transmittance, ScenesWithoutMediaAndPanesAnswerBitsOnly) {
  Service service;
  v1::TestVisibilityRequest q;
  q.set_scene_id(service.load("point.pbrt"));
  set(q.mutable_segments()->mutable_from()->mutable_offsets_m(), 0, 0, 1);
  set(q.mutable_segments()->mutable_to()->mutable_offsets_m(), 0, 0, 2);
  v1::TestVisibilityResponse r;
  ASSERT_TRUE(status_of([&](auto* c) { return service.lighting.TestVisibility(c, q, &r); }).ok());
  EXPECT_EQ(r.transmittance_size(), 0);
}

}  // namespace
}  // namespace lucerna::testing
