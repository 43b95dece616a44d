#include "server/queries/queries.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/server/queries/li_samples.h"
#include "tests/server/scene/scenes.h"

namespace lucerna {
namespace {

using ::lucerna::testing::build;
using ::lucerna::testing::description;
using ::lucerna::testing::LiSamples;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

SceneDescription one_point_light() {
  SceneDescription d = description();
  d.shapes.push_back(testing::floor(10));
  d.lights.push_back({PointLightParams{{0, 0, 3}, Rgb(18)}, {"test.pbrt", 2, 1}});
  return d;
}

TEST(SampleLi, PlacesAreRelativeToTheOriginOfTheQuery) {
  SceneDescription d = description();
  const double far = 1e7;  // where floats are a metre apart
  d.shapes.push_back(
      testing::patch({far - 1, -1, 0}, {far + 1, -1, 0}, {far - 1, 1, 0}, {far + 1, 1, 0}));
  d.lights.push_back({PointLightParams{{far + 0.25, 0, 3}, Rgb(1)}, {}});
  const auto scene = build(d);
  const std::vector<float> points{0.25F, 0, 1};
  const std::vector<float> u(2, 0.5F);
  const LiSamples a(*scene, {.receivers = {{far, 0, 0}, points}, .light = 0, .u = u});
  EXPECT_EQ(a.light_offsets_m, (std::vector<float>{0.25F, 0, 3}));
  EXPECT_EQ(a.distance_m[0], 2);
  EXPECT_EQ(a.wi, (std::vector<float>{0, 0, 1}));
}

TEST(SampleLi, ABadItemDoesNotFailItsBatch) {
  const auto scene = build(one_point_light());
  const std::vector<float> points{0, 0, 0, kNan, 0, 0, 0, 0, 3, 0, 0, 1, 0, 0, 1};
  std::vector<float> u(10, 0.5F);
  u[9] = kNan;
  const LiSamples a(*scene, {.receivers = {{}, points}, .light = 0, .u = u});
  EXPECT_EQ(a.status, (std::vector<int>{1, 7, 4, 1, 7}));  // invalid, on the light, ok, invalid u
  for (const float v : a.value) EXPECT_TRUE(std::isfinite(v));
  EXPECT_EQ(a.value[3], 0);
  EXPECT_FLOAT_EQ(a.value[9], 4.5F);  // 18 / 2^2
}

TEST(SampleLi, IsOutOfRangeWhereAPlaceDoesNotFitFloats) {
  const auto scene = build(one_point_light());
  const std::vector<float> points{0, 0, 0};
  const std::vector<float> u(2, 0.5F);
  const LiSamples a(*scene, {.receivers = {{1e300, 0, 0}, points}, .light = 0, .u = u});
  EXPECT_EQ(a.status[0], static_cast<int>(ItemResult::kOutOfRange));
}

SceneDescription many_lights() {
  SceneDescription d = one_point_light();
  for (int i = 0; i < 5; ++i) {
    d.lights.push_back(testing::point_light({double(i), 1, 2}, 1 + i));
  }
  d.shapes.push_back(
      testing::emissive(testing::patch({-1, -1, 4}, {-1, 1, 4}, {1, -1, 4}, {1, 1, 4}), 5));
  return d;
}

TEST(SampleLi, AChosenLightHasTheSamplesOfANamedLight) {
  const auto scene = build(many_lights());
  std::vector<float> points, u;
  std::vector<double> u_light;
  for (int i = 0; i < 100; ++i) {
    points.insert(points.end(), {0.1F * float(i), 0, 0.5F});
    u.insert(u.end(), {0.01F * float(i), 0.3F});
    u_light.push_back(0.01 * i);
  }
  const LiSamples chosen(*scene, {.receivers = {{}, points}, .u = u, .u_light = u_light});
  for (std::uint32_t light = 0; light < scene->lights().size(); ++light) {
    const LiSamples named(*scene, {.receivers = {{}, points}, .light = light, .u = u});
    int found = 0;
    for (std::size_t i = 0; i < 100; ++i) {
      if (chosen.light_ids[i] != scene->lights()[light].id) continue;
      ++found;
      EXPECT_EQ(chosen.value[3 * i], named.value[3 * i]);
      const Receiver receiver(0.1F * float(i), 0, 0.5);
      EXPECT_EQ(chosen.selection_probability[i], scene->lights().selector().probability(
                                                     LightSelection::kAutomatic, receiver, light));
    }
    EXPECT_GT(found, 0) << light;
  }
}

/// Receivers at all distances from a light, on it, and beyond floats.  Some of their sample
/// values are not numbers.
struct Receivers {
  std::vector<float> offsets, normals, u;
  std::vector<double> u_light;

