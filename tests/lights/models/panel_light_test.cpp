// Tests of panels beyond the contract of all lights.
#include <gmock/gmock.h>

#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "lights/models/area_light.h"
#include "lights/shapes/all_shapes.h"
#include "tests/lights/contract/contract_checks.h"

namespace lucerna::testing {
namespace {

PanelProfile profile(std::shared_ptr<const PhotometricWeb> of, const Vec3& tangent = {1, 0, 0}) {
  PanelProfile made;
  made.web = std::move(of);
  made.tangent = tangent;
  return made;
}

/// 20 cd in all directions up to `widest_deg` from the normal.
std::shared_ptr<const PhotometricWeb> even(double widest_deg) {
  return *PhotometricWeb::create(
      {.vertical_deg = {0, widest_deg}, .horizontal_deg = {0}, .intensity_cd = {20, 20}});
}

TEST(PanelLight, NearFieldEqualsThatOfAUniformOpening) {
  // Radiance does not depend on the angle: a web in proportion to the cosine is a Lambertian panel.
  PhotometricWebParams params;
  params.horizontal_deg = {0};
  constexpr int kSteps = 900;  // of a tenth of a degree: linear between to 1e-6 of the cosine
  for (int i = 0; i <= kSteps; ++i) {
    params.vertical_deg.push_back(i / 10.0);
    params.intensity_cd.push_back(std::fmax(0, 10 * std::cos(i / 10.0 * kPi / 180)));
  }
  const auto patch = [] {
    return *PatchMesh::create({{{-1, -0.5, 0}, {1, -0.5, 0}, {-1, 0.5, 0}, {1, 0.5, 0}}});
  };
  const auto panel =
      *AreaLight::create({Rgb(1)}, patch(), {.profile = profile(*PhotometricWeb::create(params))});
  const auto lambertian = *AreaLight::create({Rgb(5)}, patch());  // 10 cd / 2 m2
  RandomU random(8);
  for (int i = 0; i < 200; ++i) {
    const Vec2 u = random.pair();
    const Vec3 receiver{2 * random.next() - 1, 2 * random.next() - 1, 0.25 + random.next()};
    const auto a = panel.sample_li(receiver, u), b = lambertian.sample_li(receiver, u);
    EXPECT_NEAR(a.value.r, b.value.r, 1e-5 * b.value.r);
    EXPECT_EQ(a.pdf, b.pdf);
  }
  EXPECT_NEAR(panel.power({}).lumens.r, lambertian.power({}).lumens.r,
              1e-5 * lambertian.power({}).lumens.r);
}

TEST(PanelLight, EmitsToItsFrontOnlyUnlessTwoSided) {
  const auto panel =
      *AreaLight::create({Rgb(1)}, *Disk::create({}), {.profile = profile(even(180))});
  const auto s = panel.sample_li(Vec3{0, 0, -2}, {0.5, 0.5});
  EXPECT_EQ(s.reason, NoLight::kBehind);
  EXPECT_TRUE(panel.le({{0, 0, 0}, {0, 0, 1}}, {0, 0, -1}).is_black());
  // Half of the file's light goes up.  Those rays report that they carry no light.
  int behind = 0;
  RandomU random(9);
  for (int i = 0; i < 1000; ++i)
    behind += panel.sample_le(random.pair(), random.pair(), {}).reason == NoLight::kBehind ? 1 : 0;
  EXPECT_GT(behind, 400);
  EXPECT_LT(behind, 600);
}

TEST(PanelLight, DarkDirectionsGiveTheirReason) {
  const auto narrow = *PhotometricWeb::create(
      {.vertical_deg = {0, 30, 31, 90}, .horizontal_deg = {0}, .intensity_cd = {10, 10, 0, 0}});
  const auto panel =
      *AreaLight::create({Rgb(1)}, *Disk::create({.radius_m = 0.1}), {.profile = profile(narrow)});
  EXPECT_EQ(panel.sample_li(Vec3{0, 0, 1}, {0.5, 0.5}).reason, NoLight::kNone);
  const auto s = panel.sample_li(Vec3{2, 0, 1}, {0.5, 0.5});
  EXPECT_EQ(s.reason, NoLight::kOutsideCone);
  EXPECT_GT(s.pdf.per_sr, 0);
  const auto bounds = *panel.bounds();
  EXPECT_NEAR(bounds.cone_rad, 31 * kPi / 180, 1e-5);
}

TEST(PanelLight, GrazingDirectionsHaveAValueOrAReason) {
  // 20 cd along the plane: the radiance is unbounded, the light that arrives is not.
  const auto panel = *AreaLight::create({Rgb(1)}, *Disk::create({.radius_m = 0.5}),
                                        {.profile = profile(even(90))});
  for (const float z : {1e-3, 1e-10, 1e-20, 1e-30, 1e-38}) {
    Receiver receiver(Vec3{2, 0, z});
    receiver.area_sampling = AreaSampling::kLowDistortion;
    const auto s = panel.sample_li(receiver, {0.25, 0.25});
    EXPECT_TRUE(check_well_formed(s).ok()) << check_well_formed(s).failure;
    if (s.reason != NoLight::kNone) continue;
    // Value over density is intensity over squared distance, at any angle.
    EXPECT_NEAR(s.value.r / s.pdf.per_sr, 20 / (s.distance * s.distance), 1e-4);
  }
}

TEST(PanelLight, NearlyFlatShapesEmitByTheirOwnNormals) {
  // Bent by less than 1e-3: a receiver near the mean plane sees each point at another angle.
  const auto panel = *AreaLight::create(
      {Rgb(1), true}, *PatchMesh::create({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0.001}}}),
      {.profile = profile(even(90))});
  Receiver receiver(Vec3{4, 0.5, 0.002});
  receiver.area_sampling = AreaSampling::kLowDistortion;
  RandomU random(5);
  for (int i = 0; i < 200; ++i) {
    const auto s = panel.sample_li(receiver, random.pair());
    if (s.reason != NoLight::kNone) continue;
    EXPECT_NEAR(s.value.r / s.pdf.per_sr, 20 / (s.distance * s.distance), 1e-5);
  }
}

