#include "client/lab/distance_check.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "client/lab/comparison.h"
#include "client/lab/explain.h"
#include "client/lab/light_values.h"

namespace lucerna::verify {
namespace {

constexpr std::size_t kMostRows = 2000;
// The server knows places to about 1e-7 of their coordinates.
constexpr double kPrecision = 1e-6;
// The nearest tangent plane of a curved surface is off by less than this.
constexpr double kPlaneError = 0.1;

/// Rays of which the light is the first surface beyond `lower`, at most at `upper` [m].
struct Brackets {
  std::vector<std::size_t> rows;
  std::vector<double> lower, upper;

  void add(std::size_t row, double from, double to) {
    if (!(from >= 0 && from < to)) return;
    rows.push_back(row);
    lower.push_back(from);
    upper.push_back(to);
  }
};

/// Finds where rays meet a light, by questions about what lies between two points of a ray.
class SurfaceSearch {
 public:
  SurfaceSearch(Truth& truth, const v1::Light& light, const std::vector<Double3>& points,
                const std::vector<Double3>& directions)
      : truth_(truth),
        light_(light),
        points_(points),
        directions_(directions),
        distances(points.size(), kNaN) {}

  /// Keeps the distances of the brackets that hold the light.  Rows that have one stay.
  void search(const Brackets& all) {
    const std::vector<std::uint64_t> ahead =
        truth_.lights_ahead(places(all, all.lower), at_rows(directions_, all.rows));
    const std::vector<bool> empty = truth_.visible(places(all, all.lower), places(all, all.upper));
    Brackets found;
    for (std::size_t i = 0; i < all.rows.size(); ++i)
      if (ahead[i] == light_.id() && !empty[i] && std::isnan(distances[all.rows[i]]))
        found.add(all.rows[i], all.lower[i], all.upper[i]);
    const Brackets start = found;
    const auto is_wide = [&](std::size_t i) {
      return found.upper[i] - found.lower[i] > kPrecision * found.upper[i];
    };
    for (bool wide = !found.rows.empty(); wide;) {
      std::vector<double> middle;
      for (std::size_t i = 0; i < found.rows.size(); ++i)
        middle.push_back(0.5 * (found.lower[i] + found.upper[i]));
      const std::vector<bool> beyond =
          truth_.visible(places(start, start.lower), places(start, middle));
      wide = false;
      for (std::size_t i = 0; i < middle.size(); ++i) {
        (beyond[i] ? found.lower : found.upper)[i] = middle[i];
        wide |= is_wide(i);
      }
    }
    for (std::size_t i = 0; i < found.rows.size(); ++i)
      distances[found.rows[i]] = 0.5 * (found.lower[i] + found.upper[i]);
  }

 private:
  std::vector<Double3> places(const Brackets& b, const std::vector<double>& at) const {
    std::vector<Double3> result;
    for (std::size_t i = 0; i < at.size(); ++i)
      result.push_back(points_[b.rows[i]] + at[i] * directions_[b.rows[i]]);
    return result;
  }

  Truth& truth_;
  const v1::Light& light_;
  const std::vector<Double3>& points_;
  const std::vector<Double3>& directions_;

