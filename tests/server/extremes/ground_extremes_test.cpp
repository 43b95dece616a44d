// Row 36: grounds that are many times larger than what stands on them, level and tilted.  Points on
// the ground have no given error.  Lamps and screens are a hair above it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "server/estimate/render.h"
#include "server/queries/queries.h"
#include "server/queries/receiver_irradiance.h"
#include "server/queries/visibility.h"
#include "tests/extremes_sweep.h"
#include "tests/server/queries/li_samples.h"
#include "tests/server/scene/scenes.h"

namespace lucerna::testing {
namespace {

using Point = Vec3;

/// The plane of the ground: three unit vectors, the last one is its normal.
struct Plane {
  const char* name;
  Point x, y, n;
  Point at(double u, double v, double height) const { return x * u + y * v + n * height; }
};

const Plane kLevel{"level", {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
const Plane kTilted{"tilted", {0.6, 0, 0.8}, {-0.64, 0.6, 0.48}, {-0.48, -0.8, 0.36}};
/// Corners on this plane are no floats, whatever their size.
const Plane kRounded{"rounded", Point{2, 1, 2} / 3.0, Point{-2, 2, 1} / 3.0,
                     Point{-1, -2, 2} / 3.0};

enum class Kind { kTriangles, kPatch };

/// From -half to `reach` half on one axis, and to (2 reach - 1) half on the other.  Above 1 it has
/// no symmetry in which the rounding of corners cancels.
ShapeDescription rectangle(const Plane& plane, double half, double reach, double height,
                           Kind kind) {
  const double far = reach * half, farther = (2 * reach - 1) * half;
  const Point a = plane.at(-half, -half, height), b = plane.at(far, -half, height),
              c = plane.at(-half, farther, height), d = plane.at(far, farther, height);
  if (kind == Kind::kPatch) return patch(a, b, c, d);
  return shape(
      TriangleMeshData{.positions = {a, b, c, d}, .normals = {}, .indices = {0, 1, 2, 1, 3, 2}});
}

/// A square of 2 m whose outside faces the ground.
ShapeDescription facing_down(const Plane& plane, double height) {
  return patch(plane.at(1, -1, height), plane.at(-1, -1, height), plane.at(1, 1, height),
               plane.at(-1, 1, height));
}

/// Half sides from a thousand times the screens and lamps on it.
std::vector<double> half_sides() {
  std::vector<double> all;
  for (int exponent = 3; exponent <= 9; ++exponent) all.push_back(std::pow(10.0, exponent));
  return all;
}

template <typename F>
void for_each_ground(F&& f, const std::vector<Plane>& planes = {kLevel, kTilted, kRounded}) {
  for (const Plane& plane : planes)
    for (const Kind kind : {Kind::kTriangles, Kind::kPatch})
      for (const double half : half_sides())
        f(plane, kind, half,
          fmt::format("{} {} of {:g} m", plane.name, kind == Kind::kPatch ? "patch" : "triangles",
                      half));
}

/// Points of the ground, within `radius` of the middle.
std::vector<Point> points_on(const Plane& plane, double radius, int count) {
  std::mt19937 random(36);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::vector<Point> points;
  while (static_cast<int>(points.size()) < count) {
    const double u = unit(random), v = unit(random);
    if (u * u + v * v < 1) points.push_back(plane.at(radius * u, radius * v, 0));
  }
  return points;
}

std::vector<float> floats(const std::vector<Point>& points) {
  std::vector<float> all;
  for (const Point& p : points)
    for (const double c : {p.x, p.y, p.z}) all.push_back(static_cast<float>(c));
  return all;
}

/// The direct illuminance of points on the ground, as EstimateIrradiance answers.
std::vector<IrradianceEstimate> direct_lx(const Scene& scene, const Plane& plane,
                                          const std::vector<Point>& points) {
  const std::vector<float> offsets = floats(points);
  const ToScene to_scene(scene, {{}, offsets}, std::nullopt);
  const Vec3f normal(plane.n);
  std::vector<IrradiancePoint> at;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const ScenePoint p = on_surface(scene, to_scene(i), normal);
    at.push_back({p.position, {p.error, p.error, p.error}, plane.n});
  }
  return estimate_irradiance(scene, at, {.samples_per_block = 4, .block_count = 4, .bounces = 0},
                             {})
      .points;
}

/// A ground, a screen over its middle and a point light over the screen.
SceneDescription screened(const Plane& plane, Kind kind, double half, double height) {
  SceneDescription d = description();
  d.shapes = {rectangle(plane, half, 1.3, 0, kind),
              rectangle(plane, 1, 1, height, Kind::kTriangles)};
  LightDescription light;
  PointLightParams point;
  point.intensity_cd = Rgb(100);
  point.position_m = plane.at(0, 0, 2);
  light.params = point;
  d.lights = {light};
  return d;
}

constexpr double kHeights[] = {1e-3, 0.5};

// Points within 0.45 m of the middle are in the shadow of a screen of half side 1, and points 2 m
// away on each axis are not, if the screen is at 1e-3 or at 0.5 m.
TEST(GroundExtremes, ShadowsOfScreens) {
  Sweep sweep(36, "points on a ground, under a screen 1e-3 or 0.5 m above it and beside it",
              "grounds of 1e3 ... 1e9 m, level and tilted, triangles and patches",
              "lit in the shadow, or dark beside it");
  std::int64_t wrong = 0, cases = 0;
  for_each_ground([&](const Plane& plane, Kind kind, double half, const std::string& what) {
    for (const double height : kHeights) {
      const auto scene = build(screened(plane, kind, half, height));
      std::vector<Point> points = points_on(plane, 0.45, 100);
      const std::size_t shaded = points.size();
      for (const double u : {-2.0, 2.0}) points.push_back(plane.at(u, u, 0));
      const auto lx = direct_lx(*scene, plane, points);
      for (std::size_t i = 0; i < points.size(); ++i, ++cases) {
        const double distance2 = 4 + (i < shaded ? 0 : 8);
        const double truth = i < shaded ? 0 : 100 * 2 / std::pow(distance2, 1.5);
        const double value = luminance(lx[i].irradiance_lx);
        if (std::fabs(value - truth) <= 1e-5 * truth) continue;
        if (++wrong < 10) ADD_FAILURE() << what << ", " << height << " m: " << value << " at " << i;
      }
    }
  });
  sweep.expect_none(wrong, cases, 0);
}

TEST(GroundExtremes, LampsJustAboveTheGround) {
  Sweep sweep(36, "points on a ground, 1e-4 and 1e-3 m under a lamp of 2 m",
              "grounds of 1e3 ... 1e9 m, level and tilted, triangles and patches", "irradiance");
  // Near a ground of rounded corners, such a lamp is sampled.
  for_each_ground(
      [&](const Plane& plane, Kind kind, double half, const std::string& what) {
        for (const double height : {1e-4, 1e-3}) {
          SceneDescription d = description();
          d.shapes = {rectangle(plane, half, 1.3, 0, kind),
                      emissive(facing_down(plane, height), 2)};
          const auto scene = build(std::move(d));
          // The lamp fills the hemisphere but for a share of height^2.
          const auto lx = direct_lx(*scene, plane, points_on(plane, 0.45, 20));
          for (const IrradianceEstimate& e : lx)
            sweep.compare(luminance(e.irradiance_lx), 2 * std::numbers::pi,
                          fmt::format("{}, {:g} m", what, height));
        }
      },
      {kLevel, kTilted});
  sweep.expect_within(1e-5);
}

// Shadow rays end 16 roundings before a lamp, so they pass a sheet there.  No answer may then claim
// to be exact.
TEST(GroundExtremes, SheetsJustBeforeLamps) {
  Sweep sweep(36, "points below a lamp, with a sheet 5 to 11 roundings before the lamp",
              "coordinates of 1 ... 1e9 m, triangles and patches", "exact, but wrong");
  std::int64_t wrong = 0, cases = 0;
  for (int exponent = 0; exponent <= 9; ++exponent) {
    const double z = std::pow(10.0, exponent);
    for (const Kind kind : {Kind::kTriangles, Kind::kPatch}) {
      for (const double roundings : {5.0, 7.0, 9.0, 11.0}) {
        const double s = 1e-3 * z;
        SceneDescription d = description();
        d.shapes = {emissive(patch(kLevel.at(s, -s, z), kLevel.at(-s, -s, z), kLevel.at(s, s, z),
                                   kLevel.at(-s, s, z)),
                             2),
                    rectangle(kLevel, 0.1 * z, 1, z - roundings * 0x1p-24 * z, kind),
                    // So that the scene keeps its origin.
                    rectangle(kLevel, s, 1, -z, kind)};
        const auto scene = build(std::move(d));
        std::vector<Point> points;
        for (const double below : {0.03, 0.1, 0.3, 0.9})
          points.push_back(kLevel.at(0, 0, z - below * z));
        for (const IrradianceEstimate& e : direct_lx(*scene, kLevel, points)) {
          ++cases;
          if (e.exact && luminance(e.irradiance_lx) > 0 && ++wrong < 10)
            ADD_FAILURE() << z << " m, " << roundings << " roundings";
        }
      }
    }
  }
  sweep.expect_none(wrong, cases, 0);
}

TEST(GroundExtremes, VisibilityOfSamples) {
  Sweep sweep(36, "samples of a light, from points under a screen and beside it",
              "grounds of 1e3 ... 1e9 m, level and tilted, triangles and patches",
              "visible in the shadow, or hidden beside it");
  std::int64_t wrong = 0, cases = 0;
  for_each_ground([&](const Plane& plane, Kind kind, double half, const std::string& what) {
    for (const double height : kHeights) {
      const auto scene = build(screened(plane, kind, half, height));
      std::vector<Point> points = points_on(plane, 0.45, 100);
      const std::size_t shaded = points.size();
      for (const double u : {-2.0, 2.0}) points.push_back(plane.at(u, u, 0));
      const std::size_t n = points.size();
      const std::vector<float> offsets = floats(points);
      const std::vector<float> normals = floats(std::vector<Point>(n, plane.n));
      const LiSamples s(*scene, {.receivers = {{}, offsets},
                                 .seed = SeedRange{},
                                 .test_visibility = true,
                                 .normals = normals});
      for (std::size_t i = 0; i < n; ++i, ++cases) {
        if (s.is_visible(i) == (i >= shaded) && s.is_ok(i)) continue;
        if (++wrong < 10) ADD_FAILURE() << what << ", " << height << " m, point " << i;
      }
    }
  });
  sweep.expect_none(wrong, cases, 0);
}

/// Whether each segment is free.
std::vector<bool> visible(const Scene& scene, const std::vector<Point>& from,
                          const std::vector<Point>& to, const std::vector<Point>& normals) {
  const std::vector<float> a = floats(from), b = floats(to), n = floats(normals);
  std::vector<std::uint8_t> bits(from.size() / 8 + 1);
  std::vector<int> status(from.size());
  test_visibility(scene, {.from = {{}, a}, .to = PointArray{{}, b}, .normals = n},
                  {bits.data(), nullptr, status.data()}, {});
  std::vector<bool> seen;
  for (std::size_t i = 0; i < from.size(); ++i) seen.push_back((bits[i / 8] >> (i % 8) & 1) != 0);
  return seen;
}

TEST(GroundExtremes, Segments) {
  Sweep sweep(36,
              "segments from the ground, with and without a normal, to points under and over a "
              "screen; segments through the ground",
              "grounds of 1e3 ... 1e9 m, level and tilted, triangles and patches",
              "hidden or visible, wrongly");
  std::int64_t wrong = 0, cases = 0;
  for_each_ground([&](const Plane& plane, Kind kind, double half, const std::string& what) {
    const auto scene = build(screened(plane, kind, half, 0.5));
    const std::vector<Point> ground = points_on(plane, 0.45, 100);
    const std::vector<Point> normals(ground.size(), plane.n);
    std::vector<Point> below(ground), under(ground), over(ground), above(ground);
    for (std::size_t i = 0; i < ground.size(); ++i) {
      below[i] = ground[i] - plane.n * 1e-2;
      above[i] = ground[i] + plane.n * 1e-2;
      under[i] = ground[ground.size() - 1 - i] + plane.n * 0.4;
      over[i] = ground[ground.size() - 1 - i] + plane.n * 0.6;
    }
    const auto expect = [&](const char* which, const std::vector<bool>& seen, bool right) {
      for (std::size_t i = 0; i < seen.size(); ++i, ++cases) {
        if (seen[i] == right) continue;
        if (++wrong < 10) ADD_FAILURE() << what << ": " << which << " " << i;
      }
    };
    expect("under, normal", visible(*scene, ground, under, normals), true);
    expect("over, normal", visible(*scene, ground, over, normals), false);
    expect("under", visible(*scene, ground, under, {}), true);
    expect("over", visible(*scene, ground, over, {}), false);
    expect("above to under", visible(*scene, above, under, {}), true);
    expect("below to above", visible(*scene, below, above, {}), false);
    expect("below to under", visible(*scene, below, under, {}), false);
  });
  sweep.expect_none(wrong, cases, 0);
}

// The product of a sheet's edges and a short distance is tiny, relative to the ground's size.
TEST(GroundExtremes, SmallSheets) {
  Sweep sweep(36, "segments from a small sheet above a ground, to points over and under it",
              "sheets of 1e-3 ... 1 m, grounds of 1e3 ... 1e9 m, level and tilted",
              "hidden or visible, wrongly");
  std::int64_t wrong = 0, cases = 0;
  for_each_ground([&](const Plane& plane, Kind kind, double half, const std::string& what) {
    for (const double size : {1e-3, 1e-2, 0.1, 1.0}) {
      const double height = 10 * size;
      SceneDescription d = description();
      d.shapes = {rectangle(plane, half, 1.3, 0, kind),
                  rectangle(plane, size / 2, 1, height, Kind::kTriangles)};
      const auto scene = build(std::move(d));
      std::vector<Point> on = points_on(plane, 0.4 * size, 20);
      std::vector<Point> over, under, beyond;
      for (Point& p : on) {
        p = p + plane.n * height;
        over.push_back(p + plane.n * size + plane.x * size);
        under.push_back(p - plane.n * size + plane.x * size);
        beyond.push_back(p - plane.n * (11 * size));
      }
      const std::vector<Point> up(on.size(), plane.n), down(on.size(), -plane.n);
      const auto expect = [&](const char* which, const std::vector<bool>& seen, bool right) {
        for (std::size_t i = 0; i < seen.size(); ++i, ++cases) {
          if (seen[i] == right) continue;
          if (++wrong < 10)
            ADD_FAILURE() << what << ", sheet of " << size << " m: " << which << " " << i;
        }
      };
      expect("up", visible(*scene, on, over, up), true);
      expect("down", visible(*scene, on, under, down), true);
      expect("through the ground", visible(*scene, on, beyond, down), false);
      expect("beside the sheet", visible(*scene, over, under, {}), true);
    }
  });
  sweep.expect_none(wrong, cases, 0);
}

TEST(GroundExtremes, Pictures) {
  Sweep sweep(36, "pictures of a ground with the shadow of a screen, seen from above",
              "grounds of 1e3 ... 1e9 m, level and tilted, triangles and patches",
              "lit pixels in the shadow, or dark ones beside it");
  std::int64_t wrong = 0, cases = 0;
  for_each_ground([&](const Plane& plane, Kind kind, double half, const std::string& what) {
    // From 0.4 m, under a screen at 0.5 m and under a light at 2 m, or beside the screen.
    for (const bool shaded : {true, false}) {
      SceneDescription d = screened(plane, kind, half, 0.5);
      const Point eye = plane.at(shaded ? 0 : 4, 0, 0.4);
      d.camera.world_from_camera = *Transform::look_at(eye, eye - plane.n, plane.y);
      d.film = {.width = 16, .height = 12};
      const auto scene = build(std::move(d));
      const TileSettings settings{
          .rect = {0, 0, 16, 12}, .samples_per_block = 1, .block_count = 2, .bounces = 0};
      const TileResult tile = render_tile(*scene, settings, {});
      for (std::size_t i = 0; i < tile.channels.size(); ++i, ++cases) {
        if ((tile.channels[i].sum > 0) == !shaded) continue;
        if (++wrong < 10) ADD_FAILURE() << what << ", channel " << i << " " << shaded;
      }
    }
  });
  sweep.expect_none(wrong, cases, 0);
}

}  // namespace
}  // namespace lucerna::testing
