// Panels with a luminaire's photometry put through the contract of all lights, with the photometry
// looked up here, on a grid of right angles and halves of them.
#include <gmock/gmock.h>

#include <cmath>
#include <optional>

#include "lights/light.h"
#include "tests/lights/area_helpers.h"
#include "tests/lights/contract.h"
#include "tests/lights/contract_emission.h"

namespace lucerna::testing {
namespace {

constexpr Rgb<double> kLevel{1, 2, 4};
constexpr int kPolar = 5, kPlanes = 4;
/// At 0, 45, 90, 135 and 180 degrees from +z, in the planes C0, C90, C180 and C270 [cd].
constexpr double kIntensity[kPlanes][kPolar] = {
    {100, 80, 30, 15, 10}, {100, 120, 20, 25, 10}, {100, 60, 10, 5, 10}, {100, 40, 40, 35, 10}};

std::shared_ptr<const PhotometricWeb> web() {
  PhotometricWebParams params{.vertical_deg = {0, 45, 90, 135, 180},
                              .horizontal_deg = {0, 90, 180, 270, 360}};
  for (int plane = 0; plane <= kPlanes; ++plane)
    for (const double cd : kIntensity[plane % kPlanes]) params.intensity_cd.push_back(cd);
  return *PhotometricWeb::create(params);
}

/// Towards `w` in photometric axes: C0 is +x, C90 is -y.
double intensity(const Vec3<double>& w) {
  const double theta = std::atan2(std::hypot(w.x, w.y), w.z) / (kPi / 4);
  double phi = std::atan2(-w.y, w.x) / (kPi / 2);
  if (phi < 0) phi += 4;
  const int row = std::min(int(theta), 3), plane = std::min(int(phi), 3);
  const double t = theta - row, s = phi - plane;
  const auto at = [&](int p, int r) { return kIntensity[p % kPlanes][r]; };
  return (at(plane, row) * (1 - t) + at(plane, row + 1) * t) * (1 - s) +
         (at(plane + 1, row) * (1 - t) + at(plane + 1, row + 1) * t) * s;
}

/// The intensity over the angles up to `widest` from +z, in steps that the grid's lines fall
/// between.
Rgb<double> flux(double widest) {
  constexpr int kGrid = 2000;
  double sum = 0;
  for (int i = 0; i < kGrid; ++i)
    for (int j = 0; j < kGrid; ++j) {
      const double theta = widest * (i + 0.5) / kGrid, phi = 2 * kPi * (j + 0.5) / kGrid;
      const double r = std::sin(theta);
      sum += intensity({r * std::cos(phi), r * std::sin(phi), std::cos(theta)}) * r;
    }
  return kLevel * (sum * widest * 2 * kPi / (double(kGrid) * kGrid));
}

struct PanelCase : CaseDefaults {
  /// Radiance has a cosine below: its error grows with the tangent of the angle.
  static constexpr double kTolerance = 2e-5;
  static std::optional<Vec3<double>> in_plane(const Vec3<double>& r, const Vec3<double>& wi) {
    const double t = -r.z / wi.z;
    if (!(t > 0)) return std::nullopt;
    return r + wi * t;
  }
  static Region seen(const Vec3<double>& receiver, double reach) {
    return {normalized(-receiver), 1.05 * std::asin(reach / length(receiver))};
  }
};

/// A rectangle of 2 x 1 m that faces +z, with C0 along its longer side.
struct RectanglePanelCase : PanelCase {
  template <typename Real>
  using Light = PanelPatchMeshLight<Real>;
  static constexpr double kArea = 2;
  template <typename Real>
  static Light<Real> make(const Placement& at) {
    const auto p = [&](double x, double y) { return Vec3<Real>(at.point({x, y, 0})); };
    return *Light<Real>::create(
        {kLevel}, *PanelPatchMesh<Real>::create(
                      *PatchMesh<Real>::create({{p(-1, -0.5), p(1, -0.5), p(-1, 0.5), p(1, 0.5)}}),
                      {.web = web(), .tangent = at.direction({1, 0, 0})}));
  }
  /// The file's candela stay as they are, whatever the size.
  static constexpr int kValueLengthPower = -2;
  static constexpr int kPowerLengthPower = 0;
  static std::vector<Vec3<double>> receivers() { return {{0.5, 0.25, 2}, {-2, 1, 2}, {1, -3, 1}}; }
  static Region region(const Vec3<double>& r) { return seen(r, 1.12); }
  static Rgb<double> emitted(const Vec3<double>&, const Vec3<double>& w) {
    return kLevel * (intensity(w) / (kArea * w.z));
  }
  static Rgb<double> value(const Vec3<double>& r, const Vec3<double>& wi) {
    return in_plane(r, wi) ? emitted({}, -wi) : Rgb<double>{};
  }
  static double distance_to_surface(const Vec3<double>& p) {
    return std::fmax(std::fabs(p.z), std::fmax(std::fabs(p.x) - 1, std::fabs(p.y) - 0.5));
  }
  static Vec3<double> emission_position(const Vec3<double>&, double x, double y) {
    return {2 * x - 1, y - 0.5, 0};
  }
  static Vec2<double> emission_where(const Vec3<double>& p, const Vec3<double>&) {
    return {(p.x + 1) / 2, p.y + 0.5};
  }
  static double emission_area_m2() { return kArea; }
  static Region emission_region(const Vec3<double>&) { return {{0, 0, 1}, kPi / 2}; }
  static constexpr bool kConfined = true;
  static Rgb<double> power_by_quadrature() { return flux(kPi / 2); }
};

/// A disk of radius 0.75 that shines to both sides, mirrored, with C0 towards (1, 1).
struct DiskPanelCase : PanelCase {
  template <typename Real>
  using Light = PanelDiskLight<Real>;
  static constexpr double kArea = kPi * 0.75 * 0.75;
  template <typename Real>
  static Light<Real> make(const Placement& at) {
    return *Light<Real>::create(
        {kLevel, true},
        *PanelDisk<Real>::create(
            *Disk<Real>::create({.radius_m = 0.75, .world_from_object = at.world_from_light()}),
            {.web = web(), .tangent = at.direction({1, 1, 0.5}), .mirrored = true}));
  }
  static constexpr int kValueLengthPower = -2;
  static constexpr int kPowerLengthPower = 0;
  static std::vector<Vec3<double>> receivers() { return {{0.5, 0.25, 2}, {0.5, -1, -1.5}}; }
  static Region region(const Vec3<double>& r) { return seen(r, 0.76); }
  static Rgb<double> emitted(const Vec3<double>&, const Vec3<double>& w) {
    const double s = std::sqrt(0.5);
    // x towards (1, 1), y = x cross z = (1, -1).
    const Vec3<double> local{(w.x + w.y) * s, (w.x - w.y) * s, w.z};
    return kLevel * (intensity(local) / (kArea * std::fabs(w.z)));
  }
  static Rgb<double> value(const Vec3<double>& r, const Vec3<double>& wi) {
    return in_plane(r, wi) ? emitted({}, -wi) : Rgb<double>{};
  }
  static double distance_to_surface(const Vec3<double>& p) {
    return std::fmax(std::fabs(p.z), std::hypot(p.x, p.y) - 0.75);
  }
  static Vec3<double> emission_position(const Vec3<double>&, double x, double y) {
    const double r = 0.75 * std::sqrt(x);
    return {r * std::cos(2 * kPi * y), r * std::sin(2 * kPi * y), 0};
  }
  static Vec2<double> emission_where(const Vec3<double>& p, const Vec3<double>&) {
    const double y = std::atan2(p.y, p.x) / (2 * kPi);
    return {(p.x * p.x + p.y * p.y) / (0.75 * 0.75), y < 0 ? y + 1 : y};
  }
  static double emission_area_m2() { return kArea; }
  static Region emission_region(const Vec3<double>&) { return {}; }
  static constexpr bool kConfined = false;
  static Rgb<double> power_by_quadrature() { return flux(kPi); }
};

using PanelCases = ::testing::Types<RectanglePanelCase, DiskPanelCase>;
INSTANTIATE_TYPED_TEST_SUITE_P(Panel, AnyLight, PanelCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Panel, LightWithDensity, PanelCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Panel, LocalLight, PanelCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Panel, EmittingLight, PanelCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Panel, EmittingSurface, PanelCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Panel, EmittingDirections, PanelCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Panel, BoundedLight, PanelCases);

// ---- What is a panel's own. ----

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
  PhotometricWebParams params{.horizontal_deg = {0}};
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
      *PanelPatchMesh<double>::create(patch(), {.web = *PhotometricWeb::create(params)}));
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
      *PanelDisk<double>::create(*Disk<double>::create({.radius_m = 0.1}), {.web = narrow}));
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
      *PanelDisk<float>::create(*Disk<float>::create({.radius_m = 0.5}), {.web = even}));
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
          {.web = even}));
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
  const auto status = PanelPatchMesh<double>::create(bent, {.web = web()}).status();
  EXPECT_THAT(std::string(status.message()), ::testing::HasSubstr("allowed for a profile: flat"));
  const auto flat = *PatchMesh<double>::create({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}});
  for (const Vec3<double> tangent : {Vec3<double>{0, 0, 1}, {0, 0, 0}, {NAN, 0, 0}})
    EXPECT_FALSE(PanelPatchMesh<double>::create(flat, {.web = web(), .tangent = tangent}).ok());
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
