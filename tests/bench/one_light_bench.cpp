// What a scene with one point light pays for all that other scenes can have: bytes, and nanoseconds
// a sample, against loops written by hand for that light alone, at the same flags and with the same
// answers.  Medians of paired runs on one thread.
#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "server/denormals.h"
#include "server/queries.h"
#include "server/render.h"
#include "tests/server/scenes.h"

namespace lucerna {
namespace {

constexpr std::size_t kReceivers = 1 << 16;
constexpr int kRuns = 41;
constexpr Vec3<double> kLamp{0.5, -0.25, 3};
constexpr double kCandela = 100;

/// What the light itself is.
struct Lamp {
  Vec3<double> position;
  Rgb<double> intensity;
};

struct Arrays {
  std::vector<float> value = std::vector<float>(3 * kReceivers);
  std::vector<float> wi = value, offsets = value, normals = value;
  std::vector<float> distance = std::vector<float>(kReceivers), pdf = distance;
  std::vector<std::uint8_t> delta = std::vector<std::uint8_t>(kReceivers / 8), visible = delta;
  std::vector<std::uint64_t> ids = std::vector<std::uint64_t>(kReceivers);
  std::vector<double> probability = std::vector<double>(kReceivers);
  std::vector<int> status = std::vector<int>(kReceivers);
  SampleLiAnswer answer() {
    return {value.data(),   wi.data(),          distance.data(), offsets.data(),
            normals.data(), pdf.data(),         delta.data(),    visible.data(),
            ids.data(),     probability.data(), status.data()};
  }
};

/// SampleLi for one point light: the same arrays, the same numbers to a rounding.
void sample_by_hand(const Lamp& lamp, const std::vector<float>& receivers, Arrays& a) {
  for (std::size_t i = 0; i < kReceivers; ++i) {
    const Vec3<double> to = lamp.position - Vec3<double>(triple(receivers, i));
    const double squared = dot(to, to), distance = std::sqrt(squared), inverse = 1 / squared;
    store(a.wi.data(), i, Vec3<float>(to * (1 / distance)));
    store(
        a.value.data(), i,
        Vec3<float>(Vec3<double>(lamp.intensity.r, lamp.intensity.g, lamp.intensity.b) * inverse));
    store(a.offsets.data(), i, Vec3<float>(lamp.position));
    a.distance[i] = static_cast<float>(distance);
    a.pdf[i] = 1;
    a.delta[i / 8] |= static_cast<std::uint8_t>(1u << (i % 8));
    a.status[i] = static_cast<int>(ItemResult::kOk);
  }
}

/// EstimateIrradiance for one point light; a ray where there is a scene to hit.
void irradiance_by_hand(const Lamp& lamp, const std::vector<IrradiancePoint>& points,
                        const Scene* scene, std::vector<Rgb<double>>& answer) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    const IrradiancePoint& p = points[i];
    const Vec3<double> to = lamp.position - p.position;
    const double squared = dot(to, to), distance = std::sqrt(squared);
    const double cosine = dot(Vec3<double>(p.normal), to) / distance;
    answer[i] = {};
    if (!(cosine > 0)) continue;
    if (scene != nullptr) {
      const Vec3<float> start =
          offset_origin(Vec3<float>(p.position), p.position_error, Vec3<double>(p.normal), to);
      if (scene->occluded({start, Vec3<float>(lamp.position) - start, 0, 1})) continue;
    }
    answer[i] = lamp.intensity * (cosine / squared);
  }
}

double nanoseconds(const std::function<void()>& f) {
  const auto start = std::chrono::steady_clock::now();
  f();
  return std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - start)
             .count() /
         kReceivers;
}

double median(std::vector<double> v) {
  std::ranges::sort(v);
  return v[v.size() / 2];
}

void compare(const char* what, const std::function<void()>& by_hand,
             const std::function<void()>& by_scene) {
  std::vector<double> hand, scene, ratio;
  for (int i = 0; i < kRuns; ++i) {
    hand.push_back(nanoseconds(by_hand));
    scene.push_back(nanoseconds(by_scene));
    ratio.push_back(scene.back() / hand.back());
  }
  fmt::print("| {} | {:.1f} | {:.1f} | {:.2f} |\n", what, median(hand), median(scene),
             median(ratio));
}

void run() {
  const DenormalsAreZero denormals;
  SceneDescription d = testing::description();
  d.lights = {testing::point_light(kLamp, kCandela)};
  const auto bare = testing::build(d);
  d.shapes = {testing::floor(10)};
  const auto with_floor = testing::build(d);
  const auto lamp_in = [](const Scene& scene) {
    return Lamp{kLamp - scene.origin(), Rgb<double>(kCandela)};
  };

  std::mt19937 random(1);
  std::uniform_real_distribution<float> u(-9, 9);
  std::vector<float> receivers;
  std::vector<IrradiancePoint> points, floor_points;
  for (std::size_t i = 0; i < kReceivers; ++i) {
    const Vec3<float> p{u(random), u(random), 0};
    receivers.insert(receivers.end(), {p.x, p.y, p.z});
    const float e = 0x1p-19f;
    points.push_back({Vec3<double>(p) - bare->origin(), {e, e, e}, {0, 0, 1}});
    floor_points.push_back({Vec3<double>(p) - with_floor->origin(), {e, e, e}, {0, 0, 1}});
  }

  fmt::print("bytes: the light {}, the scene {}", sizeof(Lamp), bare->bytes());
  for (const ScenePart& part : bare->parts()) fmt::print("; {} {}", part.name, part.bytes);
  fmt::print("; one entry of its table of lights {}\n\n", sizeof(SceneLight));
  fmt::print("| ns a sample | by hand | by the scene | ratio |\n|---|---|---|---|\n");

  Arrays by_hand, by_scene;
  const std::vector<float> numbers(2 * kReceivers, 0.5f);
  SampleLiQuery query;
  query.receivers = {bare->origin(), receivers};
  query.light = 0;
  query.u = numbers;
  const Lamp of_bare = lamp_in(*bare), of_floor = lamp_in(*with_floor);
  compare(
      "SampleLi", [&] { sample_by_hand(of_bare, receivers, by_hand); },
      [&] { sample_li(*bare, query, by_scene.answer(), {}); });
  std::vector<Rgb<double>> answer(kReceivers);
  IrradianceSettings settings{.block_count = 16, .bounces = 0};
  compare(
      "irradiance, nothing to hit", [&] { irradiance_by_hand(of_bare, points, nullptr, answer); },
      [&] { estimate_irradiance(*bare, points, settings, {}); });
  compare(
      "irradiance over a floor, with a shadow ray",
      [&] { irradiance_by_hand(of_floor, floor_points, with_floor.get(), answer); },
      [&] { estimate_irradiance(*with_floor, floor_points, settings, {}); });
  double off = 0;
  for (std::size_t i = 0; i < by_hand.value.size(); ++i)
    off = std::max(off, std::fabs(1.0 - by_hand.value[i] / by_scene.value[i]));
  fmt::print("\nvalues of SampleLi differ by {:.1e} of them at most\n", off);
}

}  // namespace
}  // namespace lucerna

int main() {
  tbb::task_arena arena(1);
  arena.execute([] { lucerna::run(); });
}