 public:
  std::vector<double> distances;  ///< [m], NaN where the light was not found
};

/// Where the ray enters and leaves the bounds of the light, with a margin [m].
std::pair<double, double> within_bounds(const v1::Light& light, const Double3& x,
                                        const Double3& w) {
  const Double3 lower = double3(light.bounds().lower_m()),
                upper = double3(light.bounds().upper_m());
  const double margin = 1e-3 * length(upper - lower);
  double enters = 0, leaves = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 3; ++i) {
    const double a = (lower[i] - margin - x[i]) / w[i], b = (upper[i] + margin - x[i]) / w[i];
    if (std::isnan(a) || std::isnan(b)) continue;  // along a face
    enters = std::max(enters, std::min(a, b));
    leaves = std::min(leaves, std::max(a, b));
  }
  return {enters, leaves};
}

/// Distances to the surface of a light.  `claimed`: where it may be.  A ray may meet the light
/// several times, so a surface at the claimed distance is right.  NaN where the light was not
/// found.
std::vector<double> surface_distances(Truth& truth, const v1::Light& light,
                                      const std::vector<Double3>& points,
                                      const std::vector<Double3>& directions,
                                      const std::vector<double>& claimed, double tolerance) {
  const std::vector<double> planes = hits(truth, light, points, directions).distance;
  SurfaceSearch surface(truth, light, points, directions);
  if (is_plane(light.diffuse_area())) surface.distances = planes;
  // From nearer starts too: something may be just in front of the light.
  for (const double share : {1.0, 0.1, 0.01}) {
    Brackets near;
    for (std::size_t i = 0; i < points.size(); ++i)
      if (std::isnan(surface.distances[i]))
        near.add(i, claimed[i] * (1 - share * tolerance), claimed[i] * (1 + tolerance));
    surface.search(near);
  }
  for (const bool by_planes : {true, false}) {
    Brackets wide;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (!std::isnan(surface.distances[i])) continue;
      const auto [enters, leaves] = within_bounds(light, points[i], directions[i]);
      if (by_planes) {
        wide.add(i, planes[i] * (1 - kPlaneError), planes[i] * (1 + kPlaneError));
      } else if (std::isfinite(leaves)) {
        wide.add(i, enters, leaves);
      }
    }
    surface.search(wide);
  }
  // What is far from the nearest plane of the light is wrong, wherever the light is.
  for (std::size_t i = 0; i < points.size(); ++i)
    if (std::isnan(surface.distances[i]) &&
        std::fabs(claimed[i] - planes[i]) > kPlaneError * planes[i])
      surface.distances[i] = planes[i];
  return surface.distances;
}

}  // namespace

Finding check_distances(Truth& truth, const v1::Light& light, const Records& all_rows,
                        const Strictness& strictness) {
  const Records rows = rows_of(all_rows, some_rows(all_rows.rows, kMostRows));
  Finding f;
  f.quantity = "distance";
  f.light = light.id();
  if (!light.has_bounds() && light.kind_case() != v1::Light::kBeam) {
    f.sentence = "a light at infinity has none";
    return f;
  }
  const auto distances = [&](const std::vector<std::size_t>& which,
                             const std::vector<Double3>& directions) {
    const std::vector<Double3> points = at_rows(rows.points, which);
    if (light.kind_case() != v1::Light::kDiffuseArea)
      return hits(truth, light, points, directions).distance;
    return surface_distances(truth, light, points, directions, at_rows(rows.distance, which),
                             std::max(strictness.tolerance, 10 * kPrecision));
  };
  const std::vector<std::size_t> every = some_rows(rows.rows, rows.rows);
  std::vector<double> ours = distances(every, rows.directions);
  const std::vector<bool> back = on_back(light, rows);
  for (std::size_t i = 0; i < ours.size(); ++i)
    if (back[i]) ours[i] = kNaN;
  const auto rounded = [&](const std::vector<std::size_t>& which) {
    return ranges_of(at_rows(rows.directions, which), strictness.angle_rad,
                     [&](const std::vector<Double3>& moved) { return distances(which, moved); });
  };
  compare(rows.distance, ours, rounded, rows.place, strictness, &f);
  if (f.rows == 0) f.sentence = "another surface hides the light in all rows";
  f.explain = [rows, ours, n = truth.lights().size()](Finding& finding) {
    std::vector<Hypothesis> hypotheses;
    add_factors(ours, n, &hypotheses);
    std::vector<double> squares = ours, inverse = ours;
    for (double& d : squares) d *= d;
    for (double& d : inverse) d = 1 / d;
    hypotheses.push_back({"inverse_square", "the distance is squared", squares, 1});
    hypotheses.push_back({"distance", "the distance is inverted", inverse, 1});
    name_mistake(likely_mistake(rows.distance, ours, {}, hypotheses), &finding);
  };
  return f;
}

}  // namespace lucerna::verify
