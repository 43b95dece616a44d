// Row 9: coordinates and sizes of all magnitudes.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <optional>

#include "lights/models/all_lights.h"
#include "lights/shapes/all_shapes.h"
#include "tests/extremes_sweep.h"
#include "tests/reference_table.h"

namespace lucerna::testing {
namespace {

using Row = ReferenceTable::Row;

Vec3 receiver_of(const Row& row) { return {row["x"], row["y"], row["z"]}; }

/// All values are compared to within a few roundings of doubles.
constexpr double kRoundings = 1e-14;

/// I / d^2 in floats.
float textbook_per_square(const Vec3f& to_light) {
  return 1 / (to_light.x * to_light.x + to_light.y * to_light.y + to_light.z * to_light.z);
}

constexpr char kMagnitudes[] = "1e-100 ... 1e100";

TEST(MagnitudeExtremes, PointLights) {
  Sweep sweep(9, "point, spot and projection lights, positions and distances", kMagnitudes,
              "value");
  const ReferenceTable table("magnitude_points");
  const auto square = *ProjectedPicture::create({.fov_rad = 2.4});
  for (const auto& row : table.rows()) {
    const Vec3 position{row["px"], row["py"], row["pz"]}, receiver = receiver_of(row);
    const std::string at = row.text("px") + ", " + row.text("x");
    const auto compare = [&](const auto& light, const char* column) {
      const auto sample = light->sample_li(receiver, {});
      EXPECT_EQ(sample.reason, NoLight::kNone) << at;
      sweep.compare(sample.value.r, row[column], at);
    };
    compare(PointLight::create({.position_m = position, .intensity_cd = Rgb(1)}), "per_square");
    compare(SpotLight::create({.position_m = position,
                               .intensity_cd = Rgb(1),
                               .cone_half_angle_rad = std::numbers::pi / 3}),
            "falloff_per_square");
    compare(ProjectionLight::create(
                {.position_m = position, .picture = square, .intensity_cd = Rgb(1)}),
            "per_square");
    sweep.compare_textbook(textbook_per_square(Vec3f(position) - Vec3f(receiver)),
                           row["per_square"]);
  }
  sweep.expect_within(kRoundings);
}

/// Calls `f` with a point light, a spot and a projection of this intensity.
template <typename F>
void for_each_point_light(const Rgb& intensity_cd, F&& f) {
  f(PointLight::create({.intensity_cd = intensity_cd}));
  f(SpotLight::create({.intensity_cd = intensity_cd, .cone_half_angle_rad = 1}));
  f(ProjectionLight::create(
      {.picture = *ProjectedPicture::create({.fov_rad = 2.4}), .intensity_cd = intensity_cd}));
}

TEST(MagnitudeExtremes, DistancesWhoseSquaresLeaveTheRangeOfDoubles) {
  Sweep sweep(9, "point, spot and projection lights of 1e-300 cd near and 1e300 cd far",
              "1e-161 ... 1e-100 m, 1e100 ... 1e161 m", "value");
  for (int e = -161; e <= 161; e += e == -100 ? 200 : 1) {
    const double distance = 3 * std::pow(10.0, e), intensity = e < 0 ? 1e-300 : 1e300;
    // The exponents of long doubles reach 2^16384.
    const long double square_m2 = static_cast<long double>(distance) * distance;
    const double value = static_cast<double>(intensity / square_m2);
    const auto compare = [&](const auto& light) {
      const auto sample = light->sample_li(Vec3{0, 0, distance}, {});
      EXPECT_EQ(sample.reason, NoLight::kNone) << distance;
      sweep.compare(sample.value.r, value, std::to_string(e));
    };
    for_each_point_light(Rgb(intensity), compare);
    sweep.compare_textbook(intensity / (distance * distance), value);
  }
  sweep.expect_within(kRoundings);
}

TEST(MagnitudeExtremes, ValuesThatUnderflowAreZero) {
  Sweep sweep(9, "point, spot and projection lights of 1e-300 cd", "1e13 ... 1e150 m", "value");
  for (double distance = 1e13; distance < 2e150; distance *= 10) {
    const auto answer = [&](const auto& light) {
      const auto sample = light->sample_li(Vec3{0, 0, distance}, {});
      EXPECT_EQ(sample.distance, distance);
      sweep.answer(sample.reason != NoLight::kNone ? Sweep::name_of(sample.reason)
                   : sample.value.is_black()       ? "0"
                                                   : "not 0");
    };
    for_each_point_light(Rgb(1e-300), answer);
  }
  sweep.textbook_answer("0");
  sweep.expect_answers("0");
}

/// Calls `f` with a shape of the table magnitude_shapes.
template <typename F>
void visit_shape(const std::string& name, double s, F&& f) {
  const DiffuseEmission both{Rgb(1), true};
  if (name == "triangle") {
    f(*AreaLight::create(both, *TriangleMesh::create({{{0, 0, 0}, {s, 0, s / 4}, {s / 8, s, 0}}})));
  } else if (name == "rectangle") {
    f(*AreaLight::create(
        both, *PatchMesh::create({{{0, 0, 0}, {s, 0, 0}, {0, s / 2, 0}, {s, s / 2, 0}}})));
  } else if (name == "disk") {
    f(*AreaLight::create(both, *Disk::create({.radius_m = s})));
  } else if (name == "cylinder") {
    f(*AreaLight::create(both, *Cylinder::create({.radius_m = s, .z_min_m = -s, .z_max_m = s})));
  } else {
    f(*AreaLight::create(both, *Sphere::create({.radius_m = s})));
  }
}

/// d^2 / (A cos) in floats.
float textbook_by_area(const Vec3f& to_light, const Vec3f& normal, float area) {
  const float d2 = dot(to_light, to_light);
  const float cos = std::fabs(dot(normal, to_light)) / std::sqrt(d2);
  return d2 / (area * cos);
}

TEST(MagnitudeExtremes, DensityOfShapes) {
  Sweep sweep(9, "triangle, rectangle, disk, sphere and cylinder lights, sizes and distances",
              kMagnitudes, "density");
  const ReferenceTable table("magnitude_shapes");
  for (const auto& row : table.rows()) {
    const std::string& shape = row.text("shape");
    visit_shape(shape, row["size"], [&](const auto& light) {
      Receiver receiver(receiver_of(row));
      // Spheres keep the automatic method, which depends on the solid angle.
      if (shape != "sphere") receiver.area_sampling = AreaSampling::kLowDistortion;
      // Each shape is sampled at the u of the table's point.
      const auto sample = light.sample_li(receiver, {shape == "triangle" ? 1.0 : 0.0, 0});
      const std::string at = shape + " " + row.text("size") + ", " + row.text("x");
      EXPECT_EQ(sample.reason, NoLight::kNone) << at;
      sweep.compare(sample.pdf.per_sr, row["pdf_per_sr"], at);
      if (shape != "sphere")
        sweep.compare_textbook(
            textbook_by_area(Vec3f(sample.point - receiver.position), Vec3f(sample.normal),
                             static_cast<float>(row["area_m2"])),
            row["pdf_per_sr"]);
    });
  }
  sweep.expect_within(kRoundings);
}

TEST(MagnitudeExtremes, PowerOfShapes) {
  Sweep sweep(9, "triangle, rectangle, disk, sphere and cylinder lights, sizes", kMagnitudes,
              "power");
  const ReferenceTable table("magnitude_shapes");
  for (const auto& row : table.rows()) {
    visit_shape(row.text("shape"), row["size"], [&](const auto& light) {
      const Power power = light.power({});
      sweep.compare(power.lumens.r, 2 * std::numbers::pi * row["area_m2"],
                    row.text("shape") + " " + row.text("size"));
      EXPECT_EQ(power.error_lumens, 0);
    });
    if (row.text("shape") != "disk") continue;
    const auto s = static_cast<float>(row["size"]);
    sweep.compare_textbook(std::numbers::pi_v<float> * s * s, row["area_m2"]);
  }
  sweep.expect_within(kRoundings);
}

/// [Oosterom83] in floats.
float textbook_sr(const Vec3f& a, const Vec3f& b, const Vec3f& c) {
  const auto norm = [](const Vec3f& v) { return std::sqrt(dot(v, v)); };
  const float la = norm(a), lb = norm(b), lc = norm(c);
  return 2 * std::atan2(std::fabs(dot(a, cross(b, c))),
                        la * lb * lc + dot(a, b) * lc + dot(a, c) * lb + dot(b, c) * la);
}

TEST(MagnitudeExtremes, DensityOfSolidAngles) {
  Sweep sweep(9, "triangle and rectangle lights, sizes and distances scaled together",
              "1e-26 ... 1e22", "density by solid angle");
  const ReferenceTable table("magnitude_solid_angles");
  for (const auto& row : table.rows()) {
    visit_shape(row.text("shape"), row["size"], [&](const auto& light) {
      Receiver receiver(receiver_of(row));
      receiver.area_sampling = AreaSampling::kSolidAngle;
      for (const Vec2 u : {Vec2{0.5, 0.5}, Vec2{1, 0}}) {
        const auto sample = light.sample_li(receiver, u);
        sweep.compare(sample.pdf.per_sr, 1 / row["solid_angle_sr"],
                      row.text("shape") + " " + row.text("size") + ", " + row.text("x"));
      }
    });
    const Vec3 r = receiver_of(row);
    const auto s = row["size"];
    const auto seen = [&](double x, double y, double z) { return Vec3f(Vec3{x, y, z} - r); };
    const float textbook =
        row.text("shape") == "triangle"
            ? textbook_sr(seen(0, 0, 0), seen(s, 0, s / 4), seen(s / 8, s, 0))
            : textbook_sr(seen(0, 0, 0), seen(s, 0, 0), seen(s, s / 2, 0)) +
                  textbook_sr(seen(0, 0, 0), seen(s, s / 2, 0), seen(0, s / 2, 0));
    sweep.compare_textbook(1 / textbook, 1 / row["solid_angle_sr"]);
  }
  sweep.expect_within(kRoundings);
}

TEST(MagnitudeExtremes, DensityOfPortals) {
  Sweep sweep(9, "sky through a portal, sizes and distances", "1e-26 ... 1e31", "density");
  const ReferenceTable table("magnitude_portals");
  for (const auto& row : table.rows()) {
    const double s = row["size"];
    const auto light =
        PortalLight::create({.corners_m = {{{0, 0, 0}, {0, s / 2, 0}, {s, s / 2, 0}, {s, 0, 0}}}});
    const Vec3 receiver = receiver_of(row);
    const auto pdf = light->pdf_li(receiver, normalized(Vec3{s / 2, s / 4, 0} - receiver));
    sweep.compare(pdf.per_sr, row["pdf_per_sr"], row.text("size") + ", " + row.text("x"));
    // The textbook takes every portal as small: the squared distance over the projected area, in
    // floats.
    const Vec3f r(receiver);
    const float d2 = dot(r, r);
    sweep.compare_textbook(d2 * std::sqrt(d2) / (static_cast<float>(s * s / 2) * -r.z),
                           row["pdf_per_sr"]);
  }
  sweep.expect_within(kRoundings);
}

}  // namespace
}  // namespace lucerna::testing
