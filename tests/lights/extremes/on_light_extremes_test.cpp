// Row 7: receivers exactly on lights without a size, on pictures and panels, and in portals.
#include <gtest/gtest.h>

#include <cmath>

#include "lights/models/light.h"
#include "tests/lights/extremes/on_light.h"

namespace lucerna::testing {
namespace {

TEST(OnLightExtremes, Points) {
  Sweep sweep(7, "receiver at a point, spot, projection or goniometric light", kSwept, "answer");
  for (const Place& f : frames()) {
    const Vec3<double> position = f.point(3, 5, -7);
    record_samples(
        *PointLight<Served>::create({.position_m = position, .intensity_cd = Rgb<double>(1)}),
        position, sweep);
    SpotLightParams spot;
    spot.position_m = position;
    spot.intensity_cd = Rgb<double>(1);
    spot.cone_half_angle_rad = 1;
    record_samples(*SpotLight<Served>::create(spot), position, sweep);
    ProjectedPictureParams picture;
    picture.fov_rad = 1;
    ProjectionLightParams projection;
    projection.position_m = position;
    projection.intensity_cd = Rgb<double>(1);
    projection.picture = *ProjectedPicture::create(picture);
    record_samples(*ProjectionLight<Served>::create(projection), position, sweep);
    GoniometricLightParams goniometric;
    goniometric.position_m = position;
    goniometric.intensity = Rgb<double>(1);
    record_samples(*GoniometricLight<Served>::create(goniometric), position, sweep);
    const float d = 0;
    sweep.textbook_answer(std::isinf(1 / (d * d)) ? "infinite" : "a number");
  }
  sweep.expect_answers(NoLight::kDegenerate);
}

TEST(OnLightExtremes, PicturesAndPanels) {
  Sweep sweep(7, "receiver on a triangle, rectangle, disk with a picture or a photometric web",
              kSwept, "answer");
  const Picture picture{
      *Image::create(2, 2, {Rgb<float>(1), Rgb<float>(6), Rgb<float>(2), Rgb<float>(0.5F)}),
      ImageFilter::kBilinear, "uneven"};
  PanelProfile profile;
  profile.web = *PhotometricWeb::create({PhotometricType::kC, {0, 90, 180}, {0}, {9, 3, 1}});
  profile.tangent = {2, 1, 2};
  for (const Place& f : frames())
    for (const bool two_sided : {false, true}) {
      const DiffuseEmission emission{Rgb<double>(1), two_sided};
      const auto at = [&](double u, double v) {
        return f.point(2 * u + v, u + 2 * v, 2 * u - 2 * v);
      };
      const auto triangle = *TriangleMesh<Served>::create({{at(0, 0), at(4, 0), at(0, 8)}});
      const auto rectangle = *PatchMesh<Served>::create({{at(0, 0), at(4, 0), at(0, 8), at(4, 8)}});
      DiskParams params;
      params.radius_m = 8 * f.size;
      params.world_from_object = Transform::translate(f.point(1, 2, 3));
      const auto disk = *Disk<Served>::create(params);
      const auto all = [&](const Vec2<double>& p, const auto&... light) {
        (record_samples(light, at(p.x, p.y), sweep), ...);
      };
      const auto painted_triangle = *PaintedTriangleMeshLight<Served>::create(
          emission,
          *PaintedTriangleMesh<Served>::create(triangle, picture, {{0, 0}, {1, 0}, {0, 1}}));
      const auto painted_rectangle = *PaintedPatchMeshLight<Served>::create(
          emission, *PaintedPatchMesh<Served>::create(rectangle, picture));
      const auto panel_triangle = *PanelTriangleMeshLight<Served>::create(
          emission, *PanelTriangleMesh<Served>::create(triangle, profile));
      const auto panel_rectangle = *PanelPatchMeshLight<Served>::create(
          emission, *PanelPatchMesh<Served>::create(rectangle, profile));
      for (const Vec2<double>& p :
           {Vec2<double>{0, 0}, {4, 0}, {0, 8}, {2, 0}, {0, 5}, {2, 4}, {1, 2}})
        all(p, painted_triangle, painted_rectangle, panel_triangle, panel_rectangle);
      const auto painted_disk =
          *PaintedDiskLight<Served>::create(emission, *PaintedDisk<Served>::create(disk, picture));
      const auto panel_disk =
          *PanelDiskLight<Served>::create(emission, *PanelDisk<Served>::create(disk, profile));
      for (const Vec2<double>& p : {Vec2<double>{0, 0}, {8, 0}, {0, -8}, {1, 2}, {-3, 0.5}}) {
        record_samples(painted_disk, f.point(1 + p.x, 2 + p.y, 3), sweep);
        record_samples(panel_disk, f.point(1 + p.x, 2 + p.y, 3), sweep);
      }
    }
  sweep.expect_answers(NoLight::kDegenerate);
}

TEST(OnLightExtremes, Portals) {
  Sweep sweep(7, "receiver in a portal: at corners, on edges, inside", kSwept, "answer");
  for (const Place& f : frames()) {
    PortalLightParams params;
    params.corners_m = {{f.point(0, 0, 0), f.point(0, 8, 0), f.point(4, 8, 0), f.point(4, 0, 0)}};
    params.radiance_cd_m2 = Rgb<double>(1);
    const auto light = PortalLight<Served>::create(params);
    for (const Vec2<double>& p :
         {Vec2<double>{0, 0}, {4, 0}, {0, 8}, {4, 8}, {2, 0}, {4, 3}, {1, 7}})
      record_samples(*light, f.point(p.x, p.y, 0), sweep);
  }
  sweep.expect_answers(NoLight::kDegenerate);
}

}  // namespace
}  // namespace lucerna::testing
