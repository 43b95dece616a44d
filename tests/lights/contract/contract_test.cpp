// What every light owes: samples, densities, power and irradiance.
#include <array>
#include <cmath>
#include <cstdint>
#include <set>
#include <string>
#include <utility>

#include "lights/sampling/sobol.h"
#include "tests/lights/area_lights.h"
#include "tests/lights/contract/contract_suite.h"

namespace lucerna::testing {

const std::vector<LightCase>& all_cases() {
  static const std::vector<LightCase> cases = [] {
    std::vector<LightCase> all;
    add_area_lights(all);
    add_delta_lights(all);
    add_lights_beyond(all);
    return all;
  }();
  return cases;
}

namespace {

TEST(Contract, EveryKindOfLightHasACase) {
  std::set<std::string> kinds;
  for (const LightCase& c : all_cases()) {
    const auto light = c.make({});
    if (c.value) kinds.insert(kind_of(*light));
    // A density needs places and directions to spread over.  A light without density spreads one of
    // the two, and the other is certain.
    const int spread = (c.emission_position ? 1 : 0) + (c.emission_region ? 1 : 0);
    EXPECT_GE(spread, light->is_delta() ? 1 : 2) << c.name;
    EXPECT_EQ(static_cast<bool>(c.region), !light->is_delta()) << c.name;
    EXPECT_EQ(static_cast<bool>(c.distance_to_surface), light->bounds().has_value()) << c.name;
  }
  for (const std::string& kind : all_kinds())
    EXPECT_TRUE(kinds.contains(kind)) << kind << " has no case";
}

class AnyLight : public ContractTest {};

TEST_P(AnyLight, SamplesAgreeWithEvaluation) {
  for (const Vec3& receiver : c.receivers) {
    const Receiver r = c.receiver(receiver);
    const Verdict verdict =
        check_sample_agrees([&](Vec2 u) { return light->sample_li(r, u); },
                            [&](const Vec3& wi) { return light->pdf_li(r, wi).per_sr; },
                            [&](const Vec3& wi) { return c.value(receiver, wi); }, c.tolerance);
    EXPECT_TRUE(verdict.ok()) << verdict.failure;
  }
}

TEST_P(AnyLight, ExtremeSampleValuesGiveValidSamples) {
  for (const Vec3& receiver : c.receivers)
    for (const double x : {0.0, 1 - 0x1p-24, 1.0})
      for (const double y : {0.0, 1 - 0x1p-24, 1.0}) {
        const Verdict verdict = check_well_formed(light->sample_li(c.receiver(receiver), {x, y}));
        EXPECT_TRUE(verdict.ok()) << verdict.failure << " at u = (" << x << ", " << y << ")";
      }
}

TEST_P(AnyLight, ReceiversThatAreNotFiniteGiveAReason) {
  for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL})
    for (const Vec3& r : {Vec3{bad, 0, 0}, {0, bad, 0}, {0, 0, bad}}) {
      const auto s = light->sample_li(c.receiver(r), {0.5, 0.5});
      EXPECT_TRUE(s.reason == NoLight::kOutOfRange || s.reason == NoLight::kDegenerate);
      EXPECT_TRUE(check_well_formed(s).ok());
      EXPECT_EQ(light->pdf_li(c.receiver(r), {0, 0, 1}).per_sr, 0);
      EXPECT_EQ(light->pdf_li(c.receiver(r), SurfacePoint{{0, 0, 1}, {0, 0, 1}}).per_sr, 0);
      EXPECT_EQ(light->pdf_li(c.receiver(c.receivers.front()), r).per_sr, 0);
      EXPECT_TRUE(light->le({{0, 0, 1}, {0, 0, 1}}, {std::nan(""), 0, 0}).is_black());
    }
}

TEST_P(AnyLight, RigidMotionChangesOnlyTheFrame) {
  const Placement placement = moved();
  const auto elsewhere = c.make(placement);
  RandomU random(2);
  for (const Vec3& receiver : c.receivers) {
    const Receiver there = c.receiver(placement.point(receiver), placement);
    for (int i = 0; i < 200; ++i) {
      // The warps' frames may rotate with the motion.  So compare the same direction, not the same
      // u.
      const auto s = light->sample_li(c.receiver(receiver), random.pair());
      const auto m = elsewhere->sample_li(there, random.pair());
      ASSERT_TRUE(check_well_formed(m).ok());
      if (s.reason != NoLight::kNone) continue;
      const double pdf = elsewhere->pdf_li(there, placement.direction(s.wi)).per_sr;
      EXPECT_LE(relative_difference(pdf, s.pdf.per_sr), 1e-9);
      if (m.reason != NoLight::kNone) continue;
      const Vec3 back = placement.rigid.inverse().vector(m.wi);
      EXPECT_LE(relative_difference(m.value, c.value(receiver, back)), 1e-9);
    }
  }
  EXPECT_LE(relative_difference(elsewhere->power(kScene).lumens, light->power(kScene).lumens),
            1e-12);
}

