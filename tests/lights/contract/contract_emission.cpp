#include "tests/lights/contract/contract_emission.h"

namespace lucerna::testing {
namespace {

void expect_bounds_reach(const LightCase& c, const Placement& placement) {
  const auto light = c.make(placement);
  const auto bounds = light->bounds();
  ASSERT_TRUE(bounds.has_value());
  const Vec3 center = Vec3(bounds->lower) * 0.5 + Vec3(bounds->upper) * 0.5;
  const Verdict verdict = check_bounds_reach(
      *bounds, center, placement.length(c.size),
      [&](const Vec3& p, Vec2 u) { return light->sample_li(p, u).reason == NoLight::kNone; });
  EXPECT_TRUE(verdict.ok()) << verdict.failure;
}

}  // namespace

namespace emitting_light {

void rays_agree_with_evaluation(const LightCase& c) {
  // In double, because the value is looked up from the ray's rounded position and direction.
  const auto light = c.make({});
  const SceneSphere scene = c.scene();
  const Verdict verdict = check_emission_agrees(
      [&](Vec2 up, Vec2 ud) { return light->sample_le(up, ud, scene); },
      [&](const Vec3& p, const Vec3& w) { return light->pdf_le(p, w, scene); }, c.emitted, 1e-9);
  EXPECT_TRUE(verdict.ok()) << verdict.failure;
}

void float_rays_agree_with_their_densities(const LightCase& c) {
  const auto light = c.make({});
  const SceneSphere scene = c.scene();
  RandomU random(11);
  for (int i = 0; i < 2000; ++i) {
    const Vec2 u = random.pair();
    const auto s = light->sample_le(u, random.pair(), scene);
    ASSERT_TRUE(check_well_formed(s).ok()) << check_well_formed(s).failure;
    if (s.reason != NoLight::kNone) continue;
    const auto densities = light->pdf_le(s.origin, s.direction, scene);
    EXPECT_LE(relative_difference(s.pdf_position.per_m2, densities.position.per_m2), c.tolerance);
    EXPECT_LE(relative_difference(s.pdf_direction.per_sr, densities.direction.per_sr), c.tolerance);
  }
}

void mean_of_rays_is_the_power(const LightCase& c) {
  const auto light = c.make({});
  const SceneSphere scene = c.scene();
  const Power power = light->power(scene);
  const Verdict verdict = check_emission_mean(
      [&](Vec2 up, Vec2 ud) { return light->sample_le(up, ud, scene); }, power.lumens,
      1e-6 + power.error_lumens / std::fmax(luminance(power.lumens), 1e-300));
  EXPECT_TRUE(verdict.ok()) << verdict.failure;
}

void extreme_sample_values_give_valid_rays(const LightCase& c) {
  const auto light = c.make({});
  constexpr std::array kExtremes{0.0, 1 - 0x1p-24, 1.0};
  for (int i = 0; i < 81; ++i) {
    const auto at = [&](int n) { return kExtremes[i / n % 3]; };
    const auto s = light->sample_le({at(27), at(9)}, {at(3), at(1)}, c.scene());
    const Verdict verdict = check_well_formed(s);
    EXPECT_TRUE(verdict.ok()) << verdict.failure << " at " << i;
  }
}

void rays_of_other_lights_have_no_density(const LightCase& c) {
  const auto light = c.make({});
  const SceneSphere scene = c.scene();
  RandomU random(12);
  const EmissionPdf none{};
  for (int i = 0; i < 100; ++i) {
    const Vec2 u = random.pair();
    const auto s = light->sample_le(u, random.pair(), scene);
    EXPECT_EQ(light->pdf_le(s.origin + Vec3{20, 30, -50}, s.direction, scene), none);
    for (const Vec3& nowhere :
         {Vec3{NAN, 0, 1}, {NAN, s.direction.y, s.direction.z}, {NAN, NAN, NAN}}) {
      EXPECT_EQ(light->pdf_le(nowhere, s.direction, scene), none);
      EXPECT_EQ(light->pdf_le(s.origin, nowhere, scene), none);
    }
  }
}

void approximate_power_states_its_error(const LightCase& c) {
  const auto light = c.make({});
  const Power approximate = light->power_approximate(c.scene());
  const Verdict verdict =
      check_stated_error(approximate, c.power_by_quadrature(), c.power_tolerance);
  EXPECT_TRUE(verdict.ok()) << verdict.failure;
  EXPECT_GE(approximate.error_lumens, light->power(c.scene()).error_lumens);
}

}  // namespace emitting_light

namespace emitting_surface {

void positions_follow_the_density(const LightCase& c) {
  const auto light = c.make({});
  const SceneSphere scene = c.scene();
  RandomU random(0xe3);
  const Vec2 ud{0.25, 0.625};
  // A light that emits in proportion to a picture has one density of positions for all directions.
  // So one direction is enough.
  const Vec3 w = light->sample_le({0.5, 0.5}, ud, scene).direction;
  const Verdict verdict = check_follows_on_square(
      [&]() -> std::optional<Vec2> {
        const auto s = light->sample_le(random.pair(), ud, scene);
        if (s.reason != NoLight::kNone) return std::nullopt;
        return c.emission_where(Vec3(s.origin), Vec3(s.direction));
      },
      [&](double x, double y) {
        const Vec3 p = c.emission_position(Vec3(w), x, y);
        Vec3 leaving = w;
        if (c.emission_direction) leaving = Vec3(c.emission_direction(p));
        return light->pdf_le(Vec3(p), leaving, scene).position.per_m2 * c.emission_area_m2();
      });
  EXPECT_TRUE(verdict.ok()) << verdict.failure;
}

}  // namespace emitting_surface

namespace emitting_directions {

void directions_follow_the_density(const LightCase& c) {
  const auto light = c.make({});
  const SceneSphere scene = c.scene();
  for (const Vec2 up : {Vec2{0.5, 0.5}, Vec2{0.125, 0.75}}) {
    RandomU random(0xe4);
    const auto first = light->sample_le(up, {0.4, 0.4}, scene);
    const Region region = c.emission_region(Vec3(first.origin));
    const Verdict verdict = check_follows_on_square(
        [&]() -> std::optional<Vec2> {
          const auto s = light->sample_le(up, random.pair(), scene);
          if (s.reason != NoLight::kNone) return std::nullopt;
          return region.where(Vec3(s.direction));
        },
        [&](double x, double y) {
          const Vec3 w = region.at(x, y);
          Vec3 p = first.origin;
          // Rays from infinitely far start where their direction requires.
          if (c.enters_by_scene_disk) p = Vec3(c.emission_position(w, 0.5, 0.5));
          return light->pdf_le(p, Vec3(w), scene).direction.per_sr * region.solid_angle_sr();
        });
    EXPECT_TRUE(verdict.ok()) << verdict.failure;
  }
}

}  // namespace emitting_directions

namespace bounded_light {

void bounds_reach_wherever_light_arrives(const LightCase& c) {
  expect_bounds_reach(c, {});
  expect_bounds_reach(c, moved());
  expect_bounds_reach(c, moved());
}

// Like in a scene: beside another light, in double.
void a_tree_chooses_it_wherever_light_arrives(const LightCase& c) {
  const auto light = c.make(moved());
  const LightBounds bounds = *light->bounds();
  EXPECT_LE(bounds.normals_rad, bounds.cone_rad);
  EXPECT_GE(bounds.normals_rad + std::numbers::pi / 2, bounds.two_sided ? 0 : bounds.cone_rad);
  const Vec3 center = bounds.lower * 0.5 + bounds.upper * 0.5;
  const double size = moved().length(c.size);
  const Vec3 aside = center + Vec3{size, 3 * size, 0};
  const LightTree tree = *LightTree::create(std::vector<LightTree::Item>{
      {bounds, 1}, {{.lower = aside, .upper = aside, .cone_rad = std::numbers::pi}, 1}});
  const Verdict verdict = check_reach(
      [&](const Vec3& p) { return tree.probability(p, 0) > 0; }, center, size,
      [&](const Vec3& p, Vec2 u) { return light->sample_li(p, u).reason == NoLight::kNone; });
  EXPECT_TRUE(verdict.ok()) << verdict.failure;
}

void bounds_hold_the_light(const LightCase& c) {
  const auto light = c.make(moved());
  const Verdict verdict = check_bounds_hold(
      *light->bounds(), [&](Vec2 up, Vec2 ud) { return light->sample_le(up, ud, c.scene()); });
  EXPECT_TRUE(verdict.ok()) << verdict.failure;
}

void bounds_leave_out_the_places_that_a_cone_does(const LightCase& c) {
  const auto light = c.make({});
  const auto bounds = light->bounds();
  const Vec3 center = Vec3(bounds->lower) * 0.5 + Vec3(bounds->upper) * 0.5;
  RandomU random(13);
  int left_out = 0;
  for (int i = 0; i < 1000; ++i) {
    const Vec2 at = random.pair();
    left_out += bounds->reaches(Vec3(center + Region{}.at(at.x, at.y) * (10 * c.size))) ? 0 : 1;
  }
  if (c.confined)
    EXPECT_GT(left_out, 0);
  else
    EXPECT_EQ(left_out, 0);
}

}  // namespace bounded_light

namespace unbounded_light {

// A light at infinity is chosen by its illuminance: its flux over its cross-section.
void has_a_cross_section_and_no_bounds(const LightCase& c) {
  const auto light = c.make({});
  EXPECT_FALSE(light->bounds().has_value());
  const std::optional<double> section_m2 = light->cross_section_m2({{}, 4});
  ASSERT_TRUE(section_m2.has_value());
  EXPECT_GT(*section_m2, 0);
}

// Rays that enter by the scene's sphere cannot start where that is a point.  Rays that start on a
// portal do not use the sphere.
void a_scene_without_extent_gets_rays_of_portals_only(const LightCase& c) {
  const auto light = c.make({});
  const SceneSphere none{{}, 0};
  RandomU random(16);
  for (int i = 0; i < 100; ++i) {
    const Vec2 up = random.pair(), ud = random.pair();
    const auto s = light->sample_le(up, ud, none);
    ASSERT_TRUE(check_well_formed(s).ok()) << check_well_formed(s).failure;
    if (c.enters_by_scene_disk) {
      EXPECT_NE(s.reason, NoLight::kNone);
      EXPECT_EQ(light->pdf_le({0, 0, 0}, {0, 0, 1}, none), EmissionPdf{});
    } else {
      const auto same = light->sample_le(up, ud, c.scene());
      EXPECT_EQ(s.reason, same.reason);
      EXPECT_EQ(s.origin, same.origin);
      EXPECT_EQ(s.direction, same.direction);
      if (s.reason != NoLight::kNone) continue;
      const EmissionPdf densities = light->pdf_le(s.origin, s.direction, none);
      EXPECT_EQ(densities, light->pdf_le(s.origin, s.direction, c.scene()));
      EXPECT_GT(densities.position.per_m2, 0);
    }
  }
}

}  // namespace unbounded_light

}  // namespace lucerna::testing
