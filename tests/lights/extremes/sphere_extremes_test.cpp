// Rows 1 and 2: spheres that are far or small, and spheres that nearly touch the receiver.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <iterator>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include "lights/shapes/all_shapes.h"
#include "tests/lights/extremes/area_extremes.h"

namespace lucerna::testing {
namespace {

/// 1 - cos of the cone from the cosine, as in [Pharr10, 14.6.3].
float textbook_pdf(float radius, float distance) {
  const float sin2 = radius * radius / (distance * distance);
  const float cos_max = std::sqrt(std::max(0.0F, 1 - sin2));
  return 1 / (2 * std::numbers::pi_v<float> * (1 - cos_max));
}

AreaLight sphere_light(double radius_m) {
  return *AreaLight::create({Rgb(1)}, *Sphere::create({.radius_m = radius_m}));
}

TEST(SphereExtremes, DensityOfFarSpheres) {
  Sweep sweep(1, "sphere light, radius / distance", "1e-12 ... 0.97", "density");
  const ReferenceTable table("sphere_cone");
  for (const auto& row : table.rows()) {
    const Vec3 receiver(0, 0, row["distance_m"]);
    const auto sample = sphere_light(row["radius_m"]).sample_li(receiver, {0.5, 0.5});
    sweep.compare(sample.pdf.per_sr, row["pdf_per_sr"], row.text("radius_m"));
    sweep.compare_textbook(
        textbook_pdf(static_cast<float>(row["radius_m"]), static_cast<float>(row["distance_m"])),
        row["pdf_per_sr"]);
  }
  sweep.expect_within(1e-14);
}

/// The directions of samples from (0, 0, d) to a sphere about 0.
struct Directions {
  double widest_rad = 0, mean_square_sine = 0, farthest_off = 0;
};

Directions directions_of(double radius, double distance) {
  const auto light = sphere_light(radius);
  const Vec3 receiver(0, 0, distance);
  const Gauss<16>& rule = gauss<16>();
  Directions all;
  const auto add = [&](Vec2 u, double weight) {
    const auto s = light.sample_li(receiver, u);
    const double sine = std::hypot(s.wi.x, s.wi.y);
    all.widest_rad = std::fmax(all.widest_rad, std::atan2(sine, -s.wi.z));
    all.mean_square_sine += weight * sine * sine;
    all.farthest_off = std::fmax(all.farthest_off, std::fabs(length(s.point) / radius - 1));
  };
  for (std::size_t i = 0; i < 16; ++i)
    for (std::size_t j = 0; j < 16; ++j)
      add({rule.node[i], rule.node[j]}, rule.weight[i] * rule.weight[j]);
  for (const double u : {0.0, 1 - 0x1p-24, 1.0})
    for (const double v : {0.0, 0.25, 1.0}) add({u, v}, 0);
  return all;
}

TEST(SphereExtremes, SamplesOfFarSpheresFillTheConeAndLieOnTheSphere) {
  Sweep sweep(1, "sphere light, radius / distance", "1e-12 ... 0.97",
              "mean square sine in the cone");
  const ReferenceTable table("sphere_cone");
  for (const auto& row : table.rows()) {
    const double radius = row["radius_m"], distance = row["distance_m"];
    const Directions d = directions_of(radius, distance);
    const double half = 2 * std::asin(std::sqrt(row["one_minus_cos"] / 2));
    EXPECT_LE(d.widest_rad, half * (1 + 1e-15) + 0x1p-53) << row.text("radius_m");
    EXPECT_LE(d.farthest_off, 0x1p-51) << row.text("radius_m");
    // 1 - cos is uniform up to h, and sin^2 = 2 (1 - cos) - (1 - cos)^2.
    const double h = row["one_minus_cos"];
    sweep.compare(d.mean_square_sine, h - h * h / 3, row.text("radius_m"));
    // The textbook's cosines are uniform between 1 and that of the cone, in float.
    const float r = static_cast<float>(radius), way = static_cast<float>(distance);
    const float cos_max = std::sqrt(std::max(0.0F, 1 - r * r / (way * way)));
    const float middle = 1 - 0.5F * (1 - cos_max);
    sweep.compare_textbook(1 - middle * middle, 2 * (h / 2) - h * h / 4);
  }
  sweep.expect_within(1e-12);
}

TEST(SphereExtremes, IrradianceAndPowerOfFarSpheres) {
  constexpr double kPi = std::numbers::pi;
  Sweep sweep(1, "sphere light, radius / distance", "1e-12 ... 0.97", "irradiance");
  const ReferenceTable table("sphere_cone");
  for (const auto& row : table.rows()) {
    const double radius = row["radius_m"];
    const auto light = sphere_light(radius);
    Receiver receiver(0, 0, row["distance_m"]);
    receiver.normal = {0, 0, -1};
    const Seen seen = seen_by(light, receiver);
    const double share = radius / row["distance_m"];
    EXPECT_EQ(seen.disagreement, 0) << row.text("radius_m");
    EXPECT_LE(relative_error(seen.solid_angle_sr, 1 / row["pdf_per_sr"]), 1e-14);
    EXPECT_LE(relative_error(light.power({}).lumens.g, 4 * kPi * kPi * radius * radius), 1e-14);
    sweep.compare(seen.irradiance_lx, kPi * share * share, row.text("radius_m"));
    sweep.compare_textbook(
        1 / textbook_pdf(static_cast<float>(radius), static_cast<float>(row["distance_m"])) *
            (1 + std::sqrt(1 - share * share)) / 2,
        kPi * share * share);
  }
  sweep.expect_within(1e-13);
}

/// The rule of [Pharr10, 14.6.3]: by area where the squared distance to the surface is below 1e-4,
/// in any unit.
float textbook_pdf_near(float radius, float distance) {
  if (distance * distance - radius * radius >= 1e-4F) return textbook_pdf(radius, distance);
  // The distance to the nearest point.
  const float way = distance - radius;
  return way * way / (4 * std::numbers::pi_v<float> * radius * radius);
}

TEST(SphereExtremes, DensityJustOutside) {
  Sweep sweep(2, "receiver just outside a sphere light, radius 1e-6 ... 1e6 m",
              "gap / radius 0.1 ... 1e-15", "density");
  const ReferenceTable table("sphere_near");
  for (const auto& row : table.rows()) {
    const auto light = sphere_light(row["radius_m"]);
    const Seen seen = seen_by(light, receiver_in(row, AreaSampling::kSolidAngle));
    EXPECT_EQ(seen.without, 0) << row.text("gap");
    EXPECT_EQ(seen.disagreement, 0) << row.text("gap");
    sweep.compare(1 / seen.solid_angle_sr, row["pdf_per_sr"], row.text("gap"));
    sweep.compare_textbook(
        textbook_pdf_near(static_cast<float>(row["radius_m"]),
                          static_cast<float>(length(vector_in(row, "receiver")))),
        row["pdf_per_sr"]);
  }
  // The gap of 1e-15 is rounded, and the density depends on its square root.
  sweep.expect_within(1e-8);
}

TEST(SphereExtremes, IrradianceJustOutside) {
  Sweep sweep(2, "receiver just outside a sphere light, radius 1e-6 ... 1e6 m",
              "gap / radius 0.1 ... 1e-15", "irradiance");
  const ReferenceTable table("sphere_near");
  for (const auto& row : table.rows()) {
    sweep.compare(
        seen_by(sphere_light(row["radius_m"]), receiver_in(row, AreaSampling::kSolidAngle))
            .irradiance_lx,
        row["irradiance_lx"], row.text("gap"));
  }
  sweep.expect_within(1e-12);
}

/// A receiver inside of a sphere light that faces away from the nearest point.
struct Inside {
  double radius, depth;  ///< the latter in radii
  Vec3 center;
  AreaSampling way;
  double side;  ///< which pole is the nearest point
};

std::vector<Inside> places_inside() {
  std::vector<Inside> all;
  for (int decade = -6; decade <= 6; decade += 3)
    for (const Vec3& offset : {Vec3{0, 0, 0}, {3, -5, 7}, {1000, -2000, 500}})
      for (const AreaSampling way :
           {AreaSampling::kAutomatic, AreaSampling::kSolidAngle, AreaSampling::kSquareRoot})
        for (const double depth : {1.0, 0.5, 0.125, 0.01, 1e-3, 9e-4, 1e-4, 1e-5, 1e-6, 1e-8, 1e-10,
                                   1e-12, 1e-13, 1e-14, 1e-15}) {
          // The depth must exceed the rounding of coordinates at this distance from zero.
          if (depth < 4e-16 * (1 + std::fabs(offset.z))) continue;
          const double r = 1.3 * std::pow(10, decade);
          const double side = offset.x > 0 ? -1 : 1;
          all.push_back({r, depth, offset * r, way, side});
        }
  return all;
}

/// Integrates along u.x only, because the result is symmetric about the axis.  Along it, the
/// integrand has a kink at the horizon.  For directions that is half of u.x; for points it is the
/// share of z up to the receiver.  Near the latter the integrand changes within a layer of the
/// depth.  Gauss's rule is applied between these places.
Seen seen_along_x(const AreaLight& light, const Receiver& receiver, const Inside& place) {
  const double edge = place.side > 0 ? 1 - place.depth / 2 : place.depth / 2;
  std::set<double> ends{0, 0.5, edge, 1};
  for (double step = place.depth / 8; step < 1; step *= 4)
    for (const double end : {edge - step, edge + step})
      if (end > 0 && end < 1) ends.insert(end);
  const Gauss<24>& rule = gauss<24>();
  Seen seen;
  for (auto to = std::next(ends.begin()); to != ends.end(); ++to)
    for (std::size_t i = 0; i < 24; ++i) {
      const double from = *std::prev(to), width = *to - from;
      for (const double y : {0.1, 0.6})
        seen.add(light, receiver, {from + width * rule.node[i], y}, width * rule.weight[i] / 2);
    }
  return seen;
}

TEST(SphereExtremes, IrradianceInside) {
  // For every sampling method and depth, the receiver sees radiance 1 in its whole hemisphere.
  Sweep sweep(2,
              "receiver inside a sphere light, radius 1e-6 ... 1e6 m, at the origin or elsewhere",
              "depth / radius 1 ... 1e-15", "irradiance");
  for (const Inside& place : places_inside())
    for (const bool two_sided : {true, false}) {
      const auto light = *AreaLight::create(
          {Rgb(1), two_sided},
          *Sphere::create({.radius_m = place.radius,
                           .reverse_orientation = !two_sided,
                           .world_from_object = Transform::translate(place.center)}));
      Receiver receiver(place.center + Vec3{0, 0, place.side * place.radius * (1 - place.depth)});
      receiver.normal = {0, 0, -place.side};
      receiver.area_sampling = place.way;
      const Seen seen = seen_along_x(light, receiver, place);
      const std::string at = fmt::format("radius {} depth {} center {} way {}", place.radius,
                                         place.depth, place.center.x, static_cast<int>(place.way));
      EXPECT_EQ(seen.disagreement, 0) << at;
      sweep.compare(seen.irradiance_lx, std::numbers::pi, at);
    }
  sweep.expect_within(1e-12);
}

}  // namespace
}  // namespace lucerna::testing
