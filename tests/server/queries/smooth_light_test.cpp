// Light by way of smooth surfaces against paths that find it by chance: lamps here are so large
// that directions of surfaces find them often.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <fstream>
#include <string>
#include <vector>

#include "server/files/asset_reader.h"
#include "server/pbrt/load_pbrt.h"
#include "server/queries/receiver_irradiance.h"
#include "tests/server/scene/scenes.h"
#include "tests/temp_directory.h"

namespace lucerna::testing {
namespace {

std::shared_ptr<const Scene> smooth_scene(const std::string& text) {
  const TempDirectory folder;
  std::ofstream(folder.path() / "scene.pbrt") << text;
  absl::StatusOr<AssetReader> reader = AssetReader::open(folder.path());
  if (!reader.ok()) throw std::runtime_error(reader.status().ToString());
  auto description = load_pbrt(*reader, "scene.pbrt", {});
  if (!description.ok()) throw std::runtime_error(description.status().ToString());
  return build(*std::move(description));
}

const std::string kLargeLamp = R"(WorldBegin
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [40 30 20] "bool twosided" true
  Shape "bilinearmesh" "point3 P" [-1 -1 3  -1 1 3  1 -1 3  1 1 3]
AttributeEnd
)";
const std::string kTurnedLamp = R"(WorldBegin
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [40 30 20]
  Shape "bilinearmesh" "point3 P" [0.4 -1 0.4  0.4 1 0.4  0.4 -1 2  0.4 1 2]
AttributeEnd
)";
const std::string kRoundLamp = R"(WorldBegin
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [40 30 20]
  Translate -1 0 1.5
  Shape "sphere" "float radius" 0.6
AttributeEnd
)";
const std::string kWater = R"(
Shape "bilinearmesh" "point3 P" [-90 -90 0.5  90 -90 0.5  -90 90 0.5  90 90 0.5]
)";
const std::string kGreyFloor = R"(Material "diffuse" "rgb reflectance" [0.5 0.6 0.7]
Shape "bilinearmesh" "point3 P" [-4 -4 -0.1  4 -4 -0.1  -4 4 -0.1  4 4 -0.1]
)";
const std::string kGlassBox = R"(
Shape "bilinearmesh" "point3 P" [-1 -1 1  1 -1 1  -1 1 1  1 1 1]
Shape "bilinearmesh" "point3 P" [-1 -1 0.5  -1 1 0.5  1 -1 0.5  1 1 0.5]
Shape "bilinearmesh" "point3 P" [-1 -1 0.5  1 -1 0.5  -1 -1 1  1 -1 1]
Shape "bilinearmesh" "point3 P" [-1 1 0.5  -1 1 1  1 1 0.5  1 1 1]
Shape "bilinearmesh" "point3 P" [-1 -1 0.5  -1 -1 1  -1 1 0.5  -1 1 1]
Shape "bilinearmesh" "point3 P" [1 -1 0.5  1 1 0.5  1 -1 1  1 1 1]
)";
const std::string kUprightWall = R"(
Shape "bilinearmesh" "point3 P" [1.5 -2 0  1.5 2 0  1.5 -2 2.5  1.5 2 2.5]
)";
const std::string kOppositeWall = R"(
Shape "bilinearmesh" "point3 P" [-1.5 -2 0  -1.5 -2 2.5  -1.5 2 0  -1.5 2 2.5]
)";

struct SmoothScene {
  std::string name, text;
  std::uint32_t bounces;
};

/// The mean and its standard error, over many answers.
struct MeanIlluminance {
  double value = 0, error = 0;
};
MeanIlluminance mean_illuminance(const Scene& scene, std::uint32_t bounces,
                                 Combination combination) {
  constexpr std::size_t kAnswers = 20;
  IrradianceSettings settings{
      .seed = 5, .samples_per_block = 64, .block_count = 16, .bounces = bounces};
  settings.methods.combination = combination;
  settings.methods.closed_forms = ClosedForms::kOff;
  const std::vector<IrradiancePoint> points(
      kAnswers, {Vec3{0.2, -0.3, 0} - scene.origin(), {1e-6F, 1e-6F, 1e-6F}, {0, 0, 1}});
  const IrradianceResult r = estimate_irradiance(scene, points, settings, {});
  double sum = 0, squares = 0;
  for (const IrradianceEstimate& e : r.points) {
    const double lux = luminance(e.irradiance_lx);
    sum += lux, squares += lux * lux;
  }
  const double n = kAnswers, mean = sum / n;
  return {mean, std::sqrt(std::fmax(0, squares / n - mean * mean) / (n - 1))};
}