TEST_P(AnyLight, ScalingByPowersOfTwoChangesNoBit) {
  for (const int k : {-20, -1, 3, 20}) {
    const Placement placement{{}, k};
    const auto scaled_light = c.make(placement);
    RandomU random(3);
    for (const Vec3& receiver : c.receivers)
      for (int i = 0; i < 100; ++i) {
        const Vec2 u = random.pair();
        const auto s = light->sample_li(c.receiver(receiver), u);
        const auto t = scaled_light->sample_li(c.receiver(placement.point(receiver), placement), u);
        ASSERT_EQ(s.reason, t.reason);
        EXPECT_EQ(s.wi, t.wi);
        EXPECT_EQ(s.normal, t.normal);
        EXPECT_EQ(s.pdf, t.pdf);
        EXPECT_EQ(s.primitive, t.primitive);
        EXPECT_EQ(std::scalbn(s.distance, k), t.distance);
        EXPECT_EQ(s.value * std::scalbn(1.0, k * c.value_length_power), t.value);
      }
    const Power power = light->power(kScene);
    const Power scaled_power =
        scaled_light->power({scaled(kScene.center_m, k), std::scalbn(kScene.radius_m, k)});
    EXPECT_EQ(power.lumens * std::scalbn(1., k * c.power_length_power), scaled_power.lumens);
  }
}

INSTANTIATE_CONTRACT(AnyLight, c.value);

class LightWithDensity : public ContractTest {};

TEST_P(LightWithDensity, DensityIntegratesToTheSampledProbabilityAndSamplesFollowIt) {
  for (const Vec3& receiver : c.receivers) {
    const Receiver r = c.receiver(receiver);
    const auto sample = [&](Vec2 u) { return light->sample_li(r, u); };
    const auto pdf = [&](const Vec3& w) { return light->pdf_li(r, w).per_sr; };
    const Verdict integral = check_density_integrates(c.region(receiver), sample, pdf);
    EXPECT_TRUE(integral.ok()) << integral.failure;
    const Verdict follow = check_samples_follow_density(c.region(receiver), sample, pdf);
    EXPECT_TRUE(follow.ok()) << follow.failure;
  }
}

INSTANTIATE_CONTRACT(LightWithDensity, c.region);

/// A picture with the density of the radiance above the mean, as receivers with incomplete
/// densities sample it.
class LightWithIncompleteDensity : public ContractTest {};

TEST_P(LightWithIncompleteDensity, KeepsTheContract) {
  Receiver receiver(0, 0, 0);
  receiver.incomplete = true;
  const auto sample = [&](Vec2 u) { return light->sample_li(receiver, u); };
  const auto pdf = [&](const Vec3& w) { return light->pdf_li(receiver, w).per_sr; };
  const Verdict integral = check_density_integrates(c.region({}), sample, pdf);
  EXPECT_TRUE(integral.ok()) << integral.failure;
  const Verdict follow = check_samples_follow_density(c.region({}), sample, pdf);
  EXPECT_TRUE(follow.ok()) << follow.failure;
}

INSTANTIATE_CONTRACT(LightWithIncompleteDensity, c.name.starts_with("sky"));

class DeltaLight : public ContractTest {};

TEST_P(DeltaLight, HasNoDensityAndReportsIt) {
  RandomU random(4);
  for (const Vec3& receiver : c.receivers) {
    const auto s = light->sample_li(receiver, random.pair());
    ASSERT_EQ(s.reason, NoLight::kNone);
    EXPECT_TRUE(s.delta);
    EXPECT_EQ(s.pdf.per_sr, 0);
    EXPECT_EQ(light->pdf_li(receiver, s.wi).per_sr, 0);
    EXPECT_EQ(light->sample_li(receiver, random.pair()).wi, s.wi);
  }
}

INSTANTIATE_CONTRACT(DeltaLight, !c.region);

class LocalLight : public ContractTest {};

/// The mean of value / density over a grid of u: the illuminance on a surface that faces the light.
double facing_illuminance(const Light& light, const Receiver& receiver, const Vec3& to_light) {
  constexpr int kGrid = 64;
  double sum = 0;
  for (int i = 0; i < kGrid * kGrid; ++i) {
    const Vec2 u{(i / kGrid + 0.5) / kGrid, (i % kGrid + 0.5) / kGrid};
    const auto s = light.sample_li(receiver, u);
    if (s.reason != NoLight::kNone) continue;
    const double cos = std::fmax(0, dot(to_light, s.wi));
    sum += luminance(s.value) * cos / (s.delta ? 1.0 : s.pdf.per_sr);
  }
  return sum / (kGrid * kGrid);
}

