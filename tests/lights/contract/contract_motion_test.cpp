// What every light owes under a moving transform: at each moment it equals the light that was
// created at its place of that moment.
#include <cmath>
#include <optional>

#include "lights/models/all_lights.h"
#include "lights/models/moved_light.h"
#include "tests/lights/contract/contract_suite.h"
#include "tests/lights/contract/emission_checks.h"

namespace lucerna::testing {
namespace {

std::vector<KeyTransform> keys() {
  return {{0, Transform::translate({1, 2, 3}) * *Transform::rotate(0.4, {0, 1, 1})},
          {2, Transform::translate({-1, 0, 1}) * *Transform::rotate(2.4, {1, 1, -2})},
          {3, Transform::translate({0, 0, 4}) * *Transform::rotate(-1, {3, 0, 1})}};
}

// The light-space axes and origin at time `t`, from the definition.  The origin moves on a line.
// The rotation is R = R0 exp(t w), by a share of the turn from one key frame to the next.
Transform transform_at(double t) {
  const std::vector<KeyTransform> k = keys();
  const std::size_t i = t < k[1].time_s ? 0 : 1;
  const double part = (t - k[i].time_s) / (k[i + 1].time_s - k[i].time_s);
  const Transform step = k[i + 1].world_from_light * k[i].world_from_light.inverse();
  // Angle and axis from trace and antisymmetric part (no turn here is near 0 or pi).
  const auto& m = step.matrix();
  const double angle = std::acos((m[0][0] + m[1][1] + m[2][2] - 1) / 2);
  const Vec3 axis{m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]};
  const Vec3 a = k[i].world_from_light.point({}), b = k[i + 1].world_from_light.point({});
  return Transform::translate(a + (b - a) * part) * *Transform::rotate(angle * part, axis) *
         Transform::translate(-a) * k[i].world_from_light;
}

class MovingLight : public ContractTest {
 protected:
  Placement place_at(double t) const { return {transform_at(t), 0}; }
  const std::unique_ptr<const Light> first = c.make({keys()[0].world_from_light, 0});
  const Motion motion = *Motion::create(keys());
  const SceneSphere around{{1, 2, 3}, 9};
};

TEST_P(MovingLight, EqualsTheLightCreatedAtItsPlace) {
  int lit = 0;
  for (const double t : {0.0, 0.7, 2.0, 2.9, 3.0}) {
    const auto moved = c.make(place_at(t));
    const MovedLight posed(*first, motion.at(t));
    RandomU random(11);
    for (const Vec3& own : c.receivers) {
      const Vec3 receiver = place_at(t).point(own);
      for (int i = 0; i < 200; ++i) {
        const Vec2 u = random.pair();
        const auto s = posed.sample_li(receiver, u);
        if (s.reason != NoLight::kNone) continue;
        ++lit;
        EXPECT_NEAR(length(s.wi), 1, 1e-14);
        if (s.delta) {
          const auto m = moved->sample_li(receiver, u);
          ASSERT_EQ(m.reason, NoLight::kNone);
          EXPECT_LE(relative_difference(s.value, m.value), 1e-11);
          // Positions of a few metres have a rounding of 1e-15 m.
          EXPECT_LE(distance_between(s.wi, m.wi), 1e-12 + 4e-15 / s.distance);
          continue;
        }
        // A direction's density is that of all points along it, so at least the sample's own.
        const double pdf = moved->pdf_li(receiver, s.wi).per_sr;
        EXPECT_LE(relative_difference(posed.pdf_li(receiver, s.wi).per_sr, pdf), 1e-7);
        EXPECT_LE(s.pdf.per_sr, pdf * (1 + 1e-7));
        if (moved->is_seen_beyond()) {
          EXPECT_LE(relative_difference(s.value, moved->le_escaped(receiver, s.wi)), 1e-12);
          EXPECT_LE(relative_difference(s.value, posed.le_escaped(receiver, s.wi)), 1e-12);
        }
        if (moved->has_surface()) {
          const SurfacePoint point{s.point, s.normal, s.primitive};
          EXPECT_LE(distance_between(receiver + s.wi * s.distance, s.point), 1e-12 * s.distance);
          EXPECT_LE(relative_difference(s.value, moved->le(point, -s.wi)), c.moved_tolerance);
          EXPECT_LE(relative_difference(s.value, posed.le(point, -s.wi)), c.moved_tolerance);
          const double own_pdf = posed.pdf_li(receiver, point).per_sr;
          EXPECT_LE(relative_difference(own_pdf, s.pdf.per_sr), 1e-7);
          EXPECT_LE(relative_difference(own_pdf, moved->pdf_li(receiver, point).per_sr), 1e-7);
        }
      }
    }
    // Elsewhere some see no light, for the same reason.  (The warps of other lights may rotate.)
    for (const Vec3& receiver : {Vec3{0.1, 0.2, -0.3}, {1, 2.3, 3.7}, {-10, 50.5, 3}, {3, 3, -4}})
      EXPECT_TRUE(c.region ||
                  posed.sample_li(receiver, {}).reason == moved->sample_li(receiver, {}).reason);
    EXPECT_LE(relative_difference(posed.power(around).lumens, moved->power(around).lumens), 1e-12);
    EXPECT_LE(relative_difference(posed.power_approximate(around).lumens,
                                  moved->power_approximate(around).lumens),
              1e-12);
  }
  EXPECT_GT(lit, 500);
}

TEST_P(MovingLight, KeepsItsBitsAtItsFirstKeyFrame) {
  const MovedLight posed(*first, motion.at(0));
  RandomU random(12);
  for (const Vec3& own : c.receivers) {
    const Vec3 receiver = place_at(0).point(own);
    for (int i = 0; i < 200; ++i) {
      const Vec2 u = random.pair();
      const auto s = first->sample_li(receiver, u), p = posed.sample_li(receiver, u);
      EXPECT_EQ(s.reason, p.reason);
      EXPECT_EQ(s.value, p.value);
      EXPECT_EQ(s.wi, p.wi);
      EXPECT_EQ(s.distance, p.distance);
      EXPECT_EQ(s.point, p.point);
      EXPECT_EQ(s.normal, p.normal);
      EXPECT_EQ(s.pdf, p.pdf);
      EXPECT_EQ(first->pdf_li(receiver, s.wi), posed.pdf_li(receiver, s.wi));
      EXPECT_TRUE(check_well_formed(p).ok());
    }
  }
}

TEST_P(MovingLight, ReceiversThatAreNotFiniteGiveAReason) {
  const MovedLight posed(*first, motion.at(1));
  for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL, 3e38}) {
    const auto s = posed.sample_li(Vec3{bad, bad, 0}, {0.5, 0.5});
    EXPECT_TRUE(bad == 3e38 || s.reason != NoLight::kNone);
    EXPECT_TRUE(check_well_formed(s).ok());
  }
}

