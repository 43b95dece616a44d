// What sampling a light answers, and the words that lights and shapes share.
#pragma once

#include <cstdint>

#include "lights/maths/density.h"
#include "lights/maths/vec.h"
#include "lights/sampling/area_sampling.h"
#include "lights/spectra/rgb.h"

namespace lucerna {

/// Why a sample carries no light.  An answer, not a failure: its value is 0 and it counts as a
/// sample in every mean.
enum class NoLight : std::uint8_t {
  kNone = 0,     ///< there is light
  kBehind,       ///< the receiver is behind (or exactly in the plane of) a one-sided light
  kOutsideCone,  ///< outside the cone of a spot, beside a picture, or where either is dark
  kDegenerate,   ///< the receiver is exactly on the light: no direction or no density exists
  kBlack,        ///< the light emits nothing
  kOutOfRange,   ///< the value or the density does not fit the type it is answered in
};

/// Where light arrives, and what a light may use of it to place its samples.
template <std::floating_point Real>
struct Receiver {
  Vec3<Real> position;  ///< about the scene's origin [m]
  /// Unit, on the side that light is counted on; zero: there is none, all directions count alike.
  Vec3<Real> normal;
  AreaSampling area_sampling = AreaSampling::kAutomatic;
  /// The caller finds light by directions of its own too and weighs both: the density may then be 0
  /// where little light comes from.  [Karlik19]
  bool incomplete = false;

  Receiver() = default;
  // NOLINTNEXTLINE(google-explicit-constructor): a point is a receiver that says no more.
  Receiver(const Vec3<Real>& position) : position(position) {}
  Receiver(Real x, Real y, Real z) : position(x, y, z) {}
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

/// One ray that leaves a light.  The light's power is the mean over samples of
///   value |n.direction| / (pdf_position pdf_direction)
/// where a light without a surface has no cosine, and a density of 0 (of what is certain) is left
/// out.
template <std::floating_point Real>
struct EmissionSample {
  /// Radiance [cd/m2]; of a light that shines from one point luminous intensity [cd]; of one that
  /// shines in one direction illuminance on a surface that faces it [lx].  Finite, not negative, 0
  /// unless `reason` is kNone.
  Rgb<Real> value;
  Vec3<Real> origin;     ///< about the scene's origin [m]
  Vec3<Real> direction;  ///< unit, away from the light
  Vec3<Real> normal;     ///< of the surface, unit, as LightSample has it; zero where there is none
  AreaPdf<Real> pdf_position;         ///< 0 where the position is certain
  SolidAnglePdf<Real> pdf_direction;  ///< 0 where the direction is certain
  std::uint32_t primitive{};          ///< of the light's shape, as LightSample has it
  NoLight reason = NoLight::kNone;
};

/// The densities of an EmissionSample.
template <std::floating_point Real>
struct EmissionPdf {
  AreaPdf<Real> position;
  SolidAnglePdf<Real> direction;
  bool operator==(const EmissionPdf&) const = default;
};

/// A point of a light's own surface, as sampling or a ray found it.
template <std::floating_point Real>
struct SurfacePoint {
  Vec3<Real> position;  ///< about the scene's origin [m]
  Vec3<Real> normal;    ///< geometric, unit, on the emitting side of a one-sided light
  std::uint32_t primitive{};
};

/// A power with what is known of it.  Exact is a closed form of the light as its type holds it:
/// what double rounds in working it out, 1e-12 of it or less, is left out of the error.
/// Scene-dependent for distant and infinite lights: the flux through the disk of radius
/// `SceneSphere::radius_m` that faces the light.
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
