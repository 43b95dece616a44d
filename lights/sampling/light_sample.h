// The result of sampling a light, and the types that lights and shapes share.
#pragma once

#include <cstdint>

#include "lights/maths/density.h"
#include "lights/maths/rgb.h"
#include "lights/maths/vec.h"
#include "lights/sampling/area_sampling.h"

namespace lucerna {

/// Why a sample carries no light.  This is a result and not a failure: the value is 0, and the
/// sample counts in every mean.
enum class NoLight : std::uint8_t {
  kNone = 0,     ///< there is light
  kBehind,       ///< the receiver is behind (or exactly in the plane of) a one-sided light
  kOutsideCone,  ///< outside the cone of a spot, beside a picture, or where either is dark
  kDegenerate,   ///< the receiver is exactly on the light: no direction or no density exists
  kBlack,        ///< the light emits nothing
  kOutOfRange,   ///< the result type cannot hold the value or the density
};

/// The place where light arrives, and the data that a light may use to place its samples.
struct Receiver {
  Vec3 position;  ///< about the scene's origin [m]
  /// Unit, on the side where light counts.  Zero: no normal, and all directions count equally.
  Vec3 normal;
  AreaSampling area_sampling = AreaSampling::kAutomatic;
  /// The caller also samples directions and weights both kinds of samples.  The density may then be
  /// 0 for directions with little light.  [Karlik19]
  bool incomplete = false;

  Receiver() = default;
  // NOLINTNEXTLINE(google-explicit-constructor): a point is a receiver without more data.
  Receiver(const Vec3& position) : position(position) {}
  Receiver(double x, double y, double z) : position(x, y, z) {}
};

/// One light sample as a receiver sees it.
///
/// Irradiance estimate from one sample, n the receiver's normal:
///   delta:      E = value max(0, n.wi)                [lx]
///   otherwise:  E = value max(0, n.wi) / pdf.per_sr   [lx]
struct LightSample {
  /// Radiance [cd/m2] that arrives along `wi`.  For a delta light the illuminance [lx] on a surface
  /// that faces it.  Finite, not negative, 0 unless `reason` is kNone.
  Rgb value;
  Vec3 wi;            ///< unit, from the receiver to the light, world axes
  double distance{};  ///< to `point` [m]; infinite for distant and infinite lights
  Vec3 point;   ///< on the light, about the scene's origin [m]; unused where distance is infinite
  Vec3 normal;  ///< geometric, unit, on the emitting side; zero where the light has no surface
  SolidAnglePdf pdf;          ///< finite, positive; 0 for delta lights, which have no density
  std::uint32_t primitive{};  ///< which primitive of the light's shape `point` lies on
  bool delta = false;
  NoLight reason = NoLight::kNone;
};

/// One ray that leaves a light.  The light's power is the mean over samples of
///   value |n.direction| / (pdf_position pdf_direction)
/// A light without a surface has no cosine.  Leave out a density of 0: the position or direction is
/// then certain.
struct EmissionSample {
  /// Radiance [cd/m2].  For a light that shines from one point: luminous intensity [cd].  For a
  /// light that shines in one direction: illuminance on a surface that faces it [lx].  Finite, not
  /// negative, 0 unless `reason` is kNone.
  Rgb value;
  Vec3 origin;                  ///< about the scene's origin [m]
  Vec3 direction;               ///< unit, away from the light
  Vec3 normal;                  ///< of the surface, unit, as in LightSample; zero without a surface
  AreaPdf pdf_position;         ///< 0 where the position is certain
  SolidAnglePdf pdf_direction;  ///< 0 where the direction is certain
  std::uint32_t primitive{};    ///< of the light's shape, as in LightSample
  NoLight reason = NoLight::kNone;
};

/// The densities of an EmissionSample.
struct EmissionPdf {
  AreaPdf position;
  SolidAnglePdf direction;
  bool operator==(const EmissionPdf&) const = default;
};

/// A point of a light's surface, found by sampling or by a ray.
struct SurfacePoint {
  Vec3 position;  ///< about the scene's origin [m]
  Vec3 normal{};  ///< geometric, unit, on the emitting side of a one-sided light
  std::uint32_t primitive{};
};

/// A power with a bound on its error.  Exact means a closed form for the stored parameters.  The
/// error does not include rounding in double, which is at most 1e-12 of the power.  For distant and
/// infinite lights the power depends on the scene: it is the flux through the disk of radius
/// `SceneSphere::radius_m` that faces the light.
struct Power {
  Rgb lumens;             ///< per channel; the luminous flux is its luminance [lm]
  double error_lumens{};  ///< bound on the error of the luminous flux; 0 where exact [lm]
};

/// The sphere around a scene's geometry and its local lights, about the scene's origin.
struct SceneSphere {
  Vec3 center_m;
  double radius_m{};
};

}  // namespace lucerna
