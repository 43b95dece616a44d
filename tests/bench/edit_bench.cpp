// Edits of the lights of a large scene: 1 000 000 triangles, 10 000 point lights, and a lamp of
// 10 000 triangles.
//
//     edit_bench
//
// Prints the time of each edit, the median of nine, and the memory of the revision that dims.
#include <fmt/core.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <exception>
#include <functional>
#include <stdexcept>
#include <vector>

#include "server/scene/scene.h"

namespace lucerna {
namespace {

/// A bumpy sheet of 2 n^2 triangles.
TriangleMeshData sheet(std::uint32_t n, double size_m, const Vec3& corner) {
  TriangleMeshData mesh;
  for (std::uint32_t i = 0; i <= n; ++i)
    for (std::uint32_t j = 0; j <= n; ++j) {
      const double u = double(i) / n, v = double(j) / n;
      mesh.positions.push_back(
          corner + Vec3{u * size_m, v * size_m, 0.03 * std::sin(40 * u) * std::cos(37 * v)});
    }
  for (std::uint32_t i = 0; i < n; ++i)
    for (std::uint32_t j = 0; j < n; ++j) {
      const std::uint32_t a = i * (n + 1) + j, c = a + n + 1;
      for (const std::uint32_t k : {a, c, a + 1, a + 1, c, c + 1}) mesh.indices.push_back(k);
    }
  return mesh;
}

SceneDescription describe() {
  SceneDescription scene;
  scene.materials.push_back({});
  scene.shapes.push_back({.geometry = sheet(708, 10, {0, 0, 0})});
  scene.shapes.push_back({.geometry = sheet(71, 1, {4, 4, 2}),
                          .emission = {{.radiance_cd_m2 = {10, 10, 10}, .where = {}}}});
  for (int i = 0; i < 10'000; ++i)
    scene.lights.push_back(
        {PointLightParams{{0.1 * (i % 100), 0.1 * (i / 100), 2.5}, {1, 1, 1}}, {}});
  return scene;
}

template <typename T>
T value(absl::StatusOr<T> result) {
  if (!result.ok()) throw std::runtime_error(result.status().ToString());
  return *std::move(result);
}

double median_ms(const std::function<void(int)>& f) {
  std::vector<double> ms;
  for (int i = 0; i < 9; ++i) {
    const auto begin = std::chrono::steady_clock::now();
    f(i);
    ms.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin)
                     .count());
  }
  std::ranges::sort(ms);
  return ms[ms.size() / 2];
}

int run() {
  const tbb::global_control two(tbb::global_control::max_allowed_parallelism, 2);
  const auto scene = value(Scene::build(describe()));
  fmt::print("scene: {} triangles, {} lights, {:.1f} MB\n", scene->geometry().primitive_count(),
             scene->lights().size(), static_cast<double>(scene->bytes()) / 1e6);
  std::shared_ptr<const Scene> revision;
  const auto time = [&](const char* what, std::uint64_t light,
                        const std::function<void(LightChange&, int)>& change) {
    const double ms = median_ms([&](int i) {
      LightEdits edits;
      change(edits.changes[light], i);
      revision = value(Scene::revise(scene, std::move(edits)));
    });
    fmt::print(
        "{:24} {:8.2f} ms, {:.3f} MB of its own: {:.2f}% of the scene's\n", what, ms,
        static_cast<double>(revision->own_bytes()) / 1e6,
        100 * static_cast<double>(revision->own_bytes()) / static_cast<double>(scene->bytes()));
  };
  time("dim a point light", 5000, [](LightChange& c, int i) { c.scale = 0.5 + i; });
  time("move a point light", 5000, [](LightChange& c, int i) { c.shift_m.x = 0.1 * i + 0.1; });
  time("dim the lamp", 10'001, [](LightChange& c, int i) { c.scale = 0.5 + i; });
  time("move the lamp", 10'001, [](LightChange& c, int i) { c.shift_m.x = 0.1 * i + 0.1; });
  return 0;
}

}  // namespace
}  // namespace lucerna

int main() {
  try {
    return lucerna::run();
  } catch (const std::exception& e) {
    fmt::print(stderr, "edit_bench: {}\n", e.what());
    return 1;
  }
}
