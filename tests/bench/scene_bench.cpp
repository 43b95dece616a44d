// Rays, tiles and irradiance in a scene with a ball, a box and a room around them.
#include <benchmark/benchmark.h>

#include "server/estimate/render.h"
#include "server/files/asset_reader.h"
#include "server/pbrt/load_pbrt.h"
#include "server/scene/scene.h"
#include "tests/paths.h"

namespace lucerna {
namespace {

std::shared_ptr<const Scene> load(const std::string& name,
                                  const std::string& root = test_data("reference")) {
  auto assets = AssetReader::open(root);
  auto description = load_pbrt(*assets, name, {});
  return *Scene::build(*std::move(description));
}

void BM_ClosestHit(benchmark::State& state) {
  const auto scene = load("bounces.pbrt");
  const Camera& camera = scene->camera();
  int x = 0;
  for (auto _ : state) {
    x = (x + 7) % (camera.width() * camera.height());
    benchmark::DoNotOptimize(scene->closest_hit(camera.ray(
        static_cast<float>(x % camera.width()), static_cast<float>(x / camera.width()))));
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(BM_ClosestHit);

void BM_RenderTile(benchmark::State& state, const std::string& name,
                   const std::string& root = test_data("reference")) {
  const auto scene = load(name, root);
  TileSettings settings;
  settings.rect = {48, 28, 112, 92};
  settings.samples_per_block = 4;
  settings.block_count = 4;
  settings.bounces = static_cast<std::uint32_t>(scene->report().hints.max_depth.value_or(1) - 1);
  std::uint64_t rays = 0;
  for (auto _ : state) {
    const TileResult tile = render_tile(*scene, settings, {});
    rays += tile.work.camera_rays + tile.work.indirect_rays + tile.work.shadow_rays;
    benchmark::DoNotOptimize(tile.channels.data());
  }
  state.counters["rays"] =
      benchmark::Counter(static_cast<double>(rays), benchmark::Counter::kIsRate);
}
BENCHMARK_CAPTURE(BM_RenderTile, point, "point.pbrt")->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_RenderTile, sphere, "sphere.pbrt")
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_RenderTile, many_points, "many_points.pbrt")
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_RenderTile, bounces, "bounces.pbrt")
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_RenderTile, demo, "demo.pbrt", source_path("scenes"))
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace lucerna
