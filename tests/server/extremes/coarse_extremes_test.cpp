// Row 22: points with coarse coordinates, such as floats far from their origin, and distant
// surfaces that are level with them to within that error.  The error decides which surface a point
// lies on.  Every other surface occludes, wherever it is.
#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "server/queries/visibility.h"
#include "tests/server/extremes/ray_counts.h"

namespace lucerna::testing {
namespace {

class CoarseExtremes : public RayCounts {};

enum class Blocker { kNone, kTriangles, kPatch, kDisk };
/// The ground: one shape, or two that meet between the points and the blocker.
enum class Ground { kNone, kOne, kTwo };

TriangleMeshData level(double x0, double x1, double half, double z) {
  return {{{x0, -half, z}, {x1, -half, z}, {x0, half, z}, {x1, half, z}}, {}, {0, 1, 2, 1, 3, 2}};
}

/// A blocker half an error above the ground, at 20 to 130 errors' distance.
std::shared_ptr<const Scene> coarse_scene(double error, Blocker blocker, Ground ground) {
  SceneDescription d = description();
  const double z = 0.5 * error, from = 20 * error, to = 130 * error, half = 60 * error;
  if (blocker == Blocker::kTriangles) d.shapes.push_back({level(from, to, half, z)});
  if (blocker == Blocker::kPatch)
    // Bent by a fraction of the error, so that it stays a patch.
    d.shapes.push_back(testing::patch({from, -half, z}, {to, -half, z}, {from, half, z},
                                      {to, half, z + 0.01 * error}));
  if (blocker == Blocker::kDisk)
    d.shapes.push_back(
        {DiskParams{.radius_m = (to - from) / 2,
                    .world_from_object = Transform::translate({(from + to) / 2, 0, z})}});
  const double middle = 15 * error, beyond = 200 * error;
  if (ground == Ground::kOne) d.shapes.push_back({level(-beyond, beyond, beyond, 0)});
  if (ground == Ground::kTwo) {
    d.shapes.push_back({level(-beyond, middle, beyond, 0)});
    d.shapes.push_back({level(middle, beyond, beyond, 0)});
  }
  return build(std::move(d));
}

/// Segments that climb by one error in 150, from points within a third of an error of the ground.
/// The points are floats about a place 2^21 `error` away.
struct Ways {
  Vec3 origin;
  std::vector<float> from, to, along, lengths;
};

Ways coarse_ways(double error, std::size_t n) {
  Ways ways{{-0x1p21 * error, 0, 0}, {}, {}, {}, {}};
  Random random(3);
  const auto put = [](std::vector<float>& to, const Vec3& v) {
    const Vec3f f(v);
    to.insert(to.end(), {f.x, f.y, f.z});
  };
  for (std::size_t i = 0; i < n; ++i) {
    const auto share = [&](double a, double b) { return (a + (b - a) * uniform(random)) * error; };
    // Only some floats exist at that distance.
    const Vec3 p{0, share(-5, 5), share(-0.3, 0.3)}, q{150 * error, share(-5, 5), share(0.8, 1.2)};
    put(ways.from, p - ways.origin), put(ways.to, q - ways.origin);
    put(ways.along, q - p);
    ways.lengths.push_back(static_cast<float>(length(q - p)));
  }
  return ways;
}

/// How many points are visible, by segments and by rays.
std::int64_t visible(const Scene& scene, const Ways& ways) {
  const std::size_t n = ways.lengths.size();
  std::int64_t sum = 0;
  for (const bool segments : {true, false}) {
    VisibilityQuery query{.from = {ways.origin, ways.from}};
    if (segments)
      query.to = PointArray{ways.origin, ways.to};
    else
      query.directions = ways.along, query.lengths_m = ways.lengths;
    std::vector<std::uint8_t> bits((n + 7) / 8);
    std::vector<int> status(n);
    test_visibility(scene, query, {bits.data(), nullptr, status.data()}, {});
    for (std::size_t i = 0; i < n; ++i) sum += bits[i / 8] >> (i % 8) & 1;
  }
  return sum;
}

TEST_F(CoarseExtremes, DistantSurfacesLevelWithAPointOcclude) {
  Sweep sweep(
      22, "points with coarse coordinates, and surfaces at the same height, 20 to 130 errors away",
      "errors of 5e-27 ... 5e6 m", "surfaces missed, or the ground of the point hit");
  for (int exponent = -88; exponent <= 22; exponent += 10) {
    const double error = std::ldexp(1.0, exponent);
    const Ways ways = coarse_ways(error, 2000 * rays_times());
    const auto of = static_cast<std::int64_t>(2 * ways.lengths.size());
    for (const Ground ground : {Ground::kNone, Ground::kOne, Ground::kTwo})
      for (const Blocker blocker :
           {Blocker::kNone, Blocker::kTriangles, Blocker::kPatch, Blocker::kDisk}) {
        const std::int64_t seen = visible(*coarse_scene(error, blocker, ground), ways);
        Count c{.rays = of};
        (blocker == Blocker::kNone ? c.shadows : c.leaks) =
            blocker == Blocker::kNone ? of - seen : seen;
        expect(c, {error, {}, "error " + std::to_string(exponent)}, 1e-9);
      }
  }
  finish(sweep);
}

}  // namespace
}  // namespace lucerna::testing
