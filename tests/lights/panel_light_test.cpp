// What is a panel's own, beside the contract of all lights.
#include <gmock/gmock.h>

#include <cmath>
#include <string>
#include <vector>

#include "tests/lights/panel_cases.h"

namespace lucerna::testing {
namespace {

Estimate at_distance(double d, const Vec3<double>& to_panel) {
  const auto panel = RectanglePanelCase::make<double>({});
  return illuminance(panel, -to_panel * d, to_panel, 7, 20000);
}

TEST(PanelLight, FarFieldIsThePhotometry) {
  const Vec3<double> w = normalized(Vec3<double>{0.5, -0.25, 1});
  const double d = 2000;
  // Over a panel of 2 m the angle differs by a thousandth: intensity and distance by as much.
  EXPECT_NEAR(at_distance(d, -w).mean * d * d, intensity(w), 2e-3 * intensity(w));
}

TEST(PanelLight, NearFieldIsThatOfAnEvenlyBrightOpening) {
  // Radiance without its angle: a web in proportion to the cosine is a Lambertian panel.
  PhotometricWebParams params;
  params.horizontal_deg = {0};
  constexpr int kSteps = 900;  // of a tenth of a degree: linear between to 1e-6 of the cosine
  for (int i = 0; i <= kSteps; ++i) {
    params.vertical_deg.push_back(i / 10.0);
    params.intensity_cd.push_back(std::fmax(0, 10 * std::cos(i / 10.0 * kPi / 180)));
  }
  const auto patch = [] {
    return *PatchMesh<double>::create({{{-1, -0.5, 0}, {1, -0.5, 0}, {-1, 0.5, 0}, {1, 0.5, 0}}});
  };
  const auto panel = *AreaLight<double, PanelPatchMesh>::create(
      {Rgb<double>(1)},
      *PanelPatchMesh<double>::create(patch(), profile(*PhotometricWeb::create(params))));
  const auto lambertian =
      *AreaLight<double, PatchMesh>::create({Rgb<double>(5)}, patch());  // 10 cd / 2 m2
  RandomU random(8);
  for (int i = 0; i < 200; ++i) {
    const Vec2<double> u = random.pair<double>();
    const Vec3<double> receiver{2 * random.next() - 1, 2 * random.next() - 1, 0.25 + random.next()};
    const auto a = panel.sample_li(receiver, u), b = lambertian.sample_li(receiver, u);
    EXPECT_NEAR(a.value.r, b.value.r, 1e-5 * b.value.r);
    EXPECT_EQ(a.pdf, b.pdf);
  }
  EXPECT_NEAR(panel.power({}).lumens.r, lambertian.power({}).lumens.r,
              1e-5 * lambertian.power({}).lumens.r);
}

TEST(PanelLight, ShinesToItsFrontOnlyUnlessItHasTwoSides) {
  const auto panel = RectanglePanelCase::make<double>({});
  const auto s = panel.sample_li(Vec3<double>{0, 0, -2}, {0.5, 0.5});
  EXPECT_EQ(s.reason, NoLight::kBehind);
  EXPECT_TRUE(panel.le({{0, 0, 0}, {0, 0, 1}}, {0, 0, -1}).is_black());
  // Some of the file's light goes up: those rays say that they do not leave.
  int behind = 0;
  RandomU random(9);
  for (int i = 0; i < 1000; ++i)
    behind +=
        panel.sample_le(random.pair<double>(), random.pair<double>(), {}).reason == NoLight::kBehind
            ? 1
            : 0;
  EXPECT_GT(behind, 100);
  EXPECT_LT(behind, 500);
}

TEST(PanelLight, DarkDirectionsGiveTheirReason) {
  const auto narrow = *PhotometricWeb::create(
      {.vertical_deg = {0, 30, 31, 90}, .horizontal_deg = {0}, .intensity_cd = {10, 10, 0, 0}});
  const auto panel = *AreaLight<double, PanelDisk>::create(
      {Rgb<double>(1)},
      *PanelDisk<double>::create(*Disk<double>::create({.radius_m = 0.1}), profile(narrow)));
  EXPECT_EQ(panel.sample_li(Vec3<double>{0, 0, 1}, {0.5, 0.5}).reason, NoLight::kNone);
  const auto s = panel.sample_li(Vec3<double>{2, 0, 1}, {0.5, 0.5});
  EXPECT_EQ(s.reason, NoLight::kOutsideCone);
  EXPECT_GT(s.pdf.per_sr, 0);
  const auto bounds = *panel.bounds();
  EXPECT_NEAR(bounds.cone_rad, 31 * kPi / 180, 1e-5);
}

TEST(PanelLight, GrazingDirectionsHaveAValueOrAReason) {
  // 20 cd along the plane: the radiance has no bound, the light that arrives has.
  const auto even = *PhotometricWeb::create(
      {.vertical_deg = {0, 90}, .horizontal_deg = {0}, .intensity_cd = {20, 20}});
  const auto panel = *AreaLight<float, PanelDisk>::create(
      {Rgb<double>(1)},
      *PanelDisk<float>::create(*Disk<float>::create({.radius_m = 0.5}), profile(even)));
  for (const float z : {1e-3F, 1e-10F, 1e-20F, 1e-30F, 1e-38F}) {
    Receiver<float> receiver(Vec3<float>{2, 0, z});
    receiver.area_sampling = AreaSampling::kLowDistortion;
    const auto s = panel.sample_li(receiver, {0.25F, 0.25F});
    EXPECT_TRUE(check_well_formed(s).ok()) << check_well_formed(s).failure;
    if (s.reason != NoLight::kNone) continue;
    // Value over density: intensity over distance squared, whatever the angle.
    EXPECT_NEAR(s.value.r / s.pdf.per_sr, 20 / (s.distance * s.distance), 1e-4);
  }
}

TEST(PanelLight, NearlyFlatShapesShineByTheirOwnNormals) {
  // Bent by less than 1e-3: a receiver near the mean plane sees each point under another angle.
  const auto even = *PhotometricWeb::create(
      {.vertical_deg = {0, 90}, .horizontal_deg = {0}, .intensity_cd = {20, 20}});
  const auto panel = *AreaLight<double, PanelPatchMesh>::create(
      {Rgb<double>(1), true},
      *PanelPatchMesh<double>::create(
          *PatchMesh<double>::create({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0.001}}}),
          profile(even)));
  Receiver<double> receiver(Vec3<double>{4, 0.5, 0.002});
  receiver.area_sampling = AreaSampling::kLowDistortion;
  RandomU random(5);
  for (int i = 0; i < 200; ++i) {
    const auto s = panel.sample_li(receiver, random.pair<double>());
    if (s.reason != NoLight::kNone) continue;
    EXPECT_NEAR(s.value.r / s.pdf.per_sr, 20 / (s.distance * s.distance), 1e-5);
  }
}

