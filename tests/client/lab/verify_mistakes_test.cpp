// Which mistake is named, and when none is.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "client/lab/explain.h"
#include "client/lab/finding.h"
#include "client/lab/mistakes.h"
#include "client/lab/variation.h"

namespace lucerna::verify {
namespace {

using std::numbers::pi;
using ::testing::DoubleNear;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

const std::vector<double> kOurs = {1, 2, 3, 5, 8, 13, 0, 21};

std::vector<double> times(double factor) {
  std::vector<double> all = kOurs;
  for (double& v : all) v *= factor;
  return all;
}

std::vector<Hypothesis> factors(std::size_t lights = 1) {
  std::vector<Hypothesis> all;
  add_factors(kOurs, lights, &all);
  return all;
}

TEST(VerifyMistakes, FactorsAreNamedWithTheirDirection) {
  const auto more = likely_mistake(times(pi), kOurs, {}, factors());
  ASSERT_TRUE(more);
  EXPECT_EQ(more->mistake, "factor_pi");
  EXPECT_THAT(more->sentence, HasSubstr("a factor of pi is too many"));
  const auto less = likely_mistake(times(1 / (4 * pi)), kOurs, {}, factors());
  ASSERT_TRUE(less);
  EXPECT_EQ(less->mistake, "factor_4pi");
  EXPECT_THAT(less->sentence, HasSubstr("a factor of 4 pi is missing"));
}

TEST(VerifyMistakes, NumbersThatNoMistakeExplainsGetNoName) {
  EXPECT_FALSE(likely_mistake(times(1.3), kOurs, {}, factors()));
  // Lucerna's own numbers are no mistake.
  EXPECT_FALSE(likely_mistake(kOurs, kOurs, {}, factors()));
  // One and a half percent beside pi, where a fit allows one.
  EXPECT_FALSE(likely_mistake(times(1.015 * pi), kOurs, {}, factors()));
  EXPECT_FALSE(likely_mistake({}, {}, {}, {}));
  // A mistake must explain much more than no mistake does: here 0.6% become 0.3%.
  EXPECT_FALSE(likely_mistake(times(1.006), kOurs, {}, {{"small", "small", times(1.003), 1}}));
}

TEST(VerifyMistakes, ScatterWidensTheFit) {
  EXPECT_TRUE(likely_mistake(times(1.015 * pi), kOurs, std::vector<double>(8, 0.01), factors()));
  // But not so far that two factors are confused.
  const auto named = likely_mistake(times(2 * pi), kOurs, std::vector<double>(8, 0.01), factors());
  ASSERT_TRUE(named);
  EXPECT_EQ(named->mistake, "factor_2pi");
}

TEST(VerifyMistakes, SeveralMistakesThatFitAreAllNamed) {
  // With two lights, a half may be a missing side or a missing probability.
  const auto named = likely_mistake(times(0.5), kOurs, {}, factors(2));
  ASSERT_TRUE(named);
  EXPECT_THAT(named->mistake, HasSubstr("factor_2"));
  EXPECT_THAT(named->mistake, HasSubstr("selection"));
  EXPECT_THAT(named->sentence, HasSubstr("; or "));
}

TEST(VerifyMistakes, TheSimplerOfTwoMistakesIsNamed) {
  std::vector<Hypothesis> all = factors();
  add_product(kOurs, std::vector<double>(8, pi), 1, "product", "a product", &all);
  all.back().complexity = 2;
  all.push_back({"simple", "simple", times(pi), 0});
  const auto named = likely_mistake(times(pi), kOurs, {}, all);
  ASSERT_TRUE(named);
  EXPECT_EQ(named->mistake, "simple");
}

TEST(VerifyMistakes, RowsWithoutLightDoNotHideTheOthers) {
  std::vector<double> ours(100, 0), theirs(100, 0);
  for (std::size_t i = 0; i < 10; ++i) {
    ours[i] = 1 + static_cast<double>(i);
    theirs[i] = 2 * pi * ours[i];
  }
  std::vector<Hypothesis> all;
  add_factors(ours, 1, &all);
  const auto named = likely_mistake(theirs, ours, {}, all);
  ASSERT_TRUE(named);
  EXPECT_EQ(named->mistake, "factor_2pi");
  // A mistake that predicts light where both are dark does not fit.
  all = {{"glow", "glow", std::vector<double>(100, 1), 1}};
  std::copy(theirs.begin(), theirs.begin() + 10, all[0].predicted.begin());
  EXPECT_FALSE(likely_mistake(theirs, ours, {}, all));
}

/// 100 lamps seen from 1 to 10.9 m, with 1/r2.
struct Lamps {
  std::vector<double> distance, ours;
  Lamps() {
    for (int i = 0; i < 100; ++i) {
      distance.push_back(1 + 0.1 * i);
      ours.push_back(50 / (distance.back() * distance.back()));
    }
  }
  /// The name of the mistake in `theirs`.
  std::string name(const std::vector<double>& theirs) const {
    std::vector<Hypothesis> all;
    add_factors(ours, 1, &all);
    add_range(theirs, ours, distance, &all);
    add_clamp(theirs, ours, &all);
    const auto named = likely_mistake(theirs, ours, {}, all);
    return named ? named->mistake : "";
  }
};

TEST(VerifyMistakes, LightThatEndsAtARangeIsNamed) {
  const Lamps lamps;
  // Many rows beyond the range, and few.
  for (const double range : {5.0, 10.45}) {
    std::vector<double> cut = lamps.ours, window = lamps.ours, squared = lamps.ours;
    for (std::size_t i = 0; i < cut.size(); ++i) {
      const double share = std::max(0.0, 1 - std::pow(lamps.distance[i] / range, 4));
      if (lamps.distance[i] > range) cut[i] = 0;
      window[i] *= share;
      squared[i] *= share * share;
    }
    EXPECT_EQ(lamps.name(cut), "range") << range;
    EXPECT_EQ(lamps.name(window), "range") << range;
    EXPECT_EQ(lamps.name(squared), "range") << range;
  }
  // Rows that are dark for another reason.
  std::vector<double> shadowed = lamps.ours;
  for (std::size_t i = 0; i < 100; i += 3) shadowed[i] = 0;
  EXPECT_EQ(lamps.name(shadowed), "");
}

TEST(VerifyMistakes, NumbersThatAreCutAreNamed) {
  const Lamps lamps;
  std::vector<double> cut = lamps.ours, other = lamps.ours;
  for (double& v : cut) v = std::min(v, 20.0);
  EXPECT_EQ(lamps.name(cut), "clamped");
  for (double& v : other) v = std::pow(v, 0.8);
  EXPECT_EQ(lamps.name(other), "");
  // One number everywhere is a factor, and no cut.
  const std::vector<double> ours(100, 7), theirs(100, 5);
  std::vector<Hypothesis> all;
  add_clamp(theirs, ours, &all);
  EXPECT_TRUE(all.empty());
}

TEST(VerifyVariation, ATurnByNinetyDegreesTakesXToY) {
  LightFrame frame;
  frame.center = {1, 0, 0};
  const Variation v = turned_about_z(frame, 90);
  // From (1, 2, 0), the turned light looks as the light itself does from (3, 0, 0).
  const Double3 x = v.point({1, 2, 0});
  EXPECT_THAT(x, ElementsAre(DoubleNear(3, 1e-12), DoubleNear(0, 1e-12), DoubleNear(0, 1e-12)));
  const Double3 w = v.vector({0, 1, 0});
  EXPECT_THAT(w, ElementsAre(DoubleNear(1, 1e-12), DoubleNear(0, 1e-12), DoubleNear(0, 1e-12)));
  EXPECT_THAT(v.back(w),
              ElementsAre(DoubleNear(0, 1e-12), DoubleNear(1, 1e-12), DoubleNear(0, 1e-12)));
}

TEST(VerifyVariation, ALightTwiceAsLargeLooksAsFromHalfTheDistance) {
  v1::Light light;
  auto& area = *light.mutable_diffuse_area();
  area.set_shape(v1::AREA_SHAPE_SPHERE);
  area.mutable_round()->mutable_center_m()->set_z(3);
  area.mutable_round()->mutable_axes()->mutable_x()->set_x(1);
  area.mutable_round()->mutable_axes()->mutable_y()->set_y(1);
  area.mutable_round()->mutable_axes()->mutable_z()->set_z(1);
  const std::vector<Variation> all = resized(light);
  ASSERT_EQ(all.size(), 2U);
  EXPECT_THAT(all[0].sentence, HasSubstr("twice as large"));
  EXPECT_THAT(all[0].point({0, 0, 1}), ElementsAre(0, 0, 2));
  EXPECT_THAT(all[1].point({0, 0, 1}), ElementsAre(0, 0, -1));
}

TEST(VerifyVariation, AMapOfDirectionsHas47OtherPositions) {
  v1::Light light;
  auto& axes = *light.mutable_goniometric()->mutable_axes();
  axes.mutable_x()->set_x(1);
  axes.mutable_y()->set_y(1);
  axes.mutable_z()->set_z(1);
  const std::vector<Variation> all = turned(light);
  EXPECT_EQ(all.size(), 47U);
  int mirrored = 0;
  for (const Variation& v : all) {
    const double handed = dot(cross(v.turn[0], v.turn[1]), v.turn[2]);
    EXPECT_EQ(handed < 0, v.mistake == "map_mirrored") << v.sentence;
    mirrored += handed < 0 ? 1 : 0;
    // Each differs from the light itself.
    EXPECT_NE(v.turn, kIdentity) << v.sentence;
  }
  EXPECT_EQ(mirrored, 24);
  // A slide keeps its axis, and one that is not square its sides.
  v1::Light slide;
  auto& projection = *slide.mutable_projection();
  projection.mutable_right()->set_x(1);
  projection.mutable_up()->set_y(1);
  projection.mutable_axis()->set_z(1);
  projection.mutable_image();
  projection.set_aspect(1);
  EXPECT_EQ(turned(slide).size(), 7U);
  projection.set_aspect(1.5);
  EXPECT_EQ(turned(slide).size(), 3U);
  // Without a picture it looks the same.
  projection.clear_image();
  EXPECT_TRUE(turned(slide).empty());
}

TEST(VerifyVariation, ThePictureOfARectangleHasRightHandedAxes) {
  v1::Light light;
  auto& area = *light.mutable_diffuse_area();
  for (const Double3& corner : {Double3{1, 1, 3}, {1, 2, 3}, {2, 1, 3}, {2, 2, 3}}) {
    v1::Vector3& c = *area.add_corners_m();
    c.set_x(corner[0]);
    c.set_y(corner[1]);
    c.set_z(corner[2]);
  }
  const LightFrame frame = frame_of(light);
  EXPECT_THAT(frame.center, ElementsAre(1.5, 1.5, 3));
  EXPECT_THAT(frame.axes[0], ElementsAre(0, 1, 0));
  // (corner 2 - corner 1) x (corner 3 - corner 1) is the side that shines.
  EXPECT_THAT(frame.axes[2], ElementsAre(0, 0, -1));
  EXPECT_EQ(cross(frame.axes[0], frame.axes[1]), frame.axes[2]);
}

TEST(VerifyVariation, AnglesAreHalvedDoubledAndTakenForDegrees) {
  v1::Light light;
  light.mutable_spot()->set_cone_half_angle_rad(pi / 6);
  light.mutable_spot()->set_falloff_start_rad(pi / 10);
  const std::vector<ChangedLight> all = with_other_angles(light);
  std::vector<double> angles;
  for (const ChangedLight& c : all) angles.push_back(c.light.spot().cone_half_angle_rad());
  // cos(30 rad) is that of 30 - 8 pi, which is 4.867; its angle in [0, pi] is 10 pi - 30.
  EXPECT_THAT(angles,
              ElementsAre(DoubleNear(pi / 12, 1e-12), DoubleNear(pi / 3, 1e-12),
                          DoubleNear(10 * pi - 30, 1e-9), DoubleNear(pi / 6 * pi / 180, 1e-12)));
  // A spectrum cannot be edited.
  light.mutable_spectrum();
  EXPECT_TRUE(with_other_angles(light).empty());
}

TEST(VerifyColours, ATexelThatIsNotLinearisedIsBrighter) {
  // The table of sRGB: code 188 is 0.7373 encoded and 0.5029 linear.
  const Double3 c = not_linearised({0.5029 * 2, 0, 2}, {2, 2, 2});
  EXPECT_THAT(c,
              ElementsAre(DoubleNear(0.7373 * 2, 2e-3), DoubleNear(0, 1e-12), DoubleNear(2, 1e-9)));
  const Double3 back = linearised_twice(c, {2, 2, 2});
  EXPECT_THAT(back[0], DoubleNear(0.5029 * 2, 1e-6));
}

TEST(VerifyDecide, CorrectsForTheNumberOfTests) {
  const auto with = [](double p) {
    Finding f;
    f.quantity = "directions";
    f.p = p;
    return f;
  };
  std::vector<Finding> findings = {with(8e-4), with(0.5), with(0.9)};
  decide(findings, {});
  // Three tests: 8e-4 alone is below the level of 1e-3, and 2.4e-3 is not.
  EXPECT_EQ(findings[0].verdict, Verdict::kAgrees);
  EXPECT_DOUBLE_EQ(findings[0].adjusted_p.value(), 2.4e-3);
  findings = {with(1e-4), with(0.5), with(0.9)};
  decide(findings, {});
  EXPECT_EQ(findings[0].verdict, Verdict::kDiffers);
  EXPECT_EQ(findings[0].sentence, "no known mistake fits");
}

TEST(VerifyDecide, AnotherDensityIsTheRenderersOwnWayOnlyIfItsTestsPass) {
  Finding density, directions, integral;
  density.quantity = "density";
  density.verdict = Verdict::kDiffers;
  density.own_way_allowed = true;
  density.tests = {"directions", "integral"};
  directions.quantity = "directions";
  directions.p = 0.3;
  integral.quantity = "integral";
  integral.p = 0.4;
  std::vector<Finding> findings = {density, directions, integral};
  decide(findings, {});
  EXPECT_EQ(findings[0].verdict, Verdict::kOwnWay);
  // A test that fails.
  integral.p = 1e-9;
  findings = {density, directions, integral};
  decide(findings, {});
  EXPECT_EQ(findings[0].verdict, Verdict::kDiffers);
  // A test that could not be made.
  integral.p.reset();
  findings = {density, directions, integral};
  decide(findings, {});
  EXPECT_EQ(findings[0].verdict, Verdict::kDiffers);
  density.needs_tests = true;
  density.off = 7;
  findings = {density, directions, integral};
  decide(findings, {});
  EXPECT_EQ(findings[0].verdict, Verdict::kNotJudged);
  EXPECT_THAT(findings[0].sentence, HasSubstr("too few rows to test it"));
  // One test that fails decides.
  directions.p = 1e-9;
  findings = {density, directions, integral};
  decide(findings, {});
  EXPECT_EQ(findings[0].verdict, Verdict::kDiffers);
}

TEST(VerifyDecide, TwoDensitiesOfOneLightAreADifference) {
  Finding given, integral, density;
  given.quantity = "given density";
  given.verdict = Verdict::kDiffers;
  given.own_way_allowed = true;
  given.tests = {"given integral"};
  given.rival = "density";
  integral.quantity = "given integral";
  integral.p = 0.5;
  density.quantity = "density";
  density.verdict = Verdict::kAgrees;
  std::vector<Finding> findings = {given, integral, density};
  decide(findings, {});
  EXPECT_EQ(findings[0].verdict, Verdict::kDiffers);
  findings = {given, integral};
  decide(findings, {});
  EXPECT_EQ(findings[0].verdict, Verdict::kOwnWay);
}

}  // namespace
}  // namespace lucerna::verify
