// Requests for shadow maps, and their statistics in the answers.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/server/rpc/service_fixture.h"

namespace lucerna::testing {
namespace {

class ShadowMapsTest : public ::testing::Test {
 protected:
  v1::GetSceneResponse scene() { return service_.answer(about<v1::GetSceneRequest>(scene_)); }
  int maps_listed() {
    const v1::GetSceneResponse r = scene();
    return static_cast<int>(std::ranges::count_if(
        r.parts(), [](const v1::ScenePart& p) { return p.name() == "shadow maps"; }));
  }

  /// 64 x 64 receivers on the ground.
  template <typename Request>
  Request on_the_ground(v1::Visibility visibility) const {
    Request q;
    q.set_scene_id(scene_);
    for (int i = 0; i < 64 * 64; ++i) {
      q.mutable_receivers()->add_offsets_m(static_cast<float>(i % 64) * 0.125F - 4);
      q.mutable_receivers()->add_offsets_m(static_cast<float>(i / 64) * 0.125F - 4);
      q.mutable_receivers()->add_offsets_m(0);
      for (const float n : {0.0F, 0.0F, 1.0F}) q.add_normals(n);
    }
    q.mutable_accuracy()->set_visibility(visibility);
    return q;
  }

  Service service_;
  const std::string scene_ = service_.load("point.pbrt");
};

void expect_agreement(const v1::Cost& cost, std::uint64_t least_lookups) {
  EXPECT_GE(cost.shadow_map_lookups(), least_lookups);
  EXPECT_GT(cost.shadow_map_compared(), least_lookups / 128);
  EXPECT_LE(cost.shadow_map_disagreed(), cost.shadow_map_compared() / 20);
}

TEST_F(ShadowMapsTest, AnswersReportHowOftenTheyDisagreed) {
  auto q = on_the_ground<v1::EstimateIrradianceRequest>(v1::VISIBILITY_RAYS);
  q.set_bounces(0);
  v1::EstimateIrradianceResponse by_rays, by_maps;
  const auto call = [&](v1::EstimateIrradianceResponse* r) { return service_.call(q, r); };
  ASSERT_TRUE(call(&by_rays).ok());
  EXPECT_EQ(by_rays.cost().shadow_map_lookups(), 0U);
  EXPECT_EQ(by_rays.cost().shadow_map_compared(), 0U);
  EXPECT_EQ(maps_listed(), 0);

  q.mutable_accuracy()->set_visibility(v1::VISIBILITY_SHADOW_MAPS);
  ASSERT_TRUE(call(&by_maps).ok());
  expect_agreement(by_maps.cost(), 2000);
  EXPECT_EQ(by_maps.cost().shadow_rays(), by_maps.cost().shadow_map_compared());
  int same = 0;
  for (int i = 0; i < 64 * 64; ++i) same += by_maps.illuminance_lx(i) == by_rays.illuminance_lx(i);
  EXPECT_GT(same, 64 * 64 * 95 / 100);

  const v1::GetSceneResponse listed = scene();
  std::uint64_t sum = 0, maps = 0;
  for (const v1::ScenePart& part : listed.parts()) {
    sum += part.bytes();
    if (part.name() != "shadow maps") continue;
    maps += part.bytes();
    EXPECT_GT(part.build_ms(), 0);
    EXPECT_NE(part.why().find("a query used shadow maps"), std::string::npos);
  }
  EXPECT_GT(maps, 1000000U);
  EXPECT_EQ(listed.summary().bytes(), sum);
}

TEST_F(ShadowMapsTest, AreUsedBySampleLi) {
  auto q = on_the_ground<v1::SampleLiRequest>(v1::VISIBILITY_SHADOW_MAPS);
  q.set_light_id(1);
  q.mutable_seed()->set_seed(1);
  v1::SampleLiResponse r, by_rays;
  const auto call = [&](v1::SampleLiResponse* r) { return service_.call(q, r); };
  // The request does not include visibility.
  ASSERT_TRUE(call(&r).ok());
  EXPECT_EQ(r.cost().shadow_map_lookups(), 0U);
  EXPECT_EQ(maps_listed(), 0);
  q.set_test_visibility(true);
  for (const bool with_normals : {true, false}) {
    if (!with_normals) q.clear_normals();
    q.mutable_accuracy()->set_visibility(v1::VISIBILITY_SHADOW_MAPS);
    ASSERT_TRUE(call(&r).ok());
    expect_agreement(r.cost(), 64 * 64);
    EXPECT_EQ(maps_listed(), 1);
    q.mutable_accuracy()->set_visibility(v1::VISIBILITY_RAYS);
    ASSERT_TRUE(call(&by_rays).ok());
    int differ = 0, visible = 0;
    for (std::size_t byte = 0; byte < r.visible().size(); ++byte) {
      differ += __builtin_popcount(static_cast<unsigned char>(r.visible()[byte]) ^
                                   static_cast<unsigned char>(by_rays.visible()[byte]));
      visible += __builtin_popcount(static_cast<unsigned char>(r.visible()[byte]));
    }
    EXPECT_LT(differ, 64 * 64 / 20);
    EXPECT_GT(visible, 64 * 64 / 4);
    EXPECT_LT(visible, 64 * 64);
  }
}

TEST_F(ShadowMapsTest, AreUsedByPictures) {
  auto q = about<v1::RenderTileRequest>(scene_);
  set_rect(&q, 160, 120);
  q.mutable_accuracy()->set_samples(2);
  q.mutable_accuracy()->set_visibility(v1::VISIBILITY_SHADOW_MAPS);
  const auto r = service_.answer(q);
  expect_agreement(r.cost(), 10000);
}

}  // namespace
}  // namespace lucerna::testing
