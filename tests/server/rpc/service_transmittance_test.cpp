// Light that arrives in part, over the wire: a lamp over a tank of ink under a pane of glass.
#include <gmock/gmock.h>

#include <cmath>

#include "lights/maths/rgb.h"
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
    rpc::ServerOptions options = scenes_in(files_.path());
    service_.emplace(options);
    id_ = service_->load("tank.pbrt");
  }

  v1::TestVisibilityResponse see(v1::ThinGlass thin_glass) {
    auto q = about<v1::TestVisibilityRequest>(id_);
    q.mutable_accuracy()->set_thin_glass(thin_glass);
    // Through 1 m of ink and the pane; past both; through the floor.
    set(q.mutable_segments()->mutable_from()->mutable_offsets_m(), 0, 0, 0.25, 2, 0, 1, 0, 0, 1.5);
    set(q.mutable_segments()->mutable_to()->mutable_offsets_m(), 0, 0, 2.5, 2, 0, 3, 0, 0, -1);
    return service_->answer(q);
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
  auto q = about<v1::SampleLiRequest>(id_);
  q.set_test_visibility(true);
  set(q.mutable_receivers()->mutable_offsets_m(), 0, 0, 0.25);
  set(q.mutable_normals(), 0, 0, 1);
  auto r = service_->answer(q);
  const double lx = 100 / (2.75 * 2.75);
  EXPECT_NEAR(r.value(1), lx, 1e-4);
  ASSERT_EQ(r.transmittance_size(), 3);
  EXPECT_NEAR(r.transmittance(1), kPane * std::exp(-0.75), 1e-6);

  q.mutable_accuracy()->mutable_target_error()->set_relative(0.01);
  r.Clear();
  r = service_->answer(q);
  const auto left = [&](double absorption) { return lx * kPane * std::exp(-0.75 * absorption); };
  EXPECT_NEAR(r.estimates().illuminance_lx(0), luminance(Rgb(left(.5), left(1), left(2))), 1e-4);

  q.clear_accuracy();
  q.set_test_visibility(false);
  r.Clear();
  r = service_->answer(q);
  EXPECT_EQ(r.transmittance_size(), 0);
}

TEST_F(TransmittanceService, WavelengthsNeedMediaWithoutColour) {
  auto q = about<v1::EstimateIrradianceRequest>(id_);
  q.set_bounces(0);
  set(q.mutable_receivers()->mutable_offsets_m(), 0, 0, 0.25);
  set(q.mutable_normals(), 0, 0, 1);
  q.add_wavelengths_nm(555);
  expect_error(service_->status(q), grpc::StatusCode::INVALID_ARGUMENT, "its media have a colour");
}

TEST_F(TransmittanceService, UnknownWaysAreErrors) {
  auto q = about<v1::TestVisibilityRequest>(id_);
  q.mutable_segments();
  q.mutable_accuracy()->set_thin_glass(static_cast<v1::ThinGlass>(7));
  expect_error(service_->status(q), grpc::StatusCode::INVALID_ARGUMENT, "accuracy.thin_glass");
}

TEST(Transmittance, ScenesWithoutMediaAndPanesAnswerBitsOnly) {
  Service service;
  auto q = about<v1::TestVisibilityRequest>(service.load("point.pbrt"));
  set(q.mutable_segments()->mutable_from()->mutable_offsets_m(), 0, 0, 1);
  set(q.mutable_segments()->mutable_to()->mutable_offsets_m(), 0, 0, 2);
  const auto r = service.answer(q);
  EXPECT_EQ(r.transmittance_size(), 0);
}

}  // namespace
}  // namespace lucerna::testing
