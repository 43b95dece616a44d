// The closed set of light models.  The one place that names them all; everything that depends on
// which light it is visits the variant, and the compiler names whoever forgot one.
#pragma once

#include <variant>

#include "lights/area_light.h"
#include "lights/cylinder.h"
#include "lights/disk.h"
#include "lights/distant_light.h"
#include "lights/image_infinite_light.h"
#include "lights/infinite_light.h"
#include "lights/mesh.h"
#include "lights/point_light.h"
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
using Light =
<<<<<<< HEAD
    std::variant<PointLight<Real>, SpotLight<Real>, DistantLight<Real>, SunLight<Real>,
                 UniformInfiniteLight<Real>, TriangleMeshLight<Real>, PatchMeshLight<Real>,
                 SphereLight<Real>, DiskLight<Real>, CylinderLight<Real>>;
=======
    std::variant<PointLight<Real>, SpotLight<Real>, DistantLight<Real>, UniformInfiniteLight<Real>,
                 ImageInfiniteLight<Real>, TriangleMeshLight<Real>, PatchMeshLight<Real>,
                 SphereLight<Real>, DiskLight<Real>>;
>>>>>>> c286531 (wip2)

}  // namespace lucerna
