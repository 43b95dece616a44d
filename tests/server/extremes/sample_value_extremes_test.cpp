// Row 33: sample values at and next to the ends of [0, 1], for every light.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <type_traits>
#include <utility>
#include <variant>

#include "lights/sampling/sampling.h"
#include "lights/shapes/all_shapes.h"
#include "tests/extremes_sweep.h"
#include "tests/server/extremes/every_light_scene.h"
#include "tests/server/extremes/quad.h"

namespace lucerna::testing {
namespace {

double magnitude(Quad v) { return std::fabs(static_cast<double>(v)); }

/// World coordinates in the space of an object, by Cramer's rule.
Quad3 to_object(const Transform& world_from_object, const Quad3& p) {
  const auto& m = world_from_object.matrix();
  const auto column = [&](int j) { return Quad3(Quad(m[0][j]), Quad(m[1][j]), Quad(m[2][j])); };
  const Quad3 a = column(0), b = column(1), c = column(2), q = p - column(3);
  const Quad det = dot(a, cross(b, c));
  return {dot(q, cross(b, c)) / det, dot(a, cross(q, c)) / det, dot(a, cross(b, q)) / det};
}

double beyond(Quad value, double least, double most) {
  return std::max(
      {0.0, static_cast<double>(Quad(least) - value), static_cast<double>(value - Quad(most))});
}

/// How far beyond a sweep, along the circle.
double beyond_sweep(const Quad3& p, double phi_max_rad) {
  const double phi = azimuth(Vec3(double(p.x), double(p.y), double(p.z)));
  if (phi <= phi_max_rad) return 0;
  return std::min(phi - phi_max_rad, kTurnRad - phi) * std::hypot(double(p.x), double(p.y));
}

// How far a point (world) is from a shape, as a share of the size of the shape.

double off(const Sphere& shape, std::uint32_t, const Quad3& point, const Quad3&) {
  const SphereParams& s = shape.params();
  const Quad3 p = to_object(s.world_from_object, point);
  const Quad r = s.radius_m;
  return std::max({magnitude((dot(p, p) - r * r) / (2 * r)), beyond(p.z, s.z_min_m, s.z_max_m),
                   beyond_sweep(p, s.phi_max_rad)}) /
         s.radius_m;
}

double off(const Disk& shape, std::uint32_t, const Quad3& point, const Quad3&) {
  const DiskParams& d = shape.params();
  const Quad3 p = to_object(d.world_from_object, point);
  const double r = std::hypot(double(p.x), double(p.y));
  return std::max({magnitude(p.z - Quad(d.height_m)),
                   beyond(p.x * p.x + p.y * p.y, 0, d.radius_m * d.radius_m) / (2 * d.radius_m),
                   r < d.inner_radius_m ? d.inner_radius_m - r : 0,
                   beyond_sweep(p, d.phi_max_rad)}) /
         d.radius_m;
}

double off(const Cylinder& shape, std::uint32_t, const Quad3& point, const Quad3&) {
  const CylinderParams& c = shape.params();
  const Quad3 p = to_object(c.world_from_object, point);
  const Quad r = c.radius_m;
  return std::max({magnitude((p.x * p.x + p.y * p.y - r * r) / (2 * r)),
                   beyond(p.z, c.z_min_m, c.z_max_m), beyond_sweep(p, c.phi_max_rad)}) /
         c.radius_m;
}

/// The distance to the plane of two edges, from `corner` to `along_x` and `along_y`, and how far
/// beyond the edges, in shares of their lengths.
double off_plane(const Quad3& point, const Vec3& corner, const Vec3& along_x, const Vec3& along_y,
                 bool triangle) {
  const Quad3 a(corner), from_corner = point - a, x = Quad3(along_x) - a, y = Quad3(along_y) - a;
  const Quad3 n = cross(x, y);
  const Quad nn = dot(n, n);
  const Quad u = dot(cross(from_corner, y), n) / nn, v = dot(cross(x, from_corner), n) / nn;
  const double size = std::sqrt(static_cast<double>(std::max(dot(x, x), dot(y, y))));
  return std::max({magnitude(dot(from_corner, n)) / std::sqrt(static_cast<double>(nn)) / size,
                   beyond(u, 0, 1), beyond(v, 0, 1), triangle ? beyond(u + v, 0, 1) : 0});
}

double off(const TriangleMesh& mesh, std::uint32_t primitive, const Quad3&,
           const Quad3& about_origin) {
  const Triangle& t = mesh.primitive(primitive);
  return off_plane(about_origin, t.a, t.b, t.c, true);
}

/// The patches of the scene are flat and have right angles.
double off(const PatchMesh& mesh, std::uint32_t primitive, const Quad3&,
           const Quad3& about_origin) {
  const BilinearPatch& p = mesh.primitive(primitive);
  return off_plane(about_origin, p.p00, p.p10, p.p01, false);
}

constexpr std::array<double, 11> kValues{0,   0x1p-149,      0x1p-24, 0.25,        0.5 - 0x1p-25,
                                         0.5, 0.5 + 0x1p-24, 0.75,    1 - 0x1p-23, 1 - 0x1p-24,
                                         1};
/// This many roundings, for coordinates of up to a hundred sizes.
constexpr double kRoundings = 512 * std::numeric_limits<double>::epsilon();

constexpr char kSwept[] = "0, 2^-149, 2^-24, ... 1 - 2^-24, 1";

template <typename F>
void for_each_pair(F&& f) {
  for (const double x : kValues)
    for (const double y : kValues) f(Vec2{x, y});
}

/// About the origin of the scene: around the lights, among them, within the sphere, far away.
std::vector<Vec3> receivers(const Scene& scene) {
  std::vector<Vec3> all;
  for (const Vec3& world : {Vec3{100, -50, 0.5},
                            {98, -48.5, 1},
                            {100.7, -51.2, 2.6},
                            {97, -52, 4},
                            {103, -51, 2},
                            {100.75, -51.25, 2.9},
                            {1100, -2050, 300}})
    all.push_back(world - scene.origin());
  return all;
}

/// How far off the point is that pbrt-v3 samples on a distant sphere of radius 1 in floats.
float textbook_off(float distance, float u) {
  const float sin2 = 1 / (distance * distance);
  const float cos_max = std::sqrt(std::max(0.0F, 1 - sin2));
  const float cos_theta = (1 - u) + u * cos_max;
  const float sin2_theta = std::max(0.0F, 1 - cos_theta * cos_theta);
  const float ds =
      distance * cos_theta - std::sqrt(std::max(0.0F, 1 - distance * distance * sin2_theta));
  const float cos_alpha = (distance * distance + 1 - ds * ds) / (2 * distance);
  const float sin_alpha = std::sqrt(std::max(0.0F, 1 - cos_alpha * cos_alpha));
  return std::fabs(std::sqrt(cos_alpha * cos_alpha + sin_alpha * sin_alpha) - 1);
}

TEST(SampleValueExtremes, PointsLieOnTheirLights) {
  Sweep sweep(33, "sample values of every light with a surface", kSwept,
              "1 + distance of sampled points from the surface / its size");
  const auto scene = every_light();
  const Quad3 origin(scene->origin());
  for (const SceneLight& l : scene->lights()) {
    const std::string at = "light " + std::to_string(l.id);
    const Light& light = *l.light;
    const auto* surface = dynamic_cast<const AreaLight*>(&light);
    if (surface == nullptr) continue;
    const auto compare = [&](const Vec3& p, std::uint32_t primitive) {
      const Quad3 point(Quad(p.x) + origin.x, Quad(p.y) + origin.y, Quad(p.z) + origin.z);
      double away = 0;
      visit_shape(surface->shape(),
                  [&](const auto& shape) { away = off(shape, primitive, point, Quad3(p)); });
      sweep.compare(1 + away, 1, at);
    };
    for_each_pair([&](Vec2 pair) {
      const Vec2 u{double(pair.x), double(pair.y)};
      for (int way = 0; way <= static_cast<int>(AreaSampling::kCosineSolidAngle); ++way)
        for (const Vec3& position : receivers(*scene)) {
          Receiver receiver{position};
          receiver.area_sampling = static_cast<AreaSampling>(way);
          receiver.normal = {0, 0, 1};
          const auto s = light.sample_li(receiver, u);
          compare(s.point, s.primitive);
        }
      const auto ray = light.sample_le(u, {0.5, 0.5}, scene->sphere());
      const auto found = surface->shape().locate(ray.origin, 0);
      ASSERT_TRUE(found.has_value()) << at;
      compare(ray.origin, found->primitive);
    });
  }
  for (const double u : kValues)
    for (const float distance : {10.0F, 100.0F, 1000.0F})
      sweep.compare_textbook(1 + double{textbook_off(distance, static_cast<float>(u))}, 1);
  sweep.expect_within(kRoundings);
}

TEST(SampleValueExtremes, DensitiesMatchPdfLi) {
  Sweep sweep(33, "sample values of every light", kSwept, "density of samples against pdf_li");
  const auto scene = every_light();
  for (const SceneLight& l : scene->lights()) {
    const std::string at = "light " + std::to_string(l.id);
    const Light& light = *l.light;
    for_each_pair([&](Vec2 pair) {
      const Vec2 u{double(pair.x), double(pair.y)};
      for (const Vec3& position : receivers(*scene)) {
        Receiver receiver{position};
        receiver.normal = {0, 0, 1};
        const auto s = light.sample_li(receiver, u);
        EXPECT_NE(s.reason, NoLight::kOutOfRange) << at;
        EXPECT_TRUE(std::isfinite(s.pdf.per_sr)) << at;
        if (s.reason != NoLight::kNone) continue;
        EXPECT_TRUE(is_finite(s.value) && s.value.max_component() > 0) << at;
        if (s.delta) {
          EXPECT_EQ(s.pdf.per_sr, 0) << at;
          continue;
        }
        EXPECT_GT(s.pdf.per_sr, 0) << at;
        if (light.has_surface())
          sweep.compare(light.pdf_li(receiver, SurfacePoint{s.point, s.normal, s.primitive}).per_sr,
                        s.pdf.per_sr, at);
        else
          sweep.compare(light.pdf_li(receiver, s.wi).per_sr, s.pdf.per_sr, at);
      }
    });
  }
  // 1 / (2 pi (1 - cos)) of a sphere at a thousand radii and more, in floats.
  for (const float ratio : {1e-3F, 1e-4F, 1e-5F}) {
    const float cos_max = std::sqrt(1 - ratio * ratio);
    sweep.compare_textbook(1 / (6.2831853F * (1 - cos_max)),
                           1 / (3.14159265358979 * double{ratio} * ratio));
  }
  sweep.expect_within(kRoundings);
}

TEST(SampleValueExtremes, RayDensitiesMatchPdfLe) {
  Sweep sweep(33, "sample values of rays that leave every light", kSwept,
              "densities of rays against pdf_le");
  const auto scene = every_light();
  for (const SceneLight& l : scene->lights()) {
    const std::string at = "light " + std::to_string(l.id);
    const Light& light = *l.light;
    for_each_pair([&](Vec2 pair) {
      const Vec2 u{double(pair.x), double(pair.y)};
      for_each_pair([&](Vec2 other) {
        const Vec2 v{double(other.x), double(other.y)};
        const auto s = light.sample_le(u, v, scene->sphere());
        EXPECT_NE(s.reason, NoLight::kOutOfRange) << at;
        if (s.reason != NoLight::kNone) return;
        EXPECT_TRUE(is_finite(s.value) && s.value.max_component() > 0) << at;
        const auto pdf = light.pdf_le(s.origin, s.direction, scene->sphere());
        // 0 means certain.  The client receives all others as floats.
        for (const double density : {pdf.position.per_m2, pdf.direction.per_sr})
          EXPECT_TRUE(density == 0 || density >= std::numeric_limits<float>::min())
              << density << " of " << at << " at (" << other.x << ", " << other.y << ")";
        sweep.compare(pdf.position.per_m2, s.pdf_position.per_m2, at + " position");
        sweep.compare(pdf.direction.per_sr, s.pdf_direction.per_sr, at + " direction");
      });
    });
  }
  // The cosine of a diffuse ray from a point nearly at the edge of the disk, sqrt(1 - x^2 - y^2) in
  // floats.  The point is 2^-23 within the disk.
  for (const float u : {0.25F, 0.5F, 0.6F, 0.75F}) {
    const Vec2f d = sample_concentric_disk(Vec2f{1 - 0x1p-24F, u});
    sweep.compare_textbook(std::sqrt(std::max(0.0F, 1 - d.x * d.x - d.y * d.y)),
                           std::sqrt(0x1p-23 * (2 - 0x1p-23)));
  }
  sweep.expect_within(kRoundings);
}

}  // namespace
}  // namespace lucerna::testing
