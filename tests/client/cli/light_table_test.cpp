#include "client/cli/light_table.h"

#include <gtest/gtest.h>

#include <array>
#include <initializer_list>
#include <numbers>

#include "lucerna/v1/scene.pb.h"

namespace lucerna::cli {
namespace {

constexpr double kPi = std::numbers::pi;

void set(v1::Vector3* v, double x, double y, double z) {
  v->set_x(x);
  v->set_y(y);
  v->set_z(z);
}

void grey(v1::Rgb* c, double value) {
  c->set_r(value);
  c->set_g(value);
  c->set_b(value);
}

void image(v1::ImageInfo* i, const char* name, v1::ImageFilter filter) {
  i->set_name(name);
  i->set_width(64);
  i->set_height(32);
  i->set_filter(filter);
}

void expect(const v1::Light& light, const std::string& type, const std::string& what,
            const std::string& where) {
  EXPECT_EQ(type_of(light), type);
  EXPECT_EQ(describe_light(light), what);
  EXPECT_EQ(place_of(light), where);
}

v1::Light area(v1::AreaShape shape, std::array<double, 3> lower, std::array<double, 3> upper,
               double area_m2, std::uint64_t primitives = 1) {
  v1::Light light;
  v1::DiffuseAreaLight* a = light.mutable_diffuse_area();
  a->set_shape(shape);
  a->set_primitives(primitives);
  grey(a->mutable_radiance_cd_m2(), 4500);
  set(light.mutable_bounds()->mutable_lower_m(), lower[0], lower[1], lower[2]);
  set(light.mutable_bounds()->mutable_upper_m(), upper[0], upper[1], upper[2]);
  light.set_area_m2(area_m2);
  return light;
}

TEST(LightTable, ColouredPointLightShowsItsLuminance) {
  v1::Light light;
  set(light.mutable_point()->mutable_position_m(), 1, 2, 3);
  grey(light.mutable_point()->mutable_intensity_cd(), 10);
  expect(light, "point", "10 cd", "1 2 3");
  light.mutable_point()->mutable_intensity_cd()->set_r(0);
  light.mutable_point()->mutable_intensity_cd()->set_b(0);
  // The weight of green in white is 0.715169.
  EXPECT_EQ(describe_light(light), "7.15169 cd (RGB 0 10 0)");
  // Grey in all printed digits.
  grey(light.mutable_point()->mutable_intensity_cd(), 318.31);
  light.mutable_point()->mutable_intensity_cd()->set_g(318.31000001);
  EXPECT_EQ(describe_light(light), "318.31 cd");
}

TEST(LightTable, SpotWithEdges) {
  v1::Light light;
  v1::SpotLight* spot = light.mutable_spot();
  set(spot->mutable_position_m(), 0, 0, 3);
  set(spot->mutable_axis(), 1e-16, -1e-16, -2);
  grey(spot->mutable_intensity_cd(), 1200);
  spot->set_cone_half_angle_rad(kPi / 6);
  spot->set_falloff_start_rad(kPi * 25 / 180);
  expect(light, "spot", "half angle 30 deg, edge 5 deg, 1200 cd", "0 0 3 towards 0 0 -1");
  spot->set_profile(v1::SPOT_PROFILE_QUARTIC);
  EXPECT_EQ(describe_light(light), "half angle 30 deg, edge 5 deg (quartic), 1200 cd");
  spot->set_profile(v1::SPOT_PROFILE_QUADRATIC);
  EXPECT_EQ(describe_light(light), "half angle 30 deg, edge 5 deg (quadratic), 1200 cd");
  spot->set_falloff_start_rad(kPi / 6);
  EXPECT_EQ(describe_light(light), "half angle 30 deg, hard edge, 1200 cd");
}

TEST(LightTable, LightsAtInfinity) {
  v1::Light light;
  set(light.mutable_distant()->mutable_to_light(), 0, 0.5, 1);
  grey(light.mutable_distant()->mutable_illuminance_lx(), 800);
  expect(light, "distant", "800 lx", "from 0 0.4472 0.8944");
  set(light.mutable_sun()->mutable_to_light(), 0, 0, 1);
  grey(light.mutable_sun()->mutable_illuminance_lx(), 1e5);
  light.mutable_sun()->set_angular_diameter_rad(kPi / 360);
  expect(light, "sun", "0.5 deg across, 100000 lx", "from 0 0 1");
  grey(light.mutable_uniform_infinite()->mutable_radiance_cd_m2(), 5000);
  expect(light, "uniform infinite", "5000 cd/m2", "all around");
  v1::ImageInfiniteLight* sky = light.mutable_image_infinite();
  image(sky->mutable_map()->mutable_image(), "sky.exr", v1::IMAGE_FILTER_BILINEAR);
  sky->mutable_map()->set_mapping(v1::SPHERE_MAPPING_LATITUDE_LONGITUDE);
  grey(sky->mutable_radiance_cd_m2(), 2);
  expect(light, "image infinite",
         "image sky.exr (64 x 32 px, latitude-longitude, bilinear), 2 cd/m2 at 1", "all around");
  set(sky->mutable_axes()->mutable_x(), 1, 0, 0);
  set(sky->mutable_axes()->mutable_y(), 0, 1, 0);
  set(sky->mutable_axes()->mutable_z(), 0, 0, 1);
  EXPECT_EQ(place_of(light), "all around");
  set(sky->mutable_axes()->mutable_y(), 0, 0, 1);
  set(sky->mutable_axes()->mutable_z(), 0, -1, 0);
  EXPECT_EQ(place_of(light), "all around, +x to 1 0 0, +y to 0 0 1, +z to 0 -1 0");
  sky->clear_axes();
  for (int i = 0; i < 4; ++i) set(sky->add_portal_m(), i, 0, 0);
  expect(light, "image infinite",
         "image sky.exr (64 x 32 px, latitude-longitude, bilinear), 2 cd/m2 at 1, through a portal",
         "through 0 0 0, 1 0 0, 2 0 0, 3 0 0");
  sky->clear_map();
  expect(light, "infinite", "2 cd/m2, through a portal", "through 0 0 0, 1 0 0, 2 0 0, 3 0 0");
}

TEST(LightTable, ProjectionAndBeamWithImagesAndWithout) {
  v1::Light light;
  v1::ProjectionLight* p = light.mutable_projection();
  set(p->mutable_position_m(), 1, 0, 0);
  set(p->mutable_axis(), 0, 1, 0);
  p->set_fov_rad(kPi / 4);
  p->set_aspect(2);
  grey(p->mutable_intensity_cd(), 300);
  expect(light, "projection", "45 deg on the shorter side, aspect 2, 300 cd",
         "1 0 0 towards 0 1 0");
  image(p->mutable_image(), "slide.png", v1::IMAGE_FILTER_NEAREST);
  EXPECT_EQ(describe_light(light),
            "45 deg on the shorter side, aspect 2, 300 cd at 1, image slide.png (64 x 32 px, "
            "nearest)");
  v1::BeamLight* b = light.mutable_beam();
  set(b->mutable_position_m(), 0, 0, 2);
  set(b->mutable_axis(), 0, 0, -1);
  b->set_width_m(1.5);
  b->set_height_m(0.5);
  grey(b->mutable_illuminance_lx(), 200);
  expect(light, "beam", "1.5 x 0.5 m, 200 lx", "0 0 2 towards 0 0 -1");
  image(b->mutable_image(), "slide.png", v1::IMAGE_FILTER_NEAREST);
  EXPECT_EQ(describe_light(light),
            "1.5 x 0.5 m, 200 lx at 1, image slide.png (64 x 32 px, nearest)");
}

TEST(LightTable, GoniometricOfAnyDistribution) {
  v1::Light light;
  v1::GoniometricLight* g = light.mutable_goniometric();
  set(g->mutable_position_m(), 1, 1, 1);
  grey(g->mutable_intensity(), 7);
  expect(light, "goniometric", "7 cd", "1 1 1");
  image(g->mutable_image()->mutable_image(), "map.exr", v1::IMAGE_FILTER_BILINEAR);
  g->mutable_image()->set_mapping(v1::SPHERE_MAPPING_EQUAL_AREA);
  EXPECT_EQ(describe_light(light), "image map.exr (64 x 32 px, equal-area, bilinear), 7 cd at 1");
  v1::PhotometricFile* file = g->mutable_photometric_file();
  file->set_name("lamp.ies");
  file->set_format("IES LM-63-2002, type C");
  file->set_flux_lm(1150);
  EXPECT_EQ(describe_light(light), "lamp.ies (IES LM-63-2002, type C, 1150 lm), times 7");
  g->mutable_intensity()->set_r(0);
  g->mutable_intensity()->set_b(0);
  EXPECT_EQ(describe_light(light),
            "lamp.ies (IES LM-63-2002, type C, 1150 lm), times 5.00618 (RGB 0 7 0)");
  grey(g->mutable_intensity(), 1);
  EXPECT_EQ(describe_light(light), "lamp.ies (IES LM-63-2002, type C, 1150 lm)");
  set(light.mutable_directions()->mutable_axis(), 0, 0, -1);
  light.mutable_directions()->set_half_angle_rad(kPi / 2 + 1e-6);
  EXPECT_EQ(place_of(light), "1 1 1, within 90 deg of 0 0 -1");
  set(g->mutable_axes()->mutable_x(), 0, 1, 0);
  set(g->mutable_axes()->mutable_y(), 1, 0, 0);
  set(g->mutable_axes()->mutable_z(), 0, 0, -1);
  EXPECT_EQ(place_of(light), "1 1 1 towards 0 0 -1, C0 to 0 1 0, within 90 deg of 0 0 -1");
  set(g->mutable_axes()->mutable_y(), -1, 0, 0);
  EXPECT_EQ(place_of(light),
            "1 1 1 towards 0 0 -1, C0 to 0 1 0, mirrored, within 90 deg of 0 0 -1");
  // Type A shines along +x, with +z down.  Type B shines along +z; V = 90 is +x.
  file->set_format("IES LM-63-2002, type A");
  EXPECT_EQ(place_of(light),
            "1 1 1 towards 0 1 0, down to 0 0 -1, mirrored, within 90 deg of 0 0 -1");
  file->set_format("IES LM-63-2002, type B");
  EXPECT_EQ(place_of(light),
            "1 1 1 towards 0 0 -1, V 90 to 0 1 0, mirrored, within 90 deg of 0 0 -1");
  g->mutable_image();
  light.clear_directions();
  EXPECT_EQ(place_of(light), "1 1 1, +x to 0 1 0, +y to -1 0 0, +z to 0 0 -1");
}

TEST(LightTable, RectanglesShowTheirSidesInAnyOrientation) {
  v1::Light panel = area(v1::AREA_SHAPE_BILINEAR_MESH, {0, 0, 3}, {0.6, 1.2, 3}, 0.72);
  panel.mutable_diffuse_area()->set_two_sided(true);
  const auto corners = [&](std::initializer_list<std::array<double, 3>> list) {
    panel.mutable_diffuse_area()->clear_corners_m();
    for (const auto& [x, y, z] : list) set(panel.mutable_diffuse_area()->add_corners_m(), x, y, z);
  };
  corners({{0, 0, 3}, {0.6, 0, 3}, {0, 1.2, 3}, {0.6, 1.2, 3}});
  expect(panel, "area", "rectangle 1.2 x 0.6 m, 4500 cd/m2, two-sided", "0 0 3 to 0.6 1.2 3");
  // Sides of (0.6, 0.8, 0) and (0, 0, 0.5); the same with one corner moved; a parallelogram.
  corners({{5, 5, 0}, {5.6, 5.8, 0}, {5, 5, 0.5}, {5.6, 5.8, 0.5}});
  EXPECT_EQ(describe_light(panel), "rectangle 1 x 0.5 m, 4500 cd/m2, two-sided");
  corners({{5, 5, 0}, {5.6, 5.8, 0}, {5, 5, 0.5}, {5.6, 5.8, 0.6}});
  EXPECT_EQ(describe_light(panel), "quadrilateral, 4500 cd/m2, two-sided");
  corners({{0, 0, 0}, {1, 0, 0}, {0.5, 1, 0}, {1.5, 1, 0}});
  EXPECT_EQ(describe_light(panel), "quadrilateral, 4500 cd/m2, two-sided");
}

TEST(LightTable, MeshesShowTheirNumberOfPrimitives) {
  EXPECT_EQ(describe_light(area(v1::AREA_SHAPE_BILINEAR_MESH, {0, 0, 0}, {1, 1, 1}, 1, 6)),
            "6 quadrilaterals, 4500 cd/m2");
  EXPECT_EQ(describe_light(area(v1::AREA_SHAPE_TRIANGLE_MESH, {0, 0, 0}, {1, 1, 0}, 0.5)),
            "triangle, 4500 cd/m2");
  EXPECT_EQ(describe_light(area(v1::AREA_SHAPE_TRIANGLE_MESH, {0, 0, 0}, {1, 1, 0}, 1, 2)),
            "2 triangles, 4500 cd/m2");
}

/// A whole shape of radius 0.25; cylinders have length 0.5.
v1::Light round_light(v1::AreaShape shape) {
  v1::Light light = area(shape, {0, 0, 0}, {0.5, 0.5, 0.5}, 1);
  v1::RoundShape* round = light.mutable_diffuse_area()->mutable_round();
  round->set_radius_m(0.25);
  round->set_z_min_m(-0.25);
  round->set_z_max_m(0.25);
  round->set_phi_max_rad(2 * kPi);
  set(round->mutable_axes()->mutable_x(), 1, 0, 0);
  set(round->mutable_axes()->mutable_y(), 0, 0, 1);
  set(round->mutable_axes()->mutable_z(), 0, -1, 0);
  return light;
}

TEST(LightTable, SpheresShowDiameterAndCuts) {
  v1::Light light = round_light(v1::AREA_SHAPE_SPHERE);
  v1::RoundShape* round = light.mutable_diffuse_area()->mutable_round();
  EXPECT_EQ(describe_light(light), "sphere of diameter 0.5 m, 4500 cd/m2");
  round->set_z_min_m(0.1);
  EXPECT_EQ(describe_light(light),
            "sphere of diameter 0.5 m from 0.1 to 0.25 m along 0 -1 0, 4500 cd/m2");
  round->set_z_min_m(-0.25);
  round->set_phi_max_rad(kPi);
  round->set_reverse_orientation(true);
  EXPECT_EQ(describe_light(light),
            "sphere of diameter 0.5 m, 180 deg of it, shining inwards, 4500 cd/m2");
}

TEST(LightTable, DisksShowHoleAndSweep) {
  v1::Light light = round_light(v1::AREA_SHAPE_DISK);
  v1::RoundShape* round = light.mutable_diffuse_area()->mutable_round();
  EXPECT_EQ(describe_light(light), "disk of diameter 0.5 m, 4500 cd/m2");
  round->set_inner_radius_m(0.1);
  EXPECT_EQ(describe_light(light), "disk of diameter 0.5 m, hole of 0.2 m, 4500 cd/m2");
  round->set_phi_max_rad(kPi / 2);
  EXPECT_EQ(describe_light(light),
            "disk of diameter 0.5 m, hole of 0.2 m, 90 deg of it, 4500 cd/m2");
  round->set_phi_max_rad(2 * kPi);
  round->set_radius_y_m(1);
  EXPECT_EQ(describe_light(light), "ellipse 2 x 0.5 m, hole of 40%, 4500 cd/m2");
}

TEST(LightTable, CylindersShowSizeAndAxis) {
  v1::Light light = round_light(v1::AREA_SHAPE_CYLINDER);
  v1::RoundShape* round = light.mutable_diffuse_area()->mutable_round();
  round->set_z_min_m(-1.5);
  expect(light, "area", "cylinder of diameter 0.5 m, length 1.75 m, 4500 cd/m2",
         "0 0 0 to 0.5 0.5 0.5, along 0 -1 0");
  round->set_phi_max_rad(kPi / 3);
  round->set_reverse_orientation(true);
  EXPECT_EQ(describe_light(light),
            "cylinder of diameter 0.5 m, length 1.75 m, 60 deg of it, shining inwards, 4500 cd/m2");
}

TEST(LightTable, OneSidedPlanesShowTheirNormal) {
  v1::Light panel = area(v1::AREA_SHAPE_BILINEAR_MESH, {0, 0, 3}, {0.6, 1.2, 3}, 0.72);
  set(panel.mutable_directions()->mutable_axis(), 0, 0, -1);
  panel.mutable_directions()->set_half_angle_rad(kPi / 2);
  EXPECT_EQ(place_of(panel), "0 0 3 to 0.6 1.2 3, facing 0 0 -1");
  // A dome also shines beside its axis, so it has no normal.
  panel.mutable_directions()->set_half_angle_rad(2);
  EXPECT_EQ(place_of(panel), "0 0 3 to 0.6 1.2 3");
}

TEST(LightTable, AreaLightsWithImageAndProfile) {
  v1::Light light = area(v1::AREA_SHAPE_TRIANGLE_MESH, {0, 0, 0}, {1, 1, 0}, 0.5);
  v1::DiffuseAreaLight* a = light.mutable_diffuse_area();
  image(a->mutable_image(), "tv.png", v1::IMAGE_FILTER_NEAREST);
  EXPECT_EQ(describe_light(light), "triangle, 4500 cd/m2 at 1, image tv.png (64 x 32 px, nearest)");
  a->clear_image();
  a->mutable_profile()->set_name("panel.ldt");
  a->mutable_profile()->set_format("EULUMDAT");
  a->mutable_profile()->set_flux_lm(900);
  // The luminance that gives the 900 lm of the file from one side of 0.5 m2 is 900 / (pi 0.5). Then
  // twice that, and twice that with a second side.
  grey(a->mutable_radiance_cd_m2(), 900 / (kPi * 0.5));
  EXPECT_EQ(describe_light(light), "triangle, 572.958 cd/m2, profile panel.ldt (EULUMDAT, 900 lm)");
  grey(a->mutable_radiance_cd_m2(), 1800 / (kPi * 0.5));
  EXPECT_EQ(describe_light(light),
            "triangle, 1145.92 cd/m2, profile panel.ldt (EULUMDAT, 900 lm), flux times 2");
  a->set_two_sided(true);
  EXPECT_EQ(
      describe_light(light),
      "triangle, 1145.92 cd/m2, profile panel.ldt (EULUMDAT, 900 lm), flux times 4, two-sided");
  a->set_two_sided(false);
  set(a->mutable_profile_axes()->mutable_x(), 0, 1, 0);
  set(a->mutable_profile_axes()->mutable_y(), 1, 0, 0);
  set(a->mutable_profile_axes()->mutable_z(), 0, 0, -1);
  EXPECT_EQ(place_of(light), "0 0 0 to 1 1 0, C0 to 0 1 0");
  a->mutable_profile()->set_format("IES LM-63-2002, type A");
  EXPECT_EQ(place_of(light), "0 0 0 to 1 1 0, V 0 H 0 to 0 1 0");
  a->mutable_profile()->set_format("IES LM-63-2002, type B");
  EXPECT_EQ(place_of(light), "0 0 0 to 1 1 0, V 90 to 0 1 0");
}

TEST(LightTable, SpectraWattsAndMotionFollow) {
  v1::Light light;
  grey(light.mutable_point()->mutable_intensity_cd(), 10);
  light.mutable_spectrum()->set_black_body_k(2856);
  light.set_power_w(4.5);
  EXPECT_EQ(describe_light(light), "10 cd, black body 2856 K, 4.5 W");
  light.clear_power_w();
  light.mutable_spectrum()->set_illuminant("F2");
  EXPECT_EQ(describe_light(light), "10 cd, CIE illuminant F2");
  auto* nm = light.mutable_spectrum()->mutable_sampled()->mutable_wavelengths_nm();
  nm->Add(400);
  nm->Add(550);
  nm->Add(700);
  EXPECT_EQ(describe_light(light), "10 cd, spectrum 400 to 700 nm");
  light.clear_spectrum();
  light.mutable_motion()->add_key_frames()->set_time_s(0);
  light.mutable_motion()->add_key_frames()->set_time_s(2);
  EXPECT_EQ(describe_light(light), "10 cd, moves from 0 to 2 s");
}

TEST(LightTable, HasARowForEachLight) {
  v1::ListLightsResponse lights;
  v1::Light* light = lights.add_lights();
  *light = area(v1::AREA_SHAPE_TRIANGLE_MESH, {0, 0, 0}, {1, 1, 0}, 0.5);
  light->set_id(12);
  light->set_power_lm(7068.58);
  light->set_power_error_lm(0.25);
  light->set_source("room.pbrt:7:3");
  light = lights.add_lights();
  light->set_id(13);
  light->set_delta(true);
  grey(light->mutable_point()->mutable_intensity_cd(), 10);
  light->set_power_lm(125.664);
  EXPECT_EQ(light_table(lights.lights()).to_string(),
            "id  type   what                  where [m]       area [m2]  flux [lm]  ± [lm]  "
            "delta  made at\n"
            "12  area   triangle, 4500 cd/m2  0 0 0 to 1 1 0        0.5    7068.58    0.25  no   "
            "  room.pbrt:7:3\n"
            "13  point  10 cd                 0 0 0                        125.664   exact  yes\n");
}

TEST(LightTable, AFluxInAnotherUnitIsNotCalledLumens) {
  v1::ListLightsResponse lights;
  v1::Light* light = lights.add_lights();
  light->set_id(1);
  light->set_delta(true);
  light->set_power_lm(125.5);
  light->set_power_unit("mW");
  v1::PhotometricFile* file = light->mutable_goniometric()->mutable_photometric_file();
  file->set_name("uv.ies");
  file->set_format("IES LM-63-2002, type C");
  file->set_flux_lm(125.5);
  file->set_flux_unit("mW");
  grey(light->mutable_goniometric()->mutable_intensity(), 1);
  light->set_source("room.pbrt:7:3");
  *lights.add_lights() = *light;
  lights.mutable_lights(1)->clear_power_unit();
  EXPECT_EQ(light_table(lights.lights()).to_string(),
            "id  type         what                                       where [m]  area [m2]   "
            "flux      ±  unit  delta  made at\n"
            " 1  goniometric  uv.ies (IES LM-63-2002, type C, 125.5 mW)  0 0 0                 "
            "125.5  exact  mW    yes    room.pbrt:7:3\n"
            " 1  goniometric  uv.ies (IES LM-63-2002, type C, 125.5 mW)  0 0 0                 "
            "125.5  exact  lm    yes    room.pbrt:7:3\n");
}

TEST(LightTable, FluxesOfLightsAtInfinityAreMarked) {
  v1::ListLightsResponse lights;
  const auto add = [&] { return lights.add_lights(); };
  add()->mutable_distant();
  add()->mutable_sun();
  add()->mutable_uniform_infinite();
  add()->mutable_image_infinite();
  add()->mutable_beam();
  for (v1::Light& light : *lights.mutable_lights()) light.set_power_lm(31.25);
  EXPECT_TRUE(is_at_infinity(lights.lights(0)) && is_at_infinity(lights.lights(1)) &&
              is_at_infinity(lights.lights(2)) && is_at_infinity(lights.lights(3)));
  EXPECT_FALSE(is_at_infinity(lights.lights(4)));
  const std::string table = light_table(lights.lights()).to_string() + light_notes(lights.lights());
  std::size_t marks = 0;
  for (std::size_t at = 0; (at = table.find("*31.25 ", at)) != std::string::npos; ++at) ++marks;
  EXPECT_EQ(marks, 4U) << table;
  EXPECT_TRUE(table.ends_with(std::string("\n") + kFluxFromInfinity + "\n")) << table;
}

TEST(LightTable, FlatShapesAtZeroHaveNoHeight) {
  const double least = 0x1p-149;  // the smallest float: bounds are rounded outwards
  EXPECT_EQ(place_of(area(v1::AREA_SHAPE_DISK, {-1, -1, -least}, {1, 1, least}, 1)),
            "-1 -1 0 to 1 1 0");
  EXPECT_EQ(place_of(area(v1::AREA_SHAPE_DISK, {-1, -1, -2e-38}, {1, 1, 0}, 1)),
            "-1 -1 -2e-38 to 1 1 0");
}

TEST(LightTable, AnUnknownKindHasARow) { expect(v1::Light(), "unknown", "", ""); }

// No compiler finds a kind of light that has no words in the table.
TEST(LightTable, EveryKindOfLightHasWords) {
  const auto* kinds = v1::Light::descriptor()->FindOneofByName("kind");
  ASSERT_NE(kinds, nullptr);
  for (int i = 0; i < kinds->field_count(); ++i) {
    v1::Light light;
    light.GetReflection()->MutableMessage(&light, kinds->field(i));
    EXPECT_NE(type_of(light), "unknown") << kinds->field(i)->name();
    EXPECT_NE(describe_light(light), "") << kinds->field(i)->name();
    EXPECT_NE(place_of(light), "") << kinds->field(i)->name();
  }
}

TEST(LightTable, EveryShapeHasWords) {
  const auto* shapes = v1::AreaShape_descriptor();
  for (int i = 0; i < shapes->value_count(); ++i) {
    if (shapes->value(i)->number() == v1::AREA_SHAPE_UNSPECIFIED) continue;
    v1::Light light;
    light.mutable_diffuse_area()->set_shape(static_cast<v1::AreaShape>(shapes->value(i)->number()));
    EXPECT_FALSE(describe_light(light).starts_with("shape")) << shapes->value(i)->name();
  }
}

}  // namespace
}  // namespace lucerna::cli
