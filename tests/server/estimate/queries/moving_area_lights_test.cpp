// Moving area lights at a time: samples, rays that find them, and rays that leave them.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "server/estimate/queries/emission_queries.h"
#include "server/estimate/queries/irradiance.h"
#include "server/estimate/queries/queries.h"
#include "tests/server/estimate/moving_shapes.h"

namespace lucerna::testing {
namespace {

/// Samples of the only light at time `t`.  `receivers` are about `origin`.
struct Samples {
  Samples(const Scene& scene, const std::vector<float>& receivers, std::uint32_t count, double t,
          const Vec3<double>& origin = {})
      : n(receivers.size() / 3 * count),
        value(3 * n),
        wi(3 * n),
        point(3 * n),
        normal(3 * n),
        distance(n),
        pdf(n),
        delta(n),
        visible(n),
        status(n) {
    SampleLiQuery q;
    q.receivers = {origin, receivers};
    q.samples = count;
    q.light = 0;
    q.seed = SeedRange{};
    q.test_visibility = true;
    q.time_s = t;
    sample_li(scene, q,
              {value.data(), wi.data(), distance.data(), point.data(), normal.data(), pdf.data(),
               delta.data(), visible.data(), nullptr, nullptr, status.data()},
              {});
  }
  bool ok(std::size_t i) const { return status[i] == static_cast<int>(ItemResult::kOk); }
  bool seen(std::size_t i) const { return (visible[i / 8] >> (i % 8) & 1) != 0; }

