// What the wire costs: SampleLi compared with an echo of the same bytes, and RenderTile with the
// same render in process.  Servers are programs of their own, on the loopback interface.
//
//     wire_bench [PAIRS] [point|sphere|rectangle|tile]
//
// Both sides of a row run in turns.  The table has the medians over the pairs, and the median of
// the ratios.
#include <fmt/core.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <functional>
#include <future>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "client/cli/bench_load.h"
#include "client/cli/bench_questions.h"
#include "client/cli/server_target.h"
#include "client/library/byte_calls.h"
#include "client/testing/local_server.h"
#include "proto/common/quantile.h"
#include "server/estimate/render.h"
#include "server/files/asset_reader.h"
#include "server/pbrt/load_pbrt.h"
#include "server/scene/scene.h"
#include "tests/paths.h"
#include "tests/temp_directory.h"

namespace lucerna {
namespace {

constexpr std::uint32_t kBatch = 4096;
constexpr std::uint32_t kInFlight = 8;
constexpr int kThreads = 2;
constexpr int kTile = 64;
constexpr int kTilesInFlight = 4;
constexpr std::uint32_t kSamples = 4;
constexpr std::uint32_t kBlock = 2;
constexpr std::uint32_t kBounces = 4;

template <typename T>
T value(absl::StatusOr<T> result) {
  if (!result.ok()) throw std::runtime_error(result.status().ToString());
  return *std::move(result);
}

/// Runs both in turns and prints a row.  Both return a rate.
void compare(const std::string& name, int pairs, const std::function<double()>& ours,
             const std::function<double()>& least) {
  std::vector<double> a, b, ratios;
  for (int i = 0; i < pairs; ++i) {
    if (i % 2 == 0) b.push_back(least());
    a.push_back(ours());
    if (i % 2 == 1) b.push_back(least());
    ratios.push_back(a.back() / b.back());
  }
  fmt::print("{:<38} {:>12.4g} {:>12.4g} {:>8.3f}\n", name, median(a), median(b), median(ratios));
  std::fflush(stdout);
}

/// A running server and the load of one kind of request.
class Load {
 public:
  Load(const testing::LocalServer& server, const bench::Requests& requests)
      : calls_(value(client::ByteCalls::connect({.target = server.target()}))),
        target_(server.client(), calls_, bench::Question::kSamples, requests, {}) {}

  /// Items in a second.
  double rate() {
    const bench::Figures figures = bench::closed_loop(
        target_, kInFlight, {.warm_up_s = 0.3, .time_s = 1.5, .window_s = 1.5, .windows = 1});
    if (figures.failed() > 0) throw std::runtime_error(figures.error.ToString());
    return static_cast<double>(figures.items) / figures.seconds;
  }
  std::string answer(const bench::Requests& requests) {
    std::promise<absl::StatusOr<std::string>> done;
    calls_.call(requests.method, requests.bytes.front(), {},
                [&](absl::StatusOr<std::string> bytes) { done.set_value(std::move(bytes)); });
    return value(done.get_future().get());
  }

