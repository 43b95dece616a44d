// Measures the cost of a shaft, and how often it proves to be empty: a Cornell box, and rooms with
// furniture and lamps.  Times are medians over the same receivers, in alternation.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "lights/sampling/sobol.h"
#include "proto/common/quantile.h"
#include "server/runtime/denormals.h"
#include "server/visibility/shaft.h"
#include "tests/server/scene/scenes.h"

namespace lucerna {
namespace {

using testing::emissive;
using testing::patch;
/// A quadrilateral from its corners in ring order.
ShapeDescription around(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return patch(a, b, d, c);
}

/// The measured box, in metres: https://www.graphics.cornell.edu/online/box/data.html
SceneDescription cornell_box() {
  SceneDescription d = testing::description();
  const auto add = [&](std::initializer_list<Vec3> corners) {
    std::vector<Vec3> v;
    for (const Vec3& c : corners) v.push_back(c * 1e-3);
    d.shapes.push_back(around(v[0], v[1], v[2], v[3]));
  };
  add({{552.8, 0, 0}, {0, 0, 0}, {0, 0, 559.2}, {549.6, 0, 559.2}});
  add({{556, 548.8, 0}, {556, 548.8, 559.2}, {0, 548.8, 559.2}, {0, 548.8, 0}});
  add({{549.6, 0, 559.2}, {0, 0, 559.2}, {0, 548.8, 559.2}, {556, 548.8, 559.2}});
  add({{0, 0, 559.2}, {0, 0, 0}, {0, 548.8, 0}, {0, 548.8, 559.2}});
  add({{552.8, 0, 0}, {549.6, 0, 559.2}, {556, 548.8, 559.2}, {556, 548.8, 0}});
  const auto block = [&](double height, const std::array<Vec3, 4>& foot) {
    const Vec3 up{0, height, 0};
    add({foot[0] + up, foot[1] + up, foot[2] + up, foot[3] + up});
    for (int i = 0; i < 4; ++i)
      add({foot[i], foot[i] + up, foot[(i + 1) % 4] + up, foot[(i + 1) % 4]});
  };
  block(165, {Vec3{130, 0, 65}, {82, 0, 225}, {240, 0, 272}, {290, 0, 114}});
  block(330, {Vec3{423, 0, 247}, {265, 0, 296}, {314, 0, 456}, {472, 0, 406}});
  d.shapes.push_back(emissive(around(Vec3{343, 548.7, 227} * 1e-3, Vec3{343, 548.7, 332} * 1e-3,
                                     Vec3{213, 548.7, 332} * 1e-3, Vec3{213, 548.7, 227} * 1e-3),
                              1, true));
  return d;
}

/// A room of 12 x 8 x 3 m with lamps of three kinds and this many boxes as furniture.
SceneDescription room(int boxes) {
  SceneDescription d = testing::description();
  const auto box = [&](const Vec3& low, const Vec3& high) {
    const auto c = [&](int i) {
      return Vec3{i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z};
    };
    for (const auto& f : {std::array{0, 1, 3, 2}, std::array{4, 5, 7, 6}, std::array{0, 1, 5, 4},
                          std::array{2, 3, 7, 6}, std::array{0, 2, 6, 4}, std::array{1, 3, 7, 5}})
      d.shapes.push_back(around(c(f[0]), c(f[1]), c(f[2]), c(f[3])));
  };
  box({0, 0, 0}, {12, 8, 3});
  std::mt19937 random(3);
  std::uniform_real_distribution<double> u(0, 1);
  for (int i = 0; i < boxes; ++i) {
    const Vec3 low{11 * u(random), 7 * u(random), 0};
    box(low, low + Vec3{0.3 + u(random), 0.3 + u(random), 0.4 + 0.6 * u(random)});
  }
  for (int i = 0; i < 6; ++i) {
    const double x = 1 + 2 * i, z = 2.98;
    d.shapes.push_back(
        emissive(around({x, 2, z}, {x, 2.6, z}, {x + 0.6, 2.6, z}, {x + 0.6, 2, z}), 1, true));
    d.shapes.push_back(
        emissive(testing::shape(DiskParams{.radius_m = 0.15,
                                           .world_from_object = Transform::translate({x, 5, z})}),
                 1, true));
    d.shapes.push_back(
        emissive(testing::shape(SphereParams{
                     .radius_m = 0.1, .world_from_object = Transform::translate({x, 6.5, 2.4})}),
                 1));
  }
  return d;
}

void measure(const std::string& name, SceneDescription description, const Vec3& lower,
             const Vec3& upper) {
  using Clock = std::chrono::steady_clock;
  const DenormalsAreZero denormals;
  const auto scene = testing::build(std::move(description));
  const auto begin = Clock::now();
  const Shafts shafts(*scene);
  const double build_ms = std::chrono::duration<double, std::milli>(Clock::now() - begin).count();

  constexpr std::uint32_t kSamples = 256;
  constexpr int kRepeats = 8;
  int pairs = 0, open = 0, empty = 0, wrong = 0;
  std::vector<double> form, empty_ns, full_ns, ray_ns, samples_ns;
  volatile double sink = 0;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> u(0, 1);
  for (int i = 0; i < 400; ++i) {
    const Vec3 from = lower + Vec3{u(random) * (upper.x - lower.x), u(random) * (upper.y - lower.y),
                                   u(random) * (upper.z - lower.z)};
    const Vec3 w = normalized(Vec3{u(random) - 0.5, u(random) - 0.5, u(random) - 0.5});
    const auto hit = scene->closest_hit({Vec3f(from), Vec3f(w)});
    if (!hit || hit->light >= 0) continue;
    SurfaceHit r = *hit;
    if (dot(r.ng, w) > 0) r.ng = -r.ng;
    r.ns = r.ng;
    Receiver receiver(r.position);
    receiver.normal = r.ns;
    for (std::uint32_t l = 0; l < scene->lights().size(); ++l) {
      const auto timed = [&](int repeats, const auto& f) {
        const auto start = Clock::now();
        for (int k = 0; k < repeats; ++k) f();
        return std::chrono::duration<double, std::nano>(Clock::now() - start).count() / repeats;
      };
      double lx = 0;
      const double form_ns = timed(
          kRepeats, [&] { lx = scene->lights()[l].light->irradiance(receiver).value_or(Rgb()).g; });
      if (!(lx > 0)) continue;
      form.push_back(form_ns);
      bool is_empty = false;
      const double ns = timed(kRepeats, [&] { is_empty = shafts.is_empty(r, Vec3f(r.ns), l); });
      (is_empty ? empty_ns : full_ns).push_back(ns);
      std::uint32_t lit = 0, blocked = 0;
      double sum = 0, one_ray = 0;
      samples_ns.push_back(timed(1, [&] {
        const SobolSequence sequence(1, static_cast<std::uint64_t>(i), l);
        for (std::uint32_t k = 0; k < kSamples; ++k) {
          const Vec2f v = sequence.pair(k, 0);
          const auto s = scene->lights()[l].light->sample_li(receiver, {v.x, v.y});
          const double cosine = dot(receiver.normal, s.wi);
          if (s.reason != NoLight::kNone || !(cosine > 0)) continue;
          ++lit;
          const Ray ray = shadow_ray(r, s);
          if (scene->geometry().occluded(ray)) {
            ++blocked;
            if (k == 0) one_ray = 0;
          } else {
            sum += s.value.g * cosine / s.pdf.per_sr;
          }
        }
      }));
      const auto s = scene->lights()[l].light->sample_li(receiver, {0.5, 0.5});
      const Ray ray = shadow_ray(r, s);
      ray_ns.push_back(timed(kRepeats, [&] { one_ray += scene->geometry().occluded(ray); }));
      sink = sink + sum + one_ray;
      ++pairs, open += lit > 0 && blocked == 0, empty += is_empty;
      wrong += is_empty && blocked > 0;
    }
  }
  fmt::print(
      "{}: built in {:.3f} ms, {} bytes for {} primitives; {} receivers and lights, {} open by {} "
      "rays, {} empty ({:.1f}%), {} wrong\n"
      "  median ns: closed form {:.0f}, shaft if empty {:.0f}, if not {:.0f}, a shadow ray {:.0f}, "
      "{} "
      "samples {:.0f}\n",
      name, build_ms, shafts.bytes(), scene->geometry().primitive_count(), pairs, open, kSamples,
      empty, 100.0 * empty / std::max(1, open), wrong, median(form),
      empty_ns.empty() ? 0 : median(empty_ns), full_ns.empty() ? 0 : median(full_ns),
      median(ray_ns), kSamples, median(samples_ns));
}

}  // namespace
}  // namespace lucerna

int main() {
  lucerna::measure("Cornell box", lucerna::cornell_box(), {0.01, 0.01, 0.01}, {0.54, 0.54, 0.55});
  for (const int boxes : {0, 20, 200, 5000})
    lucerna::measure(fmt::format("room, {} boxes", boxes), lucerna::room(boxes), {0.1, 0.1, 1},
                     {11.9, 7.9, 2.9});
}