TEST_P(MovingLight, EmitsLikeTheLightCreatedAtItsPlace) {
  int lit = 0;
  for (const double t : {0.0, 0.7, 2.0, 2.9, 3.0}) {
    const auto moved = c.make(place_at(t));
    const MovedLight posed(*first, motion.at(t));
    RandomU random(13);
    for (int i = 0; i < 200; ++i) {
      const Vec2 u_position = random.pair(), u_direction = random.pair();
      const auto s = posed.sample_le(u_position, u_direction, around);
      if (s.reason != NoLight::kNone) continue;
      ++lit;
      // Positions are sampled in the light's own space.  So both lights sample the same place and
      // normal.
      if (s.normal != Vec3{}) {
        const auto same = moved->sample_le(u_position, u_direction, around);
        EXPECT_LE(distance_between(s.origin, same.origin), 1e-13);
        EXPECT_LE(distance_between(s.normal, same.normal), 1e-13);
      }
      if (const auto* area = dynamic_cast<const AreaLight*>(moved.get())) {
        const auto at = area->shape().locate(s.origin, 1e-13);
        ASSERT_TRUE(at.has_value());
        EXPECT_LE(relative_difference(s.value, moved->le(*at, s.direction)), c.moved_tolerance);
      }
      // Back along the ray is the radiance that it carries.
      if (moved->is_seen_beyond()) {
        EXPECT_LE(
            relative_difference(s.value, moved->le_escaped(s.origin + s.direction, -s.direction)),
            1e-12);
      }
      const EmissionPdf own = posed.pdf_le(s.origin, s.direction, around);
      EXPECT_LE(relative_difference(own.position.per_m2, s.pdf_position.per_m2), 1e-7);
      EXPECT_LE(relative_difference(own.direction.per_sr, s.pdf_direction.per_sr), 1e-7);
      // A light at a point recognises its position by its bits.  So use the other light's own
      // position.
      const auto there = moved->bounds();
      const bool is_point = there && there->lower == there->upper;
      EXPECT_TRUE(!is_point || distance_between(s.origin, there->lower) <= 1e-14);
      const Vec3 origin = is_point ? there->lower : s.origin;
      const EmissionPdf other = moved->pdf_le(origin, s.direction, around);
      EXPECT_LE(relative_difference(other.position.per_m2, s.pdf_position.per_m2), 1e-7);
      EXPECT_LE(relative_difference(other.direction.per_sr, s.pdf_direction.per_sr), 1e-7);
      // No ray leaves from a place where the light is not.
      EXPECT_EQ(posed.pdf_le(s.origin + Vec3{20, 30, 5}, s.direction, around), EmissionPdf{});
    }
  }
  EXPECT_GT(lit, 400);
}