 private:
  client::ByteCalls calls_;
  bench::ServerTarget target_;
};

void compare_samples(const std::string& name, const std::string& scene, int pairs) {
  const auto server = value(
      testing::LocalServer::start({.scene_root = test_data("reference"), .threads = kThreads}));
  v1::LoadSceneRequest load;
  load.set_path(scene);
  v1::GetSceneRequest get;
  get.set_scene_id(value(server.client().load_scene(load)).scene_id());
  bench::QuestionOptions options;
  options.scene = value(server.client().get_scene(get)).summary();
  const bench::Requests requests =
      value(bench::make_requests(bench::Question::kSamples, kBatch, options));
  Load ours(server, requests);
  const TempDirectory folder;
  const std::string file = (folder.path() / "answer").string();
  const std::string answer = ours.answer(requests);
  std::ofstream(file, std::ios::binary) << answer;
  setenv("LUCERNA_ECHO_ANSWER", file.c_str(), 1);
  const auto echo = value(testing::LocalServer::start({.program = LUCERNA_ECHO_SERVER}));
  Load least(echo, requests);
  compare(
      fmt::format("{} ({} + {} bytes)", name, requests.bytes.front().size(), answer.size()), pairs,
      [&] { return ours.rate(); }, [&] { return least.rate(); });
}

/// The picture in tiles, as a client renders it.
class Picture {
 public:
  Picture()
      : server_(value(testing::LocalServer::start(
            {.scene_root = source_path("scenes"), .threads = kThreads}))) {
    v1::LoadSceneRequest load;
    load.set_path("cornell/scene.pbrt");
    id_ = value(server_.client().load_scene(load)).scene_id();
    auto assets = AssetReader::open(source_path("scenes"));
    scene_ = value(Scene::build(value(load_pbrt(*assets, "cornell/scene.pbrt", {}))));
    width_ = scene_->camera().width();
    height_ = scene_->camera().height();
  }

  /// Pixels in a second.
  double over_the_wire() const {
    const int across = (width_ + kTile - 1) / kTile, down = (height_ + kTile - 1) / kTile;
    std::atomic<int> next = 0;
    return rate([&] {
      std::vector<std::jthread> callers;
      for (int i = 0; i < kTilesInFlight; ++i)
        callers.emplace_back([&] {
          for (int t = next++; t < across * down; t = next++)
            render_over_the_wire(t % across, t / across);
        });
    });
  }
  double in_process() const {
    TileSettings settings;
    settings.rect = {0, 0, width_, height_};
    settings.samples_per_block = kBlock;
    settings.block_count = kSamples / kBlock;
    settings.bounces = kBounces;
    tbb::task_arena arena(kThreads);
    return rate([&] { arena.execute([&] { (void)render_tile(*scene_, settings, {}); }); });
  }

 private:
  double rate(const std::function<void()>& render) const {
    const auto begin = std::chrono::steady_clock::now();
    render();
    return width_ * height_ /
           std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  }
  void render_over_the_wire(int x, int y) const {
    v1::RenderTileRequest request;
    request.set_scene_id(id_);
    v1::PixelRect& rect = *request.mutable_rect();
    rect.set_x0(static_cast<std::uint32_t>(x * kTile));
    rect.set_y0(static_cast<std::uint32_t>(y * kTile));
    rect.set_x1(static_cast<std::uint32_t>(std::min((x + 1) * kTile, width_)));
    rect.set_y1(static_cast<std::uint32_t>(std::min((y + 1) * kTile, height_)));
    request.set_bounces(kBounces);
    request.set_samples_per_block(kBlock);
    request.mutable_accuracy()->set_samples(kSamples);
    (void)value(server_.client().render_tile(request));
  }

  testing::LocalServer server_;
  std::string id_;
  std::shared_ptr<const Scene> scene_;
  int width_ = 0, height_ = 0;
};

int run(int pairs, const std::string& row) {
  fmt::print("{:<38} {:>12} {:>12} {:>8}\n", "", "per second", "at most", "ratio");
  for (const auto& [name, scene] : {std::pair("point", "point.pbrt"),
                                    {"sphere", "sphere.pbrt"},
                                    {"rectangle", "rectangle_near.pbrt"}})
    if (row.empty() || row == name) compare_samples(name, scene, pairs);
  if (row.empty() || row == "tile") {
    const Picture picture;
    compare(
        "tile", pairs, [&] { return picture.over_the_wire(); },
        [&] { return picture.in_process(); });
  }
  return 0;
}

}  // namespace
}  // namespace lucerna

int main(int argc, char** argv) {
  try {
    return lucerna::run(argc > 1 ? std::stoi(argv[1]) : 5, argc > 2 ? argv[2] : "");
  } catch (const std::exception& e) {
    fmt::print(stderr, "wire_bench: {}\n", e.what());
    return 1;
  }
}
