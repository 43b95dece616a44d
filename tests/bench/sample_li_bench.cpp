// The processor time of one sample of SampleLi, without the wire.
//
//     sample_li_bench [ROUNDS] [SCENE...]
//
// Scenes are those of tests/data/reference with one light: point.pbrt, sphere.pbrt and
// rectangle_near.pbrt if none is named.  As in wire_bench, a call has 4096 receivers anywhere in
// the scene's sphere, without normals.  The figure is the median over the calls, on one thread.
#include <fmt/core.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cstdint>
#include <exception>
#include <random>
#include <string>
#include <vector>

#include "server/queries/queries.h"
#include "server/runtime/denormals.h"
#include "server/runtime/parallel.h"
#include "server/scene/scene.h"
#include "tests/bench/bench_program.h"
#include "tests/bench/sample_li_arrays.h"
#include "tests/paths.h"

namespace lucerna {
namespace {

constexpr std::size_t kReceivers = 4096;

std::vector<float> receivers(const SceneSphere& sphere) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> u(-1, 1);
  std::vector<float> offsets_m;
  while (offsets_m.size() < 3 * kReceivers) {
    const Vec3 v{u(random), u(random), u(random)};
    if (dot(v, v) > 1) continue;
    const Vec3f at(sphere.center_m + v * sphere.radius_m);
    offsets_m.insert(offsets_m.end(), {at.x, at.y, at.z});
  }
  return offsets_m;
}

double sample_ns(const std::string& file, int rounds) {
  const auto scene = load_scene(test_data("reference/") + file);
  const std::vector<float> offsets_m = receivers(scene->sphere());
  SampleLiArrays arrays(kReceivers);
  const SampleLiAnswer answer = arrays.answer();
  SampleLiQuery query{.receivers = {scene->origin(), offsets_m}};
  std::vector<double> times_ns;
  for (int round = 0; round < rounds; ++round) {
    query.seed = SeedRange{.seed = static_cast<std::uint64_t>(round)};
    const std::int64_t begin_ns = thread_cpu_ns();
    (void)sample_li(*scene, query, answer, {});
    times_ns.push_back(static_cast<double>(thread_cpu_ns() - begin_ns) / kReceivers);
  }
  std::ranges::sort(times_ns);
  return times_ns[times_ns.size() / 2];
}

int run(int rounds, const std::vector<std::string>& scenes) {
  const DenormalsAreZero denormals;
  for (const std::string& scene : scenes)
    fmt::print("{:<24} {:>8.1f} ns\n", scene, sample_ns(scene, rounds));
  return 0;
}

}  // namespace
}  // namespace lucerna

int main(int argc, char** argv) {
  try {
    const int rounds =
        argc > 1 ? static_cast<int>(lucerna::number_of("ROUNDS", argv[1], 1, 1e6)) : 300;
    std::vector<std::string> scenes(argv + std::min(argc, 2), argv + argc);
    if (scenes.empty()) scenes = {"point.pbrt", "sphere.pbrt", "rectangle_near.pbrt"};
    return tbb::task_arena(1).execute([&] { return lucerna::run(rounds, scenes); });
  } catch (const std::exception& e) {
    fmt::print(stderr, "sample_li_bench: {}\n", e.what());
    return 1;
  }
}
