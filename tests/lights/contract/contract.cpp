#include "tests/lights/contract/contract.h"

namespace lucerna::testing {
namespace {

/// The mean of value / density over a grid of u: the illuminance on a surface that faces the light.
double facing_illuminance(const Light& light, const Receiver& receiver, const Vec3& to_light) {
  constexpr int kGrid = 64;
  double sum = 0;
  for (int i = 0; i < kGrid * kGrid; ++i) {
    const Vec2 u{(i / kGrid + 0.5) / kGrid, (i % kGrid + 0.5) / kGrid};
    const auto s = light.sample_li(receiver, u);
    if (s.reason != NoLight::kNone) continue;
    const double cos = std::fmax(0, dot(to_light, Vec3(s.wi)));
    sum += luminance(Rgb(s.value)) * cos / (s.delta ? 1.0 : s.pdf.per_sr);
  }
  return sum / (kGrid * kGrid);
}

}  // namespace

namespace any_light {

void samples_agree_with_evaluation(const LightCase& c) {
  const auto light = c.make({});
  for (const auto& receiver : c.receivers()) {
    const Receiver r = c.receiver(receiver, {});
    const Verdict verdict =
        check_sample_agrees([&](Vec2 u) { return light->sample_li(r, u); },
                            [&](const Vec3& wi) { return light->pdf_li(r, wi).per_sr; },
                            [&](const Vec3& wi) { return c.value(receiver, wi); }, c.tolerance);
    EXPECT_TRUE(verdict.ok()) << verdict.failure;
  }
}

void extreme_sample_values_give_valid_samples(const LightCase& c) {
  const auto light = c.make({});
  for (const auto& receiver : c.receivers()) {
    for (const float x : {0.0, 1 - 0x1p-24, 1.0}) {
      for (const float y : {0.0, 1 - 0x1p-24, 1.0}) {
        const auto s = light->sample_li(c.receiver(receiver, {}), {x, y});
        const Verdict verdict = check_well_formed(s);
        EXPECT_TRUE(verdict.ok()) << verdict.failure << " at u = (" << x << ", " << y << ")";
      }
    }
  }
}

void receivers_that_are_not_finite_give_a_reason(const LightCase& c) {
  const auto light = c.make({});
  for (const float bad : {NAN, INFINITY, -INFINITY}) {
    for (const Vec3& r : {Vec3{bad, 0, 0}, {0, bad, 0}, {0, 0, bad}}) {
      const auto s = light->sample_li(c.receiver(r, {}), {0.5, 0.5});
      EXPECT_TRUE(s.reason == NoLight::kOutOfRange || s.reason == NoLight::kDegenerate);
      EXPECT_TRUE(check_well_formed(s).ok());
      EXPECT_EQ(light->pdf_li(c.receiver(r, {}), {0, 0, 1}).per_sr, 0);
    }
  }
}

void power_equals_quadrature(const LightCase& c) {
  const auto light = c.make({});
  const Power power = light->power(c.scene());
  EXPECT_LE(relative_difference(power.lumens, c.power_by_quadrature()), c.power_tolerance);
  EXPECT_GE(power.error_lumens, 0);
}

void rigid_motion_changes_only_the_frame(const LightCase& c) {
  const Placement placement = moved();
  const auto light = c.make({});
  const auto elsewhere = c.make(placement);
  RandomU random(2);
  for (const auto& receiver : c.receivers()) {
    for (int i = 0; i < 200; ++i) {
      // The warps' frames may rotate with the motion.  So compare the same direction, not the same
      // u.
      const auto s = light->sample_li(c.receiver(receiver, {}), random.pair());
      const auto m =
          elsewhere->sample_li(c.receiver(placement.point(receiver), placement), random.pair());
      ASSERT_TRUE(check_well_formed(m).ok());
      if (s.reason != NoLight::kNone) continue;
      const auto wi = placement.direction(s.wi);
      const double pdf =
          elsewhere->pdf_li(c.receiver(placement.point(receiver), placement), wi).per_sr;
      EXPECT_LE(relative_difference(pdf, s.pdf.per_sr), 1e-9);
      if (m.reason != NoLight::kNone) continue;
      const Vec3 back = placement.rigid.inverse().vector(m.wi);
      EXPECT_LE(relative_difference(m.value, c.value(receiver, back)), 1e-9);
    }
  }
  EXPECT_LE(relative_difference(elsewhere->power(c.scene()).lumens, light->power(c.scene()).lumens),
            1e-12);
}

void scaling_by_powers_of_two_changes_no_bit(const LightCase& c) {
  const auto light = c.make({});
  const SceneSphere scene = c.scene();
  for (const int k : {-20, -1, 3, 20}) {
    const Placement placement{{}, k};
    const auto scaled_light = c.make(placement);
    RandomU random(3);
    for (const auto& receiver : c.receivers()) {
      for (int i = 0; i < 100; ++i) {
        const Vec2 u = random.pair();
        const auto s = light->sample_li(c.receiver(receiver, {}), u);
        const auto t = scaled_light->sample_li(c.receiver(placement.point(receiver), placement), u);
        ASSERT_EQ(s.reason, t.reason);
        EXPECT_EQ(s.wi, t.wi);
        EXPECT_EQ(s.normal, t.normal);
        EXPECT_EQ(s.pdf, t.pdf);
        EXPECT_EQ(s.primitive, t.primitive);
        EXPECT_EQ(std::scalbn(s.distance, k), t.distance);
        EXPECT_EQ(s.value * std::scalbn(1.0, k * c.value_length_power), t.value);
      }
    }
    const Power power = light->power(scene);
    const Power scaled_power =
        scaled_light->power({scaled(scene.center_m, k), std::scalbn(scene.radius_m, k)});
    EXPECT_EQ(power.lumens * std::scalbn(1., k * c.power_length_power), scaled_power.lumens);
  }
}

}  // namespace any_light

namespace light_with_density {

void density_integrates_to_the_sampled_probability(const LightCase& c) {
  const auto light = c.make({});
  for (const auto& receiver : c.receivers()) {
    const Receiver r = c.receiver(receiver, {});
    const Verdict verdict = check_density_integrates(
        c.region(receiver), [&](Vec2 u) { return light->sample_li(r, u); },
        [&](const Vec3& w) { return double{light->pdf_li(r, Vec3(w)).per_sr}; });
    EXPECT_TRUE(verdict.ok()) << verdict.failure;
  }
}

void samples_follow_the_density(const LightCase& c) {
  const auto light = c.make({});
  for (const auto& receiver : c.receivers()) {
    const Receiver r = c.receiver(receiver, {});
    const Verdict verdict = check_samples_follow_density(
        c.region(receiver), [&](Vec2 u) { return light->sample_li(r, u); },
        [&](const Vec3& w) { return double{light->pdf_li(r, Vec3(w)).per_sr}; });
    EXPECT_TRUE(verdict.ok()) << verdict.failure;
  }
}

}  // namespace light_with_density

namespace delta_light {

void has_no_density_and_says_so(const LightCase& c) {
  const auto light = c.make({});
  RandomU random(4);
  for (const auto& receiver : c.receivers()) {
    const Receiver r = c.receiver(receiver, {});
    const auto s = light->sample_li(r, random.pair());
    ASSERT_EQ(s.reason, NoLight::kNone);
    EXPECT_TRUE(s.delta);
    EXPECT_EQ(s.pdf.per_sr, 0);
    EXPECT_EQ(light->pdf_li(r, s.wi).per_sr, 0);
    EXPECT_EQ(light->sample_li(r, random.pair()).wi, s.wi);
  }
}

}  // namespace delta_light

namespace local_light {

void far_field_falls_off_with_the_square_of_distance(const LightCase& c) {
  const auto light = c.make({});
  const Vec3 away = c.far_direction();
  const auto scaled_illuminance = [&](double d) {
    return facing_illuminance(*light, c.receiver(c.centre() + away * d, {}), -away) *
           std::pow(d, -c.far_field_length_power);
  };
  // Nearer and farther parts of the light differ from the 1/d^2 of its centre by up to 2 size / d.
  const double d = 4096 * c.size;
  const double reference = scaled_illuminance(d);
  EXPECT_EQ(reference > 0, !c.enclosed);
  for (const double factor : {2., 16., 256.}) {
    EXPECT_LE(relative_difference(scaled_illuminance(factor * d), reference),
              2 * c.size / d + c.tolerance);
  }
}

void sampled_points_lie_on_the_light(const LightCase& c) {
  const auto light = c.make({});
  RandomU random(5);
  for (const auto& receiver : c.receivers()) {
    for (int i = 0; i < 200; ++i) {
      // Every fourth sample is from the corners and edges of the unit square.
      const float edge = i % 8 == 0 ? 0.0 : 1.0;
      const Vec2 u = i % 4 != 0 ? random.pair() : Vec2{edge, random.next()};
      const auto s = light->sample_li(c.receiver(receiver, {}), u);
      if (s.reason != NoLight::kNone) continue;
      const Vec3 p(s.point);
      const double reach = c.size + length(receiver);
      EXPECT_LE(c.distance_to_surface(p), c.tolerance * reach);
      // Receiver, direction and distance lead to the point.
      const Vec3 along = receiver + Vec3(s.wi) * double{s.distance};
      EXPECT_LE(distance_between(along, p), c.tolerance * reach);
    }
  }
}

}  // namespace local_light

}  // namespace lucerna::testing