TEST_P(LocalLight, FarFieldFallsOffWithTheSquareOfDistance) {
  const Vec3 away = c.far_direction;
  const auto scaled_illuminance = [&](double d) {
    return facing_illuminance(*light, c.receiver(c.centre + away * d), -away) *
           std::pow(d, -c.far_field_length_power);
  };
  // Nearer and farther parts of the light differ from the 1/d^2 of its centre by up to 2 size / d.
  const double d = 4096 * c.size;
  const double reference = scaled_illuminance(d);
  EXPECT_EQ(reference > 0, !c.enclosed);
  for (const double factor : {2., 16., 256.})
    EXPECT_LE(relative_difference(scaled_illuminance(factor * d), reference),
              2 * c.size / d + c.tolerance);
}

TEST_P(LocalLight, SampledPointsLieOnTheLight) {
  RandomU random(5);
  for (const Vec3& receiver : c.receivers)
    for (int i = 0; i < 200; ++i) {
      // Every fourth sample is from the corners and edges of the unit square.
      const double edge = i % 8 == 0 ? 0.0 : 1.0;
      const Vec2 u = i % 4 != 0 ? random.pair() : Vec2{edge, random.next()};
      const auto s = light->sample_li(c.receiver(receiver), u);
      if (s.reason != NoLight::kNone) continue;
      const double reach = c.size + length(receiver);
      EXPECT_LE(c.distance_to_surface(s.point), c.tolerance * reach);
      // Receiver, direction and distance lead to the point.
      EXPECT_LE(distance_between(receiver + s.wi * s.distance, s.point), c.tolerance * reach);
    }
}

INSTANTIATE_CONTRACT(LocalLight, c.value&& c.distance_to_surface);

// ---- Irradiance in closed form. ----

bool has_closed_form(const LightCase& c) {
  Receiver receiver(c.receivers.front());
  receiver.normal = {0, 0, 1};
  return c.make({})->irradiance(receiver).has_value();
}

TEST(LightWithIrradiance, UniformLightsOnPolygonsWholeDisksAndSpheresHaveAClosedForm) {
  std::set<std::string> names;
  for (const LightCase& c : all_cases())
    if (!c.receivers_only && has_closed_form(c)) names.insert(c.name);
  EXPECT_EQ(names, (std::set<std::string>{"box", "disk", "infinite", "inward_sphere",
                                          "parallelogram", "portal", "rectangle", "sphere", "sun",
                                          "sun_wide", "trapezoid", "triangles", "two_triangles"}));
}

TEST(LightWithIrradiance, ChangesSidesAtTheSurface) {
  for (const bool inwards : {false, true})
    for (const bool two_sided : {false, true}) {
      const DiffuseEmission emission{Rgb(2), two_sided};
      const auto sphere =
          *AreaLight::create(emission, *Sphere::create({.reverse_orientation = inwards}));
      const auto disk =
          *AreaLight::create(emission, *Disk::create({.reverse_orientation = inwards}));
      Receiver inside(0.5, 0.25, 0), outside(0, 0, 2), on(0, 0, 1), below(0.25, 0.5, -2);
      inside.normal = outside.normal = on.normal = {0, 0, -1};
      below.normal = {0, 0, 1};
      EXPECT_EQ(sphere.irradiance(inside)->g, inwards || two_sided ? 2 * kPi : 0);
      EXPECT_EQ(sphere.irradiance(outside)->g, !inwards || two_sided ? kPi / 2 : 0);
      EXPECT_FALSE(sphere.irradiance(on));
      EXPECT_EQ(disk.irradiance(below)->g > 0, inwards || two_sided);
      below.normal = {0, 0, -1};
      EXPECT_EQ(disk.irradiance(below)->g, 0);
    }
}

TEST(LightWithIrradiance, MeshesHideThemselvesHoweverLittleTheyBend) {
  for (const double bend : {1e-12, 1e-6, 0.5})
    EXPECT_TRUE(TriangleMesh::create(
                    {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{1, 0, 0}, {1, 1, bend}, {0, 1, 0}}})
                    ->hides_itself())
        << bend;
}

