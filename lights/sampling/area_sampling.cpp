#include "lights/sampling/area_sampling.h"

#include <algorithm>
#include <cmath>

namespace lucerna {

namespace {

// The rule of kAutomatic comes from tests/bench/area_sampling_bench.cpp.  It measures 36 places, at
// distances from a twentieth of the light's size to sixteen sizes: in front, from aside, grazing,
// cut by the receiver's horizon.  The table shows variance times time of a sample relative to
// low-distortion sampling by area, as geometric means.
//
//                          square root  solid angle  cosine  the rule without and with a normal
//   triangle                      0.97         0.31    0.26    0.30    0.24
//   slim triangle                 0.94         0.22    0.16    0.22    0.15
//   square                           -         0.23    0.18    0.22    0.17
//   strip 5 : 1                      -         0.27    0.19    0.26    0.18
//   disk                             -         0.24       -    0.23       -
//   sphere, from outside             -         0.01       -    0.01       -
//   sphere, from within              -         0.19       -    0.19       -
//
// At each place the rule is 1% to 4% worse than the best way for triangles and rectangles.
//
// kFar: sampling by area has the density distance^3 over the receiver's height above the light.  If
// it varies by less than a quarter over the light, it is as good as a solid angle, which takes 110
// to 170 ns more.  This was measured in front of the light (1.8 sizes away) and from aside (9 sizes
// away).  The ratio of squared distances is 1.25^(2/3).
//
// kFarBesideDirections: along paths, directions of the surface are weighted against samples.  Most
// of the error then has other causes, such as occlusion and reflected light, and the time of a
// solid angle matters more.  For the same error, area sampling takes 0.68 of the time in
// scenes/cornell, and 1.9 times as long in tests/data/reference's rectangle_near.  The threshold
// lies between, at a density that varies by a factor of 2.5.
//
// kUneven, kLeastCosine: the cosine's warp takes 150 ns more.  It pays if the cosines to the
// corners vary by a factor of sqrt(3) or the horizon cuts the light.  It does not pay if all
// cosines are below three times its floor (a light on the horizon, more than 16 sizes away).
constexpr double kFar = 1.16;
constexpr double kFarBesideDirections = 1.84;
constexpr double kUneven = 3;
constexpr double kLeastCosine = 3 * kCosineFloor;
// Of the five ways by area the square root has the least variance at 1 and at 16 Sobol points.
constexpr AreaSampling kByArea = AreaSampling::kSquareRoot;
// Spheres always use solid angle.  From outside, it is also faster, and no sampled point faces
// away.  From within, it is as fast.

struct Range {
  double least, most;

  explicit Range(double v) : least(v), most(v) {}
  void add(double v) { least = v < least ? v : least, most = v > most ? v : most; }
};

AreaSampling by_distances(std::span<const Vec3> points, double far) {
  Vec3 sum;
  for (const auto& p : points) sum += p;
  const Vec3 middle = sum / static_cast<double>(points.size());
  Range squares(dot(middle, middle));
  for (const auto& p : points) squares.add(dot(p, p));
  return squares.most > far * squares.least ? AreaSampling::kSolidAngle : kByArea;
}

/// Squares of the cosines to the points; negative below the horizon.
Range squared_cosines(std::span<const Vec3> points, const Vec3& normal) {
  const auto square = [&](const Vec3& p) {
    const double height = dot(p, normal);
    return height * std::fabs(height) / dot(p, p);
  };
  Range range(square(points[0]));
  for (const auto& p : points.subspan(1)) range.add(square(p));
  return range;
}

}  // namespace

AreaSampling way_for_corners(AreaSampling requested, std::span<const Vec3> corners,
                             const Vec3& normal, bool incomplete) {
  const bool has_normal = normal != Vec3{};
  if (requested == AreaSampling::kCosineSolidAngle && !has_normal) return AreaSampling::kSolidAngle;
  if (requested != AreaSampling::kAutomatic) return requested;
  // The other directions of such receivers follow the cosine.
  if (incomplete) return by_distances(corners, kFarBesideDirections);
  if (has_normal) {
    const Range cosines = squared_cosines(corners, normal);
    if (cosines.most > kLeastCosine * kLeastCosine && cosines.most > kUneven * cosines.least)
      return AreaSampling::kCosineSolidAngle;
  }
  return by_distances(corners, kFar);
}

AreaSampling way_for_disk(AreaSampling requested, const Vec3& nearest, const Vec3& farthest,
                          bool incomplete) {
  if (requested == AreaSampling::kCosineSolidAngle) return AreaSampling::kSolidAngle;
  if (requested != AreaSampling::kAutomatic) return requested;
  const Vec3 rim[] = {nearest, farthest};
  return by_distances(rim, incomplete ? kFarBesideDirections : kFar);
}

AreaSampling way_for_sphere(AreaSampling requested) {
  return is_by_area(requested) ? requested : AreaSampling::kSolidAngle;
}

}  // namespace lucerna
