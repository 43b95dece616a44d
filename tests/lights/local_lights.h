// One light of every local kind, and random places for them, for tests of choosing among lights.
#pragma once

#include <fmt/format.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lights/models/all_lights.h"
#include "lights/models/light_tree.h"
#include "lights/shapes/all_shapes.h"
#include "tests/lights/sample_statistics.h"

namespace lucerna::testing {

struct LocalLight {
  std::string name;
  std::shared_ptr<const Light> light;
};

/// About 30 lights.  Their sizes are about that of the map; the map keeps angles.
class LocalLights {
 public:
  explicit LocalLights(const Transform& world_from_light) : at_(world_from_light) {
    add_points();
    add_shapes(false);
    add_shapes(true);
  }
  std::vector<LocalLight> take() { return std::move(lights_); }

 private:
  Vec3 point(double x, double y, double z) const { return at_.point({x, y, z}); }
  double size() const { return *at_.uniform_scale(); }
  Frame axes() const {
    return {at_.vector({1, 0, 0}), at_.vector({0, 1, 0}), at_.vector({0, 0, 1})};
  }
  template <typename L>
  void add(std::string name, absl::StatusOr<L> light) {
    EXPECT_TRUE(light.ok()) << name << ": " << light.status();
    lights_.push_back({std::move(name), std::make_shared<const L>(*std::move(light))});
  }

  void add_points() {
    const Rgb cd(3);
    add("point", PointLight::create({point(1, 2, 3), cd}));
    for (const double half : {1e-6, 0.01, 0.5, 1.5, 3.0})
      for (const double start : {1.0, 0.5})
        add(fmt::format("spot of {}, from {}", half, half * start),
            SpotLight::create({point(1, 2, 3), at_.vector({0, 0, 1}), cd, half, half * start}));
    const auto goniometric = [&](const char* name, std::vector<double> vertical_deg,
                                 std::vector<double> candela) {
      GoniometricLightParams params;
      params.position_m = point(-1, 0, 2);
      params.axes = axes();
      params.intensity = Rgb(1);
      params.web = *PhotometricWeb::create(
          {PhotometricType::kC, std::move(vertical_deg), {0}, std::move(candela)});
      add(name, GoniometricLight::create(params));
    };
    goniometric("luminaire that shines down", {0, 30, 60, 65, 90}, {9, 5, 1, 0, 0});
    goniometric("luminaire that shines up and down", {0, 60, 90, 150, 180}, {9, 0, 0, 0, 3});
    ProjectionLightParams projection;
    projection.position_m = point(2, 0, 0);
    projection.axes = axes();
    projection.intensity_cd = cd;
    projection.picture = *ProjectedPicture::create({.fov_rad = 1.1, .aspect = 1.5});
    add("projection", ProjectionLight::create(projection));
    BeamLightParams beam;
    beam.position_m = point(0, 2, 0);
    beam.axes = axes();
    beam.width_m = 2 * size();
    beam.height_m = size();
    beam.illuminance_lx = Rgb(2);
    add("beam", BeamLight::create(beam));
  }

  void add_shapes(bool two_sided) {
    const DiffuseEmission emission{Rgb(2), two_sided};
    const auto named = [&](const char* shape) {
      return fmt::format("{}{}", shape, two_sided ? ", two-sided" : "");
    };
    const auto triangle =
        *TriangleMesh::create({{point(0, 0, 0), point(1, 0.25, 0.5), point(0.5, 1, -0.25)}});
    const auto bent = *TriangleMesh::create({{point(0, 0, 0), point(1, 0, 0), point(0, 1, 0)},
                                             {point(1, 0, 0), point(1, 1, 0.5), point(0, 1, 0)}});
    const auto rectangle =
        *PatchMesh::create({{point(0, 0, 0), point(2, 0, 0), point(0, 1, 0), point(2, 1, 0)}});
    const auto saddle =
        *PatchMesh::create({{point(0, 0, 0), point(1, 0, 0.25), point(0, 1, 0.5), point(1, 1, 0)}});
    DiskParams disk_params;
    disk_params.radius_m = 0.75;
    disk_params.world_from_object = at_;
    const auto disk = *Disk::create(disk_params);
    SphereParams ball;
    ball.radius_m = 0.5;
    ball.world_from_object = at_;
    SphereParams cap = ball;
    cap.z_min_m = 0.25;
    CylinderParams tube;
    tube.radius_m = 0.25;
    tube.phi_max_rad = 2;
    tube.world_from_object = at_;
    const auto sphere = *Sphere::create(ball);
    const auto cylinder = *Cylinder::create(tube);
    add(named("triangle"), AreaLight::create(emission, triangle));
    add(named("bent mesh"), AreaLight::create(emission, bent));
    add(named("rectangle"), AreaLight::create(emission, rectangle));
    add(named("saddle"), AreaLight::create(emission, saddle));
    add(named("disk"), AreaLight::create(emission, disk));
    add(named("sphere"), AreaLight::create(emission, sphere));
    add(named("cap"), AreaLight::create(emission, *Sphere::create(cap)));
    add(named("cylinder"), AreaLight::create(emission, cylinder));

    PanelProfile profile;
    profile.web =
        *PhotometricWeb::create({PhotometricType::kC, {0, 40, 80, 90}, {0}, {9, 6, 1, 0}});
    profile.tangent = at_.vector({1, 0.5, 0});
    add(named("panel"), AreaLight::create(emission, rectangle, {.profile = profile}));
    add(named("round panel"), AreaLight::create(emission, disk, {.profile = profile}));
    const Picture picture{*Image::create(2, 2, {Rgbf(1), Rgbf(0), Rgbf(2), Rgbf(0.5F)}),
                          ImageFilter::kNearest, "partly black"};
    add(named("painted rectangle"), AreaLight::create(emission, rectangle, {.picture = picture}));
    add(named("painted sphere"), AreaLight::create(emission, sphere, {.picture = picture}));
    add(named("painted cylinder"), AreaLight::create(emission, cylinder, {.picture = picture}));
  }

  Transform at_;
  std::vector<LocalLight> lights_;
};

inline LightBounds bounds_of(const LocalLight& l) { return *l.light->bounds(); }
inline double power_of(const LocalLight& l) { return l.light->power({}).lumens.max_component(); }
inline LightTree tree_of(const std::vector<LocalLight>& lights) {
  std::vector<LightTree::Item> items;
  for (const LocalLight& l : lights) items.push_back({bounds_of(l), power_of(l)});
  return *LightTree::create(items);
}
inline LightSample sample_of(const LocalLight& l, const Receiver& receiver, Vec2 u) {
  return l.light->sample_li(receiver, u);
}

/// A map with a random rotation that scales by `size` and puts the origin within `size * spread` of
/// zero.
inline Transform random_place(RandomU& random, double size, double spread) {
  const auto number = [&] { return 2.0 * random.next() - 1; };
  const Vec3 shift{number(), number(), number()};
  return Transform::translate(shift * (size * spread)) *
         *Transform::rotate(3 * number(), {number(), number(), 1.5}) *
         *Transform::scale({size, size, size});
}

}  // namespace lucerna::testing
