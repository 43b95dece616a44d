// Row 7: receivers exactly on a light.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "lights/light.h"
#include "tests/lights/extremes/area_extremes.h"
#include "tests/sweep.h"

namespace lucerna::testing {
namespace {

/// Sizes and offsets under which whole numbers stay exact.
struct Place {
  double size;
  Vec3<double> offset;
  Vec3<double> point(double x, double y, double z) const {
    return offset + Vec3<double>{x, y, z} * size;
  }
};

std::vector<Place> frames() {
  std::vector<Place> all;
  for (const int exponent : {-80, -20, 0, 20, 60}) {
    const double size = std::ldexp(1.0, exponent);
    for (const Vec3<double>& shift : {Vec3<double>{0, 0, 0}, {1, -2, 3}, {4096, -65536, 1048576}})
      all.push_back({size, shift * size});
  }
  return all;
}
constexpr char kSwept[] = "sizes 2^-80 ... 2^60 m, offsets 0 ... 1e6 sizes";

/// What one sample after another answers at a receiver that lies on the light.
template <typename Light>
void ask(const Light& light, const Vec3<Served>& position, Sweep& sweep) {
  for (int way = 0; way <= static_cast<int>(AreaSampling::kCosineSolidAngle); ++way)
    for (const double x : {0.0, 0.125, 0.4, 0.75, 1.0})
      for (const double y : {0.0, 0.3, 0.5, 0.9, 1.0}) {
        Receiver<Served> receiver(position);
        receiver.normal = {0, 0, 1};
        receiver.area_sampling = static_cast<AreaSampling>(way);
        const auto sample = light.sample_li(receiver, {x, y});
        sweep.answer(sample.reason);
        EXPECT_EQ(sample.value.max_component(), 0);
        EXPECT_TRUE(std::isfinite(sample.pdf.per_sr));
        // The density of directions says the same.
        if (sample.wi != Vec3<Served>{}) {
          EXPECT_EQ(light.pdf_li(receiver, sample.wi).per_sr, 0);
        }
      }
}

/// L A cos / d^2 of a light of radiance 1 in floats, or I / d^2 where the receiver is the point.
void textbook(const Vec3<float>& to_light, const Vec3<float>& normal, float area, Sweep& sweep) {
  const float d2 = dot(to_light, to_light);
  const float cos = dot(normal, to_light) / std::sqrt(d2);
  const float value = area * cos / d2;
  sweep.textbook_answer(std::isnan(value)   ? "NaN"
                        : std::isinf(value) ? "infinite"
                        : value == 0        ? "0"
                                            : "a number");
}

TEST(OnLightExtremes, Points) {
  Sweep sweep(7, "receiver at a point, spot, projection or goniometric light", kSwept, "answer");
  for (const Place& f : frames()) {
    const Vec3<double> position = f.point(3, 5, -7);
    ask(*PointLight<Served>::create({.position_m = position, .intensity_cd = Rgb<double>(1)}),
        position, sweep);
    SpotLightParams spot;
    spot.position_m = position;
    spot.intensity_cd = Rgb<double>(1);
    spot.cone_half_angle_rad = 1;
    ask(*SpotLight<Served>::create(spot), position, sweep);
    ProjectedPictureParams picture;
    picture.fov_rad = 1;
    ProjectionLightParams projection;
    projection.position_m = position;
    projection.intensity_cd = Rgb<double>(1);
    projection.picture = *ProjectedPicture::create(picture);
    ask(*ProjectionLight<Served>::create(projection), position, sweep);
    GoniometricLightParams goniometric;
    goniometric.position_m = position;
    goniometric.intensity = Rgb<double>(1);
    ask(*GoniometricLight<Served>::create(goniometric), position, sweep);
    const float d = 0;
    sweep.textbook_answer(std::isinf(1 / (d * d)) ? "infinite" : "a number");
  }
  sweep.expect_answers(NoLight::kDegenerate);
}

TEST(OnLightExtremes, Triangles) {
  Sweep sweep(7, "receiver on a triangle: its vertices, its edges, within", kSwept, "answer");
  for (const Place& f : frames())
    for (const bool two_sided : {false, true}) {
      const Vec3<double> a = f.point(1, 2, 3), b = f.point(9, -6, 11), c = f.point(-7, 10, 19);
      const auto light = TriangleMeshLight<Served>::create(
          {Rgb<double>(1), two_sided}, *TriangleMesh<Served>::create({{a, b, c}}));
      const Vec3<double> normal = normalized(cross(b - a, c - a));
      // Of a, b and c, in eighths: all of these are exact.
      for (const Vec3<double>& share : {Vec3<double>{8, 0, 0},
                                        {0, 8, 0},
                                        {0, 0, 8},
                                        {4, 4, 0},
                                        {0, 4, 4},
                                        {6, 0, 2},
                                        {2, 2, 4},
                                        {1, 3, 4},
                                        {3, 3, 2}}) {
        const Vec3<double> on = a + (b - a) * (share.y / 8) + (c - a) * (share.z / 8);
        ask(*light, on, sweep);
        textbook(Vec3<float>(a * 0.5 + b * 0.25 + c * 0.25) - Vec3<float>(on), Vec3<float>(normal),
                 static_cast<float>(light->area_m2()), sweep);
      }
    }
  sweep.expect_answers(NoLight::kDegenerate);
}

TEST(OnLightExtremes, Rectangles) {
  Sweep sweep(7, "receiver on a rectangle: its corners, its edges, within", kSwept, "answer");
  for (const Place& f : frames())
    for (const bool two_sided : {false, true})
      for (const bool tilted : {false, true}) {
        // (2, 1, 2), (1, 2, -2): at right angles, of length 3.
        const auto at = [&](double u, double v) {
          return tilted ? f.point(2 * u + v, u + 2 * v, 2 * u - 2 * v) : f.point(3 * u, 5 * v, 0);
        };
        const auto light = PatchMeshLight<Served>::create(
            {Rgb<double>(1), two_sided},
            *PatchMesh<Served>::create({{at(0, 0), at(4, 0), at(0, 8), at(4, 8)}}));
        for (const Vec2<double>& p : {Vec2<double>{0, 0},
                                      {4, 0},
                                      {0, 8},
                                      {4, 8},
                                      {2, 0},
                                      {0, 5},
                                      {4, 3},
                                      {1, 8},
                                      {2, 4},
                                      {1, 7},
                                      {3, 0.5}}) {
          ask(*light, at(p.x, p.y), sweep);
          textbook(Vec3<float>(at(1, 1)) - Vec3<float>(at(p.x, p.y)),
                   Vec3<float>(normalized(cross(at(1, 0) - at(0, 0), at(0, 1) - at(0, 0)))),
                   static_cast<float>(light->area_m2()), sweep);
        }
      }
  sweep.expect_answers(NoLight::kDegenerate);
}

TEST(OnLightExtremes, Trapezoids) {
  Sweep sweep(7, "receiver on a flat quadrilateral that is no rectangle", kSwept, "answer");
  for (const Place& f : frames())
    for (const bool two_sided : {false, true}) {
      // In the plane of (2, 1, 2) and (1, 2, -2): 4 of the one, 8 of the other and, opposite, 4.
      const auto at = [&](double u, double v) {
        return f.point(2 * u + v, u + 2 * v, 2 * u - 2 * v);
      };
      const auto light = PatchMeshLight<Served>::create(
          {Rgb<double>(1), two_sided},
          *PatchMesh<Served>::create({{at(0, 0), at(4, 0), at(0, 8), at(4, 4)}}));
      for (const Vec2<double>& p : {Vec2<double>{0, 0},
                                    {4, 0},
                                    {0, 8},
                                    {4, 4},
                                    {2, 0},
                                    {0, 5},
                                    {4, 3},
                                    {2, 6},
                                    {1, 2},
                                    {3, 0.5}})
        ask(*light, at(p.x, p.y), sweep);
    }
  sweep.expect_answers(NoLight::kDegenerate);
}

TEST(OnLightExtremes, BentPatchesFromTheirOwnCorner) {
  // The directions to (u, v, u v) from its corner 0 end where u or v is 1: the integral of the sine
  // of the elevation there over the azimuth is pi / 6.
  Sweep sweep(7, "receiver at a corner of a bent patch, which sees all of it",
              "sizes 2^-80 ... 2^60 m, offsets 0 ... 3 sizes", "mean of 1 / density");
  for (const Place& f : frames()) {
    // Where zero is 1e6 sizes away, doubles next to the corner are farther apart than the patch
    // is bent.
    if (max_abs(f.offset) > 3 * f.size) continue;
    const auto light =
        patch_light({f.point(0, 0, 0), f.point(1, 0, 0), f.point(0, 1, 0), f.point(1, 1, 1)});
    const Receiver<Served> receiver(f.point(0, 0, 0));
    const Seen seen = seen_beside_diagonal(light, receiver);
    EXPECT_EQ(seen.without, 0) << f.size;
    sweep.compare(seen.solid_angle_sr, std::numbers::pi / 6,
                  fmt::format("size {} offset {}", f.size, max_abs(f.offset) / f.size));
    for (const double x : {0.0, 0.3, 1.0})
      for (const auto& u : {Vec2<double>{x, 0}, {0, x}}) {
        // Along the edges, which it is on.
        const auto s = light.sample_li(receiver, u);
        EXPECT_NE(s.reason, NoLight::kNone);
        EXPECT_EQ(s.value.max_component(), 0);
      }
  }
  sweep.expect_within(1e-9);
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
        (ask(light, at(p.x, p.y), sweep), ...);
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
        ask(painted_disk, f.point(1 + p.x, 2 + p.y, 3), sweep);
        ask(panel_disk, f.point(1 + p.x, 2 + p.y, 3), sweep);
      }
    }
  sweep.expect_answers(NoLight::kDegenerate);
}

