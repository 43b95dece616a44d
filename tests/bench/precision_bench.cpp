// Light mathematics that takes and gives floats against the same in double, side by side in one
// run.  Not a test; `make precision` writes what it prints to docs/precision.md.
//
// Each light is 1 m in size and seen from a hundredth of that to 16 m away.  `off` is the worst
// relative error of the irradiance that samples stand for (value over density) against the light
// about its own zero in double: once where it stands about the scene's zero, once 5 km from it.
#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>
#include <vector>

#include "lights/light.h"
#include "lights/sobol.h"

namespace lucerna {
namespace {

constexpr int kBatch = 1024;
const Vec3<double> kFar{3000, -4000, 12};

/// Receivers below the light, about its middle.
std::vector<Vec3<double>> receivers() {
  std::vector<Vec3<double>> all;
  const SobolSequence sequence(1, 0);
  for (std::uint32_t i = 0; i < kBatch; ++i) {
    const Vec2<float> u = sequence.pair(i, 0), v = sequence.pair(i, 1);
    const double distance = 0.01 * std::exp2(u.x * std::log2(1600.0));
    all.push_back({(2.0 * v.x - 1) * distance, (2.0 * v.y - 1) * distance, -distance});
  }
  return all;
}

struct Measured {
  double ns;
  std::vector<double> irradiance;  // value over density, 0 where there is none
};

template <typename Real, typename L>
Measured sample(const L& light, const Vec3<double>& place) {
  const std::vector<Vec3<double>> offsets = receivers();
  std::vector<Receiver<Real>> points;
  for (const auto& o : offsets) {
    // Not by the rule, which a rounding may tip.
    points.emplace_back(Vec3<Real>(o + place)).area_sampling = AreaSampling::kSolidAngle;
  }
  const SobolSequence sequence(2, 0);
  Measured m{0, std::vector<double>(kBatch)};
  const auto begin = std::chrono::steady_clock::now();
  constexpr int kTimes = 32;
  for (int t = 0; t < kTimes; ++t)
    for (std::uint32_t i = 0; i < kBatch; ++i) {
      const Vec2<float> u = sequence.pair(i, 0);
      const auto s = light.sample_li(points[i], Vec2<Real>{u.x, u.y});
      m.irradiance[i] = s.reason != NoLight::kNone ? 0
                        : s.delta                  ? double{s.value.g}
                                                   : double{s.value.g} / double{s.pdf.per_sr};
    }
  const std::chrono::duration<double, std::nano> took = std::chrono::steady_clock::now() - begin;
  m.ns = took.count() / (kTimes * kBatch);
  return m;
}

double worst(const std::vector<double>& values, const std::vector<double>& truth) {
  double off = 0;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (truth[i] != 0) off = std::max(off, std::fabs(values[i] / truth[i] - 1));
  return off;
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

/// `make(Real(), place)`: the light with its middle at `place`.
template <typename Make>
void compare(const std::string& name, const Make& make) {
  constexpr int kRepeats = 15;
  const auto in_float = make(float(), Vec3<double>{}), far_float = make(float(), kFar);
  const auto in_double = make(double(), Vec3<double>{}), far_double = make(double(), kFar);
  const std::vector<double> truth = sample<double>(in_double, {}).irradiance;
  std::vector<double> float_ns, double_ns, more_ns;
  double off_float = 0;
  for (int k = 0; k < kRepeats; ++k) {
    const Measured a = sample<float>(in_float, {}), b = sample<double>(in_double, {});
    float_ns.push_back(a.ns), double_ns.push_back(b.ns), more_ns.push_back(b.ns - a.ns);
    off_float = worst(a.irradiance, truth);
  }
  fmt::print("| {} | {:.0f} | {:.0f} | {:+.0f} | {:.0e} | {:.0e} | {:.0e} |\n", name,
             median(float_ns), median(double_ns), median(more_ns), off_float,
             worst(sample<float>(far_float, kFar).irradiance, truth),
             worst(sample<double>(far_double, kFar).irradiance, truth));
}

template <typename Real>
SphereParams round_at(const Vec3<double>& p) {
  SphereParams params;
  params.radius_m = 0.005;
  params.world_from_object = Transform::translate(p);
  return params;
}

int run() {
  fmt::print(
      "| light | ns a sample, float | double | difference | off, float | off, float, 5 km "
      "away | off, double, 5 km away |\n|---|---|---|---|---|---|---|\n");
  compare("point", []<typename Real>(Real, const Vec3<double>& p) {
    return *PointLight<Real>::create({p, Rgb<double>(1)});
  });
  compare("spot", []<typename Real>(Real, const Vec3<double>& p) {
    return *SpotLight<Real>::create({p, {0, 0, -1}, Rgb<double>(1), 1.2, 0.5});
  });
  compare("triangle", []<typename Real>(Real, const Vec3<double>& p) {
    const auto at = [&](double x, double y) { return Vec3<Real>(p + Vec3<double>{x, y, 0}); };
    std::vector<Triangle<Real>> t{{at(-0.5, -0.5), at(-0.5, 0.5), at(0.5, -0.5)}};
    return *TriangleMeshLight<Real>::create({Rgb<double>(1)}, *TriangleMesh<Real>::create(t));
  });
  compare("rectangle", []<typename Real>(Real, const Vec3<double>& p) {
    const auto at = [&](double x, double y) { return Vec3<Real>(p + Vec3<double>{x, y, 0}); };
    std::vector<BilinearPatch<Real>> t{
        {at(-0.5, -0.5), at(-0.5, 0.5), at(0.5, -0.5), at(0.5, 0.5)}};
    return *PatchMeshLight<Real>::create({Rgb<double>(1)}, *PatchMesh<Real>::create(t));
  });
  compare("sphere of 5 mm", []<typename Real>(Real, const Vec3<double>& p) {
    return *SphereLight<Real>::create({Rgb<double>(1)}, *Sphere<Real>::create(round_at<Real>(p)));
  });
  compare("disk", []<typename Real>(Real, const Vec3<double>& p) {
    DiskParams params;
    params.radius_m = 0.5;
    params.reverse_orientation = true;
    params.world_from_object = Transform::translate(p);
    return *DiskLight<Real>::create({Rgb<double>(1)}, *Disk<Real>::create(params));
  });
  compare("cylinder", []<typename Real>(Real, const Vec3<double>& p) {
    CylinderParams params;
    params.radius_m = 0.005;
    params.z_min_m = -0.005, params.z_max_m = 0.005;
    params.world_from_object = Transform::translate(p);
    return *CylinderLight<Real>::create({Rgb<double>(1)}, *Cylinder<Real>::create(params));
  });
  return 0;
}

}  // namespace
}  // namespace lucerna

int main() { return lucerna::run(); }
