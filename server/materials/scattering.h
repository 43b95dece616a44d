// What a material does with light at one point: the contract of all kinds, checked by a concept.
//
// Directions are unit vectors in the local frame of a point.  +z is the shading normal, +x follows
// the surface's u coordinate.  Both point away from the surface: `wo` to where radiance leaves,
// `wi` to where light arrives from.  A surface has two sides, so wo.z may be negative.
#pragma once

#include <concepts>
#include <cstdint>
#include <optional>

#include "lights/maths/density.h"
#include "lights/maths/rgb.h"
#include "lights/maths/vec.h"

namespace lucerna {

/// Sample values of one decision, in [0, 1).
struct ScatterValues {
  double choice{};  ///< between lobes
  Vec2 direction{};
};

/// A direction of light, chosen for a direction `wo`.
struct ScatterSample {
  Vec3 wi;
  /// f |cos| / density.  With `delta`, the share of light that goes there over the probability of
  /// this choice.
  Rgb weight;
  /// Density of `wi`; 0 with `delta`, since no other direction is possible.
  SolidAnglePdf pdf{};
  bool delta = false;
};

/// Which side of the surface light comes from, as seen from `wo`.
enum class Side : std::uint8_t { kReflected = 1, kTransmitted = 2, kBoth = 3 };

constexpr bool has(Side sides, Side one) {
  return (static_cast<int>(sides) & static_cast<int>(one)) != 0;
}

/// Which quantity a path carries.  Refraction compresses radiance by the square of the ratio of
/// indices, and importance not.  [Veach97, 5.2]
enum class Carries : std::uint8_t { kRadiance, kImportance };

/// A scattering function f [1/sr] and its sampling.
///
/// - `value(wo, wi)`: f times |wi.z|.  0 for lobes of single directions.  An estimate without bias
///   if the function has no closed form (coated.h).
/// - `pdf(wo, wi)`: the density with which `sample` chooses `wi` among the lobes that are not
///   single directions.  Exact, also if `value` is an estimate.
/// - `sample(wo, values)`: a direction; nothing if no light is scattered.
/// - `single(wo, side)`: the share of light that the single direction on this side sends to `wo`:
/// the
///   mirror direction, or the refracted one.  Radiance, so refraction divides by the squared ratio
///   of indices.  0 without such a lobe.
/// - `sides()`: where light may come from.  `all_delta()`: whether all lobes are single directions.
/// No call has an error, and none allocates.
template <typename S>
concept Scattering = requires(const S& s, const Vec3& w, const ScatterValues& u) {
  { s.value(w, w) } -> std::same_as<Rgb>;
  { s.pdf(w, w) } -> std::same_as<SolidAnglePdf>;
  { s.sample(w, u) } -> std::same_as<std::optional<ScatterSample>>;
  { s.single(w, Side{}) } -> std::same_as<Rgb>;
  { s.all_delta() } -> std::same_as<bool>;
  { s.sides() } -> std::same_as<Side>;
};

/// The mirror direction at the normal +z.
inline Vec3 mirrored(const Vec3& w) { return {-w.x, -w.y, w.z}; }

inline bool same_side(const Vec3& a, const Vec3& b) { return a.z * b.z > 0; }

}  // namespace lucerna
