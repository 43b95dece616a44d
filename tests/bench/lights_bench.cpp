// Nanoseconds per light sample: SampleLi of each light model for a batch of receivers, and the
// sample points that feed it.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "lights/models/all_lights.h"
#include "lights/sampling/inverse_square.h"
#include "lights/sampling/sobol.h"
#include "lights/shapes/all_shapes.h"

namespace lucerna {
namespace {

constexpr int kBatch = 1024;

std::vector<Vec3f> receivers() {
  std::vector<Vec3f> points;
  const SobolSequence sequence(1, 0);
  for (std::uint32_t i = 0; i < kBatch; ++i) {
    const Vec2f u = sequence.pair(i, 0);
    points.emplace_back(4 * u.x - 2, 4 * u.y - 2, 0.0f);
  }
  return points;
}

template <typename L>
void sample_li(benchmark::State& state, const L& light) {
  const std::vector<Vec3f> points = receivers();
  const SobolSequence sequence(2, 0);
  for (auto _ : state) {
    float sum = 0;
    for (std::uint32_t i = 0; i < kBatch; ++i)
      sum += light.sample_li(points[i], sequence.pair(i, 0)).value.g;
    benchmark::DoNotOptimize(sum);
  }
  state.SetItemsProcessed(state.iterations() * kBatch);
}

void BM_Sobol(benchmark::State& state) {
  const SobolSequence sequence(2, 0);
  for (auto _ : state) {
    float sum = 0;
    for (std::uint32_t i = 0; i < kBatch; ++i) sum += sequence.pair(i, 0).x;
    benchmark::DoNotOptimize(sum);
  }
  state.SetItemsProcessed(state.iterations() * kBatch);
}
BENCHMARK(BM_Sobol);

void BM_SampleLiPoint(benchmark::State& state) {
  sample_li(state, *PointLight::create({{0, 0, 2}, Rgb(1)}));
}
BENCHMARK(BM_SampleLiPoint);

void BM_SampleLiSpot(benchmark::State& state) {
  sample_li(state, *SpotLight::create({{0, 0, 2}, {0, 0, -1}, Rgb(1), 0.7, 0.5}));
}
BENCHMARK(BM_SampleLiSpot);

/// A sample of the spot with the edge of its fall-off as `share(height above the cone's edge)`.
/// This measures the cost of the division by the edge's width.  All receivers are within the edge,
/// so that no branch is mispredicted.
template <typename Share>
void spot_with_edge(benchmark::State& state, const Share& share) {
  const std::vector<Vec3f> points = receivers();
  double one_minus_cos_cone = 1 - std::cos(1.2);
  benchmark::DoNotOptimize(one_minus_cos_cone);
  for (auto _ : state) {
    float sum = 0;
    for (const Vec3f& point : points) {
      LightSample sample;
      const Way way = find_way({0, 0, 2}, point, sample);
      const Vec3 chord = -way.wi - Vec3{0, 0, -1};
      const double inside = one_minus_cos_cone - dot(chord, chord) / 2;
      const double x = std::clamp(share(inside), 0.0, 1.0);
      if (x > 0) set_inverse_square(Rgb(1) * (x * x * (3 - 2 * x)), way, sample);
      sum += sample.value.g;
    }
    benchmark::DoNotOptimize(sum);
  }
  state.SetItemsProcessed(state.iterations() * kBatch);
}

void BM_SpotEdgeByReciprocal(benchmark::State& state) {
  double per_edge = 1 / (std::cos(0.2) - std::cos(1.2));
  benchmark::DoNotOptimize(per_edge);
  spot_with_edge(state, [&](double inside) { return inside * per_edge; });
}
BENCHMARK(BM_SpotEdgeByReciprocal);

void BM_SpotEdgeByQuotient(benchmark::State& state) {
  double edge = std::cos(0.2) - std::cos(1.2);
  benchmark::DoNotOptimize(edge);
  spot_with_edge(state, [&](double inside) { return inside / edge; });
}
BENCHMARK(BM_SpotEdgeByQuotient);

void BM_SampleLiProjection(benchmark::State& state) {
  ProjectionLightParams params;
  params.position_m = {0, 0, 2};
  params.axes = {{0, 1, 0}, {1, 0, 0}, {0, 0, -1}};
  params.intensity_cd = Rgb(1);
  params.picture = *ProjectedPicture::create(
      {*Image::create(64, 64, std::vector<Rgbf>(64 * 64, Rgbf(1))), ImageFilter::kNearest, 1.5});
  sample_li(state, *ProjectionLight::create(params));
}
BENCHMARK(BM_SampleLiProjection);

void BM_SampleLiDistant(benchmark::State& state) {
  sample_li(state, *DistantLight::create({{0, 0.6, 0.8}, Rgb(1)}));
}
BENCHMARK(BM_SampleLiDistant);

void BM_SampleLiUniformInfinite(benchmark::State& state) {
  sample_li(state, *UniformInfiniteLight::create({Rgb(1)}));
}
BENCHMARK(BM_SampleLiUniformInfinite);

void BM_SampleLiTriangle(benchmark::State& state) {
  std::vector<Triangle> triangle = {{{0, 0, 2}, {0, 1, 2}, {1, 0, 2}}};
  sample_li(state, *AreaLight::create({Rgb(1), true}, *TriangleMesh::create(triangle)));
}
BENCHMARK(BM_SampleLiTriangle);

void BM_SampleLiPatch(benchmark::State& state) {
  std::vector<BilinearPatch> patch = {{{0, 0, 2}, {0, 1, 2}, {1, 0, 2}, {1, 1, 2}}};
  sample_li(state, *AreaLight::create({Rgb(1), true}, *PatchMesh::create(patch)));
}
BENCHMARK(BM_SampleLiPatch);

void BM_SampleLiSphere(benchmark::State& state) {
  SphereParams params;
  params.radius_m = 0.5;
  params.world_from_object = Transform::translate({0, 0, 2});
  sample_li(state, *AreaLight::create({Rgb(1)}, *Sphere::create(params)));
}
BENCHMARK(BM_SampleLiSphere);

void BM_SampleLiDisk(benchmark::State& state) {
  DiskParams params;
  params.height_m = 2;
  params.reverse_orientation = true;
  sample_li(state, *AreaLight::create({Rgb(1)}, *Disk::create(params)));
}
BENCHMARK(BM_SampleLiDisk);

}  // namespace
}  // namespace lucerna
