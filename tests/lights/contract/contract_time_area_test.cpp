// The contract of moving lights on area lights: diffuse, with a picture, and with a luminaire's
// photometry.
#include <memory>
#include <utility>
#include <vector>

#include "lights/shapes/all_shapes.h"
#include "tests/lights/contract/contract_time.h"

namespace lucerna::testing {
namespace {

template <typename S>
AreaLight emitting(S shape, EmissionPattern pattern = {}, bool two_sided = false) {
  return *AreaLight::create({MovingCase::level(), two_sided}, std::move(shape), std::move(pattern));
}

// ---- Shapes. ----

TriangleMesh bent_triangles(const Transform& world_from_light, std::vector<Vec2f> uv = {}) {
  const auto at = [&](double x, double y, double z) { return world_from_light.point({x, y, z}); };
  return *TriangleMesh::create(
      {{at(0, 0, 1), at(1, 0, 1), at(0, 2, 1)}, {at(1, 0, 1), at(1, 2, 2), at(0, 2, 1)}},
      std::move(uv));
}

TriangleMesh flat_triangles(const Transform& world_from_light) {
  const auto at = [&](double x, double y) { return world_from_light.point({x, y, 1}); };
  return *TriangleMesh::create({{at(0, 0), at(1, 0), at(0, 2)}, {at(1, 0), at(1, 2), at(0, 2)}});
}

PatchMesh patch(const Transform& world_from_light, double bend) {
  const auto at = [&](double x, double y, double z) {
    return world_from_light.point({x, y, 1 + bend * z});
  };
  return *PatchMesh::create({{at(0, 0, 0), at(1, 0, 0), at(0, 1, 0.5), at(1, 1, 1)}});
}

Sphere sphere(const Transform& world_from_light) {
  return *Sphere::create(
      {.radius_m = 0.5,
       .world_from_object = world_from_light * Transform::translate({1, 0.5, -1})});
}

Disk disk(const Transform& world_from_light) {
  return *Disk::create({.height_m = 1, .radius_m = 0.75, .world_from_object = world_from_light});
}

Cylinder tube(const Transform& world_from_light) {
  return *Cylinder::create({.radius_m = 0.5,
                            .z_min_m = -0.25,
                            .z_max_m = 1,
                            .phi_max_rad = 4,
                            .world_from_object = world_from_light});
}

// ---- Diffuse. ----

struct MovingTriangles : MovingCase {
  static AreaLight make(const Transform& world_from_light) {
    return emitting(bent_triangles(world_from_light));
  }
};

struct MovingPatches : MovingCase {
  static AreaLight make(const Transform& world_from_light) {
    return emitting(patch(world_from_light, 1));
  }
};

struct MovingSphere : MovingCase {
  static AreaLight make(const Transform& world_from_light) {
    return emitting(sphere(world_from_light));
  }
};

struct MovingDisk : MovingCase {
  static AreaLight make(const Transform& world_from_light) {
    return emitting(disk(world_from_light));
  }
};

struct MovingCylinder : MovingCase {
  static AreaLight make(const Transform& world_from_light) {
    return emitting(tube(world_from_light));
  }
};

// ---- With a picture: no two places are alike, so a wrong place is noticed. ----

struct PaintedMovingCase : MovingCase {
  /// Positions of 10 m have a rounding of 2e-15 m.  By that, texels of 0.1 m differ by a few 1e-14
  /// of their value, times at most 60, the ratio of the brightest to the darkest.
  static constexpr double kRadianceTolerance = 1e-11;
  static Picture picture() {
    std::vector<Rgbf> texels;
    for (const float v : {1.0, 6.0, 2.0, 0.5, 3.0, 0.25, 5.0, 4.0, 8.0, 2.5, 1.5, 7.0})
      texels.emplace_back(v, 9 - v, v * v / 4);
    return {*Image::create(4, 3, std::move(texels)), ImageFilter::kBilinear, "uneven"};
  }
};

struct MovingPaintedTriangles : PaintedMovingCase {
  static AreaLight make(const Transform& world_from_light) {
    return emitting(
        bent_triangles(world_from_light, {{0, 0}, {1, 0}, {0, 1}, {1, 0}, {1, 1}, {0, 1}}),
        {.picture = picture()});
  }
};

struct MovingPaintedPatches : PaintedMovingCase {
  static AreaLight make(const Transform& world_from_light) {
    return emitting(patch(world_from_light, 1), {.picture = picture()});
  }
};

struct MovingPaintedSphere : PaintedMovingCase {
  static AreaLight make(const Transform& world_from_light) {
    return emitting(sphere(world_from_light), {.picture = picture()});
  }
};

struct MovingPaintedDisk : PaintedMovingCase {
  static AreaLight make(const Transform& world_from_light) {
    return emitting(disk(world_from_light), {.picture = picture()}, true);
  }
};

struct MovingPaintedCylinder : PaintedMovingCase {
  static AreaLight make(const Transform& world_from_light) {
    return emitting(tube(world_from_light), {.picture = picture()});
  }
};

// ---- With a photometric web: no two directions are alike. ----

struct PanelMovingCase : MovingCase {
  /// Directions have a rounding of 2e-16, and the cosine below is rarely less than 1e-3.
  static constexpr double kRadianceTolerance = 1e-11;
  static PanelProfile profile(const Transform& world_from_light) {
    PanelProfile profile;
    profile.web =
        *PhotometricWeb::create({PhotometricType::kC,
                                 {0, 60, 120, 180},
                                 {0, 90, 180, 270, 360},
                                 {9, 3, 1, 2, 9, 5, 4, 2, 9, 6, 2, 2, 9, 7, 1, 2, 9, 3, 1, 2}});
    profile.tangent = world_from_light.vector({2, 1, 0.5});
    return profile;
  }
};

struct MovingPanelTriangles : PanelMovingCase {
  static AreaLight make(const Transform& world_from_light) {
    return emitting(flat_triangles(world_from_light), {.profile = profile(world_from_light)});
  }
};

struct MovingPanelPatches : PanelMovingCase {
  static AreaLight make(const Transform& world_from_light) {
    return emitting(patch(world_from_light, 0), {.profile = profile(world_from_light)});
  }
};

struct MovingPanelDisk : PanelMovingCase {
  static AreaLight make(const Transform& world_from_light) {
    return emitting(disk(world_from_light), {.profile = profile(world_from_light)}, true);
  }
};

using DiffuseCases =
    ::testing::Types<MovingTriangles, MovingPatches, MovingSphere, MovingDisk, MovingCylinder>;
INSTANTIATE_TYPED_TEST_SUITE_P(Area, MovingLight, DiffuseCases);
using PaintedCases =
    ::testing::Types<MovingPaintedTriangles, MovingPaintedPatches, MovingPaintedSphere,
                     MovingPaintedDisk, MovingPaintedCylinder>;
INSTANTIATE_TYPED_TEST_SUITE_P(Painted, MovingLight, PaintedCases);
using PanelCases = ::testing::Types<MovingPanelTriangles, MovingPanelPatches, MovingPanelDisk>;
INSTANTIATE_TYPED_TEST_SUITE_P(Panel, MovingLight, PanelCases);

}  // namespace
}  // namespace lucerna::testing
