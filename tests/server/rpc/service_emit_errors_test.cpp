// Errors of SampleLe and PdfLe, for a whole request or for one ray.
#include <limits>

#include "every_light.h"

namespace lucerna::testing {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();

class EmitErrors : public EveryLightTest {
 protected:
  grpc::Status sample(const v1::SampleLeRequest& q) { return service_.status(q); }
  grpc::Status pdf(const v1::PdfLeRequest& q) { return service_.status(q); }
  /// One ray with its own sample values, from a named light.
  v1::SampleLeRequest own_values() const {
    v1::SampleLeRequest q = rays_of(first(v1::AREA_SHAPE_SPHERE), 1);
    set(q.mutable_u()->mutable_u(), 0.25, 0.5, 0.75, 0.5);
    return q;
  }
  v1::PdfLeRequest one_ray() const {
    const v1::Light& light = first(v1::Light::kPoint);
    v1::PdfLeRequest q = density_of(light);
    *q.mutable_points()->mutable_origin_m() = light.point().position_m();
    set(q.mutable_points()->mutable_offsets_m(), 0, 0, 0);
    set(q.mutable_directions(), 0, 0, -3);
    return q;
  }
};

void expect_reason(const grpc::Status& status, const std::string& reason) {
  EXPECT_EQ(status.error_code(), grpc::StatusCode::NOT_FOUND) << status.error_message();
  EXPECT_EQ(detail<google::rpc::ErrorInfo>(status).reason(), reason);
}

TEST_F(EmitErrors, UnknownScenesAndLightsAreNotFound) {
  v1::SampleLeRequest s = own_values();
  s.set_light_id(9999);
  expect_reason(sample(s), "NO_SUCH_LIGHT");
  s.set_light_id(0);
  expect_reason(sample(s), "NO_SUCH_LIGHT");
  s.set_scene_id("nonsense");
  expect_reason(sample(s), "SCENE_NOT_LOADED");
  s.clear_scene_id();
  expect_bad_field(sample(s), "scene_id");

  v1::PdfLeRequest p = one_ray();
  p.set_light_id(9999);
  expect_reason(pdf(p), "NO_SUCH_LIGHT");
  // 0 is the value of an unset field.
  p.set_light_id(0);
  expect_bad_field(pdf(p), "light_id");
  p.set_scene_id("nonsense");
  expect_reason(pdf(p), "SCENE_NOT_LOADED");
  p.clear_scene_id();
  expect_bad_field(pdf(p), "scene_id");
}

TEST_F(EmitErrors, BadFieldsAreNamed) {
  expect_bad_fields<v1::SampleLeRequest>(
      service_, own_values(),
      {{"u.u", [](auto& q) { q.mutable_u()->add_u(0.5F); }},
       {"u.u", [](auto& q) { q.set_count(2); }},
       {"u.u_light", [](auto& q) { q.mutable_u()->add_u_light(0.5); }},  // the light is named
       {"u.u_light", [](auto& q) { q.clear_light_id(); }},
       {"u.u[3]", [](auto& q) { q.mutable_u()->set_u(3, 1.5F); }},
       {"u.u[3]", [](auto& q) { q.mutable_u()->set_u(3, -0.5F); }},
       {"u.u_light[0]", [](auto& q) { q.clear_light_id(), q.mutable_u()->add_u_light(1); }}});
  v1::SampleLeRequest good = own_values();
  good.mutable_u()->set_u(3, 1);
  EXPECT_TRUE(service_.status(good).ok());
  good.clear_light_id();
  good.mutable_u()->add_u_light(0x1.fffffffffffffp-1);
  EXPECT_TRUE(service_.status(good).ok());
  good = own_values();
  good.clear_u();
  EXPECT_TRUE(service_.status(good).ok());  // seed 0

  expect_bad_fields<v1::PdfLeRequest>(
      service_, one_ray(),
      {{"directions", [](auto& q) { q.add_directions(1); }},
       {"points.offsets_m", [](auto& q) { q.mutable_points()->add_offsets_m(1); }},
       {"points.origin_m.y",
        [](auto& q) { q.mutable_points()->mutable_origin_m()->set_y(kNan); }}});
  EXPECT_TRUE(service_.status(one_ray()).ok());
}

TEST_F(EmitErrors, MoreItemsThanTheLimitAreResourceExhausted) {
  v1::SampleLeRequest s = own_values();
  s.clear_u();
  s.mutable_seed()->set_seed(1);
  s.set_count(65537);
  EXPECT_EQ(sample(s).error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  s.set_count(std::numeric_limits<std::uint32_t>::max());
  EXPECT_EQ(sample(s).error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  v1::PdfLeRequest p = one_ray();
  p.mutable_points()->mutable_offsets_m()->Resize(3 * 65537, 0);
  p.mutable_directions()->Resize(3 * 65537, 1);
  EXPECT_EQ(pdf(p).error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
}

TEST_F(EmitErrors, EmptyRequestsHaveEmptyAnswers) {
  v1::SampleLeRequest s = rays(0);
  const auto sr = service_.answer(s);
  EXPECT_EQ(sr.value_size() + sr.light_ids_size() + sr.points().offsets_m_size(), 0);
  v1::PdfLeRequest p = one_ray();
  p.mutable_points()->clear_offsets_m();
  p.clear_directions();
  const auto pr = service_.answer(p);
  EXPECT_EQ(pr.pdf_position_per_m2_size() + pr.pdf_direction_per_sr_size(), 0);
}

TEST_F(EmitErrors, RaysThatAreNotFiniteFailAlone) {
  v1::SampleLeRequest s = rays(4);
  set(s.mutable_u()->mutable_u(), 0.5, 0.5, 0.5, 0.5, 0.5, kNan, 0.5, 0.5,  //
      0.5, 0.5, 0.5, kInf, 0.5, 0.5, 0.5, 0.5);
  for (const double u : {0.5, 0.5, 0.5, double{kNan}}) s.mutable_u()->add_u_light(u);
  const auto sr = service_.answer(s);
  ASSERT_EQ(sr.status_size(), 4);
  EXPECT_EQ(sr.status(0), v1::ITEM_STATUS_OK);
  for (int i = 1; i < 4; ++i) {
    EXPECT_EQ(sr.status(i), v1::ITEM_STATUS_INVALID_INPUT);
    EXPECT_EQ(sr.value(3 * i), 0);
    EXPECT_EQ(sr.directions(3 * i + 2), 0);
    EXPECT_EQ(sr.pdf_direction_per_sr(i), 0);
    EXPECT_GT(sr.selection_probability(i), 0);  // so that clients can divide by it
  }
  EXPECT_GT(sr.value(0), 0);

  v1::PdfLeRequest p = one_ray();
  set(p.mutable_points()->mutable_offsets_m(), 0, 0, 0, kNan, 0, 0, 0, 0, 0, 0, 0, 0, 0, kInf, 0);
  set(p.mutable_directions(), 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, kNan, 0, 0, 0, 1);
  const auto pr = service_.answer(p);
  ASSERT_EQ(pr.status_size(), 5);
  EXPECT_EQ(pr.status(0), v1::ITEM_STATUS_OK);
  EXPECT_NEAR(pr.pdf_direction_per_sr(0), 1 / (4 * std::numbers::pi), 1e-7);
  for (int i = 1; i < 5; ++i) {
    EXPECT_EQ(pr.status(i), v1::ITEM_STATUS_INVALID_INPUT) << i;
    EXPECT_EQ(pr.pdf_direction_per_sr(i), 0);
  }
}

TEST_F(EmitErrors, DirectionsOfExtremeLengthsAreDirections) {
  v1::PdfLeRequest p = one_ray();
  set(p.mutable_points()->mutable_offsets_m(), 0, 0, 0, 0, 0, 0, 0, 0, 0);
  set(p.mutable_directions(), 0, 0, 2e-38, 0, 2e38, -2e38, 0, 1e-45, 0);
  const auto r = service_.answer(p);
  EXPECT_NEAR(r.pdf_direction_per_sr(0), 1 / (4 * std::numbers::pi), 1e-7);
  EXPECT_NEAR(r.pdf_direction_per_sr(1), 1 / (4 * std::numbers::pi), 1e-7);
  // Servers treat denormal numbers as 0.
  EXPECT_EQ(r.status(2), v1::ITEM_STATUS_INVALID_INPUT);
}

}  // namespace
}  // namespace lucerna::testing
