// A picture from many servers has the same bits as a picture that the renderer makes in this
// process.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "lucerna/client/render_job.h"
#include "lucerna/client/testing/local_server.h"
#include "server/estimate/render.h"
#include "server/files/asset_reader.h"
#include "server/pbrt/load_pbrt.h"
#include "server/scene/scene.h"
#include "tests/paths.h"

namespace lucerna {
namespace {

const std::string kScenes = test_data("reference");
constexpr std::uint32_t kPerBlock = 4, kBlocks = 8;
constexpr std::uint64_t kSeed = 5;

/// In one call, without a protocol.
client::Picture in_process(const std::string& file) {
  auto reader = AssetReader::open(kScenes);
  if (!reader.ok()) throw std::runtime_error(reader.status().ToString());
  auto description = load_pbrt(*reader, file, {});
  if (!description.ok()) throw std::runtime_error(description.status().ToString());
  const auto scene = Scene::build(*std::move(description));
  if (!scene.ok()) throw std::runtime_error(scene.status().ToString());
  const Camera& camera = (*scene)->camera();
  const TileResult tile = render_tile(
      **scene,
      {.rect = {0, 0, camera.width(), camera.height()},
       .seed = kSeed,
       .samples_per_block = kPerBlock,
       .block_count = kBlocks,
       .bounces = static_cast<std::uint32_t>((*scene)->report().hints.max_depth.value_or(1) - 1)},
      {});
  client::Picture picture{static_cast<std::uint32_t>(camera.width()),
                          static_cast<std::uint32_t>(camera.height()),
                          {},
                          {}};
  for (const BlockStatistics& s : tile.channels) {
    picture.pixels.push_back(static_cast<float>(s.sum / kBlocks));
    picture.standard_error.push_back(
        static_cast<float>(std::sqrt(s.deviation / (kBlocks * (kBlocks - 1.0)))));
  }
  return picture;
}

TEST(InProcess, AJobOnServersGivesTheSameBits) {
  std::vector<testing::LocalServer> servers;
  std::vector<std::string> targets;
  for (int i = 0; i < 2; ++i) {
    auto server = testing::LocalServer::start({.scene_root = kScenes, .threads = 1});
    ASSERT_TRUE(server.ok()) << server.status();
    servers.push_back(*std::move(server));
    targets.push_back(servers.back().target());
  }
  for (const std::string file : {"bounces.pbrt", "environment.pbrt"}) {
    SCOPED_TRACE(file);
    client::RenderJobOptions options;
    options.request.set_seed(kSeed);
    options.request.mutable_accuracy()->set_samples(kPerBlock * kBlocks);
    options.request.set_samples_per_block(kPerBlock);
    options.request.set_tile_size(24);
    options.samples_per_piece = 8;
    options.job.servers = [&]() -> absl::StatusOr<std::vector<std::string>> { return targets; };
    options.job.load = [&](const client::Client& client, const client::CallOptions& call) {
      v1::LoadSceneRequest request;
      request.set_path(file);
      return client.load_scene(request, call);
    };
    options.job.call = client::CallOptions::within(std::chrono::minutes(10));
    const auto result = client::run_render_job(options);
    ASSERT_TRUE(result.ok()) << result.status();
    const client::Picture expected = in_process(file);
    EXPECT_EQ(result->picture.pixels, expected.pixels);
    EXPECT_EQ(result->picture.standard_error, expected.standard_error);
  }
}

}  // namespace
}  // namespace lucerna