TEST(SmoothLight, EqualsThatOfDirections) {
  const std::string conductor =
      "Material \"conductor\" \"rgb reflectance\" [0.9 0.8 0.7] \"float roughness\" 0";
  const std::string glass = "Material \"dielectric\" \"float eta\" 1.5";
  const std::string pane = "Material \"thindielectric\" \"float eta\" 1.5";
  const std::string coat =
      "Material \"coateddiffuse\" \"rgb reflectance\" [0.4 0.3 0.2] \"float roughness\" 0";
  const std::string metal_coat =
      "Material \"coatedconductor\" \"float interface.roughness\" 0 \"float conductor.roughness\" "
      "0";
  const std::string ball = R"(
AttributeBegin
Translate 0.9 0.8 0.5
Shape "sphere" "float radius" 0.45
AttributeEnd
)";
  // 100 small mirrors, each turned to send light of the lamp to another place of the floor.
  std::string crowd = conductor;
  for (int i = 0; i < 100; ++i) {
    const double x = 0.35 * (i % 10) - 1.6, y = 0.35 * (i / 10) - 1.6;
    crowd += fmt::format(
        "\nAttributeBegin Translate {} {} {} Rotate {} 0 1 0 Rotate {} 1 0 0 Shape "
        "\"bilinearmesh\" "
        "\"point3 P\" [-0.15 -0.15 0 0.15 -0.15 0 -0.15 0.15 0 0.15 0.15 0] AttributeEnd",
        x, y, 0.4 + 0.01 * i, 180 + 20 * x, 20 * y);
  }
  const std::string mixture = R"(
MakeNamedMaterial "a" "string type" "diffuse" "rgb reflectance" [0.3 0.3 0.3]
MakeNamedMaterial "b" "string type" "conductor" "rgb reflectance" [0.8 0.8 0.8] "float roughness" 0
Material "mix" "string materials" ["a" "b"] "float amount" 0.6)";
  for (const SmoothScene& q : std::vector<SmoothScene>{
           {"a mirror", kLargeLamp + conductor + kUprightWall, 1},
           {"two mirrors that face each other",
            kLargeLamp + conductor + kUprightWall + kOppositeWall, 6},
           {"a pane", kLargeLamp + pane + kUprightWall, 1},
           {"two panes and a floor", kLargeLamp + kGreyFloor + pane + kUprightWall + kOppositeWall,
            3},
           {"a box of glass", kLargeLamp + glass + kGlassBox, 6},
           {"a box of glass above a floor", kLargeLamp + kGreyFloor + glass + kGlassBox, 4},
           {"a smooth coat", kLargeLamp + coat + kUprightWall, 2},
           {"two smooth coats", kLargeLamp + coat + kUprightWall + kOppositeWall, 4},
           {"a coated mirror", kLargeLamp + metal_coat + kUprightWall, 1},
           {"a mirror ball", kLargeLamp + conductor + ball, 1},
           {"a mirror ball beside a mirror", kLargeLamp + conductor + ball + kUprightWall, 3},
           {"a crowd of mirrors", kLargeLamp + crowd, 3},
           {"a crowd of mirrors above a floor", kLargeLamp + kGreyFloor + crowd, 3},
           {"a crowd of mirrors under a sky",
            "WorldBegin\nLightSource \"infinite\" \"rgb L\" [3 4 5]\n" + crowd, 3},
           {"a mixture", kLargeLamp + mixture + kUprightWall, 2},
           {"a lamp that faces away, and a mirror ball", kTurnedLamp + conductor + ball, 1},
           {"a ball of light, and a mirror ball", kRoundLamp + conductor + ball, 1},
           {"a sky above water",
            "WorldBegin\nLightSource \"infinite\" \"rgb L\" [3 4 5]\n" + glass + kWater, 1},
           {"a mirror under a sky",
            "WorldBegin\nLightSource \"infinite\" \"rgb L\" [3 4 5]\n" + conductor + kUprightWall,
            1},
           {"glass under a sky",
            "WorldBegin\nLightSource \"infinite\" \"rgb L\" [3 4 5]\n" + glass + kGlassBox, 5}}) {
    const auto scene = smooth_scene(q.text);
    const MeanIlluminance computed =
                              mean_illuminance(*scene, q.bounces, Combination::kPowerHeuristic),
                          by_chance = mean_illuminance(*scene, q.bounces, Combination::kSurfaces);
    // Five standard errors, and the rounding of corners to floats: by chance once in a million.
    EXPECT_NEAR(computed.value, by_chance.value,
                5 * std::hypot(computed.error, by_chance.error) + 1e-6 * by_chance.value)
        << q.name << ": " << computed.error << ", " << by_chance.error;
    EXPECT_GT(by_chance.value, 0) << q.name;
  }
}

