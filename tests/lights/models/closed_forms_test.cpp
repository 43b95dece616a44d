// Irradiance from area lights and skies as the mean of their samples, for every area sampling
// method.  The closed forms are derived in tests/lights/closed_forms.h.
#include "tests/lights/closed_forms.h"

#include <gtest/gtest-spi.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "lights/models/all_lights.h"
#include "lights/shapes/all_shapes.h"
#include "tests/lights/area_helpers.h"

namespace lucerna::testing {
namespace {

constexpr AreaSampling kWays[] = {AreaSampling::kAutomatic,  AreaSampling::kSquareRoot,
                                  AreaSampling::kKraemer,    AreaSampling::kParallelogram,
                                  AreaSampling::kRejection,  AreaSampling::kLowDistortion,
                                  AreaSampling::kSolidAngle, AreaSampling::kCosineSolidAngle};

struct Place {
  std::string name;
  Vec3 receiver, normal;
  double expected;  ///< at radiance 1
};

/// Compares each sampling method at each place, with the receiver's normal given and not, to within
/// 6.5 standard errors.  They are exceeded by chance once in 1e10, and no test here compares more
/// than 1000 means.  `largest_error` bounds the relative standard error, so that the test notices
/// mistakes.
template <typename Light>
void expect_every_way(const Light& light, const std::vector<Place>& places, double largest_error,
                      int samples = 40000) {
  std::uint64_t seed = 0xc105ed;
  for (const Place& p : places)
    for (const AreaSampling way : kWays)
      for (const bool with_normal : {false, true}) {
        Receiver receiver{Vec3(p.receiver)};
        receiver.area_sampling = way;
        if (with_normal) receiver.normal = Vec3(p.normal);
        const Estimate e = illuminance(light, receiver, p.normal, ++seed, samples);
        const std::string what =
            p.name + ", way " + std::to_string(int(way)) + (with_normal ? ", with normal" : "");
        EXPECT_LE(std::fabs(e.mean - p.expected), 6.5 * e.standard_error + 1e-6 * p.expected)
            << what << ": " << e.mean << " +- " << e.standard_error << ", not " << p.expected;
        EXPECT_LT(e.standard_error, largest_error * p.expected) << what;
      }
}

const std::vector<Vec3> kTriangle{{0, 0, 2}, {1, 3, 2.5}, {2, -1, 2.25}};

AreaLight triangle_light() {
  const auto v = [](int i) { return Vec3(kTriangle[i]); };
  return *AreaLight::create({Rgb(1), true}, *TriangleMesh::create({{v(0), v(1), v(2)}}));
}

Place at(const std::string& name, const Vec3& receiver, const Vec3& direction,
         const std::vector<Vec3>& polygon) {
  const Vec3 n = normalized(direction);
  return {name, receiver, n, polygon_irradiance(polygon, receiver, n)};
}

TEST(ClosedForms, TrianglesFollowLambertsFormulaForEachMethod) {
  expect_every_way(triangle_light(),
                   {at("above the horizon", {0.5, 0.25, 0}, {0, 0.25, 1}, kTriangle),
                    at("cut by the horizon", {0.5, 0.25, 0}, {1, -0.5, 0}, kTriangle),
                    at("near", {1, 1, 2.0}, {0.25, 0, 1}, kTriangle),
                    at("far", {30, -20, -40}, {-0.25, 0.5, 1}, kTriangle)},
                   0.02);
}

const std::vector<Vec3> kRectangle{{-1, -0.5, 2}, {1, -0.5, 2}, {1, 0.5, 2}, {-1, 0.5, 2}};

TEST(ClosedForms, RectanglesFollowLambertsFormulaForEachMethod) {
  const auto v = [](int i) { return Vec3(kRectangle[i]); };
  const auto light =
      *AreaLight::create({Rgb(1), true}, *PatchMesh::create({{v(0), v(1), v(3), v(2)}}));
  expect_every_way(light,
                   {at("above the horizon", {0.5, 0.25, 0}, {0, 0.25, 1}, kRectangle),
                    at("cut by the horizon", {0.5, 0.25, 0}, {1, -0.5, 0}, kRectangle),
                    at("near", {0.25, 0.25, 1.75}, {0.25, 0, 1}, kRectangle),
                    at("near, beside it", {1.5, 0, 1.75}, {-1, 0, 0.25}, kRectangle),
                    at("far", {30, -20, -40}, {-0.25, 0.5, 1}, kRectangle)},
                   0.02);
}

AreaLight sphere_light(const Vec3& centre, double radius, bool inwards = false) {
  return *AreaLight::create({Rgb(1)},
                            *Sphere::create({.radius_m = radius,
                                             .reverse_orientation = inwards,
                                             .world_from_object = Transform::translate(centre)}));
}

TEST(ClosedForms, SpheresWholeOrCutByTheHorizonAgreeForEachMethod) {
  const Vec3 centre{0, 0, 4};
  const auto place = [&](const std::string& name, const Vec3& r, const Vec3& d) {
    const Vec3 n = normalized(d);
    return Place{name, r, n, sphere_irradiance(centre, 2, r, n)};
  };
  expect_every_way(
      sphere_light(centre, 2),
      {place("whole", {0, 0, 0}, {0.8, 0, 0.6}),
       place("centre on the horizon", {0, 0, 0}, {1, 0, 0}),
       place("most of it below", {0, 0, 0}, {1, 0.5, -0.25}),
       place("most of it above", {1, -3, 2}, {-1, -0.25, 1.5}),
       place("near", {0.5, 0, 1.5}, {0.5, 0, 1}), place("far", {60, 0, -80}, {-0.5, 0, 1})},
      0.03, 80000);
}

TEST(ClosedForms, SphereFormulaAgreesWithQuadrature) {
  // The companion of the formula itself: the sum of the cosine over directions of the cap.
  const Vec3 centre{0, 0, 4};
  for (const Vec3& d : {Vec3{0.8, 0, 0.6}, {1, 0, 0}, {1, 0.5, -0.25}, {1, -0.25, 0.25}}) {
    const Vec3 n = normalized(d);
    const double expected = integrate(Region{{0, 0, 1}, std::asin(0.5)}, 2000,
                                      [&](const Vec3& w) { return std::fmax(0, dot(n, w)); });
    EXPECT_NEAR(sphere_irradiance(centre, 2, {}, n), expected, 1e-5);
  }
}

TEST(ClosedForms, InsideOfASphereGivesPiForEachMethod) {
  // For every normal, the hemisphere above it has radiance 1.
  expect_every_way(
      sphere_light({1, 2, 3}, 2, true),
      {{"centre", {1, 2, 3}, {0, 0.6, 0.8}, kPi}, {"aside", {1.5, 2.25, 4}, {0.6, 0, -0.8}, kPi}},
      0.02);
}

AreaLight disk_light(const Vec3& centre, double radius) {
  return *AreaLight::create({Rgb(1)},
                            *Disk::create({.radius_m = radius,
                                           .reverse_orientation = true,
                                           .world_from_object = Transform::translate(centre)}));
}

TEST(ClosedForms, CoaxialAndOffsetDisksAgreeForEachMethod) {
  const auto place = [](const std::string& name, double height, double offset) {
    return Place{name, {offset, 0, 3 - height}, {0, 0, 1}, disk_irradiance(1.5, height, offset)};
  };
  expect_every_way(
      disk_light({0, 0, 3}, 1.5),
      {place("coaxial", 3, 0), place("coaxial and near", 0.25, 0), place("offset", 2, 1),
       place("below its rim", 0.5, 1.5), place("beside it", 0.5, 3), place("far", 80, 60)},
      0.02);
  EXPECT_NEAR(disk_irradiance(1.5, 3, 0), kPi * 2.25 / (2.25 + 9), 1e-15);
}

TEST(ClosedForms, DisksOverTiltedReceiversAgreeForEachMethod) {
  const auto polygon = disk_as_polygon({0, 0, 3}, 1.5);
  expect_every_way(disk_light({0, 0, 3}, 1.5),
                   {at("above the horizon", {1, 0.5, 0}, {-0.25, 0, 1}, polygon),
                    at("cut by the horizon", {1, 0.5, 1}, {1, 0.25, 0}, polygon),
                    at("near, cut by the horizon", {0.5, 0.25, 2.5}, {1, 0, 0.25}, polygon)},
                   0.03);
  // The two closed forms of the tests agree where both apply.
  EXPECT_NEAR(polygon_irradiance(polygon, {1, 0, 1}, {0, 0, 1}), disk_irradiance(1.5, 2, 1), 1e-6);
}

TEST(ClosedForms, SkyGivesPiForAnyNormal) {
  const auto sky = *UniformInfiniteLight::create({Rgb(1)});
  expect_every_way(sky, {{"up", {1, 2, 3}, {0, 0, 1}, kPi}, {"aslant", {}, {0.6, 0, -0.8}, kPi}},
                   0.02);
}

TEST(ClosedForms, ComparisonRejectsALightThatIsThreePercentTooBright) {
  ::testing::TestPartResultArray failures;
  {
    ::testing::ScopedFakeTestPartResultReporter reporter(
        ::testing::ScopedFakeTestPartResultReporter::INTERCEPT_ONLY_CURRENT_THREAD, &failures);
    Place p = at("", {0.5, 0.25, 0}, {0, 0.25, 1}, kTriangle);
    p.expected /= 1.03;
    expect_every_way(triangle_light(), {p}, 0.02);
  }
  EXPECT_EQ(failures.size(), 2 * std::size(kWays));
}

}  // namespace
}  // namespace lucerna::testing
