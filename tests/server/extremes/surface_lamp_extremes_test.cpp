// Row 42: lamps without a size at, on and just before the surfaces that they are mounted on.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "server/materials/fresnel.h"
#include "server/queries/queries.h"
#include "server/queries/receiver_irradiance.h"
#include "server/queries/visibility.h"
#include "tests/extremes_sweep.h"
#include "tests/server/queries/li_samples.h"
#include "tests/server/scene/scenes.h"

namespace lucerna::testing {
namespace {

using Point = Vec3;

constexpr Point kSize{6.1, 4.3, 2.8};

/// The frame of a room and its scale.
struct Setting {
  const char* name;
  Point x, y, z;
  double scale;
  bool patches;
  Point vector(const Point& p) const { return x * p.x + y * p.y + z * p.z; }
  Point at(const Point& p) const { return vector(p) * scale; }
  std::string text() const {
    return fmt::format("{}, {:g} m, {}", name, scale, patches ? "patches" : "triangles");
  }
};

template <typename F>
void for_each_setting(F&& f) {
  for (const bool patches : {false, true})
    for (int exponent = -9; exponent <= 9; exponent += 3) {
      const double scale = std::pow(10.0, exponent);
      f(Setting{"level", {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, scale, patches});
      f(Setting{"tilted", Point{2, 1, 2} / 3.0, Point{-2, 2, 1} / 3.0, Point{-1, -2, 2} / 3.0,
                scale, patches});
    }
}

/// Two edges of a face from a corner.
ShapeDescription face(const Setting& s, const Point& corner, const Point& u, const Point& v) {
  const Point a = s.at(corner), b = s.at(corner + u), c = s.at(corner + v),
              d = s.at(corner + u + v);
  if (s.patches) return patch(a, b, c, d);
  return shape(
      TriangleMeshData{.positions = {a, b, c, d}, .normals = {}, .indices = {0, 1, 2, 1, 3, 2}});
}

SceneDescription room(const Setting& s) {
  const Point x{kSize.x, 0, 0}, y{0, kSize.y, 0}, z{0, 0, kSize.z};
  SceneDescription d = description();
  d.shapes = {face(s, {}, x, y), face(s, {}, x, z), face(s, {}, y, z),
              face(s, x, y, z),  face(s, y, x, z),  face(s, z, x, y)};
  return d;
}

/// `steps` units in the last place below the coordinate, as a float of this scale has them.
double before(double coordinate, int steps, double scale) {
  return coordinate - steps * std::ldexp(1, std::ilogb(coordinate * scale) - 23) / scale;
}

struct Mount {
  const char* name;
  Point place;
};

/// On a wall, an edge and a corner.
std::array<Mount, 3> mounts(int steps, double scale) {
  const auto near = [&](double c) { return before(c, steps, scale); };
  return {{{"wall", {3.1, 2.2, near(kSize.z)}},
           {"edge", {near(kSize.x), 2.2, near(kSize.z)}},
           {"corner", {near(kSize.x), near(kSize.y), near(kSize.z)}}}};
}

enum class Lamp { kPoint, kSpot, kWeb };

LightDescription lamp_at(Lamp kind, const Setting& s, const Point& place) {
  const Rgb cd(s.scale * s.scale);
  LightDescription light{PointLightParams{s.at(place), cd}, {"test.pbrt", 5, 1}};
  // Into the room.
  const Point inwards = s.vector(normalized(Point{-1, -1, -2}));
  if (kind == Lamp::kSpot)
    light.params = SpotLightParams{.position_m = s.at(place),
                                   .axis = inwards,
                                   .intensity_cd = cd,
                                   .cone_half_angle_rad = 2.5,
                                   .falloff_start_rad = 2.5};
  if (kind == Lamp::kWeb) {
    GoniometricLightParams web;
    web.position_m = s.at(place), web.intensity = cd;
    light.params = web;
  }
  return light;
}

/// A receiver in the room's coordinates.
struct RoomPoint {
  Point place, normal;
};

/// On the floor and on two walls, from near to far.
std::vector<RoomPoint> receivers_inside() {
  std::mt19937 random(42);
  std::uniform_real_distribution<double> unit(0.02, 0.98);
  std::vector<RoomPoint> all;
  for (int i = 0; i < 20; ++i) {
    const double u = unit(random), v = unit(random);
    all.push_back({{u * kSize.x, v * kSize.y, 0}, {0, 0, 1}});
    all.push_back({{0, u * kSize.y, v * kSize.z}, {1, 0, 0}});
    all.push_back({{u * kSize.x, 0, v * kSize.z}, {0, 1, 0}});
  }
  return all;
}

std::vector<IrradiancePoint> points_of(const Scene& scene, const Setting& s,
                                       const std::vector<RoomPoint>& receivers) {
  std::vector<float> offsets;
  for (const RoomPoint& r : receivers) {
    const Point p = s.at(r.place);
    for (const double c : {p.x, p.y, p.z}) offsets.push_back(static_cast<float>(c));
  }
  const ToScene to_scene(scene, {{}, offsets}, std::nullopt);
  std::vector<IrradiancePoint> points;
  for (std::size_t i = 0; i < receivers.size(); ++i) {
    const Point n = s.vector(receivers[i].normal);
    const ScenePoint p = on_surface(scene, to_scene(i), Vec3f(n));
    points.push_back({p.position, {p.error, p.error, p.error}, n});
  }
  return points;
}

TEST(SurfaceLampExtremes, LampsOnWallsEdgesAndCorners) {
  Sweep sweep(42, "lamp without a size on a wall, an edge and a corner of a room",
              "0 ... 4 units in the last place before them, rooms of 1e-9 ... 1e9 m, level and "
              "tilted, triangles and patches",
              "irradiance in the room");
  const std::vector<RoomPoint> receivers = receivers_inside();
  for_each_setting([&](const Setting& s) {
    for (int steps = 0; steps <= 4; ++steps)
      for (const Mount& mount : mounts(steps, s.scale))
        for (const Lamp kind : {Lamp::kPoint, Lamp::kSpot, Lamp::kWeb}) {
          SceneDescription d = room(s);
          d.lights = {lamp_at(kind, s, mount.place)};
          const auto scene = build(std::move(d));
          const auto points = points_of(*scene, s, receivers);
          for (const auto visibility : {VisibilityMethod::kRays, VisibilityMethod::kShadowMaps}) {
            if (visibility == VisibilityMethod::kShadowMaps && (steps % 4 != 0 || s.scale != 1))
              continue;
            IrradianceSettings settings{.samples_per_block = 1, .block_count = 2, .bounces = 0};
            settings.methods.visibility = visibility;
            const auto lx = estimate_irradiance(*scene, points, settings, {}).points;
            for (std::size_t i = 0; i < points.size(); ++i) {
              const Point to = s.at(mount.place) - points[i].position;
              const double d2 = dot(to, to);
              const double truth =
                  s.scale * s.scale * dot(to, points[i].normal) / (d2 * std::sqrt(d2));
              sweep.compare(
                  luminance(lx[i].irradiance_lx), truth,
                  fmt::format("{}, {} at the {}, point {}", s.text(), steps, mount.name, i));
            }
          }
        }
  });
  sweep.expect_within(1e-9);
}

TEST(SurfaceLampExtremes, SamplesOfLampsOnSurfaces) {
  Sweep sweep(42, "samples of a lamp on a wall, an edge and a corner, receivers without normals",
              "0 ... 4 units in the last place before them, rooms of 1e-9 ... 1e9 m, level and "
              "tilted, triangles and patches",
              "hidden in the room");
  const std::vector<RoomPoint> receivers = receivers_inside();
  std::int64_t wrong = 0, cases = 0;
  for_each_setting([&](const Setting& s) {
    std::vector<float> offsets;
    for (const RoomPoint& r : receivers) {
      const Point p = s.at(r.place);
      for (const double c : {p.x, p.y, p.z}) offsets.push_back(static_cast<float>(c));
    }
    const std::size_t n = receivers.size();
    for (int steps = 0; steps <= 4; ++steps)
      for (const Mount& mount : mounts(steps, s.scale)) {
        SceneDescription d = room(s);
        d.lights = {lamp_at(Lamp::kPoint, s, mount.place)};
        const auto scene = build(std::move(d));
        const LiSamples samples(
            *scene, {.receivers = {{}, offsets}, .seed = SeedRange{}, .test_visibility = true});
        for (std::size_t i = 0; i < n; ++i, ++cases) {
          if (samples.is_visible(i)) continue;
          if (++wrong < 10)
            ADD_FAILURE() << s.text() << ", " << steps << " at the " << mount.name << ", point "
                          << i;
        }
      }
  });
  sweep.expect_none(wrong, cases, 0);
}

TEST(SurfaceLampExtremes, RoomsBehindTheWall) {
  Sweep sweep(42, "the same lamps, from outside of the room",
              "4 units in the last place before a wall, an edge and a corner, or 32 if they are "
              "tilted; rooms of 1e-9 ... 1e9 m, triangles and patches",
              "lit");
  std::vector<RoomPoint> receivers;
  std::mt19937 random(43);
  std::uniform_real_distribution<double> unit(0.1, 0.9);
  for (int i = 0; i < 20; ++i)
    receivers.push_back(
        {{unit(random) * kSize.x, unit(random) * kSize.y, kSize.z + unit(random)}, {0, 0, -1}});
  std::int64_t wrong = 0, cases = 0;
  for_each_setting([&](const Setting& s) {
    // The corners of a tilted wall have larger coordinates than its distance from zero.
    for (const int steps : {s.x == Point{1, 0, 0} ? 4 : 32})
      for (const Mount& mount : mounts(steps, s.scale)) {
        SceneDescription d = room(s);
        d.lights = {lamp_at(Lamp::kPoint, s, mount.place)};
        const auto scene = build(std::move(d));
        const auto lx = estimate_irradiance(*scene, points_of(*scene, s, receivers),
                                            {.block_count = 2, .bounces = 0}, {})
                            .points;
        for (std::size_t i = 0; i < lx.size(); ++i, ++cases)
          if (luminance(lx[i].irradiance_lx) != 0 && ++wrong < 10)
            ADD_FAILURE() << s.text() << ", " << steps << " at the " << mount.name << ", point "
                          << i;
      }
  });
  sweep.expect_none(wrong, cases, 0);
}

// The image of the lamp is at the lamp itself.  No pane is between them.
TEST(SurfaceLampExtremes, LampsOnMirrorsAndPanes) {
  Sweep sweep(42, "lamp without a size on a mirror and on a pane",
              "0 ... 4 units in the last place before them, sizes of 1e-9 ... 1e9 m, level and "
              "tilted, triangles and patches",
              "irradiance before the mirror, with its reflection");
  std::mt19937 random(44);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::vector<RoomPoint> receivers;
  for (int i = 0; i < 8; ++i)
    receivers.push_back({{3 + 2 * unit(random), 2 + 2 * unit(random), unit(random)}, {0, 0, 1}});
  for_each_setting([&](const Setting& s) {
    for (const bool is_pane : {false, true})
      for (int steps = 0; steps <= 4; ++steps) {
        const Point place{3.1, 2.2, before(kSize.z, steps, s.scale)};
        SceneDescription d = description();
        d.materials = {{.params = is_pane ? MaterialParams{ThinDielectricParams{{1.5}}}
                                          : MaterialParams{MetalParams{.eta = ColourValue{Rgb(1)},
                                                                       .k = ColourValue{Rgb(4)}}}}};
        d.shapes = {face(s, {-20, -20, kSize.z}, {40, 0, 0}, {0, 40, 0})};
        d.lights = {lamp_at(Lamp::kPoint, s, place)};
        const auto scene = build(std::move(d));
        const auto points = points_of(*scene, s, receivers);
        const auto lx =
            estimate_irradiance(*scene, points,
                                {.samples_per_block = 1, .block_count = 16, .bounces = 1}, {})
                .points;
        for (std::size_t i = 0; i < points.size(); ++i) {
          const Point to = s.at(place) - points[i].position;
          const double d2 = dot(to, to), cosine = dot(to, points[i].normal) / std::sqrt(d2);
          const double once = fresnel_dielectric(cosine, 1.5);
          const double reflected =
              is_pane ? 2 * once / (1 + once) : fresnel_conductor(cosine, Rgb(1), Rgb(4)).g;
          sweep.compare(luminance(lx[i].irradiance_lx),
                        s.scale * s.scale * cosine / d2 * (1 + reflected),
                        fmt::format("{}, {} before the {}, point {}", s.text(), steps,
                                    is_pane ? "pane" : "mirror", i));
        }
      }
  });
  sweep.expect_within(1e-6);
}

// A screen just below the lamp hides it, and a lamp on one sheet lights both sides.
TEST(SurfaceLampExtremes, ScreensBelowTheLamp) {
  Sweep sweep(42, "lamp on a sheet, with and without a screen below it",
              "screens 1e-3 ... 1 m below the sheet", "lit behind the screen, or dark beside it");
  std::int64_t wrong = 0, cases = 0;
  for (const double below : {1e-3, 1e-2, 0.1, 1.0})
    for (const bool patches : {false, true}) {
      const Setting s{"level", {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, 1, patches};
      SceneDescription d = description();
      d.shapes = {face(s, {-3, -3, 2.8}, {6, 0, 0}, {0, 6, 0}),
                  face(s, {-1, -1, 2.8 - below}, {2, 0, 0}, {0, 2, 0})};
      d.lights = {point_light({0, 0, 2.8}, 1)};
      const auto scene = build(std::move(d));
      std::vector<IrradiancePoint> points;
      for (const double x : {0.0, 0.2, 0.4}) points.push_back({{x, 0.1, 0}, {}, {0, 0, 1}});
      for (const double x : {0.0, 2.0, 4.0}) points.push_back({{x, 0.1, 4}, {}, {0, 0, -1}});
      const auto lx =
          estimate_irradiance(*scene, points, {.block_count = 2, .bounces = 0}, {}).points;
      for (std::size_t i = 0; i < lx.size(); ++i, ++cases)
        if ((luminance(lx[i].irradiance_lx) > 0) != (i >= 3) && ++wrong < 10)
          ADD_FAILURE() << below << " m, point " << i;
    }
  sweep.expect_none(wrong, cases, 0);
}

}  // namespace
}  // namespace lucerna::testing
