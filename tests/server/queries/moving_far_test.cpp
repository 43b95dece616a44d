// Moving lights in scenes far from the world's zero, such as georeferenced ones.  The answers equal
// those of the same scene about zero.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "server/scene/light_at_time.h"
#include "server/scene/scene.h"
#include "tests/server/pbrt/pbrt_fixture.h"

namespace lucerna {
namespace {

using testing::message;
using testing::SceneFiles;

/// The distance between floats here is a metre or more.  The numbers are multiples of the floor's
/// extent, so that the scene's origin is exactly here.
constexpr Vec3 kFar{1e7, -2e7, 3e6};

std::string text(const Vec3& p) { return fmt::format("{} {} {} ", p.x, p.y, p.z); }

/// A sky of 4 x 4 texels with different values.
std::string sky_pfm() {
  std::string bytes = "PF\n4 4\n-1.0\n";
  for (int i = 0; i < 48; ++i) {
    const float v = 0.5F + static_cast<float>(i * 7 % 48) / 16;
    bytes.append(reinterpret_cast<const char*>(&v), sizeof v);
  }
  return bytes;
}

/// `light(o)` above a floor of 8 m, both about `o`.
template <typename Light>
std::shared_ptr<const Scene> scene_about(const Vec3& o, Light&& light) {
  const SceneFiles files;
  files.write("sky.pfm", sky_pfm());
  std::string corners;
  for (const auto& [x, y] : {std::pair{-4, -4}, {4, -4}, {-4, 4}, {4, 4}})
    corners += text(o + Vec3{double(x), double(y), 0});
  files.write("scene.pbrt", "WorldBegin Shape \"bilinearmesh\" \"point3 P\" [" + corners +
                                "]\nActiveTransform EndTime " + light(o));
  auto description = files.load("scene.pbrt");
  if (!description.ok()) throw std::runtime_error(message(description.status()));
  auto scene = Scene::build(*std::move(description));
  if (!scene.ok()) throw std::runtime_error(message(scene.status()));
  EXPECT_EQ((*scene)->origin(), o);
  EXPECT_TRUE((*scene)->moves());
  return *scene;
}

/// Numbers in the answers about a light.
struct Answers {
  struct Vector {
    const char* what;
    Vec3 v;
    double tolerance;
  };
  struct Number {
    const char* what;
    double v;  ///< in any unit
  };
  std::vector<Vector> vectors;
  std::vector<Number> numbers;
  std::vector<NoLight> reasons;
  int lit = 0;
};

/// Samples, densities, radiance, rays and power.
Answers answers_of(const Scene& scene, double t) {
  Answers all;
  const LightAtTime at_time(scene.lights()[0], t);
  const Light& light = *at_time;
  for (int i = 0; i < 64; ++i) {
    const auto of = [&](double step) { return std::fmod(i * step, 1); };
    const Vec2 u{of(0.618034), of(0.754878)}, v{of(0.569840), of(0.819173)};
    const Receiver r{{6 * of(0.324718) - 3, 6 * of(0.245122) - 3, of(0.141593)}};
    const auto s = light.sample_li(r, u);
    all.reasons.push_back(s.reason);
    if (s.reason == NoLight::kNone) {
      ++all.lit;
      all.vectors.push_back({"wi", Vec3(s.wi), 2e-6});
      all.numbers.push_back({"value", s.value.g});
      all.numbers.push_back({"pdf of a sample", s.pdf.per_sr});
      all.numbers.push_back({"pdf", light.pdf_li(r, s.wi).per_sr});
      if (light.is_seen_beyond())
        all.numbers.push_back({"radiance", light.le_escaped(r.position, s.wi).g});
    }
    const auto ray = light.sample_le(u, v, scene.sphere());
    all.reasons.push_back(ray.reason);
    if (ray.reason != NoLight::kNone) continue;
    all.vectors.push_back({"where a ray leaves", Vec3(ray.origin), 1e-5});
    all.vectors.push_back({"direction of a ray", Vec3(ray.direction), 2e-6});
    all.numbers.push_back({"density of a ray's position", ray.pdf_position.per_m2});
    all.numbers.push_back({"density of a ray's direction", ray.pdf_direction.per_sr});
    const auto known = light.pdf_le(ray.origin, ray.direction, scene.sphere());
    all.numbers.push_back({"position density of a known ray", known.position.per_m2});
    all.numbers.push_back({"direction density of a known ray", known.direction.per_sr});
  }
  all.numbers.push_back({"power", light.power(scene.sphere()).lumens.g});
  return all;
}

void expect_same_answers(const Scene& far, const Scene& near, double t) {
  const Answers a = answers_of(far, t), b = answers_of(near, t);
  ASSERT_EQ(a.reasons, b.reasons);
  EXPECT_GT(a.lit, 16);
  ASSERT_EQ(a.numbers.size(), b.numbers.size());
  for (std::size_t i = 0; i < a.vectors.size(); ++i)
    EXPECT_LE(length(a.vectors[i].v - b.vectors[i].v), a.vectors[i].tolerance) << a.vectors[i].what;
  for (std::size_t i = 0; i < a.numbers.size(); ++i)
    EXPECT_NEAR(a.numbers[i].v, b.numbers[i].v, 2e-5 * b.numbers[i].v) << a.numbers[i].what;
}

template <typename Light>
void expect_the_same_far_off(Light&& light) {
  const auto far = scene_about(kFar, light), near = scene_about({}, light);
  for (const double t : {0.0, 0.3, 1.0}) {
    SCOPED_TRACE(t);
    expect_same_answers(*far, *near, t);
  }
}

/// A window of 2 m, 3 m up; light comes down through it.
std::string portal(const Vec3& o) {
  std::string corners;
  for (const auto& [x, y] : {std::pair{-1, -1}, {-1, 1}, {1, 1}, {1, -1}})
    corners += text(o + Vec3{double(x), double(y), 3});
  return "\"point3 portal\" [" + corners + "]";
}

TEST(MovingFarOff, PortalsThatSlide) {
  expect_the_same_far_off([](const Vec3& o) {
    return "Translate 0.5 -0.25 1 ActiveTransform All LightSource \"infinite\" " + portal(o);
  });
}

TEST(MovingFarOff, PortalsThatTurnAboutTheirOwnCentre) {
  for (const std::string sky : {"", "\"string filename\" \"sky.pfm\" "})
    expect_the_same_far_off([&](const Vec3& o) {
      return "ActiveTransform All Translate " + text(o) +
             "ActiveTransform EndTime Rotate 25 1 2 0 ActiveTransform All LightSource "
             "\"infinite\" " +
             sky + portal(o);
    });
}

// They turn about the world's zero, 2e7 m away.
TEST(MovingFarOff, SkiesAndSunsThatTurnAboutTheWorldsZero) {
  for (const std::string light :
       {"\"infinite\"",
        "\"infinite\" \"string filename\" \"sky.pfm\" \"string mapping\" "
        "\"latlong\" \"string filter\" \"bilinear\"",
        "\"distant\" \"point3 from\" [1 2 5] \"point3 to\" [0 0 0] \"float angulardiameter\" 20",
        "\"distant\" \"point3 from\" [1 2 5] \"point3 to\" [0 0 0]"}) {
    SCOPED_TRACE(light);
    expect_the_same_far_off(
        [&](const Vec3&) { return "Rotate 70 1 2 2 ActiveTransform All LightSource " + light; });
  }
}

// A light without a place cannot shift.
TEST(MovingFarOff, SkiesAndSunsHaveNoShift) {
  for (const std::string light : {"\"infinite\"", "\"distant\" \"float angulardiameter\" 20"}) {
    SCOPED_TRACE(light);
    const auto turning = [&](const std::string& shift) {
      return scene_about({}, [&](const Vec3&) {
        return shift + "Rotate 70 1 2 2 ActiveTransform All LightSource " + light;
      });
    };
    for (const double t : {0.0, 0.5, 1.0})
      expect_same_answers(*turning("Translate 1e30 2 -1e9 "), *turning(""), t);
  }
}

TEST(MovingFarOff, PortalsBeyondTheRangeOfRaysAreAnError) {
  const auto error = [](const std::string& motion) {
    auto description =
        testing::load_world(motion + "\nLightSource \"infinite\" " + portal({0, 0, 0}));
    if (!description.ok()) return message(description.status());
    return message(Scene::build(*std::move(description)).status());
  };
  EXPECT_EQ(error("ActiveTransform EndTime Translate 1e9 0 0"), "");
  EXPECT_THAT(error("ActiveTransform EndTime Translate 0 1e31 0"),
              ::testing::HasSubstr("scene.pbrt:2:1: motion reaching to 1"));
}

TEST(MovingFarOff, ASceneOfOnePortalHasItsOriginThere) {
  const auto description =
      testing::load_world("LightSource \"infinite\" " + portal(kFar + Vec3{3, 5, 7}));
  ASSERT_TRUE(description.ok()) << description.status();
  const auto scene = Scene::build(*description);
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_LE(length((*scene)->origin() - kFar), 16);
  EXPECT_EQ((*scene)->sphere().radius_m, 0);  // its light comes from infinity
}

}  // namespace
}  // namespace lucerna
