// Rows 10 and 33: an answer's values match the directions and positions that it reports as floats.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "lights/sampling/sobol.h"
#include "server/queries/emission_queries.h"
#include "server/queries/queries.h"
#include "tests/extremes_sweep.h"
#include "tests/server/extremes/every_light_scene.h"
#include "tests/server/extremes/file_scenes.h"

namespace lucerna::testing {
namespace {

/// Items of one query about one light, in floats as in a request.
struct Items {
  explicit Items(std::size_t n)
      : n(n),
        points(3 * n),
        directions(3 * n),
        normals(3 * n),
        value(3 * n),
        per_m2(n),
        per_sr(n),
        distance(n),
        delta((n + 7) / 8),
        visible((n + 7) / 8),
        ids(n),
        chance(n),
        status(n) {}

  bool has_light(std::size_t i) const { return status[i] == static_cast<int>(ItemResult::kOk); }
  bool is_delta(std::size_t i) const { return (delta[i / 8] >> (i % 8) & 1) != 0; }
  bool is_visible(std::size_t i) const { return (visible[i / 8] >> (i % 8) & 1) != 0; }

  std::size_t n;
  std::vector<float> points, directions, normals, value, per_m2, per_sr, distance;
  std::vector<std::uint8_t> delta, visible;
  std::vector<std::uint64_t> ids;
  std::vector<double> chance;
  std::vector<int> status;
};

/// A light's own low-discrepancy points, and all combinations of the ends of [0, 1].
Items rays_of(const Scene& scene, std::uint32_t light, std::uint32_t n, double time_s = 0) {
  constexpr std::uint32_t kEnds = 16;
  std::vector<float> u;
  const SobolSequence points(light + 1, 0);
  for (std::uint32_t i = 0; i < n; ++i)
    for (std::uint32_t k = 0; k < 4; ++k)
      u.push_back(i < kEnds    ? static_cast<float>(i >> k & 1)
                  : k % 2 == 0 ? points.pair(i, k / 2).x
                               : points.pair(i, k / 2).y);
  Items t(n);
  sample_le(scene, {.rays = n, .light = light, .u = u, .time_s = time_s},
            {.offsets_m = t.points.data(),
             .directions = t.directions.data(),
             .light_normals = t.normals.data(),
             .value = t.value.data(),
             .pdf_position_per_m2 = t.per_m2.data(),
             .pdf_direction_per_sr = t.per_sr.data(),
             .light_ids = t.ids.data(),
             .selection_probability = t.chance.data(),
             .status = t.status.data()},
            {});
  return t;
}

Items samples_of(const Scene& scene, std::uint32_t light, const PointArray& receivers,
                 std::uint32_t samples) {
  Items t(receivers.size() * samples);
  sample_li(scene,
            {.receivers = receivers,
             .samples = samples,
             .light = light,
             .seed = SeedRange{light + 1, 0},
             .test_visibility = true},
            {.value = t.value.data(),
             .wi = t.directions.data(),
             .distance_m = t.distance.data(),
             .light_offsets_m = t.points.data(),
             .light_normals = t.normals.data(),
             .pdf_per_sr = t.per_sr.data(),
             .delta = t.delta.data(),
             .visible = t.visible.data(),
             .light_ids = t.ids.data(),
             .selection_probability = t.chance.data(),
             .status = t.status.data()},
            {});
  return t;
}

/// Densities of the rays as they are reported.
Items densities_of(const Scene& scene, std::uint32_t light, const Items& rays, double time_s = 0) {
  Items t(rays.n);
  pdf_le(scene, light, {scene.origin(), rays.points}, rays.directions, time_s, t.per_m2.data(),
         t.per_sr.data(), t.status.data(), {});
  return t;
}

/// Compares the density before the direction was rounded with the density of the rounded direction,
/// in the worst case: the textbook's way.
void compare_unrounded(Sweep& sweep, const Light& light, const SceneSphere& sphere) {
  for (int i = 1; i < 64; ++i) {
    const auto s = light.sample_le({0.5, 0.5}, {i / 64.0, std::fmod(i * 0.618, 1)}, sphere);
    if (s.reason != NoLight::kNone || !(s.pdf_direction.per_sr > 0)) continue;
    const Vec3 rounded = normalized(Vec3(Vec3f(s.direction)));
    const double density = light.pdf_le(s.origin, rounded, sphere).direction.per_sr;
    sweep.compare_textbook(s.pdf_direction.per_sr, density);
  }
}

/// Lights without a surface, by their numbers in the scene.
std::vector<std::uint32_t> lights_without_surface(const Scene& scene) {
  std::vector<std::uint32_t> found;
  for (std::uint32_t l = 0; l < scene.lights().size(); ++l)
    if (!scene.lights()[l].light->has_surface()) found.push_back(l);
  return found;
}

std::string name(const Scene& scene, std::uint32_t light) {
  return "light " + std::to_string(scene.lights()[light].id);
}

constexpr const char* kFloats = "directions and positions rounded to the floats of the answer";

/// Density and radiance along the sampled directions.
Items evaluated_along(const Scene& scene, std::uint32_t light, const PointArray& receivers,
                      const Items& samples) {
  Items t(samples.n);
  const std::size_t each = samples.n / receivers.size();
  for (std::size_t i = 0; i < t.n; ++i)
    for (std::size_t k = 0; k < 3; ++k)
      t.points[3 * i + k] = receivers.offsets_m[3 * (i / each) + k];
  const PointArray points{receivers.origin_m, t.points};
  pdf_li(scene, {.light = light, .receivers = points, .wi = samples.directions}, t.per_sr.data(),
         t.status.data(), {});
  le(scene, {.points = points, .directions = samples.directions, .light = light},
     {.radiance_cd_m2 = t.value.data(), .light_ids = t.ids.data(), .status = t.status.data()}, {});
  return t;
}

TEST(TransmittedExtremes, SamplesOfLightsWithoutSurface) {
  Sweep sweep(33, "samples of every light without a surface", kFloats,
              "value and density against Le and PdfLi of the reported direction");
  const auto scene = every_light();
  // Above everything that would hide the sky, but below the windows: the sky is visible there.
  const std::vector<float> offsets{-3, -3, 0.5F, -1, 3, 0.3F, 0.2F, 0.1F, 3.6F};
  const Vec3 middle(100, -50, 0);
  for (const std::uint32_t light : lights_without_surface(*scene)) {
    constexpr std::uint32_t kSamples = 2000;
    const Items t = samples_of(*scene, light, {middle, offsets}, kSamples);
    const Items evaluated = evaluated_along(*scene, light, {middle, offsets}, t);
    int seen = 0;
    for (std::size_t i = 0; i < t.n; ++i) {
      if (!t.has_light(i) || t.is_delta(i)) continue;
      sweep.compare(t.per_sr[i], evaluated.per_sr[i], name(*scene, light) + ", density");
      if (!t.is_visible(i)) continue;
      ++seen;
      for (std::size_t k = 3 * i; k < 3 * i + 3; ++k)
        sweep.compare(t.value[k], evaluated.value[k], name(*scene, light) + ", value");
    }
    EXPECT_TRUE(seen > 0 || t.is_delta(0)) << name(*scene, light);
  }
  sweep.expect_within(0);
}

/// Densities of rays against those of the reported rays.  `least_per_sr`: leaves out rays along the
/// surface, which rounding may move to its other side.
void compare_rays(Sweep& sweep, const Scene& scene, std::uint32_t light, double time_s,
                  float least_per_sr = 0) {
  const Items t = rays_of(scene, light, 4000, time_s);
  const Items evaluated = densities_of(scene, light, t, time_s);
  int rays = 0;
  for (std::size_t i = 0; i < t.n; ++i) {
    if (!t.has_light(i) || t.per_sr[i] < least_per_sr) continue;
    ++rays;
    sweep.compare(t.per_m2[i], evaluated.per_m2[i], name(scene, light) + ", position");
    sweep.compare(t.per_sr[i], evaluated.per_sr[i], name(scene, light) + ", direction");
  }
  EXPECT_GT(rays, 1000) << name(scene, light);
}

TEST(TransmittedExtremes, RaysOfEveryLight) {
  Sweep sweep(33, "rays of every light", kFloats, "densities against PdfLe of the reported ray");
  const auto scene = every_light();
  for (std::uint32_t light = 0; light < scene->lights().size(); ++light) {
    compare_rays(sweep, *scene, light, 0);
    compare_unrounded(sweep, *scene->lights()[light].light, scene->sphere());
  }
  sweep.expect_within(0);
}

TEST(TransmittedExtremes, RaysOfLightsThatMove) {
  Sweep sweep(33, "rays of lights that move", kFloats,
              "densities against PdfLe of the reported ray");
  const FileScene file = scene_of(
      "ActiveTransform EndTime\nTranslate 7 -3 2\nRotate 40 1 2 3\n"
      "ActiveTransform All\n"
      "LightSource \"spot\" \"float coneangle\" 0.05 \"float conedeltaangle\" 0.01\n"
      "LightSource \"projection\" \"float fov\" 30\n"
      "LightSource \"projection\" \"string projection\" \"orthographic\" \"float extent\" 0.3\n"
      "LightSource \"distant\" \"float angulardiameter\" 0.5\n"
      "LightSource \"infinite\" \"point3 portal\" [-1 -1 1  -1 1 1  1 1 1  1 -1 1]\n"
      "AreaLightSource \"diffuse\"\n"
      "Shape \"trianglemesh\" \"point3 P\" [0 0 1  1 0 1.5  0 1 1.2]\n"
      "Shape \"sphere\" \"float radius\" 0.4\n");
  ASSERT_TRUE(file.status.ok()) << file.status;
  for (std::uint32_t light = 0; light < file.scene->lights().size(); ++light)
    for (const double time_s : {0.0, 0.37, 1.0}) compare_rays(sweep, *file.scene, light, time_s);
  // The light rotates a direction again, with one rounding of doubles.
  sweep.expect_within(1e-6);
}

/// Positions are rounded relative to the scene.  This rounding is larger than that about the
/// light's own origin.
TEST(TransmittedExtremes, RaysOfSmallLightsThatMove) {
  Sweep sweep(33, "rays of round lights that move over a ground of 1e5 m", "radius 20 ... 300 m",
              "densities against PdfLe of the reported ray");
  const std::string ground =
      "Shape \"bilinearmesh\" \"point3 P\" [-5000 -5000 0  5000 -5000 0  -5000 5000 0  5000 5000 "
      "0]\n";
  for (const double radius : {20.0, 60.0, 300.0}) {
    const std::string r = "\"float radius\" " + std::to_string(radius);
    const std::string z = std::to_string(radius / 2);
    const FileScene file = scene_of(
        ground +
        "ActiveTransform EndTime\nTranslate 0.7 -0.3 0.2\nActiveTransform All\n"
        "Translate 12000 -900 300\nAreaLightSource \"diffuse\"\nShape \"sphere\" " +
        r + "\nShape \"cylinder\" " + r + " \"float zmin\" -" + z + " \"float zmax\" " + z + "\n");
    ASSERT_TRUE(file.status.ok()) << file.status;
    for (std::uint32_t light = 0; light < file.scene->lights().size(); ++light)
      for (const double time_s : {0.0, 0.37})
        compare_rays(sweep, *file.scene, light, time_s, 1e-3F);
  }
  sweep.expect_within(1e-6);
}

/// Points of these lights lie slightly off them after rounding to floats.
TEST(TransmittedExtremes, RaysOfNeedlesAndBentPatches) {
  Sweep sweep(33, "rays of needles with two acute corners, and of a patch that bends back",
              "length : width 10 ... 1e6", "densities against PdfLe of the reported ray");
  const auto patch = [](const std::string& corners) {
    return "Shape \"bilinearmesh\" \"point3 P\" [" + corners + "]\n";
  };
  std::string lights = "AreaLightSource \"diffuse\"\n";
  for (const char* width : {"0.3", "0.03", "3e-3", "3e-4", "3e-5", "3e-6"})
    lights += patch(std::string("1 2 3  1 3 6.1  ") + width + " 1.9 2.65  " + width + " 2.9 5.75");
  lights += patch("-1.12 0.85 0  -1.03 0.85 0  -1.17 0.75 0  -1.11 0.8 -0.022");
  lights += patch("0 0 0  1 0 0  0 1 0  0.1 0.1 0.6");
  const FileScene file = scene_of(lights);
  ASSERT_TRUE(file.status.ok()) << file.status;
  for (std::uint32_t light = 0; light < file.scene->lights().size(); ++light)
    compare_rays(sweep, *file.scene, light, 0);
  sweep.expect_within(0);
}

/// The sides of these patches are almost parallel.
TEST(TransmittedExtremes, RaysOfShearedNeedles) {
  Sweep sweep(33, "rays of needles with almost parallel sides, 1e4 lengths from the origin",
              "length : width 10 ... 1e4", "densities against PdfLe of the reported ray");
  std::string lights = "Shape \"disk\" \"float radius\" 1e5\nAreaLightSource \"diffuse\"\n";
  for (const double width : {0.1, 0.01, 1e-3, 1e-4})
    for (const double share : {0.5, 0.3, -0.4}) {
      const Vec3 corner{1.3e4, -2.7e3, 4.1e3}, u{0.8, 0.5, -0.33};
      const Vec3 v = u * share + Vec3{0.5, -0.8, 0.1} * width;
      std::string corners;
      for (const Vec3& p : {corner, corner + u, corner + v, corner + u + v})
        corners += fmt::format("{} {} {} ", p.x, p.y, p.z);
      lights += "Shape \"bilinearmesh\" \"point3 P\" [" + corners + "]\n";
    }
  const FileScene file = scene_of(lights);
  ASSERT_TRUE(file.status.ok()) << file.status;
  for (std::uint32_t light = 0; light < file.scene->lights().size(); ++light)
    compare_rays(sweep, *file.scene, light, 0);
  sweep.expect_within(0);
}

/// Where no float direction leads into a light, the answer describes the sampled direction.
TEST(TransmittedExtremes, LightsNarrowerThanFloats) {
  Sweep sweep(10, "spot and sun, half-angle", "1e-9 ... 1e-7 degrees",
              "flux and illuminance from samples whose directions floats cannot represent");
  const std::vector<float> here{0, 0, 0};
  for (const char* cone : {"1e-7", "1e-8", "1e-9"}) {
    const FileScene file = scene_of(
        std::string("LightSource \"spot\" \"point3 from\" [1 2 3] \"point3 to\" [2 0 -1] ") +
        "\"float conedeltaangle\" 0 \"float coneangle\" " + cone +
        "\nLightSource \"distant\" \"rgb L\" [5 5 5] \"point3 from\" [1 -2 3] " +
        "\"point3 to\" [0 0 0] \"float angulardiameter\" " + cone);
    ASSERT_TRUE(file.status.ok()) << file.status;
    const Scene& scene = *file.scene;
    const double lumens = scene.lights()[0].light->power(scene.sphere()).lumens.g;
    const Items rays = rays_of(scene, 0, 200);
    const Items samples = samples_of(scene, 1, {{}, here}, 200);
    for (std::size_t i = 0; i < rays.n; ++i) {
      ASSERT_TRUE(rays.has_light(i) && samples.has_light(i)) << cone;
      sweep.compare(double{rays.value[3 * i + 1]} / rays.per_sr[i], lumens, cone);
      sweep.compare(double{samples.value[3 * i + 1]} / samples.per_sr[i], 5, cone);
    }
  }
  // The rounding of the quotient of two floats.
  sweep.expect_within(1.2e-7);
}

/// Also at the rim, which rounding may cross.
TEST(TransmittedExtremes, SmallSuns) {
  Sweep sweep(10, "sun, angular diameter", "30 ... 1e-4 degrees",
              "radiance and density against Le and PdfLi of the reported direction");
  const std::vector<float> here{0, 0, 0};
  const Vec3f axis = normalized(Vec3f{1, -2, 3});
  for (const char* diameter : {"30", "0.5", "0.01", "1e-3", "1e-4"}) {
    const FileScene file =
        scene_of(std::string("LightSource \"distant\" \"point3 from\" [1 -2 3] ") +
                 "\"point3 to\" [0 0 0] \"float angulardiameter\" " + diameter);
    ASSERT_TRUE(file.status.ok()) << file.status;
    const Items t = samples_of(*file.scene, 0, {{}, here}, 4000);
    const Items evaluated = evaluated_along(*file.scene, 0, {{}, here}, t);
    for (std::size_t i = 0; i < t.n; ++i) {
      ASSERT_TRUE(t.has_light(i));
      sweep.compare(t.per_sr[i], evaluated.per_sr[i], diameter);
      sweep.compare(t.value[3 * i], evaluated.value[3 * i], diameter);
      // Whether the light is met, judged by the cosine.
      const float half = std::stof(diameter) * std::numbers::pi_v<float> / 360;
      sweep.compare_textbook(dot(triple(t.directions, i), axis) >= std::cos(half) ? 1 : 0, 1);
    }
  }
  sweep.expect_within(0);
}

TEST(TransmittedExtremes, NarrowSpots) {
  Sweep sweep(10, "spot with a soft or hard edge, half-angle", "1 ... 1e-5 degrees",
              "density of rays against PdfLe of the reported direction");
  for (const char* cone : {"1", "0.05", "0.01", "1e-3", "1e-4", "1e-5"}) {
    for (const bool soft : {true, false}) {
      const std::string delta = soft ? cone : "0";
      const FileScene file = scene_of(
          std::string("LightSource \"spot\" \"point3 from\" [1 2 3] \"point3 to\" [2 0 -1] ") +
          "\"float coneangle\" " + cone + " \"float conedeltaangle\" " + delta);
      ASSERT_TRUE(file.status.ok()) << file.status;
      const Items t = rays_of(*file.scene, 0, 4000);
      const Items evaluated = densities_of(*file.scene, 0, t);
      for (std::size_t i = 0; i < t.n; ++i) {
        ASSERT_TRUE(t.has_light(i));
        sweep.compare(t.per_sr[i], evaluated.per_sr[i], cone);
      }
      compare_unrounded(sweep, *file.scene->lights()[0].light, file.scene->sphere());
    }
  }
  sweep.expect_within(0);
}

}  // namespace
}  // namespace lucerna::testing