  explicit Receivers(const Vec3f& light) {
    constexpr float kInf = INFINITY, kMost = std::numeric_limits<float>::max();
    for (float size = 1e-42F; size < 1e38F; size *= 7)
      for (const Vec3f& way : {Vec3f{1, 2, -3}, {-1, 0, 0}, {0, 0.3F, 1}}) add(light + way * size);
    for (const Vec3f& at : {light,
                            Vec3f{kNan, 0, 0},
                            {0, kInf, 0},
                            {0, -kInf, kInf},
                            {kMost, kMost, kMost},
                            {kMost, -kMost, 0},
                            {0, 0, 0}})
      add(at);
    for (const std::size_t bad : {std::size_t{20}, u.size() - 1}) u[bad] = bad == 20 ? kNan : kInf;
  }
  void add(const Vec3f& at) {
    offsets.insert(offsets.end(), {at.x, at.y, at.z});
    normals.insert(normals.end(), {0, 0, 1});
    u.insert(u.end(), {0.25F, 0.75F});
    u_light.push_back(0.5);
  }
};

TEST(SampleLi, OfAPointLightIsTheSameByEveryPathOfTheCode) {
  const Vec3f at{1, -2, 0.5F};
  for (const double candela : {0.0, 1e-30, 18.0, 1e30}) {
    SceneDescription d = description();
    d.lights = {testing::point_light(Vec3(at), candela)};
    const auto scene = build(d);
    const Receivers r(at);
    for (const Vec3& origin : {Vec3{}, {0.1, 0, -3e5}}) {
      SampleLiQuery query{.receivers = {origin, r.offsets}, .light = 0, .u = r.u};
      const LiSamples plain(*scene, query);
      query.normals = r.normals;  // which need each whole sample
      const LiSamples whole(*scene, query);
      EXPECT_EQ(plain, whole) << candela;
      query.normals = {};
      query.light = {};
      query.u_light = r.u_light;
      LiSamples chosen(*scene, query);
      chosen.light_ids = plain.light_ids,
      chosen.selection_probability = plain.selection_probability;
      EXPECT_EQ(plain, chosen) << candela;
      const auto ok = std::ranges::count(plain.status, static_cast<int>(ItemResult::kOk));
      if (candela == 18) {
        EXPECT_GT(ok, 150);
      } else if (candela == 0) {
        EXPECT_EQ(ok, 0);
      }
    }
  }
}

TEST(SampleLi, TheOnlyLightIsChosenAsByAnyPathOfTheCode) {
  SceneDescription lamp = description(), panel = description();
  lamp.lights = {testing::point_light({1, -2, 0.5}, 18)};
  panel.shapes = {testing::emissive(testing::floor(1), 5)};
  for (const SceneDescription& d : {lamp, panel}) {
    const auto scene = build(d);
    ASSERT_EQ(scene->lights().size(), 1U);
    const Receivers r({1, -2, 0.5F});
    for (const std::uint32_t samples : {1U, 3U}) {
      SampleLiQuery query{
          .receivers = {{}, r.offsets}, .samples = samples, .seed = SeedRange{.seed = 4}};
      const LiSamples plain(*scene, query);
      query.test_visibility = true;  // which chooses a light for each sample
      LiSamples chosen(*scene, query);
      chosen.visible = plain.visible;
      EXPECT_EQ(plain, chosen) << samples;
      // Receivers without a place choose no light.
      EXPECT_EQ(plain.light_ids.front(), scene->lights()[0].id);
      EXPECT_GT(std::ranges::count(plain.light_ids, 0U), 0);
      EXPECT_EQ(std::ranges::count(plain.selection_probability, 1.0), std::ssize(plain.light_ids));
    }
  }
}

TEST(SampleLi, ASceneWithoutLightsIsBlack) {
  SceneDescription d = description();
  d.shapes.push_back(testing::floor(1));
  const auto scene = build(d);
  const std::vector<float> points{0, 0, 1};
  const LiSamples a(*scene, {.receivers = {{}, points}, .seed = SeedRange{}});
  EXPECT_EQ(a.status[0], static_cast<int>(ItemResult::kBlack));
  EXPECT_EQ(a.light_ids[0], 0U);
}

TEST(ToScene, DefaultErrorIsAFewUlpsOfTheCoordinates) {
  const auto scene = build(one_point_light());
  const std::vector<float> points{1, 0, 0, 0, -1000, 0};
  const ToScene to_scene(*scene, {{}, points}, std::nullopt);
  EXPECT_FLOAT_EQ(to_scene(0).error, 4 * 1.1920929e-7F);  // 4 * 2^-23
  EXPECT_FLOAT_EQ(to_scene(1).error, 4000 * 1.1920929e-7F);
  EXPECT_EQ(ToScene(*scene, {{}, points}, 0.25F)(1).error, 0.25F);
}

}  // namespace
}  // namespace lucerna