class LightWithIrradiance : public ContractTest {
 protected:
  /// Receivers that face the light's middle, that face aside, and whose horizon may cut the light.
  std::vector<Receiver> receivers() const {
    std::vector<Vec3> positions = c.receivers;
    positions.insert(positions.end(), c.near_receivers.begin(), c.near_receivers.end());
    std::vector<Receiver> all;
    for (const Vec3& position : positions) {
      const Vec3 to = normalized(c.centre - position);
      const auto frame = Frame::around(to == Vec3{} ? Vec3{0, 0, 1} : to);
      for (const Vec3& local : {Vec3{0, 0, 1},
                                {0.6, 0, 0.8},
                                {0.8, -0.6, 0.125},
                                {-0.6, 0.8, -0.0625},
                                {0, 1, -0.375},
                                {0, 0, -1}}) {
        Receiver receiver = c.receiver(position);
        receiver.normal = normalized(frame.world_from_local(local));
        all.push_back(receiver);
      }
    }
    return all;
  }
};

/// The mean of samples over Sobol points, in the green channel.  The standard error comes from
/// independent randomisations of the points.
std::pair<double, double> mean_of_samples(const Light& light, const Receiver& receiver,
                                          std::uint64_t item) {
  constexpr int kBlocks = 16;
  constexpr std::uint32_t kSamples = 4096;
  double sum = 0, squares = 0;
  for (int r = 0; r < kBlocks; ++r) {
    const SobolSequence sequence(7, item, static_cast<std::uint64_t>(r));
    double mean = 0;
    for (std::uint32_t i = 0; i < kSamples; ++i) {
      const Vec2f u = sequence.pair(i, 0);
      const auto s = light.sample_li(receiver, {u.x, u.y});
      if (s.reason == NoLight::kNone)
        mean += s.value.g * std::fmax(0, dot(receiver.normal, s.wi)) / s.pdf.per_sr / kSamples;
    }
    sum += mean, squares += mean * mean;
  }
  const double mean = sum / kBlocks;
  const double variance = std::fmax(0, squares / kBlocks - mean * mean) / (kBlocks - 1);
  return {mean, std::sqrt(variance)};
}

TEST_P(LightWithIrradiance, IsTheMeanOfSamples) {
  std::uint64_t item = 0;
  int lit = 0;
  for (const Receiver& receiver : receivers()) {
    const auto lx = light->irradiance(receiver);
    ASSERT_TRUE(lx);
    const auto [mean, error] = mean_of_samples(*light, receiver, ++item);
    // 16 randomisations are off by more than 12 standard errors less than once in 1e8 (Student).
    EXPECT_LE(std::fabs(lx->g - mean), 12 * error + 1e-9 * mean)
        << mean << " +- " << error << " at " << item;
    EXPECT_LE(error, 0.01 * std::fmax(mean, 0.01))
        << "the test is too inaccurate to notice mistakes";
    lit += lx->g > 0;
  }
  EXPECT_GT(lit, 0);
}

TEST_P(LightWithIrradiance, RigidMotionChangesNothing) {
  const Placement placement = moved();
  const auto elsewhere = c.make(placement);
  for (const Receiver& receiver : receivers()) {
    Receiver there(placement.point(receiver.position));
    there.normal = placement.direction(receiver.normal);
    const auto a = light->irradiance(receiver), b = elsewhere->irradiance(there);
    ASSERT_TRUE(a && b);
    EXPECT_LE(std::fabs(a->g - b->g), 1e-12 * std::fmax(1, a->g));
  }
}

TEST_P(LightWithIrradiance, ScalingByPowersOfTwoChangesNoBit) {
  for (const int k : {-20, -1, 3, 20}) {
    const Placement placement{{}, k};
    const auto scaled_light = c.make(placement);
    for (const Receiver& receiver : receivers()) {
      Receiver there(placement.point(receiver.position));
      there.normal = receiver.normal;
      EXPECT_EQ(light->irradiance(receiver), scaled_light->irradiance(there));
    }
  }
}

TEST_P(LightWithIrradiance, HasNoResultForInvalidReceivers) {
  Receiver receiver(c.receivers.front());
  EXPECT_FALSE(light->irradiance(receiver)) << "without a normal all directions count alike";
  receiver.normal = {0, 0, 1};
  EXPECT_TRUE(light->irradiance(receiver));
  for (const double bad : {std::nan(""), HUGE_VAL}) {
    Receiver nowhere = receiver, no_way = receiver;
    nowhere.position.y = bad, no_way.normal.x = bad;
    EXPECT_FALSE(light->irradiance(nowhere));
    EXPECT_FALSE(light->irradiance(no_way));
  }
}

TEST_P(LightWithIrradiance, OnlyLightsInSeveralPlanesHideThemselves) {
  // Rotated and shifted, so that no corner is exactly in the plane of the others.
  EXPECT_EQ(c.make(moved())->hides_itself(), c.name == "box");
}

INSTANTIATE_CONTRACT(LightWithIrradiance, has_closed_form(c));

}  // namespace
}  // namespace lucerna::testing
