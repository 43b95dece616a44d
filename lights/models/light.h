// The closed set of light models.  The one place that names them all; everything that depends on
// which light it is visits a Light, and the compiler names whoever forgot one.
#pragma once

#include <concepts>
#include <cstdint>
#include <memory>
#include <type_traits>
#include <utility>
#include <variant>

#include "lights/models/area_light.h"
#include "lights/models/beam_light.h"
#include "lights/models/distant_light.h"
#include "lights/models/goniometric_light.h"
#include "lights/models/image_infinite_light.h"
#include "lights/models/infinite_light.h"
#include "lights/models/irradiance.h"
#include "lights/models/point_light.h"
#include "lights/models/portal_light.h"
#include "lights/models/projection_light.h"
#include "lights/models/spot_light.h"
#include "lights/models/sun_light.h"
#include "lights/shapes/cylinder.h"
#include "lights/shapes/disk.h"
#include "lights/shapes/mesh.h"
#include "lights/shapes/sphere.h"

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

/// All of them, as a list.
template <std::floating_point Real>
using LightModels =
    std::variant<PointLight<Real>, SpotLight<Real>, DistantLight<Real>, SunLight<Real>,
                 UniformInfiniteLight<Real>, ImageInfiniteLight<Real>, TriangleMeshLight<Real>,
                 PatchMeshLight<Real>, SphereLight<Real>, DiskLight<Real>, CylinderLight<Real>,
                 PaintedTriangleMeshLight<Real>, PaintedPatchMeshLight<Real>,
                 PaintedSphereLight<Real>, PaintedDiskLight<Real>, PaintedCylinderLight<Real>,
                 PanelTriangleMeshLight<Real>, PanelPatchMeshLight<Real>, PanelDiskLight<Real>,
                 GoniometricLight<Real>, ProjectionLight<Real>, BeamLight<Real>, PortalLight<Real>>;

template <typename T, typename Types>
inline constexpr bool kIsOneOf = false;
template <typename T, typename... Types>
inline constexpr bool kIsOneOf<T, std::variant<Types...>> = (std::is_same_v<T, Types> || ...);

/// A light of one of the models, immutable.  Models larger than a point light lie beside it, so
/// that a table of lights has entries of a point light's size and not of the largest model's, which
/// is ten times that.  Copies share them.
///
/// Scenes hold lights in double; float is what docs/precision.md and the contracts compare with.
template <std::floating_point Real>
class Light {
 public:
  template <typename Model>
  requires kIsOneOf<Model, LightModels<Real>>
  // NOLINTNEXTLINE(google-explicit-constructor): a model is a light.
  Light(Model model) : stored_(stored(std::move(model))) {}

  /// `f` called with the model.
  template <typename F>
  friend decltype(auto) visit(F&& f, const Light& light) {
    return std::visit([&](const auto& stored) -> decltype(auto) { return f(model_in(stored)); },
                      light.stored_);
  }

  /// Null where the light is of another model.
  template <typename Model>
  const Model* get_if() const {
    const auto* stored = std::get_if<Stored<Model>>(&stored_);
    return stored != nullptr ? &model_in(*stored) : nullptr;
  }

  /// Memory of what lies beside it.
  std::uint64_t bytes_beside() const {
    return std::visit(
        []<typename S>(const S& stored) -> std::uint64_t {
          using Model = std::decay_t<decltype(model_in(stored))>;
          return std::is_same_v<S, Model> ? 0 : sizeof(Model);
        },
        stored_);
  }

 private:
  template <typename Model>
  using Stored = std::conditional_t<sizeof(Model) <= sizeof(PointLight<Real>), Model,
                                    std::shared_ptr<const Model>>;
  template <typename Models>
  struct Storage;
  template <typename... Models>
  struct Storage<std::variant<Models...>> {
    using type = std::variant<Stored<Models>...>;
  };

  template <typename Model>
  static Stored<Model> stored(Model model) {
    if constexpr (std::is_same_v<Stored<Model>, Model>)
      return model;
    else
      return std::make_shared<const Model>(std::move(model));
  }
  template <typename Model>
  static const Model& model_in(const Model& model) {
    return model;
  }
  template <typename Model>
  static const Model& model_in(const std::shared_ptr<const Model>& model) {
    return *model;
  }

  typename Storage<LightModels<Real>>::type stored_;
};

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

/// Lights most of whose samples are told by direction, distance and value alone.
template <typename L>
concept HasPlainSamples = requires(const L& light, const Vec3<double>& v) {
  light.plain_sample_li(v);
};
static_assert(HasPlainSamples<PointLight<double>>);

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
