// Row 7: receivers exactly on lights without a size, on pictures and panels, and in portals.
#include <gtest/gtest.h>

#include <cmath>

#include "lights/models/all_lights.h"
#include "lights/shapes/all_shapes.h"
#include "tests/lights/extremes/on_light.h"

namespace lucerna::testing {
namespace {

TEST(OnLightExtremes, Points) {
  Sweep sweep(7, "receiver at a point, spot, projection or goniometric light", kSwept, "answer");
  for (const Place& f : frames()) {
    const Vec3 position = f.point(3, 5, -7);
    record_samples(*PointLight::create({.position_m = position, .intensity_cd = Rgb(1)}), position,
                   sweep);
    record_samples(*SpotLight::create(
                       {.position_m = position, .intensity_cd = Rgb(1), .cone_half_angle_rad = 1}),
                   position, sweep);
    record_samples(*ProjectionLight::create({.position_m = position,
                                             .picture = *ProjectedPicture::create({.fov_rad = 1}),
                                             .intensity_cd = Rgb(1)}),
                   position, sweep);
    record_samples(*GoniometricLight::create({.position_m = position, .intensity = Rgb(1)}),
                   position, sweep);
    const float d = 0;
    sweep.textbook_answer(std::isinf(1 / (d * d)) ? "infinite" : "a number");
  }
  sweep.expect_answers(NoLight::kDegenerate);
}

TEST(OnLightExtremes, PicturesAndPanels) {
  Sweep sweep(7, "receiver on a triangle, rectangle, disk with a picture or a photometric web",
              kSwept, "answer");
  const Picture picture{*Image::create(2, 2, {Rgbf(1), Rgbf(6), Rgbf(2), Rgbf(0.5F)}),
                        ImageFilter::kBilinear, "uneven"};
  PanelProfile profile;
  profile.web = *PhotometricWeb::create({PhotometricType::kC, {0, 90, 180}, {0}, {9, 3, 1}});
  profile.tangent = {2, 1, 2};
  for (const Place& f : frames())
    for (const bool two_sided : {false, true}) {
      const DiffuseEmission emission{Rgb(1), two_sided};
      const auto at = [&](double u, double v) {
        return f.point(2 * u + v, u + 2 * v, 2 * u - 2 * v);
      };
      const auto triangle =
          *TriangleMesh::create({{at(0, 0), at(4, 0), at(0, 8)}}, {{0, 0}, {1, 0}, {0, 1}});
      const auto rectangle = *PatchMesh::create({{at(0, 0), at(4, 0), at(0, 8), at(4, 8)}});
      const auto disk = *Disk::create(
          {.radius_m = 8 * f.size, .world_from_object = Transform::translate(f.point(1, 2, 3))});
      for (const EmissionPattern& pattern :
           {EmissionPattern{.picture = picture}, EmissionPattern{.profile = profile}}) {
        for (const Vec2& p : {Vec2{0, 0}, {4, 0}, {0, 8}, {2, 0}, {0, 5}, {2, 4}, {1, 2}}) {
          record_samples(*AreaLight::create(emission, triangle, pattern), at(p.x, p.y), sweep);
          record_samples(*AreaLight::create(emission, rectangle, pattern), at(p.x, p.y), sweep);
        }
        const auto round = *AreaLight::create(emission, disk, pattern);
        for (const Vec2& p : {Vec2{0, 0}, {8, 0}, {0, -8}, {1, 2}, {-3, 0.5}})
          record_samples(round, f.point(1 + p.x, 2 + p.y, 3), sweep);
      }
    }
  sweep.expect_answers(NoLight::kDegenerate);
}

TEST(OnLightExtremes, Portals) {
  Sweep sweep(7, "receiver in a portal: at corners, on edges, inside", kSwept, "answer");
  for (const Place& f : frames()) {
    PortalLightParams params;
    params.corners_m = {{f.point(0, 0, 0), f.point(0, 8, 0), f.point(4, 8, 0), f.point(4, 0, 0)}};
    params.radiance_cd_m2 = Rgb(1);
    const auto light = PortalLight::create(params);
    for (const Vec2& p : {Vec2{0, 0}, {4, 0}, {0, 8}, {4, 8}, {2, 0}, {4, 3}, {1, 7}})
      record_samples(*light, f.point(p.x, p.y, 0), sweep);
  }
  sweep.expect_answers(NoLight::kDegenerate);
}

}  // namespace
}  // namespace lucerna::testing
