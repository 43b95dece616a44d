// Le.
#include <limits>

#include "service_fixture.h"

namespace lucerna::testing {
namespace {

class EmissionServiceTest : public ::testing::Test {
 protected:
  /// From the floor below the sphere (12 cd/m2 about (0.7, -1.2, 2.6)) up into it, and aside.
  v1::LeRequest le_request() const {
    auto q = about<v1::LeRequest>(sphere_);
    q.mutable_points()->mutable_origin_m()->set_x(0.7);
    set(q.mutable_points()->mutable_offsets_m(), 0, -1.2, 0, 0, -1.2, 0);
    set(q.mutable_directions(), 0, 0, 2, 1, 0, 1);
    return q;
  }

  Service service_;
  std::string sphere_ = service_.load("sphere.pbrt");
};

TEST_F(EmissionServiceTest, LeIsTheRadianceOfTheLightThatTheRayMeets) {
  auto r = service_.answer(le_request());
  EXPECT_EQ(std::vector<float>(r.radiance_cd_m2().begin(), r.radiance_cd_m2().end()),
            (std::vector<float>{12, 12, 12, 0, 0, 0}));
  EXPECT_EQ(r.light_ids(0), 1U);
  EXPECT_EQ(r.light_ids(1), 0U);
  EXPECT_EQ(r.status_size(), 0);
  EXPECT_EQ(r.cost().samples(), 2U);
  EXPECT_EQ(r.cost().indirect_rays(), 2U);
  r = service_.answer(about<v1::LeRequest>(sphere_));
  EXPECT_EQ(r.light_ids_size(), 0);
}

TEST_F(EmissionServiceTest, LeRefusesInvalidFields) {
  expect_bad_fields<v1::LeRequest>(
      service_, le_request(),
      {{"directions", [](auto& q) { q.add_directions(1); }},
       {"points.offsets_m", [](auto& q) { q.mutable_points()->add_offsets_m(1); }},
       {"points.origin_m.z",
        [](auto& q) { q.mutable_points()->mutable_origin_m()->set_z(kNan); }}});
  v1::LeRequest q = le_request();
  q.set_light_id(9);
  EXPECT_EQ(detail<google::rpc::ErrorInfo>(service_.status(q)).reason(), "NO_SUCH_LIGHT");
  q = le_request();
  q.set_scene_id("nonsense");
  EXPECT_EQ(service_.status(q).error_code(), grpc::StatusCode::NOT_FOUND);
  q = le_request();
  q.mutable_points()->mutable_offsets_m()->Resize(3 * 65537, 0);
  EXPECT_EQ(service_.status(q).error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_TRUE(service_.status(le_request()).ok());
}

}  // namespace
}  // namespace lucerna::testing
