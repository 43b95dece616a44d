#include <cmath>
#include <limits>

#include "service_fixture.h"

namespace lucerna::testing {
namespace {

class LightingServiceTest : public ::testing::Test {
 protected:
  v1::SampleLiRequest sample_request() const {
    auto q = about<v1::SampleLiRequest>(point_);
    q.set_light_id(1);
    set(q.mutable_receivers()->mutable_offsets_m(), 1.2, -1.5, 0.2);
    set(q.mutable_u()->mutable_u(), 0.5, 0.5);
    return q;
  }

  Service service_;
  std::string point_ = service_.load("point.pbrt");  // 10 cd at (1.2, -1.5, 3.2)
};

TEST_F(LightingServiceTest, SampleLiAnswersWithValueDirectionAndCost) {
  v1::SampleLiRequest q = sample_request();
  q.set_test_visibility(true);
  const auto r = service_.answer(q);
  EXPECT_NEAR(r.value(0), 10.0 / 9, 1e-6);  // 10 cd / (3 m)^2
  EXPECT_NEAR(r.wi(2), 1, 1e-6);
  EXPECT_NEAR(r.distance_m(0), 3, 1e-6);
  EXPECT_EQ(r.delta(), std::string(1, '\1'));
  EXPECT_EQ(r.visible(), std::string(1, '\1'));
  EXPECT_EQ(r.light_ids_size(), 0);  // the light was named
  EXPECT_EQ(r.status_size(), 0);     // all items are ok
  EXPECT_EQ(r.cost().samples(), 1U);
  EXPECT_EQ(r.cost().shadow_rays(), 1U);
}

TEST_F(LightingServiceTest, EmptyBatchesAreAnsweredWithNothing) {
  v1::SampleLiRequest q = sample_request();
  q.mutable_receivers()->clear_offsets_m();
  q.mutable_u()->clear_u();
  const auto r = service_.answer(q);
  EXPECT_EQ(r.value_size(), 0);
  EXPECT_TRUE(service_.status(about<v1::EstimateIrradianceRequest>(point_)).ok());
  auto v = about<v1::TestVisibilityRequest>(point_);
  v.mutable_segments();
  const auto vr = service_.answer(v);
  EXPECT_EQ(vr.count(), 0U);
}

TEST_F(LightingServiceTest, SamplesWithoutValuesAndSeedHaveSeedZero) {
  v1::SampleLiRequest q = sample_request();
  q.clear_u();
  auto unset = service_.answer(q);
  q.mutable_seed()->set_seed(0);
  auto zero = service_.answer(q);
  q.mutable_seed()->set_seed(1);
  auto one = service_.answer(q);
  for (v1::SampleLiResponse* r : {&unset, &zero, &one}) r->clear_cost();
  EXPECT_EQ(unset.SerializeAsString(), zero.SerializeAsString());
}

TEST_F(LightingServiceTest, BadFieldsAreNamedWithTheirValue) {
  expect_bad_fields<v1::SampleLiRequest>(
      service_, sample_request(),
      {{"receivers.origin_m.y",
        [](auto& q) { q.mutable_receivers()->mutable_origin_m()->set_y(kNan); }},
       {"receivers.offsets_m", [](auto& q) { q.mutable_receivers()->add_offsets_m(1); }},
       {"u.u", [](auto& q) { q.mutable_u()->add_u(0.5F); }},
       {"u.u[1]", [](auto& q) { q.mutable_u()->set_u(1, 1.5F); }},
       {"u.u_light", [](auto& q) { q.clear_light_id(); }},
       {"u.u_light[0]", [](auto& q) { q.clear_light_id(), q.mutable_u()->add_u_light(1.0); }},
       {"position_error_m", [](auto& q) { q.set_position_error_m(-1); }},
       {"normals", [](auto& q) { q.add_normals(1); }},
       {"accuracy.samples", [](auto& q) { q.mutable_accuracy()->set_samples(0); }}});
  EXPECT_TRUE(service_.status(sample_request()).ok());
}

TEST_F(LightingServiceTest, UnknownScenesAndLightsAreNotFound) {
  v1::SampleLiRequest q = sample_request();
  q.set_scene_id("nonsense");
  EXPECT_EQ(service_.status(q).error_code(), grpc::StatusCode::NOT_FOUND);
  q = sample_request();
  q.set_light_id(99);
  expect_error(service_.status(q), grpc::StatusCode::NOT_FOUND, "", "NO_SUCH_LIGHT");
}

TEST_F(LightingServiceTest, ATooLargeBatchIsResourceExhaustedWithoutARetryDelay) {
  v1::SampleLiRequest q = sample_request();
  q.mutable_receivers()->mutable_offsets_m()->Resize(3 * 65537, 0);
  const grpc::Status s = service_.status(q);
  EXPECT_EQ(s.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_FALSE(detail<google::rpc::RetryInfo>(s).has_retry_delay());
}

TEST_F(LightingServiceTest, BitsDependNeitherOnThreadsNorOnSplits) {
  auto q = about<v1::SampleLiRequest>(service_.load("many_points.pbrt"));
  q.set_test_visibility(true);
  q.mutable_seed()->set_seed(3);
  for (int i = 0; i < 6000; ++i) {
    for (const float x : {0.001F * float(i), -1.0F, 1.0F}) q.mutable_receivers()->add_offsets_m(x);
  }
  auto whole = service_.answer(q);
  rpc::ServerOptions one = service_options();
  one.lanes.threads = 1;
  Service alone(one);
  alone.load("many_points.pbrt");
  auto other = alone.answer(q);
  whole.clear_cost();
  other.clear_cost();
  EXPECT_EQ(whole.SerializeAsString(), other.SerializeAsString());

  auto* offsets = q.mutable_receivers()->mutable_offsets_m();
  offsets->erase(offsets->begin(), offsets->begin() + 3 * 4000);
  q.mutable_seed()->set_first_item(4000);
  const auto part = service_.answer(q);
  EXPECT_TRUE(std::equal(part.value().begin(), part.value().end(), whole.value().begin() + 12000));
  EXPECT_TRUE(std::equal(part.light_ids().begin(), part.light_ids().end(),
                         whole.light_ids().begin() + 4000));
  EXPECT_EQ(part.visible(), whole.visible().substr(500));
}

TEST_F(LightingServiceTest, DirectIrradianceOfAPointLightIsExact) {
  auto q = about<v1::EstimateIrradianceRequest>(point_);
  q.set_bounces(0);
  q.set_per_light(true);
  // Under the light, turned towards it and away; and one that is NaN.
  set(q.mutable_receivers()->mutable_offsets_m(), 1.2, -1.5, 1.2, 1.2, -1.5, 1.2, kNan, 0, 0);
  set(q.mutable_normals(), 0, 0, 2, 0, 0, -1, 0, 0, 1);
  auto r = service_.answer(q);
  EXPECT_NEAR(r.illuminance_lx(0), 2.5, 1e-5);  // 10 cd / (2 m)^2
  EXPECT_EQ(r.illuminance_lx(1), 0);
  EXPECT_EQ(r.standard_error_lx(0), 0);
  EXPECT_EQ(r.status(2), v1::ITEM_STATUS_INVALID_INPUT);
  ASSERT_EQ(r.shares_size(), 1);
  EXPECT_EQ(r.shares(0).illuminance_lx(0), r.illuminance_lx(0));
  EXPECT_EQ(r.samples(), 256U);
  q.mutable_accuracy()->set_samples(1);
  r = service_.answer(q);
  EXPECT_EQ(r.standard_error_lx_size(), 0);
}

TEST_F(LightingServiceTest, PdfLiOfADeltaLightIsZero) {
  auto q = about<v1::PdfLiRequest>(point_);
  q.set_light_id(1);
  set(q.mutable_receivers()->mutable_offsets_m(), 0, 0, 2);
  set(q.mutable_wi(), 0, 0, 1);
  auto r = service_.answer(q);
  ASSERT_EQ(r.pdf_per_sr_size(), 1);
  EXPECT_EQ(r.pdf_per_sr(0), 0);
  q.add_wi(1);
  expect_bad_field(service_.call(q, &r), "wi");
}

TEST_F(LightingServiceTest, VisibilityOfSegmentsAndRays) {
  auto q = about<v1::TestVisibilityRequest>(point_);
  // Along the floor's underside and through the floor.
  set(q.mutable_segments()->mutable_from()->mutable_offsets_m(), -3, -3, 1, -3, -3, 1);
  set(q.mutable_segments()->mutable_to()->mutable_offsets_m(), -3, -3, 2, -3, -3, -1);
  v1::TestVisibilityResponse r;
  const auto call = [&] { return service_.call(q, &r); };
  ASSERT_TRUE(call().ok());
  EXPECT_EQ(r.visible(), std::string(1, '\1'));
  EXPECT_EQ(r.count(), 2U);
  q.mutable_segments()->mutable_to()->add_offsets_m(1);
  expect_bad_field(call(), "segments.to.offsets_m");
  q.clear_segments();
  expect_bad_field(call(), "between");
  set(q.mutable_rays()->mutable_from()->mutable_offsets_m(), -3, -3, 0);
  set(q.mutable_rays()->mutable_directions(), 0, 0, 1);
  ASSERT_TRUE(call().ok());
  EXPECT_EQ(r.visible(), std::string(1, '\1'));
  set(q.mutable_rays()->mutable_lengths_m(), 1, 2);
  expect_bad_field(call(), "rays.lengths_m");
}

}  // namespace
}  // namespace lucerna::testing