TEST(PanelLight, ShapesThatAreNotFlatAreRefused) {
  const auto bent = *PatchMesh<double>::create({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0.1}}});
  const auto status = PanelPatchMesh<double>::create(bent, profile(web())).status();
  EXPECT_THAT(std::string(status.message()), ::testing::HasSubstr("allowed for a profile: flat"));
  const auto flat = *PatchMesh<double>::create({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}});
  for (const Vec3<double> tangent : {Vec3<double>{0, 0, 1}, {0, 0, 0}, {NAN, 0, 0}})
    EXPECT_FALSE(PanelPatchMesh<double>::create(flat, profile(web(), tangent)).ok());
}

TEST(PhotometricWebFlux, DownwardsIsThatTowardsPlusZ) {
  // Constant: half of 4 pi, in types C and A; cells that straddle the horizon are cut at it.
  for (const auto type : {PhotometricType::kC, PhotometricType::kA}) {
    const bool c = type == PhotometricType::kC;
    const auto even = *PhotometricWeb::create(
        {.type = type,
         .vertical_deg =
             c ? std::vector<double>{0, 70, 120, 180} : std::vector<double>{-90, -20, 30, 90},
         .horizontal_deg = c ? std::vector<double>{0} : std::vector<double>{-90, 90},
         .intensity_cd = std::vector<double>(c ? 4 : 8, 3.0)});
    EXPECT_NEAR(even->downward_flux_lm(), even->flux_lm() / 2, 1e-12 * even->flux_lm());
  }
  // More above than below: 0 at +z rising to 8 at -z, linear in the angle.
  const auto rising = *PhotometricWeb::create(
      {.vertical_deg = {0, 180}, .horizontal_deg = {0}, .intensity_cd = {0, 8}});
  // 2 pi times the integral of 8 theta / pi sin(theta) from 0 to pi/2, which is 16.
  EXPECT_NEAR(rising->downward_flux_lm(), 16, 1e-12);
}

}  // namespace
}  // namespace lucerna::testing
