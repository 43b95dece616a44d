// No answer holds NaN, an infinity or a negative number, for any query about any light.  The test
// makes random scenes of extreme lights and sends every query about each with random extreme items.
//
// LUCERNA_WIRE_ITEMS: how many items, by default 100000.  With fewer, the test does not require
// that every light and every reason occurs.  LUCERNA_WIRE_SCENE: the number of a single scene, to
// reproduce a failure.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iostream>
#include <map>
#include <numeric>

#include "tests/server/extremes/wire_answers.h"
#include "tests/server/extremes/wire_methods.h"
#include "tests/server/extremes/wire_queries.h"
#include "tests/server/extremes/wire_scenes.h"
#include "tests/server/extremes/wire_settings.h"
#include "tests/server/rpc/health_client.h"
#include "tests/temp_directory.h"

namespace lucerna::testing {
namespace {

constexpr std::uint64_t kDefaultItems = 100000;
constexpr std::uint64_t kAllScenes = ~std::uint64_t{0};

class WireProperty : public ::testing::Test {
 protected:
  /// Known by hand: 5 cd at 1 m.
  void expect_it_serves() {
    EXPECT_EQ(health(service_, ""), grpc::health::v1::HealthCheckResponse::SERVING);
    std::ofstream(root_.path() / "calm.pbrt")
        << "WorldBegin LightSource \"point\" \"rgb I\" [5 5 5] \"point3 from\" [0 0 3]\n";
    v1::SampleLiRequest q;
    q.set_scene_id(service_.load("calm.pbrt"));
    set(q.mutable_receivers()->mutable_offsets_m(), 0, 0, 2);
    q.mutable_seed()->set_seed(1);
    const auto r = service_.answer(q);
    ASSERT_FALSE(HasFailure());
    EXPECT_EQ(Vec3f(5, 5, 5), triple(r.value(), 0));
    EXPECT_EQ(Vec3f(0, 0, 1), triple(r.wi(), 0));
    EXPECT_EQ(r.distance_m(0), 1);
    EXPECT_EQ(r.status_size(), 0);
  }

  /// Sends every query about one scene, and adds up the counts.  A failure names what is needed to
  /// reproduce it.
  void query_scene(std::uint64_t number) {
    constexpr std::uint64_t kSeed = 20260101;
    constexpr int kBatch = 40;
    SCOPED_TRACE(fmt::format("LUCERNA_WIRE_SCENE={}", number));
    ExtremeNumbers numbers(kSeed + number);
    const WireScene scene = scenes_.load(number, numbers);
    ASSERT_FALSE(HasFailure());
    WireQueries queries(service_, numbers, scene, kBatch);
    const v1::Light* queried = nullptr;
    for (const v1::Light& light : queries.lights()) {
      queried = &light;
      queries.query_light(light);
      if (!queries.failures().empty()) break;
      ++lights_[scene.kinds.at(light.source().substr(0, light.source().rfind(':')))];
    }
    if (queries.failures().empty()) {
      queried = nullptr;
      queries.query_scene();
      queries.send_invalid();
      queries.query_edit();
      queries.query_lease();
    }
    for (const std::string& failure : queries.failures()) ADD_FAILURE() << failure;
    if (HasFailure()) {
      if (queried != nullptr) std::cout << queried->ShortDebugString() << "\n";
      std::cout << scenes_.text();
      FAIL();
    }
    scenes_.release(scene.id);
    for (const auto& [method, n] : queries.items()) items_[method] += n;
    for (const auto& [what, n] : queries.counts()) counts_[what] += n;
    in_part_ += queries.in_part_count();
    negative_ += queries.negative_count();
  }

  /// Queries that are not about scenes are sent item by item.
  std::uint64_t items() {
    std::uint64_t sum = 0;
    for (const auto* method : all_methods())
      if (method->service()->name() != "SceneService") sum += items_[method->name()];
    return sum;
  }

  /// Every method whose answers hold numbers was called.
  void expect_all_methods() {
    for (const auto& [method, n] : scenes_.items()) items_[method] += n;
    const auto ask = [&](const std::string& method, const auto& request) {
      for (const std::string& wrong : wrong_numbers(service_.answer(request)))
        ADD_FAILURE() << wrong;
      ++items_[method];
    };
    ask("GetServerInfo", v1::GetServerInfoRequest());
    ask("GetStats", v1::GetStatsRequest());
    ask("ListLeases", v1::ListLeasesRequest());
    for (const auto* method : all_methods()) {
      if (!holds_numbers(*method->output_type())) continue;
      EXPECT_GT(items_[method->name()], 0u) << method->full_name();
    }
  }

  TempDirectory root_;
  Service service_{scenes_in(root_.path())};
  WireScenes scenes_{service_, root_.path()};
  std::map<std::string, std::uint64_t> items_;   // by method
  std::map<std::string, std::uint64_t> lights_;  // by kind
  WireQueries::Counts counts_;
  std::uint64_t in_part_ = 0, negative_ = 0;  // as in WireQueries
};

TEST_F(WireProperty, EveryNumberIsFiniteAndNotNegative) {
  const auto wanted = whole_number_of("LUCERNA_WIRE_ITEMS", 1, kDefaultItems);
  if (!wanted.ok()) FAIL() << wanted.status().message();
  const auto only = whole_number_of("LUCERNA_WIRE_SCENE", 0, kAllScenes);
  if (!only.ok()) FAIL() << only.status().message();
  if (*only != kAllScenes) return query_scene(*only);
  std::uint64_t scenes = 0;
  for (; items() < *wanted; ++scenes) {
    query_scene(scenes);
    if (HasFailure()) return;
  }
  for (const auto& [what, n] : counts_)
    std::cout << fmt::format("{:20} {:28} {}\n", what.first, v1::ItemStatus_Name(what.second), n);
  for (const char* method : {"EstimatePower", "RenderTile", "RenderImage"})
    std::cout << fmt::format("{:20} {:28} {}\n", method, "", items_[method]);
  const std::uint64_t lights =
      std::accumulate(lights_.begin(), lights_.end(), std::uint64_t{0},
                      [](std::uint64_t sum, const auto& kind) { return sum + kind.second; });
  std::cout << fmt::format("{} items of {} lights in {} scenes, {} lines refused, {} numbers\n",
                           items(), lights, scenes, scenes_.refused(), numbers_seen());
  std::cout << fmt::format("{} numbers of light that arrives in part, {} channels below 0\n",
                           in_part_, negative_);
  expect_it_serves();
  if (*wanted < kDefaultItems) return;  // too few items for everything to occur
  expect_all_methods();
  EXPECT_GT(in_part_, 0u);
  EXPECT_GT(negative_, 0u);
  for (const std::string& kind : light_kinds()) EXPECT_GT(lights_[kind], 0u) << kind;
  for (int s = v1::ITEM_STATUS_OK; s <= v1::ItemStatus_MAX; ++s) {
    const auto status = static_cast<v1::ItemStatus>(s);
    // These are only of EstimateIrradiance.
    if (status == v1::ITEM_STATUS_INSIDE_SOLID || status == v1::ITEM_STATUS_MAY_MISS_LIGHT)
      continue;
    EXPECT_GT((counts_[{"SampleLi", status}]), 0u) << v1::ItemStatus_Name(status);
  }
}

}  // namespace
}  // namespace lucerna::testing
