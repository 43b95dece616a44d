// A set of points has bitwise the same answers in one batch and in many.
#include <gtest/gtest.h>

#include "client/library/batches.h"
#include "client/library/points.h"
#include "client/testing/local_server_test.h"
#include "tests/paths.h"

namespace lucerna {
namespace {

class Split : public testing::LocalServerTest {
 protected:
  testing::LocalServerOptions options() const override {
    return {.scene_root = test_data("reference")};
  }

  std::string load(const std::string& path) const {
    v1::LoadSceneRequest request;
    request.set_path(path);
    return client().load_scene(request).value().scene_id();
  }

  static std::vector<client::Double3> grid() {
    std::vector<client::Double3> points;
    for (int i = 0; i < 10; ++i) points.push_back({-2 + 0.4 * i, 0.3 * i - 2, 0});
    return points;
  }
};

template <class Response>
std::string without_cost(Response response) {
  response.clear_cost();
  return response.SerializeAsString();
}

TEST_F(Split, SampleLiIsTheSameInOneBatchAndInMany) {
  v1::SampleLiRequest request;
  request.set_scene_id(load("sphere.pbrt"));
  *request.mutable_receivers() = client::make_points(grid());
  request.mutable_seed()->set_seed(7);
  request.mutable_accuracy()->set_samples(4);
  request.set_test_visibility(true);
  const auto whole = client().sample_li(request);
  ASSERT_TRUE(whole.ok()) << whole.status();
  ASSERT_EQ(whole->pdf_per_sr_size(), 40);
  // Batches of 3, 3, 3 and 1 receivers.
  const auto split = client::sample_li_in_batches(client(), request, {.max_items = 13});
  ASSERT_TRUE(split.ok()) << split.status();
  EXPECT_EQ(without_cost(*split), without_cost(*whole));
  // The companion that must differ: another position in the set.
  request.mutable_seed()->set_first_item(1);
  EXPECT_NE(without_cost(*client().sample_li(request)), without_cost(*whole));
}

TEST_F(Split, IrradianceIsTheSameInOneBatchAndInMany) {
  v1::EstimateIrradianceRequest request;
  request.set_scene_id(load("sphere.pbrt"));
  *request.mutable_receivers() = client::make_points(grid());
  for (int i = 0; i < 10; ++i) {
    for (const float n : {0.0F, 0.0F, 1.0F}) request.add_normals(n);
  }
  request.mutable_seed()->set_seed(7);
  request.mutable_accuracy()->set_samples(16);
  request.set_per_light(true);
  const auto whole = client().estimate_irradiance(request);
  ASSERT_TRUE(whole.ok()) << whole.status();
  const auto split = client::estimate_irradiance_in_batches(client(), request, {.max_items = 3});
  ASSERT_TRUE(split.ok()) << split.status();
  EXPECT_EQ(without_cost(*split), without_cost(*whole));
  request.mutable_seed()->set_first_item(1);
  EXPECT_NE(without_cost(*client().estimate_irradiance(request)), without_cost(*whole));
}

TEST_F(Split, RaysThatLeaveLightsAreTheSameInOneBatchAndInMany) {
  v1::SampleLeRequest request;
  request.set_scene_id(load("many_points.pbrt"));
  request.set_count(40);
  request.mutable_seed()->set_seed(7);
  request.mutable_seed()->set_first_item(1000);
  const auto whole = client().sample_le(request);
  ASSERT_TRUE(whole.ok()) << whole.status();
  ASSERT_EQ(whole->light_ids_size(), 40);
  const auto split = client::sample_le_in_batches(client(), request, {.max_items = 13});
  ASSERT_TRUE(split.ok()) << split.status();
  EXPECT_EQ(without_cost(*split), without_cost(*whole));
  request.mutable_seed()->set_first_item(1001);
  EXPECT_NE(without_cost(*client().sample_le(request)), without_cost(*whole));

  v1::PdfLeRequest densities;
  densities.set_scene_id(request.scene_id());
  densities.set_light_id(whole->light_ids(0));
  *densities.mutable_points() = whole->points();
  *densities.mutable_directions() = whole->directions();
  const auto all = client().pdf_le(densities);
  ASSERT_TRUE(all.ok()) << all.status();
  const auto parts = client::pdf_le_in_batches(client(), densities, {.max_items = 13});
  ASSERT_TRUE(parts.ok()) << parts.status();
  EXPECT_EQ(without_cost(*parts), without_cost(*all));
  EXPECT_GT(all->pdf_direction_per_sr(0), 0);
}

TEST_F(Split, MoreRaysThanOneBatchHoldsAreAnswered) {
  const auto info = client().get_server_info();
  ASSERT_TRUE(info.ok()) << info.status();
  v1::SampleLeRequest request;
  request.set_scene_id(load("point.pbrt"));
  request.set_light_id(1);
  request.set_count(info->limits().max_batch_items() + 1);
  request.mutable_seed()->set_seed(7);
  EXPECT_EQ(client().sample_le(request).status().code(), absl::StatusCode::kResourceExhausted);
  const auto split = client::sample_le_in_batches(client(), request);
  ASSERT_TRUE(split.ok()) << split.status();
  EXPECT_EQ(split->pdf_direction_per_sr_size(), static_cast<int>(request.count()));
  EXPECT_EQ(split->cost().samples(), request.count());
}

TEST_F(Split, MorePointsThanOneBatchHoldsAreAnswered) {
  const auto info = client().get_server_info();
  ASSERT_TRUE(info.ok()) << info.status();
  const std::size_t count = info->limits().max_batch_items() + std::size_t{1};
  const std::vector<client::Double3> from(count, {1.2, -1.5, 0});
  const std::vector<client::Double3> to(count, {1.2, -1.5, 3.2});
  v1::TestVisibilityRequest request;
  request.set_scene_id(load("point.pbrt"));
  *request.mutable_segments()->mutable_from() = client::make_points(from);
  *request.mutable_segments()->mutable_to() = client::make_points(to);
  EXPECT_EQ(client().test_visibility(request).status().code(),
            absl::StatusCode::kResourceExhausted);
  const auto split = client::test_visibility_in_batches(client(), request);
  ASSERT_TRUE(split.ok()) << split.status();
  EXPECT_EQ(split->count(), count);
  EXPECT_EQ(split->visible()[split->visible().size() / 2], '\xff');
}

}  // namespace
}  // namespace lucerna