/// The flux from the front of `panel`, a bent patch over the unit square, within `width` of the
/// mean plane on both sides.  Integrates radiance times cosine by the midpoint rule.
double flux_along_plane(const AreaLight& panel, double width) {
  const auto& surface = dynamic_cast<const PatchMesh&>(panel.shape());
  const Frame axes = Frame::around(surface.normals().axis);
  constexpr int kSide = 12, kHeights = 64, kAzimuths = 120;
  double sum = 0;
  for (int p = 0; p < kSide * kSide; ++p) {
    const Vec2 uv{(p % kSide + 0.5) / kSide, (p / kSide + 0.5) / kSide};
    const auto& patch = surface.primitive(0);
    const SurfacePoint point{patch.at(uv), patch.normal(uv), 0};
    for (int i = 0; i < kHeights; ++i)
      for (int j = 0; j < kAzimuths; ++j) {
        const double z = std::sin(width) * (2 * (i + 0.5) / kHeights - 1);
        const double phi = 2 * kPi * (j + 0.5) / kAzimuths, r = std::sqrt(1 - z * z);
        const Vec3 w = axes.world_from_local({r * std::cos(phi), r * std::sin(phi), z});
        sum += panel.le(point, w).r * dot(w, point.normal);
      }
  }
  return sum * surface.area() * 4 * kPi * std::sin(width) / (kSide * kSide * kHeights * kAzimuths);
}