// Far from zero, floats are coarser than the light's own space, by the distance over the light's
// size.  Positions must still be found.  (Rays from infinity start at the scene's own sphere, which
// is never far from a scene's origin.)
TEST_P(MovingLight, FindsItsOwnPositionsFarFromTheOrigin) {
  if (c.enters_by_scene_disk) return;
  const Motion far = motion.about({}, {-3000, 700, 50});
  const SceneSphere scene{{3000, -700, -50}, 9};
  for (const double t : {0.0, 0.7, 2.9}) {
    const MovedLight posed(*first, far.at(t));
    RandomU random(14);
    for (int i = 0; i < 100; ++i) {
      const auto s = posed.sample_le(random.pair(), random.pair(), scene);
      if (s.reason != NoLight::kNone) continue;
      const EmissionPdf own = posed.pdf_le(s.origin, s.direction, scene);
      EXPECT_EQ(own.position.per_m2 > 0, s.pdf_position.per_m2 > 0);
      EXPECT_EQ(own.direction.per_sr > 0, s.pdf_direction.per_sr > 0);
    }
  }
}

TEST_P(MovingLight, BoundsHoldRaysAtTheTime) {
  for (const double t : {0.0, 0.7, 2.9}) {
    const MovedLight posed(*first, motion.at(t));
    const auto bounds = posed.bounds();
    ASSERT_EQ(bounds.has_value(), first->bounds().has_value());
    if (!bounds) continue;
    const auto moved = *c.make(place_at(t))->bounds();
    RandomU random(15);
    for (int i = 0; i < 500; ++i) {
      const auto s = posed.sample_le(random.pair(), random.pair(), around);
      if (s.reason != NoLight::kNone) continue;
      for (int axis = 0; axis < 3; ++axis) {
        EXPECT_GE(s.origin[axis], bounds->lower[axis]);
        EXPECT_LE(s.origin[axis], bounds->upper[axis]);
      }
      EXPECT_LE(
          std::atan2(length(cross(bounds->axis, s.direction)), dot(bounds->axis, s.direction)),
          bounds->cone_rad + 1e-12);
      for (int far = 1; far < 9; far += 7)
        EXPECT_TRUE(bounds->reaches(s.origin + s.direction * static_cast<double>(far)));
    }
    // At most the bounds of a rotated box: no longer than the diagonal of the light's own.
    const double diagonal =
        distance_between(first->bounds()->lower, first->bounds()->upper) * (1 + 1e-6) + 1e-5;
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_LE(bounds->upper[axis] - bounds->lower[axis], diagonal);
      EXPECT_GE(moved.upper[axis] + 1e-5, bounds->lower[axis]);
    }
    EXPECT_NEAR(bounds->cone_rad, moved.cone_rad, 2e-5);
  }
}

INSTANTIATE_CONTRACT(MovingLight, !c.receivers_only);

}  // namespace
}  // namespace lucerna::testing