// From a mirror to a rough metal, the light of a point changes without a jump.  Facets of 0.15 are
// rough enough that directions find it too.
TEST(SmoothLight, RoughnessIsOneContinuum) {
  const auto metal = [](double alpha) {
    return "WorldBegin\nLightSource \"point\" \"rgb I\" [300 300 300] \"point3 from\" [0.4 0 2.6]\n"
           "Material \"conductor\" \"rgb reflectance\" [0.8 0.8 0.8] \"bool remaproughness\" false "
           "\"float roughness\" " +
           std::to_string(alpha) + kUprightWall;
  };
  const auto sampled = [&](double alpha) {
    return mean_illuminance(*smooth_scene(metal(alpha)), 1, Combination::kPowerHeuristic);
  };
  const MeanIlluminance mirror = sampled(0);
  double before = mirror.value;
  for (const double alpha : {0.0005, 0.001, 0.0011, 0.002, 0.005, 0.01, 0.02, 0.04}) {
    const MeanIlluminance m = sampled(alpha);
    EXPECT_LT(m.error, 0.002 * m.value) << alpha;
    // Lobes of this width are almost even over the light's surroundings.
    EXPECT_NEAR(m.value, before, 5 * m.error + 0.02 * m.value) << alpha;
    before = m.value;
  }
}

/// The answer at one receiver.
IrradianceEstimate smooth_answer(const Scene& scene, const Vec3& normal = {0, 0, 1},
                                 std::optional<std::uint32_t> bounces = {}) {
  const std::vector<IrradiancePoint> points{
      {Vec3{0.2, -0.3, 0} - scene.origin(), {1e-6F, 1e-6F, 1e-6F}, normal}};
  return estimate_irradiance(scene, points,
                             {.samples_per_block = 16, .block_count = 16, .bounces = bounces}, {})
      .points[0];
}

TEST(SmoothLight, BehindALensMayBeMissed) {
  const std::string lens = R"(
Material "dielectric" "float eta" 1.5
AttributeBegin
Translate 0 0 1
Shape "sphere" "float radius" 0.4
AttributeEnd
)";
  // Nothing bounds the light of a point that a lens focuses.
  const auto point =
      smooth_scene("WorldBegin\nLightSource \"point\" \"point3 from\" [1 0 3]\n" + lens);
  const IrradianceEstimate e = smooth_answer(*point);
  EXPECT_EQ(e.missed.kind, MissedLight::Kind::kByWay);
  EXPECT_EQ(e.missed.bound_lx, 0);
  // The light of a small lamp has a bound, and is not found.
  const auto lamp = smooth_scene(R"(WorldBegin
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [4000 4000 4000]
  Shape "bilinearmesh" "point3 P" [1 0 3  1 0.001 3  1.001 0 3  1.001 0.001 3]
AttributeEnd
)" + lens);
  const IrradianceEstimate s = smooth_answer(*lamp);
  EXPECT_EQ(s.missed.kind, MissedLight::Kind::kByWay);
  EXPECT_GT(s.missed.bound_lx, 0);
  EXPECT_LE(s.missed.bound_lx, kPi * 4000);
  EXPECT_GT(s.illuminance_lx.upper, luminance(s.irradiance_lx) + s.missed.bound_lx * 0.99);
  // A large lamp behind the lens is found often enough.
  EXPECT_EQ(smooth_answer(*smooth_scene(kLargeLamp + lens)).missed.kind, MissedLight::Kind::kNone);
}

