// Nanoseconds per choice among 10 to 1e6 lights by a tree, and the time to build the tree.
#include <benchmark/benchmark.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "lights/models/light_tree.h"
#include "lights/sampling/sobol.h"

namespace lucerna {
namespace {

/// Lights in a box with a square metre per light: lamps that shine everywhere, spots and panels, in
/// all directions.
std::vector<LightTree::Item> lights(std::uint32_t count) {
  constexpr double kPi = std::numbers::pi;
  const SobolSequence sequence(3, 0);
  const double side = std::sqrt(count);
  std::vector<LightTree::Item> all;
  for (std::uint32_t i = 0; i < count; ++i) {
    const Vec2f u = sequence.pair(i, 0), v = sequence.pair(i, 1), w = sequence.pair(i, 2);
    const Vec3 at{side * u.x, side * u.y, 4.0 * v.x};
    const double phi = 2 * kPi * w.x, z = 2.0 * w.y - 1, r = std::sqrt(1 - z * z);
    LightTree::Item item{{.lower = at, .upper = at, .cone_rad = kPi}, 0.5 + v.y};
    if (i % 3 != 0) item.bounds.axis = {r * std::cos(phi), r * std::sin(phi), z};
    if (i % 3 == 1) item.bounds.cone_rad = item.bounds.normals_rad = 0.6;
    if (i % 3 == 2) {
      item.bounds.upper += Vec3{0.3, 0.3, 0.3};
      item.bounds.cone_rad = kPi / 2;
      item.bounds.normals_rad = 0;
    }
    all.push_back(item);
  }
  return all;
}

void BM_LightTreeChoose(benchmark::State& state) {
  const auto count = static_cast<std::uint32_t>(state.range(0));
  const LightTree tree = *LightTree::create(lights(count));
  const double side = std::sqrt(count);
  const SobolSequence sequence(4, 0);
  constexpr std::uint32_t kBatch = 4096;
  std::vector<Receiver> receivers;
  std::vector<double> u;
  for (std::uint32_t i = 0; i < kBatch; ++i) {
    const Vec2f at = sequence.pair(i, 0);
    receivers.emplace_back(Vec3{side * at.x, side * at.y, 0});
    receivers.back().normal = {0, 0, 1};
    u.push_back(sequence.pair(i, 1).x);
  }
  for (auto _ : state) {
    double sum = 0;
    for (std::uint32_t i = 0; i < kBatch; ++i)
      if (const auto choice = tree.choose(receivers[i], u[i])) sum += choice->probability;
    benchmark::DoNotOptimize(sum);
  }
  state.SetItemsProcessed(state.iterations() * kBatch);
  state.counters["bytes_per_light"] = static_cast<double>(tree.bytes()) / count;
}
BENCHMARK(BM_LightTreeChoose)->Arg(10)->Arg(100)->Arg(10'000)->Arg(1'000'000);

void BM_LightTreeBuild(benchmark::State& state) {
  const std::vector<LightTree::Item> items = lights(static_cast<std::uint32_t>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(LightTree::create(items));
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(BM_LightTreeBuild)->Arg(100)->Arg(10'000)->Arg(1'000'000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace lucerna
