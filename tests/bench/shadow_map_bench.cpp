// Measures the gain and the errors of shadow maps, on the five scenes of scenes/.  It prints the
// time of direct irradiance and of a tile with rays and with maps, medians of paired runs on one
// thread, and how often maps disagreed with rays.  `shadow_map_bench [RUNS]`.
#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <functional>
#include <string>
#include <vector>

#include "proto/common/quantile.h"
#include "server/estimate/light_visibility.h"
#include "server/estimate/render.h"
#include "server/queries/receiver_irradiance.h"
#include "server/runtime/parallel.h"
#include "tests/bench/shipped_scene.h"

namespace lucerna {
namespace {

double ms(const std::function<void()>& f) {
  const std::int64_t start = thread_cpu_ns();
  f();
  return 1e-6 * static_cast<double>(thread_cpu_ns() - start);
}

/// `answer(method)` is timed and returns its work.
void compare(const std::string& scene, const char* what, int runs,
             const std::function<WorkCounts(VisibilityMethod)>& answer) {
  const WorkCounts work = answer(VisibilityMethod::kShadowMaps);  // creates the maps
  const WorkCounts by_rays = answer(VisibilityMethod::kRays);
  std::vector<double> rays, maps, ratios;
  for (int i = 0; i < runs; ++i) {
    rays.push_back(ms([&] { answer(VisibilityMethod::kRays); }));
    maps.push_back(ms([&] { answer(VisibilityMethod::kShadowMaps); }));
    ratios.push_back(maps.back() / rays.back());
  }
  const auto n = static_cast<double>(work.map_compared);
  fmt::print("| {} | {} | {:.0f} | {:.0f} | {:.2f} | {} | {} | {} |\n", scene, what, median(rays),
             median(maps), median(ratios), by_rays.shadow_rays, work.map_lookups,
             n > 0 ? fmt::format("{:.2f}% of {}", 100 * static_cast<double>(work.map_disagreed) / n,
                                 work.map_compared)
                   : "-");
}

/// Compares a single ray with a single look-up: from each receiver to each light with a map [ns].
std::string by_itself(const Scene& scene, const std::vector<IrradiancePoint>& receivers, int runs) {
  struct Item {
    std::uint32_t light;
    Vec3 position, normal;
    Ray ray;
  };
  std::vector<Item> items;
  for (const IrradiancePoint& p : receivers) {
    SurfaceHit hit;
    hit.position = p.position, hit.position_error = p.position_error;
    hit.ns = p.normal, hit.ng = p.normal;
    for (std::uint32_t l = 0; l < scene.lights().size(); ++l) {
      if (shadow_maps(scene).map(l) == nullptr) continue;
      const auto sample = scene.lights()[l].light->sample_li(Receiver(p.position), {0.5, 0.5});
      if (sample.reason != NoLight::kNone || !(dot(hit.ng, sample.wi) > 0)) continue;
      items.push_back({l, hit.position, hit.ng, shadow_ray(hit, sample)});
    }
  }
  if (items.empty()) return "";
  const LightVisibility visibility(scene, Methods{.visibility = VisibilityMethod::kShadowMaps});
  std::vector<double> rays, maps;
  std::size_t occluded = 0, wrong = 0;
  for (int i = 0; i < runs; ++i) {
    const double n = 1e-6 * static_cast<double>(items.size());
    occluded = wrong = 0;
    rays.push_back(ms([&] {
                     for (const Item& at : items) occluded += scene.geometry().occluded(at.ray);
                   }) /
                   n);
    std::size_t by_map = 0;
    maps.push_back(ms([&] {
                     for (const Item& at : items)
                       by_map +=
                           visibility.by_map(at.light, at.position, at.normal).value_or(false);
                   }) /
                   n);
  }
  for (const Item& at : items)
    wrong +=
        visibility.by_map(at.light, at.position, at.normal) != scene.geometry().occluded(at.ray);
  return fmt::format(
      "a ray {:.0f} ns, a look-up {:.0f} ns; of all {}, {:.1f}% are occluded, and {:.2f}% disagree",
      median(rays), median(maps), items.size(),
      100.0 * static_cast<double>(occluded) / items.size(),
      100.0 * static_cast<double>(wrong) / items.size());
}

int run(int runs) {
  fmt::print(
      "| scene | question | rays [ms] | maps [ms] | ratio | shadow rays | look-ups | disagree |\n"
      "|---|---|---|---|---|---|---|---|\n");
  std::string built;
  for (const char* name : {"cornell", "meadow", "room", "stage", "street"}) {
    const auto scene = load_shipped(name);
    const std::vector<IrradiancePoint> receivers = shipped_points(*scene, name);
    compare(name, "irradiance", runs, [&](VisibilityMethod visibility) {
      IrradianceSettings settings{.seed = 1, .samples_per_block = 4, .block_count = 16};
      settings.bounces = 0;
      settings.methods.visibility = visibility;
      return estimate_irradiance(*scene, receivers, settings, {}).work;
    });
    compare(name, "tile", runs, [&](VisibilityMethod visibility) {
      const int w = scene->camera().width(), h = scene->camera().height();
      TileSettings settings{.rect = {w / 2 - 48, h / 2 - 48, w / 2 + 48, h / 2 + 48},
                            .seed = 1,
                            .samples_per_block = 8};
      settings.bounces = 1;
      settings.methods.visibility = visibility;
      return render_tile(*scene, settings, {}).work;
    });
    const std::string alone = by_itself(*scene, receivers, runs);
    for (const ScenePart& part : scene->parts())
      if (part.name == "shadow maps")
        built += fmt::format("- {}: {:.1f} MiB, {:.0f} ms on one thread ({}); {}\n", name,
                             static_cast<double>(part.bytes) / (1 << 20), part.build_ms, part.why,
                             alone);
  }
  fmt::print("\n{}", built);
  return 0;
}

}  // namespace
}  // namespace lucerna

int main(int argc, char** argv) {
  tbb::task_arena arena(1);
  return arena.execute([&] { return lucerna::run(argc > 1 ? std::stoi(argv[1]) : 5); });
}
