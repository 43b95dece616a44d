// The same scene in other units gives the same answers: to the last bit for powers of two, to
// within rounding for other factors.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "server/estimate/render.h"
#include "server/queries/queries.h"
#include "server/queries/receiver_irradiance.h"
#include "tests/extremes_sweep.h"
#include "tests/server/extremes/invariant_scene.h"
#include "tests/server/extremes/scaled_scene.h"
#include "tests/server/queries/li_samples.h"
#include "tests/server/scene/scenes.h"

namespace lucerna::testing {
namespace {

/// All answers about a scene, with lengths and what scales with them in units of a scene of factor
/// `s`.
struct Answers {
  std::vector<double> picture, irradiance, samples, choices;
};

Answers answers_of(const SceneDescription& description, double s, std::uint32_t samples,
                   std::uint32_t samples_per_point, const Methods& methods = {}) {
  const auto scene = build(scaled_scene(description, s));
  Answers a;
  const TileResult tile = render_tile(*scene,
                                      {.rect = {0, 0, 32, 24},
                                       .seed = 3,
                                       .samples_per_block = samples,
                                       .bounces = 2,
                                       .methods = methods},
                                      {});
  for (const BlockStatistics& c : tile.channels) a.picture.push_back(c.sum);

  std::vector<IrradiancePoint> points;
  std::vector<float> offsets;
  const Vec3 origin = kEveryLightMiddle * s;
  for (int i = 0; i < 60; ++i) {
    const Vec3 p{0.6 * (i % 8) - 2, 0.7 * (i / 8) - 2.5, 0.05 + 0.02 * i};
    const Vec3f offset(p * s);
    offsets.insert(offsets.end(), {offset.x, offset.y, offset.z});
    IrradiancePoint point;
    point.position = decltype(point.position)(Vec3(offset) + (origin - scene->origin()));
    const auto error = static_cast<float>(1e-6 * s);
    point.position_error = {error, error, error};
    point.normal = normalized(Vec3{0.3 * (i % 3), 0.2, 1});
    points.push_back(point);
  }
  for (const IrradianceEstimate& e :
       estimate_irradiance(
           *scene, points,
           {.seed = 4, .samples_per_block = samples_per_point, .bounces = 1, .methods = methods},
           {})
           .points)
    a.irradiance.insert(a.irradiance.end(),
                        {e.irradiance_lx.r, e.irradiance_lx.g, e.irradiance_lx.b});

  const LiSamples li(*scene, {.receivers = {origin, offsets},
                              .samples = 8,
                              .seed = SeedRange{5, 0},
                              .test_visibility = true});
  for (std::size_t i = 0; i < li.size(); ++i) {
    a.choices.insert(a.choices.end(), {double(li.light_ids[i]), li.selection_probability[i]});
    a.samples.insert(
        a.samples.end(),
        {double(li.status[i]), double(li.visible[i / 8]), li.pdf_per_sr[i], li.distance_m[i] / s,
         li.light_offsets_m[3 * i] / s, li.light_offsets_m[3 * i + 2] / s});
    for (int k = 0; k < 3; ++k)
      a.samples.insert(a.samples.end(), {li.value[3 * i + k], li.wi[3 * i + k]});
  }
  const Receiver receiver(kEveryLightMiddle * s - scene->origin());
  for (std::uint32_t l = 0; l < scene->lights().size(); ++l)
    for (const LightSelection how : {LightSelection::kPower, LightSelection::kBvh})
      a.choices.push_back(scene->lights().selector().probability(how, receiver, l));
  return a;
}

void compare_all(Sweep& sweep, const std::vector<double>& served, const std::vector<double>& truth,
                 const std::string& what) {
  ASSERT_EQ(served.size(), truth.size());
  for (std::size_t i = 0; i < truth.size(); ++i)
    sweep.compare(served[i], truth[i], what + " " + std::to_string(i));
}

TEST(InvarianceExtremes, PowersOfTwoChangeNoBit) {
  Sweep sweep(9, "scene with every light, scaled by a power of two", "2^-40 ... 2^40",
              "picture, irradiances, light samples, choices");
  const SceneDescription d = invariant_scene();
  const Answers one = answers_of(d, 1, 4, 16);
  for (const int exponent : {-40, -20, -10, -1, 1, 10, 20, 40}) {
    const Answers other = answers_of(d, std::ldexp(1.0, exponent), 4, 16);
    const std::string by = " by 2^" + std::to_string(exponent);
    compare_all(sweep, other.picture, one.picture, "pixel" + by);
    compare_all(sweep, other.irradiance, one.irradiance, "irradiance" + by);
    compare_all(sweep, other.samples, one.samples, "sample" + by);
    compare_all(sweep, other.choices, one.choices, "choice" + by);
  }
  sweep.expect_within(0);
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v;
  return sum / double(values.size());
}

TEST(InvarianceExtremes, MillimetresAndKilometresKeepTheMean) {
  Sweep sweep(9, "scene with every light, in other units", "mm, km",
              "mean of picture, irradiances");
  const SceneDescription d = invariant_scene();
  // Where lights are about equally near to each other, their tree may split differently.  Then the
  // samples differ.
  const Methods by_power{.light_selection = LightSelection::kPower};
  const Answers metres = answers_of(d, 1, 64, 1024, by_power);
  for (const double s : {1e3, 1e-3}) {
    const Answers other = answers_of(d, s, 64, 1024, by_power);
    sweep.compare(mean(other.picture), mean(metres.picture), "picture " + std::to_string(s));
    sweep.compare(mean(other.irradiance), mean(metres.irradiance), "lx " + std::to_string(s));
  }
  sweep.expect_within(1e-5);
}

/// A floor, a wall, a lamp and a point light, of any size.
SceneDescription small_room() {
  SceneDescription d = description();
  d.shapes = {
      floor(1),
      {ball(1,
            [](const Vec3& p) {
              return p * 0.2 + Vec3{0.3, 0.2, 0.3};
            })},
      {SphereParams{.radius_m = 0.15, .world_from_object = Transform::translate({-0.4, 0.1, 0.2})}},
      emissive(patch({-0.5, 0.5, 1}, {0.5, 0.5, 1}, {-0.5, -0.5, 1}, {0.5, -0.5, 1}), 3)};
  d.objects = {{"ball", {{ball(1, [](const Vec3& p) { return p * 2.0; })}}}};
  d.instances = {{0, Transform::translate({0, -0.5, 0.3}) * *Transform::scale({0.1, 0.1, 0.1})}};
  d.lights = {point_light({0.5, -0.4, 0.9}, 1)};
  d.camera.world_from_camera = *Transform::look_at({1, -2, 1.2}, {0, 0, 0.2}, {0, 0, 1});
  d.camera.screen_min = {-0.5, -0.5}, d.camera.screen_max = {0.5, 0.5};
  d.film = {.width = 32, .height = 24};
  return d;
}

std::vector<double> picture_of(const SceneDescription& d, double s, std::uint32_t samples) {
  const auto scene = build(scaled_scene(d, s));
  const TileResult tile = render_tile(
      *scene, {.rect = {0, 0, 32, 24}, .seed = 3, .samples_per_block = samples, .bounces = 2}, {});
  std::vector<double> picture;
  for (const BlockStatistics& c : tile.channels) picture.push_back(c.sum);
  return picture;
}

TEST(InvarianceExtremes, ScenesOfAnySizeLookTheSame) {
  Sweep sweep(9, "a room with a lamp and a point light, of any size", "1e-31 ... 1e29 m",
              "mean of a picture");
  const SceneDescription d = small_room();
  const double truth = mean(picture_of(d, 1, 64));
  for (const double s :
       {1e-31, 1e-30, 1e-25, 1e-20, 1e-15, 1e-10, 1e-5, 1e5, 1e10, 1e15, 1e19, 1e24, 1e29})
    sweep.compare(mean(picture_of(d, s, 64)), truth, std::to_string(std::log10(s)));
  sweep.expect_within(1e-6);
}

// The least error of positions (kLeastError) is 2e-5 of this room.  So a ray that touches an edge
// may pass it: here in one of 49152 samples.
TEST(InvarianceExtremes, TheLeastSizeLooksNearlyTheSame) {
  Sweep sweep(9, "the same room, near the least size", "1e-32 m", "mean of a picture");
  const SceneDescription d = small_room();
  sweep.compare(mean(picture_of(d, 1e-32, 64)), mean(picture_of(d, 1, 64)), "-32");
  sweep.expect_within(1e-4);
}

// With many lamps, a few candidates are drawn, and one is chosen by its contribution.
TEST(InvarianceExtremes, LightsOfAnyStrengthAreChosenAlike) {
  Sweep sweep(9, "room of twelve point lights, all scaled by a power of two", "2^-120 ... 2^120",
              "picture");
  const auto picture = [](int exponent) {
    SceneDescription d = small_room();
    d.shapes.pop_back();  // the lamp
    d.lights.clear();
    for (int i = 0; i < 12; ++i)
      d.lights.push_back(
          point_light({0.1 * i - 0.6, 0.3 * (i % 3), 0.7}, std::ldexp(1.0 + i % 5, exponent)));
    std::vector<double> p = picture_of(d, 1, 4);
    for (double& v : p) v = std::ldexp(v, -exponent);
    return p;
  };
  const std::vector<double> truth = picture(0);
  for (const int exponent : {-120, -60, -10, 10, 60, 120})
    compare_all(sweep, picture(exponent), truth, "2^" + std::to_string(exponent) + " pixel");
  sweep.expect_within(0);
}

TEST(InvarianceExtremes, RaysMeetMovingObjectsOfAnySize) {
  Sweep sweep(9, "ball that moves by twice its size in a second", "1e-30 ... 1e29 m",
              "where a ray hits it at half the time");
  for (const double s : {1e-30, 1e-20, 1e-10, 1.0, 1e5, 1e10, 1e15, 1e19, 1e24, 1e29})
    for (const bool as_instance : {false, true}) {
      SceneDescription d = description();
      const KeyTransform keys[] = {{0, Transform()}, {1, Transform::translate({4 * s, 0, 0})}};
      const auto motion = std::make_shared<const Motion>(*Motion::create(keys));
      // A cube.  The ray meets one of its sides.
      TriangleMeshData cube = room();
      for (Vec3& p : cube.positions) p = p * s;
      if (as_instance) {
        d.objects = {{"cube", {{cube}}}};
        d.instances = {{0, Transform(), motion}};
      } else {
        d.shapes.push_back({cube});
        d.shapes[0].motion = motion;
      }
      const auto scene = build(std::move(d));
      const Vec3 o = scene->origin();
      Ray ray{Vec3f(Vec3{2.3 * s, 0.1 * s, 9 * s} - o), Vec3f{0, 0, -1}};
      ray.time_s = 0.5;
      const auto hit = scene->closest_hit(ray);
      ASSERT_TRUE(hit) << s;
      sweep.compare(hit->t / s, 8, std::to_string(std::log10(s)));
      ray.time_s = 0;
      EXPECT_FALSE(scene->closest_hit(ray)) << s;
    }
  sweep.expect_within(1e-6);
}

TEST(InvarianceExtremes, SmallerSizesAreRefused) {
  Sweep sweep(9, "the same room, or an instance of an object of this size", "1e-300 ... 1e-33 m",
              "answer at load");
  const auto answer = [&](const SceneDescription& d) {
    const auto scene = Scene::build(d);
    const std::string message(scene.status().message());
    sweep.answer(scene.ok() ? "built" : message.substr(message.find("allowed")));
  };
  for (const double s : {1e-33, 1e-35, 1e-38, 1e-45, 1e-60, 1e-100, 1e-300}) {
    answer(scaled_scene(small_room(), s));
    SceneDescription d = description();
    d.objects = {{"speck", {{ball(1, [&](const Vec3& p) { return p * (0.2 * s); })}}}};
    d.instances = {{0, *Transform::scale({1 / s, 1 / s, 1 / s})}};
    answer(d);
  }
  sweep.textbook_answer("black");
  sweep.expect_answers("allowed: 0, or at least 1e-32");
}

TEST(InvarianceExtremes, LargerSizesAreRefused) {
  Sweep sweep(9, "the same room", "1e31 ... 1e300 m", "answer at load");
  for (const double s : {1e31, 1e35, 1e40, 1e100, 1e300}) {
    const auto scene = Scene::build(scaled_scene(small_room(), s));
    const std::string message(scene.status().message());
    sweep.answer(scene.ok() ? "built" : message.substr(message.find("allowed")));
  }
  sweep.textbook_answer("Embree aborts the process from 1.8e18 m on");
  sweep.expect_answers("allowed: coordinates up to 1e30");
}

}  // namespace
}  // namespace lucerna::testing
