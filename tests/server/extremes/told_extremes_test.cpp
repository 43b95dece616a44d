// Rows 10 and 33: what answers say of directions and positions holds of the floats that tell them.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "server/emission_queries.h"
#include "server/queries.h"
#include "tests/server/extremes/every_light_scene.h"
#include "tests/server/extremes/file_scenes.h"
#include "tests/sweep.h"

namespace lucerna::testing {
namespace {

/// Items of one query of one light, as the wire has them.
struct Told {
  explicit Told(std::size_t n)
      : n(n),
        points(3 * n),
        directions(3 * n),
        normals(3 * n),
        value(3 * n),
        per_m2(n),
        per_sr(n),
        distance(n),
        bits((n + 7) / 8),
        ids(n),
        chance(n),
        status(n) {}

  bool has_light(std::size_t i) const { return status[i] == static_cast<int>(ItemResult::kOk); }

  std::size_t n;
  std::vector<float> points, directions, normals, value, per_m2, per_sr, distance;
  std::vector<std::uint8_t> bits;
  std::vector<std::uint64_t> ids;
  std::vector<double> chance;
  std::vector<int> status;
};

Told rays_of(const Scene& scene, std::uint32_t light, std::uint32_t n) {
  Told t(n);
  sample_le(scene, {.rays = n, .light = light, .seed = SeedRange{light + 1, 0}},
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

Told samples_of(const Scene& scene, std::uint32_t light, const PointArray& receivers,
                std::uint32_t samples) {
  Told t(receivers.size() * samples);
  std::vector<std::uint8_t> visible(t.bits.size());
  sample_li(
      scene,
      {.receivers = receivers, .samples = samples, .light = light, .seed = SeedRange{light + 1, 0}},
      {.value = t.value.data(),
       .wi = t.directions.data(),
       .distance_m = t.distance.data(),
       .light_offsets_m = t.points.data(),
       .light_normals = t.normals.data(),
       .pdf_per_sr = t.per_sr.data(),
       .delta = t.bits.data(),
       .visible = visible.data(),
       .light_ids = t.ids.data(),
       .selection_probability = t.chance.data(),
       .status = t.status.data()},
      {});
  return t;
}

/// Densities of the rays as they are told.
Told densities_of(const Scene& scene, std::uint32_t light, const Told& rays) {
  Told t(rays.n);
  pdf_le(scene, light, {scene.origin(), rays.points}, rays.directions, 0, t.per_m2.data(),
         t.per_sr.data(), t.status.data(), {});
  return t;
}

/// What a pdf that was not rounded with its direction says of it, at worst: the textbook's way.
template <typename L>
void compare_unrounded(Sweep& sweep, const L& light, const SceneSphere& sphere) {
  for (int i = 1; i < 64; ++i) {
    const auto s = light.sample_le({0.5, 0.5}, {i / 64.0, std::fmod(i * 0.618, 1)}, sphere);
    if (s.reason != NoLight::kNone || !(s.pdf_direction.per_sr > 0)) continue;
    const Vec3<double> told = normalized(Vec3<double>(Vec3<float>(s.direction)));
    const double density = light.pdf_le(s.origin, told, sphere).direction.per_sr;
    sweep.compare_textbook(s.pdf_direction.per_sr, density);
  }
}

/// Lights that have no surface, by the numbers in their scene.
std::vector<std::uint32_t> lights_without_surface(const Scene& scene) {
  std::vector<std::uint32_t> found;
  for (std::uint32_t l = 0; l < scene.lights().size(); ++l)
    std::visit(
        [&]<typename L>(const L&) {
          if constexpr (!SeenOnSurface<L>) found.push_back(l);
        },
        scene.lights()[l].light);
  return found;
}

std::string name(const Scene& scene, std::uint32_t light) {
  return "light " + std::to_string(scene.lights()[light].id);
}

constexpr const char* kFloats = "directions and positions as the wire's floats tell them";

/// Density and radiance along the directions that samples tell.
Told asked_along(const Scene& scene, std::uint32_t light, const PointArray& receivers,
                 const Told& samples) {
  Told t(samples.n);
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

TEST(ToldExtremes, SamplesOfLightsWithoutSurface) {
  Sweep sweep(33, "samples of every light without a surface", kFloats,
              "value and density against Le and PdfLi of the direction told");
  const auto scene = every_light();
  // Above all that would hide the sky, but below the windows: there the sky is seen.
  const std::vector<float> offsets{-3, -3, 0.5F, -1, 3, 0.3F, 0.2F, 0.1F, 3.6F};
  const Vec3<double> middle(100, -50, 0);
  for (const std::uint32_t light : lights_without_surface(*scene)) {
    constexpr std::uint32_t kSamples = 2000;
    const Told t = samples_of(*scene, light, {middle, offsets}, kSamples);
    const Told asked = asked_along(*scene, light, {middle, offsets}, t);
    for (std::size_t i = 0; i < t.n; ++i) {
      const bool is_delta = (t.bits[i / 8] >> (i % 8) & 1) != 0;
      if (!t.has_light(i) || is_delta) continue;
      sweep.compare(t.per_sr[i], asked.per_sr[i], name(*scene, light) + ", density");
      // Where nothing stands between.
      if (asked.ids[i] == 0) continue;
      for (std::size_t k = 3 * i; k < 3 * i + 3; ++k)
        sweep.compare(t.value[k], asked.value[k], name(*scene, light) + ", value");
    }
  }
  sweep.expect_within(0);
}

TEST(ToldExtremes, RaysOfLightsWithoutSurface) {
  Sweep sweep(33, "rays of every light without a surface", kFloats,
              "densities against PdfLe of the ray told");
  const auto scene = every_light();
  for (const std::uint32_t light : lights_without_surface(*scene)) {
    const Told t = rays_of(*scene, light, 4000);
    const Told asked = densities_of(*scene, light, t);
    for (std::size_t i = 0; i < t.n; ++i) {
      if (!t.has_light(i)) continue;
      sweep.compare(t.per_m2[i], asked.per_m2[i], name(*scene, light) + ", position");
      sweep.compare(t.per_sr[i], asked.per_sr[i], name(*scene, light) + ", direction");
    }
    std::visit([&](const auto& l) { compare_unrounded(sweep, l, scene->sphere()); },
               scene->lights()[light].light);
  }
  sweep.expect_within(0);
}

/// Also at the rim, which rounding leads over.
TEST(ToldExtremes, SmallSuns) {
  Sweep sweep(10, "sun, angular diameter", "30 ... 1e-4 degrees",
              "radiance and density against Le and PdfLi of the direction told");
  const std::vector<float> here{0, 0, 0};
  const Vec3<float> axis = normalized(Vec3<float>{1, -2, 3});
  for (const char* diameter : {"30", "0.5", "0.01", "1e-3", "1e-4"}) {
    const FileScene file =
        scene_of(std::string("LightSource \"distant\" \"point3 from\" [1 -2 3] ") +
                 "\"point3 to\" [0 0 0] \"float angulardiameter\" " + diameter);
    ASSERT_TRUE(file.status.ok()) << file.status;
    const Told t = samples_of(*file.scene, 0, {{}, here}, 4000);
    const Told asked = asked_along(*file.scene, 0, {{}, here}, t);
    for (std::size_t i = 0; i < t.n; ++i) {
      ASSERT_TRUE(t.has_light(i));
      sweep.compare(t.per_sr[i], asked.per_sr[i], diameter);
      sweep.compare(t.value[3 * i], asked.value[3 * i], diameter);
      // Whether it is met by the cosine.
      const float half = std::stof(diameter) * std::numbers::pi_v<float> / 360;
      sweep.compare_textbook(dot(triple(t.directions, i), axis) >= std::cos(half) ? 1 : 0, 1);
    }
  }
  sweep.expect_within(0);
}

TEST(ToldExtremes, NarrowSpots) {
  Sweep sweep(10, "spot, half angle, soft and hard edge", "1 ... 1e-5 degrees",
              "density of rays against PdfLe of the direction told");
  for (const char* cone : {"1", "0.05", "0.01", "1e-3", "1e-4", "1e-5"}) {
    for (const bool soft : {true, false}) {
      const std::string delta = soft ? cone : "0";
      const FileScene file = scene_of(
          std::string("LightSource \"spot\" \"point3 from\" [1 2 3] \"point3 to\" [2 0 -1] ") +
          "\"float coneangle\" " + cone + " \"float conedeltaangle\" " + delta);
      ASSERT_TRUE(file.status.ok()) << file.status;
      const Told t = rays_of(*file.scene, 0, 4000);
      const Told asked = densities_of(*file.scene, 0, t);
      for (std::size_t i = 0; i < t.n; ++i) {
        ASSERT_TRUE(t.has_light(i));
        sweep.compare(t.per_sr[i], asked.per_sr[i], cone);
      }
      std::visit([&](const auto& l) { compare_unrounded(sweep, l, file.scene->sphere()); },
                 file.scene->lights()[0].light);
    }
  }
  sweep.expect_within(0);
}

}  // namespace
}  // namespace lucerna::testing