TEST(OnLightExtremes, CutSpheresAndRims) {
  Sweep sweep(7, "receiver on a sphere off its axes, on the rim of a cut sphere or a cylinder",
              kSwept, "answer");
  for (const Place& f : frames()) {
    SphereParams whole;
    whole.radius_m = 9 * f.size;
    whole.world_from_object = Transform::translate(f.point(1, 2, 3));
    const auto ball =
        *SphereLight<Served>::create({Rgb<double>(1)}, *Sphere<Served>::create(whole));
    for (const Vec3<double>& p : {Vec3<double>{1, 4, 8}, {-4, 7, 4}, {6, -3, -6}, {8, 4, -1}})
      ask(ball, f.point(1 + p.x, 2 + p.y, 3 + p.z), sweep);
    SphereParams part = whole;
    part.radius_m = 5 * f.size;
    part.z_min_m = -4 * f.size;
    part.z_max_m = 3 * f.size;
    const auto cut = *SphereLight<Served>::create({Rgb<double>(1)}, *Sphere<Served>::create(part));
    for (const Vec3<double>& p : {Vec3<double>{4, 0, 3}, {0, -4, 3}, {-3, 0, -4}, {3, 4, 0}})
      ask(cut, f.point(1 + p.x, 2 + p.y, 3 + p.z), sweep);
    CylinderParams cylinder;
    cylinder.radius_m = 5 * f.size;
    cylinder.z_min_m = -8 * f.size;
    cylinder.z_max_m = 8 * f.size;
    cylinder.world_from_object = whole.world_from_object;
    const auto tube =
        *CylinderLight<Served>::create({Rgb<double>(1)}, *Cylinder<Served>::create(cylinder));
    for (const Vec3<double>& p : {Vec3<double>{5, 0, 8}, {3, 4, 8}, {-4, 3, -8}, {-3, -4, 1}})
      ask(tube, f.point(1 + p.x, 2 + p.y, 3 + p.z), sweep);
  }
  sweep.expect_answers(NoLight::kDegenerate);
}

