// The predicted time of requests, which decides the lane they wait in.
#include <gtest/gtest.h>

#include "proto/common/sample_blocks.h"
#include "server/rpc/handlers/estimate_irradiance_handler.h"
#include "server/rpc/handlers/le_handler.h"
#include "server/rpc/handlers/predicted_time.h"
#include "server/rpc/handlers/sample_le_handler.h"
#include "server/rpc/handlers/sample_li_handler.h"
#include "server/store/scene_store.h"
#include "tests/paths.h"

namespace lucerna::rpc {
namespace {

constexpr int kPredictedItems = 1000, kWavelengths = 128;

class Prediction : public ::testing::Test {
 protected:
  /// Predicted seconds for `request`, which names no scene yet, with this number of wavelengths.
  template <typename Request, typename Response>
  double predicted(Prepared (*prepare)(const CallContext&, const Request&, Response*),
                   Request request, int wavelengths) {
    request.set_scene_id(scene_);
    for (int i = 0; i < wavelengths; ++i) request.add_wavelengths_nm(400 + i);
    Response response;
    const Prepared task = prepare({*scenes_, *assets_, limits_}, request, &response);
    EXPECT_TRUE(task.ok()) << task.status();
    return task.ok() ? task->predicted_s : 0;
  }
  /// Expects that wavelengths count: each value of each item at each of them.
  template <typename Request, typename Response>
  void expect_counted(Prepared (*prepare)(const CallContext&, const Request&, Response*),
                      const Request& request, double values) {
    const double more = predicted(prepare, request, kWavelengths) - predicted(prepare, request, 0);
    EXPECT_GE(more, (1 - 1e-9) * values * kWavelengths * kWavelengthSeconds);
    EXPECT_LE(more, 3 * values * kWavelengths * kWavelengthSeconds);
  }

  RequestLimits limits_;
  std::unique_ptr<AssetStore> assets_ = AssetStore::open({}).value();
  std::unique_ptr<SceneStore> scenes_ =
      SceneStore::open({.root = test_data("reference")}, assets_.get()).value();
  // 400 lights with an RGB colour each.
  std::string scene_ = scenes_->load("many_points.pbrt").value().stored.scene->id();
};

TEST_F(Prediction, CountsWavelengthsOfEachCall) {
  v1::SampleLiRequest li;
  li.mutable_receivers()->mutable_offsets_m()->Resize(3 * kPredictedItems, 1);
  li.mutable_seed();
  expect_counted(handle_sample_li, li, kPredictedItems);
  v1::LeRequest looking;
  looking.mutable_points()->mutable_offsets_m()->Resize(3 * kPredictedItems, 1);
  looking.mutable_directions()->Resize(3 * kPredictedItems, 1);
  expect_counted(handle_le, looking, kPredictedItems);
  v1::SampleLeRequest rays;
  rays.set_count(kPredictedItems);
  rays.mutable_seed();
  expect_counted(handle_sample_le, rays, kPredictedItems);
  v1::EstimateIrradianceRequest meter;
  meter.mutable_receivers()->mutable_offsets_m()->Resize(3 * kPredictedItems, 1);
  meter.mutable_normals()->Resize(3 * kPredictedItems, 1);
  meter.set_bounces(0);
  expect_counted(handle_estimate_irradiance, meter, kPredictedItems);
}

TEST(SampleBlocks, AreLimitedByTheNumberingOfSamples) {
  EXPECT_EQ(default_samples_per_block(1U << 31, 1), 1U << 28);
  EXPECT_EQ(default_samples_per_block(1U << 30, 8), 1U << 27);
  EXPECT_EQ(default_samples_per_block(48, 1), 16U);
}

}  // namespace
}  // namespace lucerna::rpc
