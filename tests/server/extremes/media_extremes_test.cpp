// Row 41: media that absorb light, and thin panes.  The references are closed forms in long double.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "server/queries/queries.h"
#include "server/queries/receiver_irradiance.h"
#include "server/queries/visibility.h"
#include "tests/extremes_sweep.h"
#include "tests/server/queries/li_samples.h"
#include "tests/server/scene/scenes.h"

namespace lucerna::testing {
namespace {

/// A circle around the z axis that bounds media: `above` on the side of +z.
ShapeDescription level(double z, double radius, std::int32_t below, std::int32_t above,
                       const Vec3& at = {}) {
  ShapeDescription s = shape(
      DiskParams{.height_m = z, .radius_m = radius, .world_from_object = Transform::translate(at)});
  s.media = MediumSides{below, above};
  s.is_interface = true;
  return s;
}

/// The same as a square of two triangles.
ShapeDescription triangles(double z, double half_side, std::int32_t below, std::int32_t above) {
  const double s = half_side;
  TriangleMeshData mesh;
  mesh.positions = {{-s, -s, z}, {s, -s, z}, {s, s, z}, {-s, s, z}};
  mesh.indices = {0, 1, 2, 0, 2, 3};
  ShapeDescription square = shape(std::move(mesh));
  square.media = MediumSides{below, above};
  square.is_interface = true;
  return square;
}

/// A pane of glass around the z axis.
ShapeDescription pane(SceneDescription& d, double z, double radius, double eta) {
  ShapeDescription s = shape(DiskParams{.height_m = z, .radius_m = radius});
  s.material = static_cast<std::uint32_t>(d.materials.size());
  d.materials.push_back({.params = ThinDielectricParams{{eta}}});
  return s;
}

/// What a pane passes, from Fresnel's amplitudes with angles of Snell's law, and the series of all
/// reflections between its sides.
long double pane_share(long double x, long double z, long double eta) {
  const long double cosine = std::fabs(z) / std::hypot(x, z),
                    sine = std::fabs(x) / std::hypot(x, z);
  const long double inner_sine = sine / eta;
  if (inner_sine >= 1) return 0;
  const long double inner = std::sqrt((1 - inner_sine) * (1 + inner_sine));
  // The share that passes one side, which does not cancel where nearly all is reflected.
  const auto passed = [&](long double a, long double b) { return 4 * a * b / ((a + b) * (a + b)); };
  const long double once = (passed(cosine, eta * inner) + passed(eta * cosine, inner)) / 2;
  return once / (2 - once);  // (1 - R) / (1 + R)
}

/// The share of green light that arrives along the segment from `origin + from` to `origin + to`.
double seen(const Scene& scene, const Vec3f& from, const Vec3f& to, const Vec3& origin = {}) {
  const std::array f{from.x, from.y, from.z}, t{to.x, to.y, to.z};
  std::uint8_t visible = 0;
  std::array<float, 3> share{};
  int status = 0;
  test_visibility(scene, {.from = {origin, f}, .to = PointArray{origin, t}},
                  {&visible, share.data(), &status}, {});
  EXPECT_EQ(status, static_cast<int>(ItemResult::kOk));
  EXPECT_EQ(visible, 1);
  return share[1];
}

/// The transmittance of a sample of the scene's only light.
double sampled(const Scene& scene, const Vec3f& from) {
  const std::array f{from.x, from.y, from.z};
  std::array<float, 3> share{};
  LiSamples s(1);
  SampleLiAnswer answer = s.answer();
  answer.transmittance = share.data();
  sample_li(scene, {.receivers = {{}, f}, .light = 0, .seed = SeedRange{}, .test_visibility = true},
            answer, {});
  EXPECT_TRUE(s.is_ok(0) && s.is_visible(0));
  return share[1];
}

/// The irradiance that the scene's point light gives at a point without a surface.
double irradiance(const Scene& scene, const Vec3& at, const Vec3& normal) {
  const IrradiancePoint point{at - scene.origin(), {}, decltype(IrradiancePoint::normal)(normal)};
  const auto result =
      estimate_irradiance(scene, std::span(&point, 1), {.block_count = 2, .bounces = 0}, {});
  EXPECT_TRUE(result.points[0].exact);
  return result.points[0].irradiance_lx.g;
}

/// Compares shares of light.  A depth has the rounding of its length, so a deep share is compared
/// by its depth.
void compare_depth(Sweep& sweep, double share, long double depth, const std::string& at) {
  if (depth <= 1)
    sweep.compare(share, static_cast<double>(std::exp(-depth)), at);
  else
    sweep.compare(static_cast<double>(-std::log(static_cast<long double>(share))),
                  static_cast<double>(depth), at);
}

constexpr long double kDeepest = 87.3L;  // exp(-87.3) is just above the least normal float

struct Fog {
  double length_m, depth;
  double per_m() const { return depth / length_m; }
  std::string text() const { return fmt::format("depth {:g} over {:g} m", depth, length_m); }
};

/// Depths from `least` on over lengths from 1e-9 to 1e9 m.
std::vector<Fog> fogs(double least, double most) {
  std::vector<Fog> all;
  for (const double length : {1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e6, 1e9})
    for (double depth = least; depth <= most; depth *= 2.7) all.push_back({length, depth});
  return all;
}

/// Fog between two circles.
SceneDescription slab(const Fog& fog) {
  SceneDescription d = description();
  const double l = fog.length_m;
  d.media = {{Rgb(fog.per_m())}};
  d.shapes = {level(0, 4 * l, -1, 0), level(l, 4 * l, 0, -1)};
  return d;
}

TEST(MediaExtremes, SegmentsThroughFog) {
  Sweep sweep(41, "fog between two circles, segments through it and within it; closed form",
              "depth 1e-12 ... 87, lengths 1e-9 ... 1e9 m",
              "transmittance; its logarithm if the depth is above 1");
  for (const Fog& fog : fogs(1e-12, 2 * double{kDeepest})) {
    const auto scene = build(slab(fog));
    const auto l = static_cast<float>(fog.length_m);
    const long double per_m = fog.per_m();
    struct Segment {
      float x, z0, z1;
      long double inside;  // of z
    };
    for (const Segment& s :
         {Segment{0, -l, 2 * l, fog.length_m}, Segment{l, -l / 4, 3 * l, fog.length_m},
          Segment{0, l / 4, 3 * l / 4, l / 2}, Segment{l, 3 * l / 4, l / 4, l / 2}}) {
      const long double dz = static_cast<long double>(s.z1) - s.z0;
      const long double length = std::hypot(2.0L * s.x, dz) * (s.inside / std::fabs(dz));
      if (per_m * length > kDeepest) continue;
      compare_depth(sweep, seen(*scene, {-s.x, 0, s.z0}, {s.x, 0, s.z1}), per_m * length,
                    fog.text());
      compare_depth(sweep, seen(*scene, {s.x, 0, s.z1}, {-s.x, 0, s.z0}), per_m * length,
                    fog.text());
    }
  }
  sweep.expect_within(3e-7);
}

TEST(MediaExtremes, PointsInFog) {
  Sweep sweep(41, "point light in fog; closed form", "depth 1e-12 ... 87, lengths 1e-9 ... 1e9 m",
              "transmittance of samples, and irradiance; the logarithm if the depth is above 1");
  for (const Fog& fog : fogs(1e-12, double{kDeepest})) {
    SceneDescription d = description();
    const auto l = static_cast<float>(fog.length_m);
    const long double per_m = fog.per_m(), depth = per_m * l;
    d.media = {{Rgb(fog.per_m())}};
    d.surrounding_medium = 0;
    d.lights = {point_light({0, 0, double{l}}, double{l} * l)};  // 1 lx without fog
    const auto scene = build(std::move(d));
    compare_depth(sweep, sampled(*scene, {}), depth, fog.text());
    compare_depth(sweep, irradiance(*scene, {}, {0, 0, 1}), depth, fog.text());
  }
  sweep.expect_within(3e-7);
}

TEST(MediaExtremes, FogThatLetsNothingPass) {
  Sweep sweep(41, "fog that leaves less light than the least normal float",
              "depth 88 ... 1e18, and 1e300 / m", "transmittance and irradiance");
  std::vector<Fog> all = fogs(88, 1e18);
  for (const double length : {1e-9, 1.0, 1e9}) all.push_back({length, length * 1e300});
  for (const Fog& fog : all) {
    SceneDescription d = slab(fog);
    d.lights = {point_light({0, 0, 2 * fog.length_m}, fog.length_m * fog.length_m)};
    const auto scene = build(std::move(d));
    const auto l = static_cast<float>(fog.length_m);
    const auto answer = [&](double share) {
      sweep.answer(share == 0 ? "0" : fmt::format("{:g} at {}", share, fog.text()));
    };
    answer(seen(*scene, {0, 0, -l}, {0, 0, 2 * l}));
    answer(sampled(*scene, {0, 0, -l}));
    // Irradiance is a double.
    if (fog.depth > 700) answer(irradiance(*scene, {0, 0, -fog.length_m}, {0, 0, 1}));
  }
  sweep.expect_answers("0");
}

TEST(MediaExtremes, RaysThatEndNowhere) {
  Sweep sweep(41, "endless rays", "absorption 1e-30 ... 1e30 / m, around the scene or beside it",
              "transmittance: 0 in fog, 1 without");
  for (double per_m = 1e-30; per_m < 1e31; per_m *= 1e3) {
    for (const bool around : {true, false}) {
      SceneDescription d = description();
      d.media = {{Rgb(0, per_m, 0)}};
      d.shapes = {level(0, 1, around ? -1 : 0, around ? 0 : -1)};
      const auto scene = build(std::move(d));
      const std::array<float, 3> from{0, 0, 0.5}, up{0, 0, 1};
      std::uint8_t visible = 0;
      std::array<float, 3> share{};
      int status = 0;
      test_visibility(*scene, {.from = {{}, from}, .directions = up},
                      {&visible, share.data(), &status}, {});
      const std::array<float, 3> expected{1, around ? 0.0F : 1.0F, 1};
      sweep.answer(share == expected && visible == 1
                       ? "right"
                       : fmt::format("{} {} {} at {:g}", share[0], share[1], share[2], per_m));
    }
  }
  sweep.expect_answers("right");
}

TEST(MediaExtremes, ThinLayers) {
  Sweep sweep(41, "layer of ink amid 2 m of air, as circles or triangles; closed form",
              "thickness 1e-1 ... 1e-6 m, at distances 0 ... 1e6 m from zero",
              "transmittance at depth 1");
  for (const double away : {0.0, 1.0, 1e3, 1e6}) {
    for (double thickness = 0.1; thickness > 5e-7; thickness /= 10) {
      const double lower = away, upper = away + thickness, per_m = 1 / thickness;
      for (const bool flat : {true, false}) {
        SceneDescription d = description();
        d.media = {{Rgb(per_m)}};
        if (flat)
          d.shapes = {level(lower, 4, -1, 0), level(upper, 4, 0, -1)};
        else
          d.shapes = {triangles(lower, 4, -1, 0), triangles(upper, 4, 0, -1)};
        const auto scene = build(std::move(d));
        // Corners of triangles are floats about the scene's origin.
        const auto height = [&](double z) {
          const double above = z - scene->origin().z;
          return flat ? above : double{static_cast<float>(above)};
        };
        const long double depth = static_cast<long double>(per_m) *
                                  (static_cast<long double>(height(upper)) - height(lower));
        for (const float x : {0.0F, 0.5F, 2.0F}) {
          // The segment has no corner of the scale of the layer.
          const long double slant = std::hypot(1.0L, static_cast<long double>(x));
          const double truth = static_cast<double>(std::exp(-depth * slant));
          const std::string at = fmt::format("{:g} m of {} at {:g} m, x {:g}", thickness,
                                             flat ? "circles" : "triangles", away, x);
          sweep.compare(seen(*scene, {-x, 0.3F, -1}, {x, 0.3F, 1}, {0, 0, away}), truth, at);
          sweep.compare(seen(*scene, {x, 0.3F, 1}, {-x, 0.3F, -1}, {0, 0, away}), truth, at);
        }
      }
    }
  }
  sweep.expect_within(3e-7);
}

TEST(MediaExtremes, LayersThinnerThanFloatsTell) {
  Sweep sweep(41, "layer of ink between two circles, or a ball of ink; closed form",
              "thickness / distance 1e-7 ... 1e-10", "transmittance at depth 1");
  for (double thickness = 1e-7; thickness > 5e-11; thickness /= 10) {
    SceneDescription flat = description(), round = description();
    flat.media = round.media = {{Rgb(1 / thickness)}};
    flat.shapes = {level(0, 4, -1, 0), level(thickness, 4, 0, -1)};
    round.shapes = {shape(SphereParams{.radius_m = thickness / 2})};
    round.shapes[0].media = MediumSides{0, -1};
    round.shapes[0].is_interface = true;
    const auto layer = build(std::move(flat)), ball = build(std::move(round));
    const std::string at = fmt::format("{:g}", thickness);
    for (const float x : {0.0F, 0.5F, 2.0F}) {
      const double truth =
          static_cast<double>(std::exp(-std::hypot(1.0L, static_cast<long double>(x))));
      sweep.compare(seen(*layer, {-x, 0.3F, -1}, {x, 0.3F, 1}), truth, "layer " + at);
      sweep.compare(seen(*layer, {x, 0.3F, 1}, {-x, 0.3F, -1}), truth, "layer " + at);
      sweep.compare(seen(*layer, {-x, 0.3F, -1}, {0, 0.3F, -1e-3F}), 1, "before layer " + at);
    }
    const double truth = std::exp(-1.0);
    sweep.compare(seen(*ball, {0, -1, 0}, {0, 1, 0}), truth, "ball " + at);
    sweep.compare(seen(*ball, {0, 1, 1}, {0, -1, -1}), truth, "ball " + at);
  }
  sweep.expect_within(1e-5);
}

TEST(MediaExtremes, ManyLayers) {
  Sweep sweep(41, "layers of two inks by turns; closed form", "1 ... 1000 boundaries",
              "logarithm of the transmittance");
  for (const int layers : {1, 2, 9, 100, 999}) {
    SceneDescription d = description();
    // 1 m of each ink at any number of layers.
    const double thickness = 2.0 / layers, a = 3, b = 7;
    d.media = {{Rgb(a)}, {Rgb(b)}};
    for (int i = 0; i <= layers; ++i)
      d.shapes.push_back(
          level(i * thickness, 4, i == 0 ? -1 : (i - 1) % 2, i == layers ? -1 : i % 2));
    const auto scene = build(std::move(d));
    const int of_b = layers / 2, of_a = layers - of_b;
    const long double depth = static_cast<long double>(thickness) * (of_a * 3 + of_b * 7);
    const std::string at = fmt::format("{} layers", layers);
    compare_depth(sweep, seen(*scene, {0, 0, -1}, {0, 0, 3}), depth, at);
    compare_depth(sweep, seen(*scene, {0, 0, 3}, {0, 0, -1}), depth, at);
    const long double slant = std::hypot(1.0L, 0.75L / 4);
    compare_depth(sweep, seen(*scene, {0.75F, 0, 3}, {0, 0, -1}), depth * slant, at);
  }
  sweep.expect_within(3e-7);
}

TEST(MediaExtremes, BallsWithinBalls) {
  Sweep sweep(41, "balls of two inks within one another; closed form", "1 ... 500 balls",
              "logarithm of the transmittance");
  for (const int balls : {1, 2, 9, 100, 500}) {
    SceneDescription d = description();
    d.media = {{Rgb(3)}, {Rgb(7)}};
    for (int i = 1; i <= balls; ++i) {
      ShapeDescription s = shape(SphereParams{.radius_m = double(i) / balls});
      s.media = MediumSides{i % 2, i == balls ? -1 : (i + 1) % 2};
      s.is_interface = true;
      d.shapes.push_back(s);
    }
    const auto scene = build(std::move(d));
    for (const double beside : {0.001, 0.3333, 0.9}) {
      long double depth = 0, last = 0;
      const auto y = static_cast<float>(beside);
      for (int i = 1; i <= balls; ++i) {
        const long double r = static_cast<long double>(double(i) / balls);
        if (r <= y) continue;
        const long double half = std::sqrt((r - y) * (r + y));
        depth += 2 * (half - last) * (i % 2 == 1 ? 7 : 3);
        last = half;
      }
      compare_depth(sweep, seen(*scene, {0, y, -2}, {0, y, 2}), depth,
                    fmt::format("{} balls, {} m beside", balls, beside));
    }
  }
  sweep.expect_within(3e-7);
}

struct Slope {
  float x, z;
  double eta;
  std::string text() const { return fmt::format("eta {:g}, tangent {:g}", eta, x / z); }
};

std::vector<Slope> slopes() {
  std::vector<Slope> all;
  for (const double eta :
       {1 + 1e-15, 1 + 1e-12, 1 + 1e-9, 1 + 1e-6, 1.001, 1.1, 1.5, 4.0, 30.0, 1000.0})
    for (float z = 1; z > 5e-7F; z *= 0.37F)
      for (const float x : {1.0F, 0.0F}) all.push_back({x, z, eta});
  return all;
}

TEST(MediaExtremes, PanesAtAnyAngle) {
  Sweep sweep(41, "thin pane; Fresnel's equations in long double",
              "cosine 1 ... 5e-7, index 1 + 1e-15 ... 1000",
              "transmittance of segments and samples, and irradiance");
  for (const Slope& s : slopes()) {
    SceneDescription d = description();
    d.shapes = {pane(d, 0, 0.25, s.eta)};
    const double squared = double{s.x} * s.x + double{s.z} * s.z;
    d.lights = {point_light({s.x, 0, s.z}, 4 * squared)};  // 1 lx without the pane
    const auto scene = build(std::move(d));
    const double truth = static_cast<double>(pane_share(s.x, s.z, s.eta));
    sweep.compare(seen(*scene, {-s.x, 0, -s.z}, {s.x, 0, s.z}), truth, s.text());
    sweep.compare(seen(*scene, {s.x, 0, s.z}, {-s.x, 0, -s.z}), truth, s.text());
    sweep.compare(sampled(*scene, {-s.x, 0, -s.z}), truth, s.text());
    const Vec3 towards = normalized(Vec3{s.x, 0, s.z});
    sweep.compare(irradiance(*scene, {-s.x, 0, -s.z}, towards), truth, s.text());
    // In floats with Snell's law and without the series, from the floats of the unit direction.
    const auto cosine = static_cast<float>(towards.z), eta = static_cast<float>(s.eta);
    const float inner = std::sqrt(1 - (1 - cosine * cosine) / (eta * eta));
    const float p = (eta * cosine - inner) / (eta * cosine + inner);
    const float q = (cosine - eta * inner) / (cosine + eta * inner);
    const float r = (p * p + q * q) / 2;
    sweep.compare_textbook((1 - r) / (1 + r), truth);
  }
  sweep.expect_within(3e-7);
}

TEST(MediaExtremes, PanesBeyondTheCriticalAngle) {
  Sweep sweep(41, "thin pane of an index below 1", "index 1e-3 ... 1 - 1e-6", "transmittance");
  for (const double eta : {1e-3, 0.1, 0.5, 0.9, 0.999, 1 - 1e-6}) {
    for (float z = 1; z > 5e-7F; z *= 0.37F) {
      const long double sine = 1 / std::hypot(1.0L, static_cast<long double>(z));
      if (std::fabs(sine / eta - 1) < 1e-6) continue;  // floats cannot tell on which side it is
      SceneDescription d = description();
      d.shapes = {pane(d, 0, 0.25, eta)};
      const auto scene = build(std::move(d));
      sweep.compare(seen(*scene, {-1, 0, -z}, {1, 0, z}),
                    static_cast<double>(pane_share(1, z, eta)), fmt::format("{} {}", eta, z));
    }
  }
  sweep.expect_within(3e-7);
}

TEST(MediaExtremes, PanesThatNearlyTouch) {
  Sweep sweep(41, "two thin panes close to each other; closed form",
              "gap / distance 1e-1 ... 1e-14", "transmittance");
  for (double gap = 0.1; gap > 5e-15; gap /= 10) {
    SceneDescription d = description();
    d.shapes = {pane(d, 0, 4, 1.5), pane(d, gap, 4, 1.7)};
    const auto scene = build(std::move(d));
    for (const float x : {0.0F, 0.5F, 2.0F})
      sweep.compare(seen(*scene, {-x, 0, -1}, {x, 0, 1}),
                    static_cast<double>(pane_share(x, 1, 1.5) * pane_share(x, 1, 1.7)),
                    fmt::format("{:g}", gap));
  }
  sweep.expect_within(3e-7);
}

TEST(MediaExtremes, ManyPanes) {
  Sweep sweep(41, "thin panes one behind another; closed form", "1 ... 1000 panes",
              "logarithm of the transmittance");
  for (const int panes : {1, 2, 10, 100, 1000}) {
    for (const double eta : {1.01, 1.5, 4.0}) {
      SceneDescription d = description();
      for (int i = 0; i < panes; ++i) d.shapes.push_back(pane(d, i * 1e-3, 4, eta));
      const auto scene = build(std::move(d));
      for (const float x : {0.0F, 1.0F, 3.0F}) {
        const long double depth = -panes * std::log(pane_share(x, 2, eta));
        if (depth > kDeepest) continue;
        compare_depth(sweep, seen(*scene, {-x / 2, 0, -0.5F}, {x / 2, 0, 1.5F}), depth,
                      fmt::format("{} panes of eta {}, x {}", panes, eta, x));
      }
    }
  }
  sweep.expect_within(3e-7);
}

}  // namespace
}  // namespace lucerna::testing