TEST(OnLightExtremes, CornersOfAnyDigits) {
  Sweep sweep(7, "receiver at a corner of a triangle or a rectangle of random digits", kSwept,
              "answer");
  std::mt19937 random(7);
  std::uniform_real_distribution<double> digits(-1, 1);
  const auto any = [&] { return Vec3<double>{digits(random), digits(random), digits(random)}; };
  for (const Place& f : frames())
    for (int i = 0; i < 20; ++i) {
      const auto at = [&f](const Vec3<double>& p) { return f.point(p.x, p.y, p.z); };
      const Vec3<double> a = any(), e = any(), way = any();
      const Vec3<double> h = normalized(cross(e, way)) * 0.7;
      const DiffuseEmission emission{Rgb<double>(1), i % 2 == 0};
      const auto triangle = TriangleMeshLight<Served>::create(
          emission, *TriangleMesh<Served>::create({{at(a), at(a + e), at(a + way)}}));
      const Vec3<double> within = (a * 2 + (a + e) + (a + way)) / 4;
      for (const Vec3<double>& corner : {a, a + e, a + way}) {
        ask(*triangle, at(corner), sweep);
        textbook(Vec3<float>(at(within)) - Vec3<float>(at(corner)),
                 Vec3<float>(normalized(cross(e, way))), static_cast<float>(triangle->area_m2()),
                 sweep);
      }
      const auto rectangle = PatchMeshLight<Served>::create(
          emission, *PatchMesh<Served>::create({{at(a), at(a + e), at(a + h), at(a + e + h)}}));
      for (const Vec3<double>& corner : {a, a + e, a + h, a + e + h})
        ask(*rectangle, at(corner), sweep);
    }
  sweep.expect_answers(NoLight::kDegenerate);
}

