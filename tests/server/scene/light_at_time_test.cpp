// LightAtTime compared with the models themselves: one light of each kind, at rest and moving.
#include "server/scene/light_at_time.h"

#include <gtest/gtest.h>

#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "server/files/asset_reader.h"
#include "server/pbrt/load_pbrt.h"
#include "tests/lights/area_lights.h"
#include "tests/paths.h"
#include "tests/server/scene/scenes.h"

namespace lucerna {
namespace {

SceneDescription every_light() {
  auto assets = AssetReader::open(test_data());
  if (!assets.ok()) throw std::runtime_error(assets.status().ToString());
  AssetReader reader = *std::move(assets);
  return load_pbrt(reader, "lights/every_light.pbrt").value();
}

std::shared_ptr<const Scene> scene_of(bool moving) {
  SceneDescription d = every_light();
  if (moving) {
    const std::vector<KeyTransform> keys{
        {0, Transform::translate({0.1, 0.2, 0})},
        {2, Transform::translate({1, -2, 0.5}) * *Transform::rotate(0.7, {1, 2, 3})}};
    const auto motion = std::make_shared<const Motion>(Motion::create(keys).value());
    for (LightDescription& l : d.lights) l.motion = motion;
    for (ShapeDescription& s : d.shapes) s.motion = motion;
  }
  return testing::build(std::move(d));
}

TEST(LightAtTime, EveryKindOfLightIsInTheScene) {
  std::set<std::string> kinds;
  const auto scene = scene_of(false);
  for (const SceneLight& light : scene->lights()) kinds.insert(testing::kind_of(*light.light));
  EXPECT_EQ(kinds, testing::all_kinds());
}

TEST(LightAtTime, IsTheLightItselfAtRest) {
  const auto scene = scene_of(false);
  for (const SceneLight& light : scene->lights())
    EXPECT_EQ(&*LightAtTime(light, 0.75), light.light.get());
}

TEST(LightAtTime, IsTheMovedLightInMotion) {
  const auto scene = scene_of(true);
  ASSERT_TRUE(scene->moves());
  for (const SceneLight& light : scene->lights())
    for (const double time_s : {-1.0, 0.75, 3.0}) {
      const LightAtTime at_time(light, time_s);
      const MovedLight moved(*light.light, light.moving->at(time_s));
      Receiver receiver(scene->sphere().center_m + Vec3{-0.7, 1.2, -0.9});
      receiver.normal = normalized(Vec3{0.3, -0.6, 1});
      const LightSample a = at_time->sample_li(receiver, {0.3, 0.6});
      const LightSample b = moved.sample_li(receiver, {0.3, 0.6});
      EXPECT_EQ(a.reason, b.reason) << light.id;
      EXPECT_EQ(a.wi, b.wi) << light.id;
      EXPECT_EQ(a.value, b.value) << light.id;
      EXPECT_EQ(a.pdf, b.pdf) << light.id;
    }
}

TEST(LightAtTime, HasNoMemberThatItsModelLacks) {
  SceneDescription d = testing::description();
  d.lights = {testing::point_light({0, 0, 3}, 100)};
  const auto scene = testing::build(std::move(d));
  const LightAtTime point(scene->lights()[0], 0);
  const Vec3 up{0, 0, 1};
  const SurfacePoint nowhere{{}, up, 0};
  EXPECT_TRUE(point->le(nowhere, up).is_black());
  EXPECT_TRUE(point->le_escaped({}, up).is_black());
  EXPECT_TRUE(point->le_leaving({}, up).is_black());
  EXPECT_EQ(point->pdf_li(Receiver(0, 0, 0), nowhere).per_sr, 0);
  EXPECT_FALSE(point->irradiance(Receiver(0, 0, 0)));
  EXPECT_FALSE(point->hides_itself());
}

}  // namespace
}  // namespace lucerna