TEST(PanelLight, FluxOfABentPanelHasTheErrorOfItsHorizon) {
  // 20 cd down to the mean plane or from there on, and 0 on its other side.
  const auto lit = [](PhotometricType type, std::vector<double> vertical, std::vector<double> cd) {
    PhotometricWebParams params{type, std::move(vertical), {0}, cd};
    if (type != PhotometricType::kC) {
      params.horizontal_deg = {-90, 90};
      params.intensity_cd.insert(params.intensity_cd.end(), cd.begin(), cd.end());
    }
    return *PhotometricWeb::create(params);
  };
  using enum PhotometricType;
  const double lean = std::sqrt(0.5) * 1e-3;  // of the normals at the patch's corners from the mean
  const auto panel = [](double z, const std::shared_ptr<const PhotometricWeb>& web,
                        bool two_sided) {
    return *AreaLight::create({Rgb(1), two_sided},
                              *PatchMesh::create({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, z}}}),
                              {.profile = profile(web)});
  };
  struct Case {
    std::shared_ptr<const PhotometricWeb> web;
    double front_lm, band_sr_per_rad;
  };
  for (const Case& c : {Case{lit(kC, {0, 90}, {20, 20}), 40 * kPi, 2 * kPi},
                        Case{lit(kC, {90, 180}, {20, 20}), 0, 2 * kPi},
                        // Towards +x only.
                        Case{lit(kA, {0, 90}, {20, 20}), 0, kPi},
                        Case{lit(kB, {-90, 90}, {20, 20}), 40 * kPi, 2 * kPi}}) {
    const auto bent = panel(0.001, c.web, false);
    const Power power = bent.power({});
    EXPECT_NEAR(power.lumens.r, c.front_lm, 1e-9);
    const double width = 1.5 * lean;
    const double band = 20 * c.band_sr_per_rad * std::sin(width);
    const double stated = c.front_lm > 0 ? band : 0;
    const double off = std::fabs(flux_along_plane(bent, width) - stated);
    // The planes of a normal and of the mean normal enclose this angle.  All around they enclose
    // two wedges of twice the angle in solid angle, one of them lit.  The ratio of the mean angle
    // to the largest is that of the mean distance from a square's centre to that of its corners:
    // 0.5411.
    const double wedge = c.band_sr_per_rad / kPi * 0.5411 * lean;
    EXPECT_NEAR(off, 20 * wedge, 0.02 * 20 * wedge);
    EXPECT_GE(power.error_lumens, off);
    EXPECT_NEAR(power.error_lumens, 20 * c.band_sr_per_rad * lean, 1e-3 * band);
    // Of both sides only that of the area, which is a rounding.
    const auto both = panel(0.001, c.web, true);
    const Power of_both = both.power({});
    EXPECT_EQ(of_both.error_lumens,
              luminance(of_both.lumens) * (both.shape().area_error_m2() / both.shape().area()));
    EXPECT_EQ(panel(0, c.web, false).power({}).error_lumens, 0);
  }
  // Triangles are flat, whatever plane their rounded corners lie in.
  RandomU random(11);
  const auto next = [&] {
    return Vec3(float(random.next()), float(random.next()), float(random.next()));
  };
  for (int i = 0; i < 50; ++i) {
    const auto triangle =
        *AreaLight::create({Rgb(1)}, *TriangleMesh::create({{next(), next(), next()}}),
                           {.profile = profile(lit(kC, {0, 90}, {20, 20}), {1, 0.1, 0.2})});
    EXPECT_EQ(triangle.power({}).error_lumens, 0);
  }
}

TEST(PanelLight, ShapesThatAreNotFlatAreRefused) {
  const auto bent = *PatchMesh::create({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0.1}}});
  const auto status = photometric_axes(bent, profile(even(90))).status();
  EXPECT_THAT(std::string(status.message()), ::testing::HasSubstr("allowed for a profile: flat"));
  const auto flat = *PatchMesh::create({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}});
  for (const Vec3& tangent : {Vec3{0, 0, 1}, {0, 0, 0}, {NAN, 0, 0}})
    EXPECT_FALSE(photometric_axes(flat, profile(even(90), tangent)).ok());
}

TEST(PhotometricWebFlux, DownwardFluxIsTowardsPlusZ) {
  // Constant: half of 4 pi, in types C and A.  Cells across the horizon are cut at it.
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
