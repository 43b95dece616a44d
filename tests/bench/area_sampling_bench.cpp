// Compares the ways to choose points on area lights: variance and time, side by side.  Not a test.
// lights/sampling/area_sampling.cpp has the rule that follows from these tables.
//
//     ninja -C build/release area_sampling_bench && build/release/tests/bench/area_sampling_bench
//
// For each light, place and way it prints n times the variance of the irradiance with n samples,
// over the square of the irradiance.  Samples are Owen-scrambled Sobol points.  `lit` is the
// whole light.  `edge` hides one side of a straight edge through its middle, in the mean of eight
// edges.  It also prints the time of a sample [ns] and `cost`, variance times time relative to the
// first way.  For `cost` the variance is the mean of n = 1 and n = 16, with one place in ten on an
// edge.  The time is that of a sample and of the other work of a query.
#include <fmt/core.h>

#include <ctime>
#include <string>
#include <vector>

#include "lights/models/all_lights.h"
#include "lights/sampling/sobol.h"
#include "lights/shapes/all_shapes.h"

namespace lucerna {
namespace {

/// Other work of a query per sample [ns]: a shadow ray, and a ray in a direction sampled at the
/// surface, at 300 ns each (demo.pbrt takes 370).
constexpr double kRestOfASample = 600;

struct Place {
  std::string name;
  Vec3 receiver, normal;
};

/// The light is centred on the origin in the plane z = 0, has size 1 and emits to -z.
std::vector<Place> places() {
  std::vector<Place> all;
  for (const double d : {0.05, 0.1, 0.2, 0.5, 1., 2., 4., 8., 16.}) {
    all.push_back({fmt::format("facing, {} away", d), {0.1 * d, 0.05 * d, -d}, {0, 0, 1}});
    all.push_back({fmt::format("cut by the horizon, {} away", d),
                   {0.1 * d, 0.05 * d, -d},
                   normalized(Vec3{1, 0.2, 0.1})});
    all.push_back(
        {fmt::format("beside it, {} away", d), {0.7 + 0.8 * d, 0.1, -0.6 * d}, {0, 0, 1}});
    all.push_back({fmt::format("grazing, {} away", d),
                   {0.7 + d, 0.2, -0.05 * d},
                   normalized(Vec3{-1, 0.2, 0.4})});
  }
  return all;
}

struct Way {
  std::string name;
  AreaSampling way;
  bool normal;
};

struct Measured {
  double lit[2], edge[2];  // n = 1 and 16
  double ns;
};

double now_ns() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return 1e9 * double(t.tv_sec) + double(t.tv_nsec);
}

constexpr int kEdges = 8;

struct Moments {
  double sum = 0, squares = 0;
  void add(double v) { sum += v, squares += v * v; }
  double mean(int n) const { return sum / n; }
  double variance(int n) const { return squares / n - mean(n) * mean(n); }
};

template <typename L>
Measured measure(const L& light, const Place& place, const Way& way) {
  Receiver r{Vec3f(place.receiver)};
  r.area_sampling = way.way;
  if (way.normal) r.normal = Vec3f(place.normal);
  Measured m{};
  for (int k = 0; k < 2; ++k) {
    const int n = k == 0 ? 1 : 16, replicates = k == 0 ? 16384 : 2048;
    Moments lit, edge[kEdges];
    for (int i = 0; i < replicates; ++i) {
      const SobolSequence sequence(i, k);
      double e = 0, cut[kEdges] = {};
      for (int j = 0; j < n; ++j) {
        const auto s = light.sample_li(r, sequence.pair(j, 0));
        if (s.reason != NoLight::kNone) continue;
        const double one =
            s.value.g * std::fmax(0, dot(place.normal, Vec3(s.wi))) / s.pdf.per_sr / n;
        e += one;
        for (int a = 0; a < kEdges; ++a) {
          const double angle = 2 * std::numbers::pi * (a + 0.3) / kEdges;
          if (s.point.x * std::cos(angle) + s.point.y * std::sin(angle) > 0) cut[a] += one;
        }
      }
      lit.add(e);
      for (int a = 0; a < kEdges; ++a) edge[a].add(cut[a]);
    }
    const double square = lit.mean(replicates) * lit.mean(replicates);
    m.lit[k] = n * lit.variance(replicates) / square;
    for (const Moments& c : edge) m.edge[k] += n * c.variance(replicates) / square / kEdges;
  }

  m.ns = INFINITY;
  for (int repeat = 0; repeat < 5; ++repeat) {
    constexpr int kTimed = 2000;
    const SobolSequence sequence(1, 3);
    std::vector<Vec2f> u;
    for (std::uint32_t i = 0; i < kTimed; ++i) u.push_back(sequence.pair(i, 0));
    float sink = 0;
    const double start = now_ns();
    for (const auto& v : u) sink += light.sample_li(r, v).pdf.per_sr;
    const double ns = (now_ns() - start) / kTimed;
    if (sink > 0) m.ns = std::min(m.ns, ns);
  }
  return m;
}

double cost(const Measured& m) {
  double variance = 0;
  for (int k = 0; k < 2; ++k) variance += (0.9 * m.lit[k] + 0.1 * m.edge[k]) / 2;
  return variance * (m.ns + kRestOfASample);
}

template <typename L>
void table(const std::string& name, const L& light, const std::vector<Way>& ways,
           const std::vector<Place>& at = places()) {
  fmt::print("\n{}\n{:36} {:22} {:>9} {:>9} {:>9} {:>9} {:>5} {:>8}\n", name, "place", "way",
             "lit, 1", "lit, 16", "edge, 1", "edge, 16", "ns", "cost");
  std::vector<double> log_cost(ways.size());
  int seen = 0;
  for (const Place& place : at) {
    double first = 0;
    if (light.sample_li(Vec3f(place.receiver), {0.5F, 0.5F}).reason != NoLight::kNone)
      continue;  // inside of a sphere
    ++seen;
    for (std::size_t w = 0; w < ways.size(); ++w) {
      const Measured m = measure(light, place, ways[w]);
      if (w == 0) first = cost(m);
      log_cost[w] += std::log(cost(m) / first);
      fmt::print("{:36} {:22} {:9.3g} {:9.3g} {:9.3g} {:9.3g} {:5.0f} {:8.3f}\n", place.name,
                 ways[w].name, m.lit[0], m.lit[1], m.edge[0], m.edge[1], m.ns, cost(m) / first);
    }
  }
  for (std::size_t w = 0; w < ways.size(); ++w)
    fmt::print("{:36} {:22} {:52.3f}\n", "all places (geometric mean)", ways[w].name,
               std::exp(log_cost[w] / seen));
}

/// Inside of a sphere about the origin with radius 1/2.
std::vector<Place> places_within() {
  std::vector<Place> all;
  for (const double d : {0., 0.1, 0.25, 0.4, 0.45, 0.49})
    for (const double turn : {0., 2., 4.})
      all.push_back({fmt::format("{} off the centre, turned {}", d, turn),
                     {d, 0, 0},
                     {std::cos(turn), 0, std::sin(turn)}});
  return all;
}

const Way kLowDistortion{"low-distortion", AreaSampling::kLowDistortion, false};
const Way kSolidAngle{"solid-angle", AreaSampling::kSolidAngle, false};
const Way kCosine{"cosine-solid-angle", AreaSampling::kCosineSolidAngle, true};
const Way kAutomatic{"automatic", AreaSampling::kAutomatic, true};
const Way kAutomaticBlind{"automatic, no normal", AreaSampling::kAutomatic, false};

void run() {
  const Rgb level(1);
  using V = Vec3f;
  const auto triangle = [&](const V& a, const V& b, const V& c) {
    return *AreaLight::create({level}, *TriangleMesh::create({{a, b, c}}));
  };
  const std::vector<Way> triangle_ways{kLowDistortion,
                                       {"square-root", AreaSampling::kSquareRoot, false},
                                       {"kraemer", AreaSampling::kKraemer, false},
                                       {"parallelogram", AreaSampling::kParallelogram, false},
                                       {"rejection", AreaSampling::kRejection, false},
                                       kSolidAngle,
                                       kCosine,
                                       kAutomaticBlind,
                                       kAutomatic};
  table("triangle", triangle({-0.5F, -0.4F, 0}, {0, 0.6F, 0}, {0.6F, -0.3F, 0}), triangle_ways);
  table("half of a square", triangle({-0.5F, -0.5F, 0}, {-0.5F, 0.5F, 0}, {0.5F, -0.5F, 0}),
        triangle_ways);
  table("slim triangle", triangle({0.5F, 0.1F, 0}, {-0.5F, -0.05F, 0}, {-0.5F, 0.05F, 0}),
        triangle_ways);
  const auto rectangle = [&](float x, float y) {
    return *AreaLight::create(
        {level}, *PatchMesh::create({{V{-x, -y, 0}, V{-x, y, 0}, V{x, -y, 0}, V{x, y, 0}}}));
  };
  const std::vector<Way> ways{kLowDistortion, kSolidAngle, kCosine, kAutomaticBlind, kAutomatic};
  table("square", rectangle(0.5F, 0.5F), ways);
  table("strip 5 : 1", rectangle(0.5F, 0.1F), ways);
  table("sphere", *AreaLight::create({level}, *Sphere::create({.radius_m = 0.5})),
        {kLowDistortion, kSolidAngle, kAutomatic});
  table(
      "sphere from within",
      *AreaLight::create({level}, *Sphere::create({.radius_m = 0.5, .reverse_orientation = true})),
      {kLowDistortion, kSolidAngle, kAutomatic}, places_within());
  table("disk",
        *AreaLight::create({level}, *Disk::create({.radius_m = 0.5, .reverse_orientation = true})),
        {kLowDistortion, kSolidAngle, kAutomatic});
}

}  // namespace
}  // namespace lucerna

int main() { lucerna::run(); }
