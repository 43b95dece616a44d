// Row 29: powers, exact and by textbook formulas.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lights/models/all_lights.h"
#include "lights/shapes/all_shapes.h"
#include "tests/lights/extremes/map_pictures.h"

namespace lucerna::testing {
namespace {

using Row = ReferenceTable::Row;
constexpr float kFloatPi = std::numbers::pi_v<float>;

/// Compares the exact power with the reference, and checks the stated error of the approximate one.
template <typename L>
void check_power(Sweep& sweep, const L& light, double truth, const std::string& at,
                 const SceneSphere& scene = {}) {
  const Power exact = light.power(scene), approximate = light.power_approximate(scene);
  sweep.compare(exact.lumens.g, truth, at);
  const double rounding = 1e-12 * truth;
  EXPECT_LE(std::fabs(exact.lumens.g - truth), exact.error_lumens + rounding) << at;
  EXPECT_LE(std::fabs(approximate.lumens.g - truth), approximate.error_lumens + rounding) << at;
}

TEST(PowerExtremes, Spots) {
  Sweep sweep(29, "spot, half-angle; also 30 degrees with an edge of 5 degrees",
              "1e-5 ... 180 degrees, all profiles", "power");
  const ReferenceTable table("spot_powers");
  for (const auto& row : table.rows())
    for (const SpotProfile profile :
         {SpotProfile::kSmoothstep, SpotProfile::kQuadratic, SpotProfile::kQuartic}) {
      const auto light = *SpotLight::create({.intensity_cd = Rgb(1),
                                             .cone_half_angle_rad = row["cone_rad"],
                                             .falloff_start_rad = row["start_rad"],
                                             .profile = profile});
      const double truth = row[profile == SpotProfile::kSmoothstep  ? "smoothstep_lm"
                               : profile == SpotProfile::kQuadratic ? "quadratic_lm"
                                                                    : "quartic_lm"];
      check_power(sweep, light, truth, row.text("cone_rad"));
      const float sum = std::cos(static_cast<float>(row["start_rad"])) +
                        std::cos(static_cast<float>(row["cone_rad"]));
      sweep.compare_textbook(2 * kFloatPi * (1 - 0.5F * sum), truth);
    }
  sweep.expect_within(2e-15);
}

ProjectionLight projection(const Row& row, std::shared_ptr<const Image> image, ImageFilter filter) {
  return *ProjectionLight::create({.picture = *ProjectedPicture::create({.image = std::move(image),
                                                                         .filter = filter,
                                                                         .fov_rad = row["fov_rad"],
                                                                         .aspect = row["aspect"]}),
                                   .intensity_cd = Rgb(1)});
}

const char* const kProjections = "1e-5 ... 179.999 degrees, aspect 1e-3 ... 1e3";
std::string place_of(const Row& row) { return row.text("fov_deg") + " " + row.text("aspect"); }

TEST(PowerExtremes, EvenProjections) {
  Sweep sweep(29, "projection, field of view", kProjections, "power");
  const ReferenceTable table("projection_powers");
  for (const auto& row : table.rows()) {
    check_power(sweep, projection(row, nullptr, ImageFilter::kNearest), row["even_lm"],
                place_of(row));
    // pbrt-v3's formula: the cone about the corner.
    const float shorter = std::tan(static_cast<float>(row["fov_rad"]) / 2);
    const auto aspect = static_cast<float>(row["aspect"]);
    const float corner = shorter * std::hypot(std::max(aspect, 1.0F), 1 / std::min(aspect, 1.0F));
    sweep.compare_textbook(2 * kFloatPi * (1 - std::cos(std::atan(corner))), row["even_lm"]);
  }
  sweep.expect_within(1e-14);
}

TEST(PowerExtremes, ProjectedPictures) {
  Sweep sweep(29, "projection of a picture, field of view", kProjections, "power");
  const ReferenceTable table("projection_powers");
  for (const auto& row : table.rows()) {
    const auto light = projection(row, grey_image(4, 3, patchy_texel), ImageFilter::kNearest);
    check_power(sweep, light, row["picture_lm"], place_of(row));
    // pbrt-v4's formula: each texel counts as its middle.
    sweep.compare_textbook(static_cast<float>(light.params().picture->integral_by_centres_sr().g),
                           row["picture_lm"]);
  }
  sweep.expect_within(1e-14);
}

TEST(PowerExtremes, BilinearProjectedPictures) {
  Sweep sweep(29, "projection of a picture, bilinear", "1 ... 150 degrees, aspect 1/3 ... 64",
              "power");
  const ReferenceTable table("bilinear_projection_powers");
  for (const auto& row : table.rows())
    check_power(sweep, projection(row, grey_image(4, 3, patchy_texel), ImageFilter::kBilinear),
                row["picture_lm"], place_of(row));
  sweep.expect_within(2e-14);
}

template <typename S>
AreaLight shining(absl::StatusOr<S> shape, EmissionPattern pattern = {}) {
  return *AreaLight::create({Rgb(1)}, *std::move(shape), std::move(pattern));
}

void check_areas(Sweep& sweep, bool bent) {
  const ReferenceTable table("area_powers");
  for (const auto& row : table.rows()) {
    if ((row.text("shape") == "bent") != bent) continue;
    const double s = row["size"], truth = row["power_lm"];
    const std::string name = row.text("shape"), at = name + " " + row.text("size");
    const auto v = [s](double x, double y, double z) { return Vec3{s * x, s * y, s * z}; };
    if (name == "sphere") {
      const SphereParams p{.radius_m = s, .z_min_m = -s / 2, .z_max_m = 0.75 * s, .phi_max_rad = 2};
      check_power(sweep, shining(Sphere::create(p)), truth, at);
    } else if (name == "disk") {
      const DiskParams p{.radius_m = s, .inner_radius_m = s / 4, .phi_max_rad = 2};
      check_power(sweep, shining(Disk::create(p)), truth, at);
    } else if (name == "cylinder") {
      const CylinderParams p{.radius_m = s / 2, .z_min_m = 0, .z_max_m = 3 * s, .phi_max_rad = 2};
      check_power(sweep, shining(Cylinder::create(p)), truth, at);
    } else if (name == "triangle") {
      check_power(sweep, shining(TriangleMesh::create({{v(0, 0, 0), v(1, 0, 0), v(0, 2, 2)}})),
                  truth, at);
      // The cross product in floats, whose squares exceed their range.
      const auto f = static_cast<float>(s);
      const float area = std::sqrt(2 * (2 * f * f) * (2 * f * f)) / 2;
      sweep.compare_textbook(kFloatPi * area, truth);
    } else {
      const bool flat = name == "flat";
      check_power(sweep,
                  shining(PatchMesh::create({{v(0, 0, 0), v(flat ? 2 : 1, 0, 0), v(0, 1, 0),
                                              v(flat ? 2 : 1, 1, flat ? 0 : 0.5)}})),
                  truth, at);
    }
  }
}

TEST(PowerExtremes, AreaLights) {
  Sweep sweep(29, "sphere, disk, cylinder, triangle and flat patch, size", "1e-18 ... 1e18 m",
              "power");
  check_areas(sweep, false);
  sweep.expect_within(1e-15);
}

TEST(PowerExtremes, BentPatches) {
  Sweep sweep(29, "patch that is not flat, size", "1e-6 ... 1e6 m", "power");
  check_areas(sweep, true);
  sweep.expect_within(1e-11);
}

TEST(PowerExtremes, PhotometryAndPictures) {
  Sweep sweep(29, "photometric web, intensity; sphere with a picture, radius", "1e-9 ... 1e9",
              "power");
  const ReferenceTable table("picture_powers");
  for (const auto& row : table.rows()) {
    const double size = row["size"], truth = row["power_lm"];
    if (row.text("light") == "web") {
      PhotometricWebParams web{.vertical_deg = {0, 10, 30, 60, 90, 180},
                               .horizontal_deg = {0, 90, 135, 270, 360},
                               .intensity_cd = {}};
      for (const double b : web.horizontal_deg)
        for (const double a : web.vertical_deg)
          web.intensity_cd.push_back(size * (1 + std::fmod(7 * a + 3 * std::fmod(b, 360), 11)));
      check_power(
          sweep,
          *GoniometricLight::create({.intensity = Rgb(1), .web = *PhotometricWeb::create(web)}),
          truth, "web " + row.text("size"));
    } else {
      const Picture picture{grey_image(4, 3, patchy_texel), ImageFilter::kNearest, ""};
      check_power(sweep, shining(Sphere::create({.radius_m = size}), {.picture = picture}), truth,
                  "painted sphere " + row.text("size"));
    }
  }
  sweep.expect_within(1e-14);
}

TEST(PowerExtremes, OtherLights) {
  Sweep sweep(29, "point, uniform sky, distant and beam, size", "1e-18 ... 1e18 m", "power");
  const ReferenceTable table("other_powers");
  for (const auto& row : table.rows()) {
    const double size = row["size"], truth = row["power_lm"];
    const std::string name = row.text("light"), at = name + " " + row.text("size");
    const SceneSphere scene{{}, size};
    const Rgb one(1);
    if (name == "point")
      check_power(sweep, *PointLight::create({.intensity_cd = one}), truth, at, scene);
    else if (name == "infinite")
      check_power(sweep, *UniformInfiniteLight::create({.radiance_cd_m2 = one}), truth, at, scene);
    else if (name == "distant")
      check_power(sweep, *DistantLight::create({.illuminance_lx = one}), truth, at, scene);
    else
      check_power(
          sweep, *BeamLight::create({.width_m = size, .height_m = 3 * size, .illuminance_lx = one}),
          truth, at, scene);
    const auto r = static_cast<float>(size);
    if (name == "infinite") sweep.compare_textbook(4 * kFloatPi * kFloatPi * r * r, truth);
  }
  sweep.expect_within(1e-15);
}

/// Where the sky has a picture, the power is computed by quadrature, and its stated error holds.
TEST(PowerExtremes, Portals) {
  Sweep sweep(29, "portal, side", "1e-6 ... 1e6 m, with and without a picture", "power");
  const ReferenceTable table("portal_powers");
  for (const auto& row : table.rows()) {
    const double side = row["side"];
    const Vec3 across = row.text("n") == "x" ? Vec3{0, side, 0} : Vec3{0, 0, side};
    const Vec3 up = row.text("n") == "x" ? Vec3{0, 0, 3 * side} : Vec3{3 * side, 0, 0};
    PortalLightParams params{.corners_m = {{{}, up, across + up, across}}};
    if (row.text("sky") == "picture")
      params.map = *SphereMap::create(grey_image(8, 5, patchy_texel),
                                      SphereMapping::kLatitudeLongitude, ImageFilter::kNearest);
    check_power(sweep, *PortalLight::create(params), row["power_lm"],
                row.text("sky") + " " + row.text("n") + " " + row.text("side"));
  }
  // Cells are pi / 515 high and 2 pi / 512 wide.  Midpoints overestimate the integral of the
  // azimuth's sine by a 24th of the squared width.  They overestimate that of the sine of twice the
  // polar angle by a 24th of the square of twice the height.  Each is 6e-6.  Where the horizon cuts
  // a row of cells, a quarter of the squared height is missing, 9e-6.  The error stated with each
  // power is at least as large (check_power).
  sweep.expect_within(1e-5);
}

}  // namespace
}  // namespace lucerna::testing
