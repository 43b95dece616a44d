// Compares light mathematics in float and in double in one run: time, and error against the
// references of tests/data/extremes/ordinary_lights.txt.  Not a test; `make precision` writes its
// output to docs/precision.md.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <stdexcept>
#include <string>
#include <vector>

#include "lights/maths/gauss.h"
#include "lights/models/light.h"
#include "lights/sampling/sobol.h"
#include "tests/reference_table.h"

namespace lucerna {
namespace {

using testing::ReferenceTable;

const Vec3<double> kFar{3000, -4000, 12};

/// A receiver, a sample value, and the reference results.
struct Place {
  Vec3<double> receiver;
  Vec2<double> u;
  double truth;
};

std::vector<Place> places(const ReferenceTable& table, const std::string& light) {
  std::vector<Place> all;
  for (const auto& row : table.rows())
    if (row.text("light") == light)
      all.push_back({{row["x"], row["y"], row["z"]}, {row["ux"], row["uy"]}, row["truth"]});
  if (all.empty()) throw std::runtime_error("no references of the light " + light);
  return all;
}

template <typename Real>
Receiver<Real> receiver_at(const Vec3<double>& p) {
  Receiver<Real> receiver{Vec3<Real>(p)};
  // Does not apply the rule, whose outcome may depend on a rounding.
  receiver.area_sampling = AreaSampling::kSolidAngle;
  return receiver;
}

/// Value over density if there is one; 0 without light.
template <typename Real>
double estimate(const LightSample<Real>& s) {
  if (s.reason != NoLight::kNone) return 0;
  return s.delta ? double{s.value.g} : double{s.value.g} / double{s.pdf.per_sr};
}

/// The integral over all samples of a light whose density depends on the direction.  It uses
/// Gauss's rule in the four parts of the square in which samples of a disk are smooth.
template <typename Real, typename L>
double mean_estimate(const L& light, const Receiver<Real>& receiver) {
  constexpr std::size_t kNodes = 32;
  const Gauss<kNodes>& rule = gauss<kNodes>();
  double sum = 0;
  for (std::size_t i = 0; i < kNodes; ++i)
    for (std::size_t j = 0; j < kNodes; ++j) {
      const double a = rule.node[i], b = a * (2 * rule.node[j] - 1);
      const double weight = rule.weight[i] * rule.weight[j] * a / 2;
      for (const Vec2<double> p : {Vec2<double>{a, b}, {-a, b}, {b, a}, {b, -a}})
        sum += weight *
               estimate(light.sample_li(receiver, Vec2<Real>{static_cast<Real>((1 + p.x) / 2),
                                                             static_cast<Real>((1 + p.y) / 2)}));
    }
  return sum;
}

/// The worst relative error.
template <typename Real, typename L>
double worst(const L& light, const Vec3<double>& shift, const std::vector<Place>& places,
             bool mean) {
  double off = 0;
  for (const Place& p : places) {
    const Receiver<Real> receiver = receiver_at<Real>(p.receiver + shift);
    const double value =
        mean ? mean_estimate(light, receiver)
             : estimate(light.sample_li(
                   receiver, Vec2<Real>{static_cast<Real>(p.u.x), static_cast<Real>(p.u.y)}));
    off = std::max(off, std::fabs(value / p.truth - 1));
  }
  return off;
}

/// Nanoseconds of processor time per sample.
template <typename Real, typename L>
double time(const L& light, const std::vector<Place>& places) {
  constexpr std::uint32_t kValues = 1024;
  std::vector<Receiver<Real>> receivers;
  for (const Place& p : places) receivers.push_back(receiver_at<Real>(p.receiver));
  const SobolSequence sequence(2, 0);
  std::vector<Vec2<Real>> values;
  for (std::uint32_t i = 0; i < kValues; ++i) {
    const Vec2<float> u = sequence.pair(i, 0);
    values.push_back({u.x, u.y});
  }
  double sum = 0;
  const std::clock_t begin = std::clock();
  for (const auto& u : values)
    for (const auto& receiver : receivers) sum += estimate(light.sample_li(receiver, u));
  const double took_ns = 1e9 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  volatile double kept = sum;  // keeps the compiler from removing the work
  static_cast<void>(kept);
  return took_ns / static_cast<double>(values.size() * receivers.size());
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

/// `make(Real(), place)` returns the light with its middle at `place`.
template <typename Make>
void compare(const ReferenceTable& table, const std::string& name, const Make& make) {
  constexpr int kRepeats = 15;
  const std::vector<Place> all = places(table, name);
  const auto in_float = make(float(), Vec3<double>{}), far_float = make(float(), kFar);
  const auto in_double = make(double(), Vec3<double>{}), far_double = make(double(), kFar);
  std::vector<double> float_ns, double_ns, more_ns;
  for (int k = 0; k < kRepeats; ++k) {
    float_ns.push_back(time<float>(in_float, all));
    double_ns.push_back(time<double>(in_double, all));
    more_ns.push_back(double_ns.back() - float_ns.back());
  }
  const bool mean = name == "disk";
  fmt::print("| {} | {:.0f} | {:.0f} | {:+.0f} | {:.0e} | {:.0e} | {:.0e} | {:.0e} |\n", name,
             median(float_ns), median(double_ns), median(more_ns),
             worst<float>(in_float, {}, all, mean), worst<double>(in_double, {}, all, mean),
             worst<float>(far_float, kFar, all, mean), worst<double>(far_double, kFar, all, mean));
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
      "| light | ns a sample, float | double | difference | off, float | off, double | off, float, "
      "5 km away | off, double, 5 km away |\n|---|---|---|---|---|---|---|---|\n");
  const ReferenceTable table("ordinary_lights");
  compare(table, "point", []<typename Real>(Real, const Vec3<double>& p) {
    return *PointLight<Real>::create({p, Rgb<double>(1)});
  });
  compare(table, "spot", []<typename Real>(Real, const Vec3<double>& p) {
    return *SpotLight<Real>::create({p, {0, 0, -1}, Rgb<double>(1), 1.2, 0.5});
  });
  compare(table, "triangle", []<typename Real>(Real, const Vec3<double>& p) {
    const auto at = [&](double x, double y) { return Vec3<Real>(p + Vec3<double>{x, y, 0}); };
    std::vector<Triangle<Real>> t{{at(-0.5, -0.5), at(-0.5, 0.5), at(0.5, -0.5)}};
    return *TriangleMeshLight<Real>::create({Rgb<double>(1)}, *TriangleMesh<Real>::create(t));
  });
  compare(table, "rectangle", []<typename Real>(Real, const Vec3<double>& p) {
    const auto at = [&](double x, double y) { return Vec3<Real>(p + Vec3<double>{x, y, 0}); };
    std::vector<BilinearPatch<Real>> t{
        {at(-0.5, -0.5), at(-0.5, 0.5), at(0.5, -0.5), at(0.5, 0.5)}};
    return *PatchMeshLight<Real>::create({Rgb<double>(1)}, *PatchMesh<Real>::create(t));
  });
  compare(table, "sphere", []<typename Real>(Real, const Vec3<double>& p) {
    return *SphereLight<Real>::create({Rgb<double>(1)}, *Sphere<Real>::create(round_at<Real>(p)));
  });
  compare(table, "disk", []<typename Real>(Real, const Vec3<double>& p) {
    DiskParams params;
    params.radius_m = 0.5;
    params.reverse_orientation = true;
    params.world_from_object = Transform::translate(p);
    return *DiskLight<Real>::create({Rgb<double>(1)}, *Disk<Real>::create(params));
  });
  compare(table, "cylinder", []<typename Real>(Real, const Vec3<double>& p) {
    CylinderParams params;
    params.radius_m = 0.005;
    params.z_min_m = -0.005, params.z_max_m = 0.005;
    params.world_from_object = Transform::translate(p);
    return *CylinderLight<Real>::create({Rgb<double>(1)}, *Cylinder<Real>::create(params));
  });
  return EXIT_SUCCESS;
}

}  // namespace
}  // namespace lucerna

int main() {
  try {
    return lucerna::run();
  } catch (const std::exception& error) {
    fmt::print(stderr, "precision_bench: {}\n", error.what());
    return EXIT_FAILURE;
  }
}
