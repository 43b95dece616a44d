#include <cmath>
#include <limits>

#include "service_fixture.h"

namespace lucerna::testing {
namespace {

class LightingServiceTest : public ::testing::Test {
 protected:
  grpc::Status sample(const v1::SampleLiRequest& q, v1::SampleLiResponse* r) {
    return status_of([&](auto* c) { return service_.lighting.SampleLi(c, q, r); });
  }
  grpc::Status irradiance(const v1::EstimateIrradianceRequest& q,
                          v1::EstimateIrradianceResponse* r) {
    return status_of([&](auto* c) { return service_.lighting.EstimateIrradiance(c, q, r); });
  }
  v1::SampleLiRequest sample_request() const {
    v1::SampleLiRequest q;
    q.set_scene_id(point_);
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
  v1::SampleLiResponse r;
  ASSERT_TRUE(sample(q, &r).ok());
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
  v1::SampleLiResponse r;
  EXPECT_TRUE(sample(q, &r).ok());
  EXPECT_EQ(r.value_size(), 0);
  v1::EstimateIrradianceRequest e;
  e.set_scene_id(point_);
  v1::EstimateIrradianceResponse er;
  EXPECT_TRUE(irradiance(e, &er).ok());
  v1::TestVisibilityRequest v;
  v.set_scene_id(point_);
  v.mutable_segments();
  v1::TestVisibilityResponse vr;
  EXPECT_TRUE(status_of([&](auto* c) { return service_.lighting.TestVisibility(c, v, &vr); }).ok());
  EXPECT_EQ(vr.count(), 0U);
}

TEST_F(LightingServiceTest, SamplesWithoutValuesAndSeedHaveSeedZero) {
  v1::SampleLiRequest q = sample_request();
  q.clear_u();
  v1::SampleLiResponse unset, zero, one;
  ASSERT_TRUE(sample(q, &unset).ok());
  q.mutable_seed()->set_seed(0);
  ASSERT_TRUE(sample(q, &zero).ok());
  q.mutable_seed()->set_seed(1);
  ASSERT_TRUE(sample(q, &one).ok());
  for (v1::SampleLiResponse* r : {&unset, &zero, &one}) r->clear_cost();
  EXPECT_EQ(unset.SerializeAsString(), zero.SerializeAsString());
}

TEST_F(LightingServiceTest, BadFieldsAreNamedWithTheirValue) {
  v1::SampleLiResponse r;
  v1::SampleLiRequest q = sample_request();
  q.mutable_receivers()->mutable_origin_m()->set_y(kNan);
  expect_bad_field(sample(q, &r), "receivers.origin_m.y");
  q = sample_request();
  q.mutable_receivers()->add_offsets_m(1);
  expect_bad_field(sample(q, &r), "receivers.offsets_m");
  q = sample_request();
  q.mutable_u()->add_u(0.5F);
  expect_bad_field(sample(q, &r), "u.u");
  q = sample_request();
  q.mutable_u()->set_u(1, 1.5F);
  expect_bad_field(sample(q, &r), "u.u[1]");
  q = sample_request();
  q.clear_light_id();
  expect_bad_field(sample(q, &r), "u.u_light");
  q.mutable_u()->add_u_light(1.0);
  expect_bad_field(sample(q, &r), "u.u_light[0]");
  q = sample_request();
  q.set_time_s(kNan);
  expect_bad_field(sample(q, &r), "time_s");
  q = sample_request();
  q.set_position_error_m(-1);
  expect_bad_field(sample(q, &r), "position_error_m");
  q = sample_request();
  q.add_normals(1);
  expect_bad_field(sample(q, &r), "normals");
  q = sample_request();
  q.mutable_accuracy()->set_samples(0);
  expect_bad_field(sample(q, &r), "accuracy.samples");
  EXPECT_TRUE(sample(sample_request(), &r).ok());
}

TEST_F(LightingServiceTest, UnknownScenesAndLightsAreNotFound) {
  v1::SampleLiResponse r;
  v1::SampleLiRequest q = sample_request();
  q.set_scene_id("nonsense");
  EXPECT_EQ(sample(q, &r).error_code(), grpc::StatusCode::NOT_FOUND);
  q = sample_request();
  q.set_light_id(99);
  const grpc::Status s = sample(q, &r);
  EXPECT_EQ(s.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(detail<google::rpc::ErrorInfo>(s).reason(), "NO_SUCH_LIGHT");
}

TEST_F(LightingServiceTest, ATooLargeBatchIsResourceExhaustedWithoutARetryDelay) {
  v1::SampleLiResponse r;
  v1::SampleLiRequest q = sample_request();
  q.mutable_receivers()->mutable_offsets_m()->Resize(3 * 65537, 0);
  const grpc::Status s = sample(q, &r);
  EXPECT_EQ(s.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_FALSE(detail<google::rpc::RetryInfo>(s).has_retry_delay());
}

TEST_F(LightingServiceTest, BitsDependNeitherOnThreadsNorOnSplits) {
  v1::SampleLiRequest q;
  q.set_scene_id(service_.load("many_points.pbrt"));
  q.set_test_visibility(true);
  q.mutable_seed()->set_seed(3);
  for (int i = 0; i < 6000; ++i) {
    for (const float x : {0.001F * float(i), -1.0F, 1.0F}) q.mutable_receivers()->add_offsets_m(x);
  }
  v1::SampleLiResponse whole, other, part;
  ASSERT_TRUE(sample(q, &whole).ok());
  rpc::ServerOptions one = service_options();
  one.lanes.threads = 1;
  Service alone(one);
  alone.load("many_points.pbrt");
  ASSERT_TRUE(status_of([&](auto* c) { return alone.lighting.SampleLi(c, q, &other); }).ok());
  whole.clear_cost();
  other.clear_cost();
  EXPECT_EQ(whole.SerializeAsString(), other.SerializeAsString());

  auto* offsets = q.mutable_receivers()->mutable_offsets_m();
  offsets->erase(offsets->begin(), offsets->begin() + 3 * 4000);
  q.mutable_seed()->set_first_item(4000);
  ASSERT_TRUE(sample(q, &part).ok());
  EXPECT_TRUE(std::equal(part.value().begin(), part.value().end(), whole.value().begin() + 12000));
  EXPECT_TRUE(std::equal(part.light_ids().begin(), part.light_ids().end(),
                         whole.light_ids().begin() + 4000));
  EXPECT_EQ(part.visible(), whole.visible().substr(500));
}

TEST_F(LightingServiceTest, DirectIrradianceOfAPointLightIsExact) {
  v1::EstimateIrradianceRequest q;
  q.set_scene_id(point_);
  q.set_bounces(0);
  q.set_per_light(true);
  // Under the light, turned towards it and away; and one that is NaN.
  set(q.mutable_receivers()->mutable_offsets_m(), 1.2, -1.5, 1.2, 1.2, -1.5, 1.2, kNan, 0, 0);
  set(q.mutable_normals(), 0, 0, 2, 0, 0, -1, 0, 0, 1);
  v1::EstimateIrradianceResponse r;
  ASSERT_TRUE(irradiance(q, &r).ok());
  EXPECT_NEAR(r.illuminance_lx(0), 2.5, 1e-5);  // 10 cd / (2 m)^2
  EXPECT_EQ(r.illuminance_lx(1), 0);
  EXPECT_EQ(r.standard_error_lx(0), 0);
  EXPECT_EQ(r.status(2), v1::ITEM_STATUS_INVALID_INPUT);
  ASSERT_EQ(r.shares_size(), 1);
  EXPECT_EQ(r.shares(0).illuminance_lx(0), r.illuminance_lx(0));
  EXPECT_EQ(r.samples(), 256U);
  q.mutable_accuracy()->set_samples(1);
  ASSERT_TRUE(irradiance(q, &r).ok());
  EXPECT_EQ(r.standard_error_lx_size(), 0);
}

TEST_F(LightingServiceTest, PdfLiOfADeltaLightIsZero) {
  v1::PdfLiRequest q;
  q.set_scene_id(point_);
  q.set_light_id(1);
  set(q.mutable_receivers()->mutable_offsets_m(), 0, 0, 2);
  set(q.mutable_wi(), 0, 0, 1);
  v1::PdfLiResponse r;
  ASSERT_TRUE(status_of([&](auto* c) { return service_.lighting.PdfLi(c, q, &r); }).ok());
  ASSERT_EQ(r.pdf_per_sr_size(), 1);
  EXPECT_EQ(r.pdf_per_sr(0), 0);
  q.add_wi(1);
  expect_bad_field(status_of([&](auto* c) { return service_.lighting.PdfLi(c, q, &r); }), "wi");
}

TEST_F(LightingServiceTest, VisibilityOfSegmentsAndRays) {
  v1::TestVisibilityRequest q;
  q.set_scene_id(point_);
  // Along the floor's underside and through the floor.
  set(q.mutable_segments()->mutable_from()->mutable_offsets_m(), -3, -3, 1, -3, -3, 1);
  set(q.mutable_segments()->mutable_to()->mutable_offsets_m(), -3, -3, 2, -3, -3, -1);
  v1::TestVisibilityResponse r;
  const auto call = [&] {
    return status_of([&](auto* c) { return service_.lighting.TestVisibility(c, q, &r); });
  };
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
