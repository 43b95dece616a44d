// Helpers for the sweeps over area lights: lights from rows of the tables, and integrals over all
// samples of a light.
#pragma once

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "lights/maths/gauss.h"
#include "lights/models/all_lights.h"
#include "lights/shapes/all_shapes.h"
#include "tests/extremes_sweep.h"
#include "tests/reference_table.h"

namespace lucerna::testing {

/// The components of `name` in a row.
inline Vec3 vector_in(const ReferenceTable::Row& row, const std::string& name) {
  return {row[name + "_x"], row[name + "_y"], row[name + "_z"]};
}

/// The receiver of a row with its normal, which samples points by `way`.
inline Receiver receiver_in(const ReferenceTable::Row& row, AreaSampling way) {
  Receiver receiver(vector_in(row, "receiver"));
  receiver.normal = vector_in(row, "normal");
  receiver.area_sampling = way;
  return receiver;
}

/// The irradiance of a light about the origin so small that its cosine at the receiver is constant.
/// It is the textbook's solid angle times that cosine.
inline double textbook_irradiance(float solid_angle_sr, const ReferenceTable::Row& row) {
  return solid_angle_sr * dot(vector_in(row, "normal"), normalized(-vector_in(row, "receiver")));
}

inline AreaLight triangle_light(const std::array<Vec3, 3>& corner) {
  return *AreaLight::create({Rgb(1), true},
                            *TriangleMesh::create({{corner[0], corner[1], corner[2]}}));
}
inline AreaLight patch_light(const std::array<Vec3, 4>& corner) {
  return *AreaLight::create({Rgb(1), true},
                            *PatchMesh::create({{corner[0], corner[1], corner[2], corner[3]}}));
}

/// Sums over samples of the whole unit square.
struct Seen {
  double solid_angle_sr = 0;  ///< the mean of 1 / density
  double irradiance_lx = 0;   ///< the mean of value cos / density
  double disagreement =
      0;  ///< the largest difference between the density of a sample and that of its point
  int without = 0;  ///< samples without light

  template <typename Light>
  void add(const Light& light, const Receiver& receiver, Vec2 u, double weight) {
    const auto sample = light.sample_li(receiver, u);
    if (sample.reason != NoLight::kNone) {
      ++without;
      return;
    }
    const double pdf = sample.pdf.per_sr;
    solid_angle_sr += weight / pdf;
    irradiance_lx += weight * sample.value.g * std::fmax(0, dot(receiver.normal, sample.wi)) / pdf;
    const double of_point =
        light.pdf_li(receiver, SurfacePoint{sample.point, sample.normal, sample.primitive}).per_sr;
    disagreement = std::fmax(disagreement, relative_error(of_point, pdf));
  }
};

/// How a sample value moves a point: by a share of a length, or of an area.  An area grows with the
/// square of a length, so the point is smooth in the root of the sample value.
enum class By { kShare, kRoot };

/// Integrates by Gauss's rule, which is exact to rounding for smooth integrands.
template <std::size_t kNodes = 24, typename Light>
Seen seen_by(const Light& light, const Receiver& receiver, By by_x = By::kShare,
             By by_y = By::kShare, Vec2 from = {0, 0}, Vec2 to = {1, 1}) {
  const Gauss<kNodes>& rule = gauss<kNodes>();
  struct Node {
    double at, weight;
  };
  const auto node = [&](std::size_t i, By by, double a, double b) {
    const double x = by == By::kRoot ? rule.node[i] * rule.node[i] : rule.node[i];
    const double w = rule.weight[i] * (by == By::kRoot ? 2 * rule.node[i] : 1);
    return Node{std::lerp(a, b, x), w * (b - a)};
  };
  Seen seen;
  for (std::size_t i = 0; i < kNodes; ++i)
    for (std::size_t j = 0; j < kNodes; ++j) {
      const Node x = node(i, by_x, from.x, to.x), y = node(j, by_y, from.y, to.y);
      seen.add(light, receiver, {x.at, y.at}, x.weight * y.weight);
    }
  return seen;
}

/// Integrates by the same rule on both sides of the square's diagonal, where a map may be folded.
/// Uses the roots of both sample values.
template <std::size_t kNodes = 24, typename Light>
Seen seen_beside_diagonal(const Light& light, const Receiver& receiver) {
  const Gauss<kNodes>& rule = gauss<kNodes>();
  Seen seen;
  for (std::size_t i = 0; i < kNodes; ++i)
    for (std::size_t j = 0; j < kNodes; ++j) {
      const double s = rule.node[i], t = rule.node[j];
      const double larger = s * s, smaller = larger * t * t;
      const double weight = rule.weight[i] * rule.weight[j] * (2 * s * larger) * (2 * t);
      seen.add(light, receiver, {larger, smaller}, weight);
      seen.add(light, receiver, {smaller, larger}, weight);
    }
  return seen;
}

/// Integrates functions with kinks at unknown places.  Halves the square across, then along, until
/// halves and whole agree to `enough`, for irradiances of about 1.
template <typename Light>
Seen seen_in_halves(const Light& light, const Receiver& receiver, By by_y, Vec2 from = {0, 0},
                    Vec2 to = {1, 1}, double enough = 1e-11, int depth = 26) {
  const auto part = [&](Vec2 a, Vec2 b) {
    return seen_by<12>(light, receiver, By::kShare, by_y, a, b);
  };
  const Vec2 middle{(from.x + to.x) / 2, (from.y + to.y) / 2};
  const Seen whole = part(from, to);
  for (const bool across : {true, false}) {
    const Vec2 end = across ? Vec2{middle.x, to.y} : Vec2{to.x, middle.y};
    const Vec2 begin = across ? Vec2{middle.x, from.y} : Vec2{from.x, middle.y};
    Seen first = part(from, end), second = part(begin, to);
    const double change = first.irradiance_lx + second.irradiance_lx - whole.irradiance_lx;
    if (std::fabs(change) <= enough * std::fmin(1, whole.irradiance_lx)) continue;
    if (depth == 0) break;
    first = seen_in_halves(light, receiver, by_y, from, end, enough, depth - 1);
    second = seen_in_halves(light, receiver, by_y, begin, to, enough, depth - 1);
    return {first.solid_angle_sr + second.solid_angle_sr,
            first.irradiance_lx + second.irradiance_lx,
            std::fmax(first.disagreement, second.disagreement), first.without + second.without};
  }
  return whole;
}

}  // namespace lucerna::testing