// Of these surfaces, no path of a lamp without a size is computed, or not every one.
TEST(SmoothLight, ByWayOfNearlySmoothSurfacesMayBeMissed) {
  const std::string point = "WorldBegin\nLightSource \"point\" \"point3 from\" [0 0 2.5]\n";
  const std::string wall = "Shape \"bilinearmesh\" \"point3 P\" [1 -3 0 1 3 0 1 -3 4 1 3 4]\n";
  const std::string facing =
      "Shape \"bilinearmesh\" \"point3 P\" [-1.5 -3 0 -1.5 3 0 -1.5 -3 4 -1.5 3 4]\n";
  const auto metal = [](const std::string& roughness) {
    return "Material \"conductor\" \"bool remaproughness\" false " + roughness + "\n";
  };
  const auto checks = [](const char* a, const char* b) {
    return fmt::format(
        "Texture \"t\" \"float\" \"checkerboard\" \"float tex1\" {} \"float tex2\" {}\n", a, b);
  };
  const std::string textured = metal("\"texture roughness\" \"t\"");
  const auto missed = [&](const std::string& more) {
    return smooth_answer(*smooth_scene(point + more)).missed.kind == MissedLight::Kind::kByWay;
  };
  EXPECT_TRUE(
      missed("Material \"dielectric\" \"bool remaproughness\" false \"float roughness\" "
             "0.002 Shape \"disk\" \"float radius\" 3 \"float height\" 1"))
      << "glass that is nearly smooth";
  EXPECT_TRUE(missed(metal("\"float uroughness\" 0.002 \"float vroughness\" 0.2") + wall))
      << "brushed metal";
  EXPECT_TRUE(missed(checks("0.002", "0.5") + textured + wall)) << "a texture that is smooth";
  EXPECT_FALSE(missed(checks("0.3", "0.5") + textured + wall)) << "a texture that is rough";
  EXPECT_TRUE(missed(metal("\"float roughness\" 0.04") +
                     "AttributeBegin Translate 1 0 1 Shape \"sphere\" \"float radius\" 0.3 "
                     "AttributeEnd"))
      << "a curved surface";
  EXPECT_FALSE(missed(metal("\"float roughness\" 0.002") + wall)) << "one plane";
  EXPECT_TRUE(missed(metal("\"float roughness\" 0.002") + wall + facing)) << "two planes";
  EXPECT_TRUE(missed(metal("\"float roughness\" 0") +
                     "AttributeBegin Translate 0 0 1 Shape \"sphere\" \"float radius\" 4 "
                     "AttributeEnd"))
      << "inside of a mirror ball";
  const std::string above =
      "Shape \"bilinearmesh\" \"point3 P\" [-3 -3 2.5 3 -3 2.5 -3 3 2.5 3 3 2.5]\n";
  EXPECT_TRUE(missed(metal("\"float roughness\" 0.02") + above)) << "a lamp on such a plane";
  EXPECT_TRUE(missed("Material \"dielectric\" " + above)) << "a lamp on glass";
  EXPECT_FALSE(missed(metal("\"float roughness\" 0") + above)) << "a lamp on a mirror";
}

TEST(SmoothLight, BySeveralMirrorsOfManyMayBeMissed) {
  const std::string point = "WorldBegin\nLightSource \"point\" \"point3 from\" [0 0 3]\n";
  const std::string mirror =
      "Material \"conductor\" \"rgb reflectance\" [0.9 0.9 0.9] \"float roughness\" 0\n";
  const auto ball = [](double x) {
    return fmt::format(
        "AttributeBegin Translate {} 0 1 Shape \"sphere\" \"float radius\" 0.3 AttributeEnd\n", x);
  };
  const auto kind = [](const std::string& text, std::optional<std::uint32_t> bounces) {
    return smooth_answer(*smooth_scene(text), {0, 0, 1}, bounces).missed.kind;
  };
  using Kind = MissedLight::Kind;
  EXPECT_EQ(kind(point + mirror + ball(1), {}), Kind::kNone);
  EXPECT_EQ(kind(point + mirror + ball(1) + ball(-1), {}), Kind::kByWay);
  EXPECT_EQ(kind(point + mirror + ball(1) + ball(-1), 1), Kind::kNone);
  std::string tiles = point + mirror;
  for (int i = 0; i < 20; ++i)
    tiles += fmt::format(
        "Shape \"bilinearmesh\" \"point3 P\" [{0} 0 {1} {2} 0 {1} {0} 1 {1} {2} 1 {1}]\n", 0.1 * i,
        1 + 0.1 * i, 0.1 * i + 0.1);
  EXPECT_EQ(kind(tiles, {}), Kind::kByWay);
  EXPECT_EQ(kind(tiles, 1), Kind::kNone);
}