  std::size_t n;
  std::vector<float> value, wi, point, normal, distance, pdf;
  std::vector<std::uint8_t> delta, visible;
  std::vector<int> status;
};

std::vector<float> pdfs(const Scene& scene, const Vec3<float>& receiver,
                        const std::vector<float>& wi, double t) {
  std::vector<float> receivers, pdf(wi.size() / 3);
  std::vector<int> status(pdf.size());
  for (std::size_t i = 0; i < pdf.size(); ++i)
    receivers.insert(receivers.end(), {receiver.x, receiver.y, receiver.z});
  pdf_li(scene, {.receivers = {{}, receivers}, .wi = wi, .time_s = t}, pdf.data(), status.data(),
         {});
  return pdf;
}

TEST(MovingAreaLights, AreSampledAtTheirPlaceAtThatTime) {
  for (const Kind& kind : kinds()) {
    const auto moves = scene_of(emissive(moved(kind), 5, true));
    for (const double t : {0.0, 0.5, 1.3, 2.0}) {
      SCOPED_TRACE(std::string(kind.name) + " at " + std::to_string(t));
      const auto still = scene_of(emissive(kind.make(placed_at(t)), 5, true));
      const Vec3<float> receiver{-1, 3, 4};
      const Samples s(*moves, {receiver.x, receiver.y, receiver.z}, 256, t);
      // A light at that place has the same densities in every sampled direction.
      const std::vector<float> own = pdfs(*moves, receiver, s.wi, t);
      const std::vector<float> made_there = pdfs(*still, receiver, s.wi, t);
      std::vector<float> from;
      for (int i = 0; i < 256; ++i) from.insert(from.end(), {receiver.x, receiver.y, receiver.z});
      std::vector<float> radiance(3 * 256);
      std::vector<std::uint64_t> lights(256);
      std::vector<int> status(256);
      le(*moves, {.points = {{}, from}, .directions = s.wi, .time_s = t},
         {radiance.data(), lights.data(), status.data()}, {});
      int lit = 0, differ = 0, agree = 0;
      for (std::size_t i = 0; i < 256; ++i) {
        if (!s.ok(i)) continue;
        ++lit;
        EXPECT_EQ(s.value[3 * i], 5);
        // At the very edge, a rounded direction may miss one of them.
        const bool same = std::fabs(own[i] - made_there[i]) <= 2e-3F * made_there[i];
        differ += same ? 0 : 1;
        agree += radiance[3 * i] == 5 ? 1 : 0;
      }
      EXPECT_GT(lit, 100);
      EXPECT_LE(differ, 2);
      EXPECT_GE(agree, lit - 2);
    }
  }
}

TEST(MovingAreaLights, GiveTheIrradianceOfADiskInItsPlace) {
  // On the axis of a disk of radius r at height h: E = pi L r^2 / (r^2 + h^2).
  SceneDescription d = description();
  d.shapes.push_back(floor(9));
  d.shapes.push_back(emissive(
      shape(DiskParams{.height_m = -2,
                       .radius_m = 1,
                       .world_from_object =
                           Transform::translate({-3, 0, 0}) * *Transform::rotate(M_PI, {1, 0, 0})}),
      10));
  d.shapes.back().motion = sliding({6, 0, 0}, 2);
  const auto scene = build(std::move(d));
  ASSERT_EQ(scene->origin(), Vec3<double>{});
  const double below = M_PI * 10 / 5;
  for (const double t : {0.0, 0.4, 1.0, 2.0}) {
    const auto x = static_cast<float>(3 * t - 3);
    const std::vector<IrradiancePoint> points{{{x, 0, 0}, {1e-6F, 1e-6F, 1e-6F}, {0, 0, 1}}};
    const auto e = estimate_irradiance(
        *scene, points, {.samples_per_block = 64, .block_count = 64, .bounces = 0, .time_s = t},
        {});
    const double error = e.points[0].standard_error_lx.g;
    // Seven standard errors, which come from 64 blocks; exceeded by chance less than once in 1e8.
    EXPECT_NEAR(e.points[0].irradiance_lx.g, below, 7 * error) << t;
    EXPECT_LT(error, 0.01 * below);
  }
}

TEST(MovingAreaLights, RaysStartAtTheirPlaceAtThatTime) {
  for (const Kind& kind : kinds()) {
    SCOPED_TRACE(kind.name);
    const auto scene = scene_of(emissive(moved(kind), 5));
    constexpr std::uint32_t kRays = 64;
    for (const double t : {0.0, 1.3}) {
      std::vector<float> offsets(3 * kRays), directions(3 * kRays), normals(3 * kRays);
      std::vector<float> value(3 * kRays), position(kRays), direction(kRays);
      std::vector<int> status(kRays);
      sample_le(*scene, {.rays = kRays, .light = 0, .seed = SeedRange{}, .time_s = t},
                {offsets.data(), directions.data(), normals.data(), value.data(), position.data(),
                 direction.data(), nullptr, nullptr, status.data()},
                {});
      std::vector<float> reported_position(kRays), reported_direction(kRays);
      std::vector<int> reported_status(kRays);
      const PointArray points{scene->origin(), offsets};
      pdf_le(*scene, 0, points, directions, t, reported_position.data(), reported_direction.data(),
             reported_status.data(), {});
      for (std::size_t i = 0; i < kRays; ++i) {
        ASSERT_EQ(status[i], 1);
        EXPECT_NEAR(reported_position[i], position[i], 1e-3F * position[i]);
        EXPECT_NEAR(reported_direction[i], direction[i], 1e-3F * direction[i]);
        // A ray from straight in front meets it there.
        const Vec3<float> o = triple(offsets, i), n = triple(normals, i);
        Ray back{o + n * 0.01F, -n};
        back.time_s = t;
        const auto hit = scene->closest_hit(back);
        EXPECT_TRUE(hit && hit->light == 0 && std::fabs(hit->t - 0.01F) < 1e-5F);
      }
      // A moment later the light is elsewhere.
      pdf_le(*scene, 0, points, directions, t + 0.3, reported_position.data(),
             reported_direction.data(), reported_status.data(), {});
      int found = 0;
      for (const float p : reported_position) found += p > 0 ? 1 : 0;
      EXPECT_LE(found, 2);
    }
  }
}

// Rays to a moving light end in the light's own coordinates, which may be large where the scene's
// are small.  Points of the light near the scene's zero must not be mistaken for obstacles.
TEST(MovingAreaLights, DoNotShadowTheirOwnPoints) {
  SceneDescription d = description();
  TriangleMeshData mesh;
  constexpr int kSide = 33;
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) mesh.positions.push_back({1e3 / 32 * x, 1e3 / 32 * y, 0.0});
  for (std::uint32_t y = 0; y + 1 < kSide; ++y)
    for (std::uint32_t x = 0; x + 1 < kSide; ++x) {
      const std::uint32_t i = y * kSide + x;
      mesh.indices.insert(mesh.indices.end(),
                          {i, i + 1, i + kSide, i + 1, i + kSide + 1, i + kSide});
    }
  d.shapes.push_back(emissive(shape(mesh), 1, true));
  // Its middle moves to the scene's zero, tilted.
  d.shapes.back().motion = moving(
      {{0, {}}, {1, *Transform::rotate(0.6, {1, 2, 0.5}) * Transform::translate({-510, -490, 0})}});
  d.shapes.push_back(floor(0.5, 2000));
  d.shapes.push_back(floor(0.5, -2000));
  const auto scene = build(std::move(d));
  const Vec3<double> n = Transform(*Transform::rotate(0.6, {1, 2, 0.5})).vector({0, 0, 1});
  std::mt19937 random(3);
  std::uniform_real_distribution<double> u(-1, 1);
  std::vector<float> receivers;
  for (int i = 0; i < 500; ++i) {
    const Frame<double> frame = Frame<double>::around(n);
    const double side = i % 2 == 0 ? 1 : -1;
    const Vec3<float> p(frame.s * u(random) + frame.t * u(random) +
                        n * (side * std::exp(3 * u(random))));
    receivers.insert(receivers.end(), {p.x, p.y, p.z});
  }
  const Samples s(*scene, receivers, 64, 1);
  int hidden = 0, lit = 0;
  for (std::size_t i = 0; i < s.n; ++i) {
    if (!s.ok(i)) continue;
    ++lit;
    hidden += s.seen(i) ? 0 : 1;
  }
  EXPECT_GT(lit, 30000);
  EXPECT_EQ(hidden, 0);
}

}  // namespace
}  // namespace lucerna::testing
