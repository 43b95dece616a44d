// Closed white boxes of each shape that can be an area light.  Walls emit L everywhere and reflect
// rho.  So the radiance is L / (1 - rho) in every direction, and the irradiance pi L / (1 - rho) at
// every place.  The tests notice light that is lost or counted twice: in sampling, in weighting, or
// between two walls.  A finite number of reflections gives exactly a partial sum of the same
// series.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "server/estimate/render.h"
#include "server/queries/receiver_irradiance.h"
#include "tests/server/scene/scenes.h"

namespace lucerna {
namespace {

using testing::build;
using testing::emissive;

constexpr double kL = 2;
/// The number of reflections.  0.7^25 = 1.3e-4 of the light is left out; 0.5^25 is negligible.
constexpr std::uint32_t kBounces = 24;

/// L (1 + rho + ... + rho^reflections).
double series(double rho, std::uint32_t reflections) {
  return kL * (1 - std::pow(rho, reflections + 1)) / (1 - rho);
}

/// A box of six quadrilaterals about (1, 2, 3) whose outsides face inwards.  `skew` moves the
/// corners out of their cube.  Then the sides are bilinear patches whose straight edges still meet.
std::vector<std::array<Vec3, 4>> sides(double skew) {
  const auto corner = [&](int i) {
    const Vec3 c{i & 1 ? 1.0 : -1.0, i & 2 ? 1.0 : -1.0, i & 4 ? 1.0 : -1.0};
    const double pull = skew * ((i * 5) % 8) / 8.0;
    return Vec3{1, 2, 3} + c + Vec3{-c.y, c.z, c.x} * pull;
  };
  std::vector<std::array<Vec3, 4>> all;
  for (const auto& [a, b, c, d] : {std::array{0, 1, 2, 3},
                                   {4, 6, 5, 7},
                                   {0, 4, 1, 5},
                                   {2, 3, 6, 7},
                                   {0, 2, 4, 6},
                                   {1, 5, 3, 7}})
    all.push_back({corner(a), corner(b), corner(c), corner(d)});
  return all;
}

ShapeList triangles() { return {emissive({testing::room({1, 2, 3})}, kL)}; }

/// Each side is a light of its own.
ShapeList rectangles() {
  ShapeList shapes;
  for (const auto& s : sides(0))
    shapes.push_back(emissive(testing::patch(s[0], s[1], s[2], s[3]), kL));
  return shapes;
}

/// All sides are one light.
ShapeList patches() {
  PatchMeshData mesh;
  for (const auto& s : sides(0.4))
    for (const Vec3& p : s) {
      mesh.indices.push_back(static_cast<std::uint32_t>(mesh.positions.size()));
      mesh.positions.push_back(p);
    }
  return {emissive({mesh}, kL)};
}

const Transform kPlace =
    Transform::translate({1, 2, 3}) * *Transform::rotate(0.7, Vec3{1, -2, 0.5});

ShapeList sphere() {
  return {emissive(
      {SphereParams{.radius_m = 1.25, .reverse_orientation = true, .world_from_object = kPlace}},
      kL)};
}

/// Half a sphere, closed by a disk.
ShapeList dome() {
  return {
      emissive({SphereParams{.radius_m = 1.25,
                             .z_min_m = 0,
                             .reverse_orientation = true,
                             .world_from_object = kPlace * Transform::translate({0, 0, -0.5})}},
               kL),
      emissive({DiskParams{.height_m = -0.5, .radius_m = 1.25, .world_from_object = kPlace}}, kL)};
}

/// A cylinder closed by a disk on one side, and by an annulus and the disk in its hole on the
/// other.
ShapeList drum() {
  const auto lid = [](double inner, double outer) {
    return emissive({DiskParams{.height_m = 0.75,
                                .radius_m = outer,
                                .inner_radius_m = inner,
                                .reverse_orientation = true,
                                .world_from_object = kPlace}},
                    kL);
  };
  return {
      emissive({CylinderParams{.radius_m = 1.25,
                               .z_min_m = -0.75,
                               .z_max_m = 0.75,
                               .reverse_orientation = true,
                               .world_from_object = kPlace}},
               kL),
      emissive({DiskParams{.height_m = -0.75, .radius_m = 1.25, .world_from_object = kPlace}}, kL),
      lid(0, 0.5), lid(0.5, 1.25)};
}

using Shapes = ShapeList (*)();

/// The same with a uniform grey picture on each light, at a quarter of the level.  Each triangle
/// shows half of it.
template <Shapes kOf>
ShapeList painted() {
  auto shapes = kOf();
  for (ShapeDescription& s : shapes) {
    s.emission->radiance_cd_m2 = Rgb(kL / 4);
    s.emission->picture = Picture{*Image::create(2, 2, std::vector<Rgbf>(4, Rgbf(4))),
                                  ImageFilter::kBilinear, "grey"};
    if (auto* mesh = std::get_if<TriangleMeshData>(&s.geometry))
      for (std::size_t i = 0; i < mesh->indices.size(); i += 3)
        mesh->corner_uv.insert(mesh->corner_uv.end(), {{0, 0}, {1, 0}, {1, 1}});
  }
  return shapes;
}

/// Gives a light of `area_m2` the photometry of a Lambertian one, I(theta) = cos(theta) cd.  A
/// panel has the radiance I / (A cos(theta)) in each direction, here 1 / A in all.  So it equals
/// the diffuse light.  Straight lines between angles 0.1 degrees apart are off the cosine by a
/// relative 4e-7 (h^2 / 8).
void make_panel(ShapeDescription& shape, double area_m2) {
  static const std::shared_ptr<const PhotometricWeb> web = [] {
    PhotometricWebParams cosine;
    cosine.horizontal_deg = {0};
    for (int i = 0; i <= 900; ++i) {
      cosine.vertical_deg.push_back(i / 10.0);
      cosine.intensity_cd.push_back(i < 900 ? std::cos(i * std::numbers::pi / 1800) : 0);
    }
    return *PhotometricWeb::create(cosine);
  }();
  PanelProfile& profile = shape.emission->panel.emplace();
  profile.web = web;
  profile.tangent = {1, 2, 3};  // not along any side's normal
  shape.emission->radiance_cd_m2 = Rgb(kL * area_m2);
}

/// The sides of a cube, each a panel of one patch.
ShapeList rectangle_panels() {
  auto shapes = rectangles();
  for (ShapeDescription& s : shapes) make_panel(s, 4);
  return shapes;
}

/// The sides of a cube, each a panel of two triangles.
ShapeList triangle_panels() {
  const TriangleMeshData room = testing::room({1, 2, 3});
  ShapeList shapes;
  for (std::size_t i = 0; i < room.indices.size(); i += 6) {
    TriangleMeshData side;
    for (std::size_t k = i; k < i + 6; ++k) {
      side.indices.push_back(static_cast<std::uint32_t>(side.positions.size()));
      side.positions.push_back(room.positions[room.indices[k]]);
    }
    shapes.push_back(emissive({side}, kL));
    make_panel(shapes.back(), 4);
  }
  return shapes;
}

/// The drum with panels for its disks.  Its wall is not flat and stays diffuse.
ShapeList disk_panels() {
  auto shapes = drum();
  for (ShapeDescription& s : shapes)
    if (const auto* disk = std::get_if<DiskParams>(&s.geometry))
      make_panel(s, std::numbers::pi * (disk->radius_m * disk->radius_m -
                                        disk->inner_radius_m * disk->inner_radius_m));
  return shapes;
}

struct Box {
  const char* name;
  Shapes shapes;
};
void PrintTo(const Box& box, std::ostream* out) { *out << box.name; }

class ClosedBox : public ::testing::TestWithParam<std::tuple<Box, double>> {
 protected:
  double rho() const { return std::get<1>(GetParam()); }
  std::shared_ptr<const Scene> scene() const {
    SceneDescription d = testing::description(rho());
    d.shapes = std::get<0>(GetParam()).shapes();
    d.camera.world_from_camera = *Transform::look_at({1.1, 1.8, 2.9}, {2, 3, 3.3}, {0, 0, 1});
    d.camera.screen_min = {-2, -2};
    d.camera.screen_max = {2, 2};
    return build(std::move(d));
  }
};

// Blocks of one sample are independent, so their mean is nearly normally distributed.  The limits
// are seven standard errors for each of 192 pixels, and 5.5 for their mean.  They are exceeded by
// chance once in 1e7.
TEST_P(ClosedBox, HasTheSameRadianceEverywhere) {
  const auto room = scene();
  constexpr std::uint64_t kBlocks = 64;
  EXPECT_NEAR(series(rho(), kBounces + 1), kL / (1 - rho()), 2e-4 * kL / (1 - rho()));
  for (const std::uint32_t bounces : {0U, 1U, kBounces}) {
    const TileResult tile = render_tile(
        *room, {.rect = {0, 0, 16, 12}, .seed = 5, .block_count = kBlocks, .bounces = bounces}, {});
    const double expected = series(rho(), bounces + 1);
    double sum = 0, variance = 0;
    int pixels = 0;
    for (std::size_t i = 0; i < tile.channels.size(); i += 3, ++pixels) {
      const double mean = tile.channels[i].sum / kBlocks;
      const double v = tile.channels[i].deviation / (kBlocks * (kBlocks - 1.0));
      EXPECT_NEAR(mean, expected, 7 * std::sqrt(v) + 1e-5 * expected) << "pixel " << pixels;
      sum += mean, variance += v;
    }
    const double error = std::sqrt(variance) / pixels;
    EXPECT_LT(error, 0.007 * expected) << bounces;
    EXPECT_NEAR(sum / pixels, expected, 5.5 * error + 1e-5 * expected) << bounces;
  }
}

// Normals at points near the middle and near the walls.  The limit is seven standard errors for
// each of 24, exceeded by chance once in 1e9, and 5.5 for their mean.
TEST_P(ClosedBox, IrradianceIsPiTimesTheRadianceEverywhere) {
  const auto room = scene();
  std::vector<IrradiancePoint> points;
  for (int i = 0; i < 24; ++i) {
    // In all directions, 0, 0.2 or 0.4 from the middle: within every box.
    const double z = (i % 8 + 0.5) / 4 - 1, phi = 2.4 * i, r = std::sqrt(1 - z * z);
    const Vec3 n{r * std::cos(phi), r * std::sin(phi), z};
    const Vec3 off = Vec3{n.y, n.z, n.x} * (0.2 * (i / 8));
    const Vec3 p = Vec3{1, 2, 3} + off - room->origin();
    points.push_back({p, {1e-6F, 1e-6F, 1e-6F}, n});
  }
  const IrradianceResult result =
      estimate_irradiance(*room, points, {.seed = 6, .block_count = 256, .bounces = kBounces}, {});
  const double expected = std::numbers::pi * series(rho(), kBounces);
  const double n = static_cast<double>(points.size());
  double sum = 0, variance = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const IrradianceEstimate& e = result.points[i];
    EXPECT_NEAR(e.irradiance_lx.g, expected, 7 * e.illuminance_error_lx + 1e-5 * expected)
        << "point " << i;
    sum += e.irradiance_lx.g, variance += e.illuminance_error_lx * e.illuminance_error_lx;
  }
  const double error = std::sqrt(variance) / n;
  EXPECT_LT(error, 0.01 * expected);
  EXPECT_NEAR(sum / n, expected, 5.5 * error + 1e-5 * expected);
}

std::string name_of(const ::testing::TestParamInfo<std::tuple<Box, double>>& info) {
  return std::string(std::get<0>(info.param).name) +
         (std::get<1>(info.param) < 0.6 ? "_half" : "_most");
}

// A disk or a cylinder does not close a box alone.  They do with each other and with part of a
// sphere.
INSTANTIATE_TEST_SUITE_P(
    Shapes, ClosedBox,
    ::testing::Combine(::testing::Values(Box{"triangles", triangles}, Box{"rectangles", rectangles},
                                         Box{"patches", patches}, Box{"sphere", sphere},
                                         Box{"dome", dome}, Box{"drum", drum}),
                       ::testing::Values(0.5, 0.7)),
    name_of);

// Reflection does not depend on how the walls emit: one albedo, the higher.
INSTANTIATE_TEST_SUITE_P(
    Emissions, ClosedBox,
    ::testing::Combine(::testing::Values(Box{"painted_triangles", painted<triangles>},
                                         Box{"painted_rectangles", painted<rectangles>},
                                         Box{"painted_patches", painted<patches>},
                                         Box{"painted_sphere", painted<sphere>},
                                         Box{"painted_dome", painted<dome>},
                                         Box{"painted_drum", painted<drum>},
                                         Box{"triangle_panels", triangle_panels},
                                         Box{"rectangle_panels", rectangle_panels},
                                         Box{"disk_panels", disk_panels}),
                       ::testing::Values(0.7)),
    name_of);

// A box that is not closed: a fortieth of the area is missing and lets light out.
TEST(OpenBox, HasLessRadiance) {
  SceneDescription d = testing::description(0.5);
  d.shapes = drum();
  std::get<DiskParams>(d.shapes[2].geometry).radius_m = 0.25;
  d.camera.world_from_camera = *Transform::look_at({1.1, 1.8, 2.9}, {2, 3, 3.3}, {0, 0, 1});
  const IrradiancePoint point{{}, {1e-6F, 1e-6F, 1e-6F}, {0, 0, 1}};
  const auto room = build(std::move(d));
  IrradiancePoint p = point;
  p.position = Vec3{1, 2, 3} - room->origin();
  const auto e = estimate_irradiance(*room, std::span(&p, 1),
                                     {.seed = 6, .block_count = 16384, .bounces = kBounces}, {})
                     .points[0];
  EXPECT_LT(e.irradiance_lx.g, std::numbers::pi * kL / 0.5 - 7 * e.illuminance_error_lx);
}

}  // namespace
}  // namespace lucerna