TEST(SmoothLight, ThatSurfacesReflectMayBeMissed) {
  // A spot lights a small part of the wall, which few directions meet.
  const std::string spot = R"(WorldBegin
LightSource "spot" "point3 from" [0 0 1] "point3 to" [9 9 1.5] "float coneangle" 0.01 "float conedeltaangle" 0
)";
  const std::string wall = R"(Material "diffuse" "rgb reflectance" [0.5 0.5 0.5]
Shape "bilinearmesh" "point3 P" [9 -99 -99  9 99 -99  9 -99 99  9 99 99]
)";
  EXPECT_EQ(smooth_answer(*smooth_scene(spot + wall)).missed.kind, MissedLight::Kind::kReflected);
  // The light of a mirror has an interval, which ends at the answer.
  const std::string by_mirror = R"(
LightSource "spot" "point3 from" [-1 0 1] "point3 to" [-3 0 0.6] "float coneangle" 5
Material "conductor" "float roughness" 0
Shape "bilinearmesh" "point3 P" [-3 -1 0  -3 1 0  -3 -1 1  -3 1 1]
)";
  const IrradianceEstimate mirrored = smooth_answer(*smooth_scene(spot + by_mirror + wall));
  EXPECT_GT(luminance(mirrored.irradiance_lx), 0);
  EXPECT_LT(mirrored.illuminance_lx.lower, mirrored.illuminance_lx.upper);
  EXPECT_EQ(mirrored.missed.kind, MissedLight::Kind::kReflected);
  // A receiver that faces away sees no surface.
  EXPECT_EQ(smooth_answer(*smooth_scene(spot + wall), {-1, 0, 0}).missed.kind,
            MissedLight::Kind::kNone);
}

/// The share that a conductor of index 1 with this reflectance along its normal reflects.
double of_conductor(double reflectance, double cosine) {
  const std::complex<double> eta(1, -2 * std::sqrt(reflectance / (1 - reflectance)));
  const std::complex<double> inside = std::sqrt(1.0 - (1 - cosine * cosine) / (eta * eta));
  return (std::norm((eta * cosine - inside) / (eta * cosine + inside)) +
          std::norm((cosine - eta * inside) / (cosine + eta * inside))) /
         2;
}

// A lamp and a receiver halfway between two mirrors: the images stand in a row.
TEST(SmoothLight, LongChainsOfMirrorsCount) {
  for (const double reflectance : {0.5, 0.75, 0.97}) {
    const auto scene = smooth_scene(fmt::format(R"(WorldBegin
LightSource "point" "rgb I" [1 1 1] "point3 from" [0.5 0 1]
Material "conductor" "rgb reflectance" [{0} {0} {0}] "float roughness" 0
Shape "bilinearmesh" "point3 P" [0 -50 -50  0 50 -50  0 -50 50  0 50 50]
Shape "bilinearmesh" "point3 P" [1 -50 -50  1 50 -50  1 -50 50  1 50 50]
)",
                                                reflectance));
    double right = 1;
    for (int k = 1; k < 2000; ++k) {
      const double distance = std::hypot(k, 1), cosine = k / distance;
      right += 2 * std::pow(of_conductor(reflectance, cosine), k) / std::pow(distance, 3);
    }
    const IrradiancePoint at{Vec3{0.5, 0, 0} - scene->origin(), {}, {0, 0, 1}};
    const IrradianceEstimate e =
        estimate_irradiance(*scene, {&at, 1}, {.samples_per_block = 16, .block_count = 16}, {})
            .points[0];
    constexpr double kOfFloats = 2e-4;
    EXPECT_LE(e.illuminance_lx.lower, right * (1 + kOfFloats)) << reflectance;
    // More mirrors than a path may have send on much of the light of good ones.
    const bool is_good = reflectance > 0.9;
    EXPECT_EQ(e.missed.kind, is_good ? MissedLight::Kind::kByWay : MissedLight::Kind::kNone);
    if (!is_good) {
      EXPECT_GE(e.illuminance_lx.upper, right * (1 - kOfFloats)) << reflectance;
    }
  }
}

}  // namespace
}  // namespace lucerna::testing
