// What sampling a light answers, and the words that lights and shapes share.
#pragma once

#include <cstdint>

#include "lights/density.h"
#include "lights/rgb.h"
#include "lights/vec.h"

namespace lucerna {

/// Why a sample carries no light.  An answer, not a failure: its value is 0 and it counts as a
/// sample in every mean.
enum class NoLight : std::uint8_t {
  kNone = 0,     ///< there is light
  kBehind,       ///< the receiver is behind (or exactly in the plane of) a one-sided light
  kOutsideCone,  ///< outside the cone of a spot
  kDegenerate,   ///< the receiver is exactly on the light: no direction or no density exists
  kBlack,        ///< the light emits nothing
  kOutOfRange,   ///< the value or the density does not fit the type it is answered in
};

/// One light sample as a receiver sees it.
///
/// Irradiance estimate from one sample, n the receiver's normal:
///   delta:      E = value max(0, n.wi)                [lx]
///   otherwise:  E = value max(0, n.wi) / pdf.per_sr   [lx]
template <std::floating_point Real>
struct LightSample {
  /// Radiance [cd/m2] arriving along `wi`; for a delta light the illuminance [lx] on a surface
  /// that faces it.  Finite, not negative, 0 unless `reason` is kNone.
  Rgb<Real> value;
  Vec3<Real> wi;    ///< unit, from the receiver to the light, world axes
  Real distance{};  ///< to `point` [m]; infinite for distant and infinite lights
  Vec3<Real>
      point;  ///< on the light, about the scene's origin [m]; unused where distance is infinite
  Vec3<Real>
      normal;  ///< geometric, unit, on the emitting side; zero where the light has no surface
  SolidAnglePdf<Real> pdf;    ///< finite, positive; 0 for delta lights, which have no density
  std::uint32_t primitive{};  ///< which primitive of the light's shape `point` lies on
  bool delta = false;
  NoLight reason = NoLight::kNone;
};

/// A point of a light's own surface, as sampling or a ray found it.
template <std::floating_point Real>
struct SurfacePoint {
  Vec3<Real> position;  ///< about the scene's origin [m]
  Vec3<Real> normal;    ///< geometric, unit, on the emitting side of a one-sided light
  std::uint32_t primitive{};
};

/// A power with what is known of it.  Scene-dependent for distant and infinite lights: the flux
/// through the disk of radius `SceneSphere::radius_m` that faces the light.
struct Power {
  Rgb<double> lumens;     ///< per channel; the luminous flux is its luminance [lm]
  double error_lumens{};  ///< bound on the error of the luminous flux; 0 where exact [lm]
};

/// The sphere around a scene's geometry and its local lights, about the scene's origin.
struct SceneSphere {
  Vec3<double> center_m;
  double radius_m{};
};

}  // namespace lucerna