TEST(OnLightExtremes, Disks) {
  Sweep sweep(7, "receiver on a disk: its middle, its rim, between", kSwept, "answer");
  for (const Place& f : frames())
    for (const bool two_sided : {false, true}) {
      DiskParams params;
      params.radius_m = 4 * f.size;
      params.world_from_object = Transform::translate(f.point(1, 2, 3));
      const auto light =
          DiskLight<Served>::create({Rgb<double>(1), two_sided}, *Disk<Served>::create(params));
      for (const Vec2<double>& p :
           {Vec2<double>{0, 0}, {4, 0}, {0, -4}, {-4, 0}, {1, 2}, {-3, 0.5}, {2, -2}}) {
        ask(*light, f.point(1 + p.x, 2 + p.y, 3), sweep);
        textbook(Vec3<float>(f.point(1, 2.5, 3)) - Vec3<float>(f.point(1 + p.x, 2 + p.y, 3)),
                 {0, 0, 1}, static_cast<float>(light->area_m2()), sweep);
      }
    }
  sweep.expect_answers(NoLight::kDegenerate);
}

TEST(OnLightExtremes, SpheresAndCylindersFromWithout) {
  Sweep sweep(7, "receiver on a sphere or a cylinder that shines outwards", kSwept, "answer");
  for (const Place& f : frames()) {
    SphereParams sphere;
    sphere.radius_m = 4 * f.size;
    sphere.world_from_object = Transform::translate(f.point(1, 2, 3));
    const auto ball =
        SphereLight<Served>::create({Rgb<double>(1)}, *Sphere<Served>::create(sphere));
    CylinderParams cylinder;
    cylinder.radius_m = 4 * f.size;
    cylinder.z_min_m = -8 * f.size;
    cylinder.z_max_m = 8 * f.size;
    cylinder.world_from_object = sphere.world_from_object;
    const auto tube =
        CylinderLight<Served>::create({Rgb<double>(1)}, *Cylinder<Served>::create(cylinder));
    for (const Vec2<double>& p : {Vec2<double>{4, 0}, {0, -4}, {-4, 0}}) {
      const Vec3<double> on = f.point(1 + p.x, 2 + p.y, 3);
      ask(*ball, on, sweep);
      ask(*tube, on, sweep);
      textbook(Vec3<float>(f.point(1, 2, 7)) - Vec3<float>(on), {0, 0, 1},
               static_cast<float>(ball->area_m2()), sweep);
    }
  }
  sweep.expect_answers(NoLight::kDegenerate);
}

