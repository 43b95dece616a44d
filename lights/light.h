// The closed set of light models.  The one place that names them all; everything that depends on
// which light it is visits the variant, and the compiler names whoever forgot one.
#pragma once

#include <variant>

#include "lights/area_light.h"
#include "lights/beam_light.h"
#include "lights/cylinder.h"
#include "lights/disk.h"
#include "lights/distant_light.h"
#include "lights/goniometric_light.h"
#include "lights/image_infinite_light.h"
#include "lights/infinite_light.h"
#include "lights/irradiance.h"
#include "lights/mesh.h"
#include "lights/point_light.h"
#include "lights/portal_light.h"
#include "lights/projection_light.h"
#include "lights/sphere.h"
#include "lights/spot_light.h"
#include "lights/sun_light.h"

namespace lucerna {

template <std::floating_point Real>
using TriangleMeshLight = AreaLight<Real, TriangleMesh>;
template <std::floating_point Real>
using PatchMeshLight = AreaLight<Real, PatchMesh>;
template <std::floating_point Real>
using SphereLight = AreaLight<Real, Sphere>;
template <std::floating_point Real>
using DiskLight = AreaLight<Real, Disk>;
template <std::floating_point Real>
using CylinderLight = AreaLight<Real, Cylinder>;
template <std::floating_point Real>
using PaintedTriangleMeshLight = AreaLight<Real, PaintedTriangleMesh>;
template <std::floating_point Real>
using PaintedPatchMeshLight = AreaLight<Real, PaintedPatchMesh>;
template <std::floating_point Real>
using PaintedSphereLight = AreaLight<Real, PaintedSphere>;
template <std::floating_point Real>
using PaintedDiskLight = AreaLight<Real, PaintedDisk>;
template <std::floating_point Real>
using PaintedCylinderLight = AreaLight<Real, PaintedCylinder>;
template <std::floating_point Real>
using PanelTriangleMeshLight = AreaLight<Real, PanelTriangleMesh>;
template <std::floating_point Real>
using PanelPatchMeshLight = AreaLight<Real, PanelPatchMesh>;
template <std::floating_point Real>
using PanelDiskLight = AreaLight<Real, PanelDisk>;

/// Scenes hold them in double; float is what docs/precision.md and the contracts compare with.
template <std::floating_point Real>
using Light =
    std::variant<PointLight<Real>, SpotLight<Real>, DistantLight<Real>, SunLight<Real>,
                 UniformInfiniteLight<Real>, ImageInfiniteLight<Real>, TriangleMeshLight<Real>,
                 PatchMeshLight<Real>, SphereLight<Real>, DiskLight<Real>, CylinderLight<Real>,
                 PaintedTriangleMeshLight<Real>, PaintedPatchMeshLight<Real>,
                 PaintedSphereLight<Real>, PaintedDiskLight<Real>, PaintedCylinderLight<Real>,
                 PanelTriangleMeshLight<Real>, PanelPatchMeshLight<Real>, PanelDiskLight<Real>,
                 GoniometricLight<Real>, ProjectionLight<Real>, BeamLight<Real>, PortalLight<Real>>;

// Said here, so that a change of the signature is an error and not an estimate where there was a
// closed form.
static_assert(HasIrradiance<TriangleMeshLight<double>> && HasIrradiance<PatchMeshLight<double>> &&
              HasIrradiance<SphereLight<double>> && HasIrradiance<DiskLight<double>> &&
              HasIrradiance<SunLight<double>> && HasIrradiance<UniformInfiniteLight<double>> &&
              HasIrradiance<PortalLight<double>> && !HasIrradiance<PaintedDiskLight<double>> &&
              !HasIrradiance<PanelDiskLight<double>> && !HasIrradiance<CylinderLight<double>>);

/// Lights that rays which leave the scene meet, wherever they started.
template <typename L>
concept SeenBeyond = requires(const L& light, const Vec3<double>& v) {
  light.le_escaped(v, v);
};
// Said here, so that a change of the signature is an error and not a black sky.
static_assert(SeenBeyond<SunLight<double>> && SeenBeyond<UniformInfiniteLight<double>> &&
              SeenBeyond<ImageInfiniteLight<double>> && SeenBeyond<PortalLight<double>>);

/// Lights without a surface whose rays carry what their start and direction say.
template <typename L>
concept LeavesFreely = requires(const L& light, const Vec3<double>& v) {
  light.le_leaving(v, v);
};
static_assert(LeavesFreely<SpotLight<double>> && LeavesFreely<GoniometricLight<double>> &&
              LeavesFreely<ProjectionLight<double>> && LeavesFreely<BeamLight<double>> &&
              LeavesFreely<SunLight<double>> && LeavesFreely<ImageInfiniteLight<double>> &&
              LeavesFreely<PortalLight<double>>);

/// Lights with a surface that rays may hit.
template <typename L>
concept SeenOnSurface = requires(const L& light, const SurfacePoint<double>& p,
                                 const Vec3<double>& v) {
  light.le(p, v);
  light.pdf_li(Receiver<double>(v), p);
};
static_assert(SeenOnSurface<TriangleMeshLight<double>> && SeenOnSurface<PaintedDiskLight<double>> &&
              !SeenOnSurface<PointLight<double>> && !SeenBeyond<SphereLight<double>>);

}  // namespace lucerna
