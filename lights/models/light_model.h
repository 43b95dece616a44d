// The members that every light has, as a concept.  lights/models/light.h checks it for all lights,
// so a light that lacks a member does not compile.
#pragma once

#include <absl/status/statusor.h>

#include <concepts>
#include <cstdint>
#include <numbers>
#include <optional>
#include <utility>

#include "lights/models/irradiance.h"
#include "lights/models/light_bounds.h"
#include "lights/sampling/light_sample.h"

namespace lucerna {

using Box = std::pair<Vec3, Vec3>;  ///< lower and upper corner [m, world]

/// Where a light without a surface is.
struct LightPlace {
  /// A point of the light or of its portal [m, world].  Coordinates near it are small.  None for
  /// lights that have only directions.
  std::optional<Vec3> anchor_m{};
  /// The smallest box around the points where its rays start.  None for lights at infinity.
  std::optional<Box> box_m{};
  /// The smallest box around its portal.
  std::optional<Box> portal_m{};
};

/// Memory that belongs to one light only, without its own object [bytes].  Shared data is not
/// counted.
struct LightBytes {
  std::uint64_t all = 0;
  std::uint64_t tables = 0;  ///< the part of `all` from which points and directions are drawn
};

/// Lights that rays meet when they leave the scene, for any start of the ray.
template <typename L>
concept SeenBeyond = requires(const L& light, const Vec3& v) {
  light.le_escaped(v, v);
};

/// Lights without a surface whose rays have a value that depends on their start and direction.
template <typename L>
concept LeavesFreely = requires(const L& light, const Vec3& v) {
  light.le_leaving(v, v);
};

/// Lights whose samples mostly consist only of direction, distance and value.
template <typename L>
concept HasPlainSamples = requires(const L& light, const Vec3& v) {
  light.plain_sample_li(v);
};

/// Lights with a surface that rays may hit.
template <typename L>
concept SeenOnSurface = requires(const L& light, const SurfacePoint& p, const Vec3& v) {
  light.le(p, v);
  light.pdf_li(Receiver(v), p);
};

/// Accepts every kind of data that lights share, such as pictures and photometric webs.
struct AnySharedData {
  template <typename Data>
  void operator()(const Data& /*data*/) const {}
};

/// The members that every light has:
/// - `kDelta`: no density exists for its directions.
/// - `sample_li`, `pdf_li`: light that arrives at a receiver.
/// - `sample_le`, `pdf_le`: rays that leave the light.
/// - `power`, `power_approximate`: luminous flux [lm].
/// - `bounds`: a box and a cone of directions; none at infinity.
/// - `cross_section_m2`: the area that all of its flux passes through at any distance [m2].  None
///   if illuminance falls off with distance.
/// - `own_bytes`: its memory.
/// - `for_each_shared(f)`: calls `f` with each picture, photometric web and intensity map that
///   other lights may share.  `f` has one overload for each type, so a new type does not compile
///   until memory reports count it.
template <typename L>
concept AnyLightModel = requires(const L& light, const Receiver& receiver, const Vec3& v,
                                 const Vec2& u, const SceneSphere& scene) {
  { L::kDelta } -> std::convertible_to<bool>;
  { light.sample_li(receiver, u) } -> std::same_as<LightSample>;
  { light.pdf_li(receiver, v) } -> std::same_as<SolidAnglePdf>;
  { light.sample_le(u, u, scene) } -> std::same_as<EmissionSample>;
  { light.pdf_le(v, v, scene) } -> std::same_as<EmissionPdf>;
  { light.power(scene) } -> std::same_as<Power>;
  { light.power_approximate(scene) } -> std::same_as<Power>;
  { light.bounds() } -> std::same_as<std::optional<LightBounds>>;
  { light.cross_section_m2(scene) } -> std::same_as<std::optional<double>>;
  { light.own_bytes() } -> std::same_as<LightBytes>;
  light.for_each_shared(AnySharedData());
};

/// Lights that have each optional member that their kind needs:
/// - A ray's value is `le`, `le_leaving`, or the same for all rays (`kSameForAllRays`).
/// - Rays and camera paths can meet what has a density: `le` or `le_escaped`.
/// - Lights with a density state whether irradiance has a closed form (`kHasIrradiance`).  They
///   also have an upper bound of it (`most_irradiance`).  See lights/models/irradiance.h.
template <typename L>
concept HasMembersOfItsKind = (SeenOnSurface<L> || LeavesFreely<L> ||
                               requires { requires L::kSameForAllRays; }) &&
                              (L::kDelta || SeenOnSurface<L> ||
                               SeenBeyond<L>)&&(L::kDelta ||
                                                requires(const L& light, const Receiver& receiver) {
                                                  requires L::kHasIrradiance == HasIrradiance<L>;
                                                  {
                                                    light.most_irradiance(receiver)
                                                    } -> std::same_as<MostIrradiance>;
                                                });

/// A light with a surface, which comes from a shape.
template <typename L>
concept SurfaceLightModel = AnyLightModel<L> && requires(const L& light) {
  light.shape();
  light.emission();
  { light.area_m2() } -> std::same_as<double>;
};

/// A light without a surface, which comes from `Params`.
template <typename L>
concept FreeLightModel = AnyLightModel<L> &&
    requires(const L& light, const typename L::Params& params, const Vec3& origin_m) {
  { L::create(params, origin_m) } -> std::same_as<absl::StatusOr<L>>;
  { L::place(params) } -> std::same_as<LightPlace>;
  { light.params() } -> std::same_as<const typename L::Params&>;
};

template <typename L>
concept LightModel = SurfaceLightModel<L> || FreeLightModel<L>;

/// `cross_section_m2` of lights at infinity: the disk that covers the scene's sphere.
inline double scene_disk_area_m2(const SceneSphere& scene) {
  return std::numbers::pi * scene.radius_m * scene.radius_m;
}

}  // namespace lucerna
