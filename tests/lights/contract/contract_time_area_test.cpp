// The contract of moving lights on area lights: diffuse, with a picture, and with a luminaire's
// photometry.
#include <memory>
#include <utility>
#include <vector>

#include "tests/lights/contract/contract_time.h"

namespace lucerna::testing {
namespace {

template <typename Light, typename Shape>
Light emitting(Shape shape, bool two_sided = false) {
  return *Light::create({MovingCase::level(), two_sided}, std::move(shape));
}

// ---- Shapes. ----

template <typename Real>
TriangleMesh<Real> bent_triangles(const Transform& world_from_light) {
  const auto at = [&](double x, double y, double z) {
    return Vec3<Real>(world_from_light.point({x, y, z}));
  };
  return *TriangleMesh<Real>::create(
      {{at(0, 0, 1), at(1, 0, 1), at(0, 2, 1)}, {at(1, 0, 1), at(1, 2, 2), at(0, 2, 1)}});
}

template <typename Real>
TriangleMesh<Real> flat_triangles(const Transform& world_from_light) {
  const auto at = [&](double x, double y) { return Vec3<Real>(world_from_light.point({x, y, 1})); };
  return *TriangleMesh<Real>::create(
      {{at(0, 0), at(1, 0), at(0, 2)}, {at(1, 0), at(1, 2), at(0, 2)}});
}

template <typename Real>
PatchMesh<Real> patch(const Transform& world_from_light, double bend) {
  const auto at = [&](double x, double y, double z) {
    return Vec3<Real>(world_from_light.point({x, y, 1 + bend * z}));
  };
  return *PatchMesh<Real>::create({{at(0, 0, 0), at(1, 0, 0), at(0, 1, 0.5), at(1, 1, 1)}});
}

template <typename Real>
Sphere<Real> sphere(const Transform& world_from_light) {
  return *Sphere<Real>::create(
      {.radius_m = 0.5,
       .world_from_object = world_from_light * Transform::translate({1, 0.5, -1})});
}

template <typename Real>
Disk<Real> disk(const Transform& world_from_light) {
  return *Disk<Real>::create(
      {.height_m = 1, .radius_m = 0.75, .world_from_object = world_from_light});
}

template <typename Real>
Cylinder<Real> tube(const Transform& world_from_light) {
  return *Cylinder<Real>::create({.radius_m = 0.5,
                                  .z_min_m = -0.25,
                                  .z_max_m = 1,
                                  .phi_max_rad = 4,
                                  .world_from_object = world_from_light});
}

// ---- Diffuse. ----

struct MovingTriangles : MovingCase {
  template <typename Real>
  static TriangleMeshLight<Real> make(const Transform& world_from_light) {
    return emitting<TriangleMeshLight<Real>>(bent_triangles<Real>(world_from_light));
  }
};

struct MovingPatches : MovingCase {
  template <typename Real>
  static PatchMeshLight<Real> make(const Transform& world_from_light) {
    return emitting<PatchMeshLight<Real>>(patch<Real>(world_from_light, 1));
  }
};

struct MovingSphere : MovingCase {
  template <typename Real>
  static SphereLight<Real> make(const Transform& world_from_light) {
    return emitting<SphereLight<Real>>(sphere<Real>(world_from_light));
  }
};

struct MovingDisk : MovingCase {
  template <typename Real>
  static DiskLight<Real> make(const Transform& world_from_light) {
    return emitting<DiskLight<Real>>(disk<Real>(world_from_light));
  }
};

struct MovingCylinder : MovingCase {
  template <typename Real>
  static CylinderLight<Real> make(const Transform& world_from_light) {
    return emitting<CylinderLight<Real>>(tube<Real>(world_from_light));
  }
};

// ---- With a picture: no two places are alike, so a wrong place is noticed. ----

struct PaintedMovingCase : MovingCase {
  /// Positions of 10 m have a rounding of 2e-15 m.  By that, texels of 0.1 m differ by a few 1e-14
  /// of their value, times at most 60, the ratio of the brightest to the darkest.
  static constexpr double kRadianceTolerance = 1e-11;
  static Picture picture() {
    std::vector<Rgb<float>> texels;
    for (const float v : {1.F, 6.F, 2.F, 0.5F, 3.F, 0.25F, 5.F, 4.F, 8.F, 2.5F, 1.5F, 7.F})
      texels.emplace_back(v, 9 - v, v * v / 4);
    return {*Image::create(4, 3, std::move(texels)), ImageFilter::kBilinear, "uneven"};
  }
};

struct MovingPaintedTriangles : PaintedMovingCase {
  template <typename Real>
  static PaintedTriangleMeshLight<Real> make(const Transform& world_from_light) {
    return emitting<PaintedTriangleMeshLight<Real>>(
        *PaintedTriangleMesh<Real>::create(bent_triangles<Real>(world_from_light), picture(),
                                           {{0, 0}, {1, 0}, {0, 1}, {1, 0}, {1, 1}, {0, 1}}));
  }
};

struct MovingPaintedPatches : PaintedMovingCase {
  template <typename Real>
  static PaintedPatchMeshLight<Real> make(const Transform& world_from_light) {
    return emitting<PaintedPatchMeshLight<Real>>(
        *PaintedPatchMesh<Real>::create(patch<Real>(world_from_light, 1), picture()));
  }
};

struct MovingPaintedSphere : PaintedMovingCase {
  template <typename Real>
  static PaintedSphereLight<Real> make(const Transform& world_from_light) {
    return emitting<PaintedSphereLight<Real>>(
        *PaintedSphere<Real>::create(sphere<Real>(world_from_light), picture()));
  }
};

struct MovingPaintedDisk : PaintedMovingCase {
  template <typename Real>
  static PaintedDiskLight<Real> make(const Transform& world_from_light) {
    return emitting<PaintedDiskLight<Real>>(
        *PaintedDisk<Real>::create(disk<Real>(world_from_light), picture()), true);
  }
};

struct MovingPaintedCylinder : PaintedMovingCase {
  template <typename Real>
  static PaintedCylinderLight<Real> make(const Transform& world_from_light) {
    return emitting<PaintedCylinderLight<Real>>(
        *PaintedCylinder<Real>::create(tube<Real>(world_from_light), picture()));
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
  template <typename Real>
  static PanelTriangleMeshLight<Real> make(const Transform& world_from_light) {
    return emitting<PanelTriangleMeshLight<Real>>(*PanelTriangleMesh<Real>::create(
        flat_triangles<Real>(world_from_light), profile(world_from_light)));
  }
};

struct MovingPanelPatches : PanelMovingCase {
  template <typename Real>
  static PanelPatchMeshLight<Real> make(const Transform& world_from_light) {
    return emitting<PanelPatchMeshLight<Real>>(
        *PanelPatchMesh<Real>::create(patch<Real>(world_from_light, 0), profile(world_from_light)));
  }
};

struct MovingPanelDisk : PanelMovingCase {
  template <typename Real>
  static PanelDiskLight<Real> make(const Transform& world_from_light) {
    return emitting<PanelDiskLight<Real>>(
        *PanelDisk<Real>::create(disk<Real>(world_from_light), profile(world_from_light)), true);
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