TEST(OnLightExtremes, SpheresFromWithin) {
  Sweep sweep(7, "receiver on a sphere that shines inwards", kSwept,
              "density of points across, cos / pi");
  // A sampled point is where doubles so far from zero lie, off the sphere by a rounding of its
  // coordinates; a radius is four sizes.
  const auto bound = [](double offset_sizes) { return 1e-14 + 2 * 0x1p-53 * offset_sizes / 4; };
  double farthest = 0;
  for (const Place& f : frames()) farthest = std::fmax(farthest, max_abs(f.offset) / f.size);
  for (const Place& f : frames())
    for (const bool two_sided : {false, true}) {
      SphereParams params;
      params.radius_m = 4 * f.size;
      params.reverse_orientation = !two_sided;
      params.world_from_object = Transform::translate(f.point(1, 2, 3));
      const auto light =
          SphereLight<Served>::create({Rgb<double>(1), two_sided}, *Sphere<Served>::create(params));
      for (const Vec3<double>& outwards :
           {Vec3<double>{1, 0, 0}, {0, -1, 0}, {-1, 0, 0}, {0, 0, 1}})
        for (const double x : {0.125, 0.4, 0.75})
          for (const double y : {0.1, 0.3, 0.6, 0.9}) {
            const Receiver<Served> receiver(f.point(1, 2, 3) + outwards * params.radius_m);
            const auto sample = light->sample_li(receiver, {x, y});
            ASSERT_EQ(sample.reason, NoLight::kNone);
            const double cos = -dot(sample.wi, outwards), truth = cos / std::numbers::pi;
            const std::string at = fmt::format("size {}, u {}, {}", f.size, x, y);
            sweep.compare(sample.pdf.per_sr, truth, at);
            EXPECT_LE(relative_error(sample.pdf.per_sr, truth), bound(max_abs(f.offset) / f.size))
                << at;
            const Vec3<float> way = Vec3<float>(sample.point) - Vec3<float>(receiver.position);
            const float d2 = dot(way, way);
            const float cos_light = -dot(Vec3<float>(sample.normal), way) / std::sqrt(d2);
            sweep.compare_textbook(
                d2 / (std::fabs(cos_light) * static_cast<float>(light->area_m2())), truth);
          }
    }
  sweep.expect_within(bound(farthest));
}

TEST(OnLightExtremes, Portals) {
  Sweep sweep(7, "receiver in a portal: its corners, its edges, within", kSwept, "answer");
  for (const Place& f : frames()) {
    PortalLightParams params;
    params.corners_m = {{f.point(0, 0, 0), f.point(0, 8, 0), f.point(4, 8, 0), f.point(4, 0, 0)}};
    params.radiance_cd_m2 = Rgb<double>(1);
    const auto light = PortalLight<Served>::create(params);
    for (const Vec2<double>& p :
         {Vec2<double>{0, 0}, {4, 0}, {0, 8}, {4, 8}, {2, 0}, {4, 3}, {1, 7}})
      ask(*light, f.point(p.x, p.y, 0), sweep);
  }
  sweep.expect_answers(NoLight::kDegenerate);
}

}  // namespace
}  // namespace lucerna::testing
