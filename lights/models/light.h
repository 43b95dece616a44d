// The interface of all lights: what a light owes, on one page.  lights/models/all_lights.h lists
// the kinds.  A light is immutable, so safe to share between threads.
#pragma once

#include <cstdint>
#include <numbers>
#include <optional>

#include "lights/maths/bounds.h"
#include "lights/models/light_bounds.h"
#include "lights/models/light_mover.h"
#include "lights/sampling/light_sample.h"

namespace lucerna {

class Image;
class IntensityMap;
class PhotometricWeb;
struct LightParams;  // lights/models/all_lights.h

/// Where a light without a surface is.
struct LightPlace {
  /// A point of the light or of its portal [m, world].  Coordinates near it are small.  None for
  /// lights that have only directions.
  std::optional<Vec3> anchor_m{};
  /// The smallest box around the points where its rays start.  None for lights at infinity.
  std::optional<Bounds> box_m{};
  /// The smallest box around its portal.
  std::optional<Bounds> portal_m{};
};

/// Memory of one light [bytes].  Data of SharedData are not counted.
struct LightBytes {
  std::uint64_t object = 0;  ///< the light itself
  std::uint64_t data = 0;    ///< beside it
  std::uint64_t tables = 0;  ///< the part of `data` from which points and directions are drawn
};

/// Data that other lights may share; null: none.
struct SharedData {
  const Image* image = nullptr;
  const PhotometricWeb* web = nullptr;
  const IntensityMap* map = nullptr;

  bool empty() const { return image == nullptr && web == nullptr && map == nullptr; }
};

/// Upper bounds of the illuminance at a receiver, or of the spherical illuminance if it has no
/// normal.  `lx` is 0 only where certainly no light arrives.
struct MostIrradiance {
  double lx = 0;
  /// Of one sample of `sample_li`: its value times the cosine, divided by the density.  Infinite if
  /// no bound is known.
  double sample_lx = 0;
};

/// What the members of a light can return.
struct LightTraits {
  bool is_delta = false;        ///< no density exists for its directions
  bool has_surface = false;     ///< rays may hit it: `le`, `ray_from` and `pdf_li` of a point
  bool is_seen_beyond = false;  ///< rays meet it when they leave the scene: `le_escaped`
  bool leaves_freely = false;   ///< no surface, and `le_leaving` depends on start and direction
  bool has_irradiance = false;  ///< `irradiance` may have a closed form
};

/// A light.  Positions are about the scene's origin [m], directions are unit vectors in world axes
/// unless a member says otherwise.  `slack_m`: how far rounding may have moved a position off the
/// light, in addition to the rounding to `double`; lights that do not compare places ignore it.
class Light {
 public:
  virtual ~Light() = default;

  const LightTraits& traits() const { return traits_; }
  bool is_delta() const { return traits_.is_delta; }
  bool has_surface() const { return traits_.has_surface; }
  bool is_seen_beyond() const { return traits_.is_seen_beyond; }
  bool leaves_freely() const { return traits_.leaves_freely; }
  bool has_irradiance() const { return traits_.has_irradiance; }

  /// Light that arrives at `receiver` without occlusion, from a direction drawn with `u`; or the
  /// reason why there is none.
  virtual LightSample sample_li(const Receiver& receiver, Vec2 u) const = 0;
  /// The density with which `sample_li` chooses the direction `wi` [1/sr]; 0 for delta lights.
  virtual SolidAnglePdf pdf_li(const Receiver& receiver, const Vec3& wi) const = 0;
  /// The density with which it chooses a point of the surface [1/sr]; 0 without a surface.
  virtual SolidAnglePdf pdf_li(const Receiver& receiver, const SurfacePoint& point) const = 0;

  /// Irradiance without occlusion on the side that `receiver` faces, in closed form [lx].  Nothing
  /// if there is no such form, or if the receiver has no normal or is not finite.  A surface, or
  /// the light itself (`hides_itself`), may block a part of it.
  virtual std::optional<Rgb> irradiance(const Receiver& receiver) const = 0;
  virtual bool hides_itself() const = 0;
  virtual MostIrradiance most_irradiance(const Receiver& receiver) const = 0;

  /// Radiance that leaves `point` of the surface towards `w` of any length [cd/m2]; 0 without a
  /// surface.
  virtual Rgb le(const SurfacePoint& point, const Vec3& w) const = 0;
  /// Radiance that a ray from `origin` meets when it leaves the scene towards `w` [cd/m2]; 0 for
  /// lights that are not seen beyond it.
  virtual Rgb le_escaped(const Vec3& origin, const Vec3& w) const = 0;
  /// The `value` of the ray of `sample_le` that leaves the light at `origin` towards `w`, in the
  /// unit of EmissionSample::value.  0 unless `leaves_freely`.
  virtual Rgb le_leaving(const Vec3& origin, const Vec3& w, double slack_m = 0) const = 0;

  /// A ray that leaves the light, drawn with two pairs of numbers in [0, 1]; or the reason why
  /// there is none.  `scene`: rays from infinity start on the disk of this sphere that faces them.
  virtual EmissionSample sample_le(Vec2 u_position, Vec2 u_direction,
                                   const SceneSphere& scene) const = 0;
  /// The ray that leaves `point` of the surface, which may be rounded, towards `w`, with the
  /// density of `sample_le`.  Empty without a surface.
  virtual EmissionSample ray_from(const SurfacePoint& point, const Vec3& w,
                                  double slack_m = 0) const = 0;
  /// The densities of `sample_le` [1/m2, 1/sr]; 0 if a position or a direction is certain or has no
  /// light.
  virtual EmissionPdf pdf_le(const Vec3& position, const Vec3& w, const SceneSphere& scene,
                             double slack_m = 0) const = 0;

  /// Luminous flux [lm] with a bound on its error.  From infinity: through the disk of `scene`.
  virtual Power power(const SceneSphere& scene) const = 0;
  /// The same by the textbook's formula; its difference to `power` is part of the error.
  virtual Power power_approximate(const SceneSphere& scene) const = 0;

  /// A box and a cone that hold all of its rays.  None at infinity.
  virtual std::optional<LightBounds> bounds() const = 0;
  /// The area that all of its flux passes through at any distance [m2].  None if illuminance falls
  /// off with distance.
  virtual std::optional<double> cross_section_m2(const SceneSphere& scene) const = 0;

  virtual LightBytes own_bytes() const = 0;
  virtual SharedData shared_data() const = 0;
  /// The parameters that it was made from.  Nothing for lights with a surface.
  virtual std::optional<LightParams> made_from() const = 0;

 protected:
  explicit Light(const LightTraits& traits) : traits_(traits) {}
  Light(const Light&) = default;
  Light& operator=(const Light&) = default;

 private:
  LightTraits traits_;
};

/// A light whose directions have no density.  Rays do not meet it.
class DeltaLight : public Light {
 public:
  SolidAnglePdf pdf_li(const Receiver&, const Vec3&) const final { return {}; }
  SolidAnglePdf pdf_li(const Receiver&, const SurfacePoint&) const final { return {}; }
  std::optional<Rgb> irradiance(const Receiver&) const final { return std::nullopt; }
  bool hides_itself() const final { return false; }
  /// Of the only sample.
  MostIrradiance most_irradiance(const Receiver& receiver) const final;
  Rgb le(const SurfacePoint&, const Vec3&) const final { return {}; }
  Rgb le_escaped(const Vec3&, const Vec3&) const final { return {}; }
  EmissionSample ray_from(const SurfacePoint&, const Vec3&, double) const final { return {}; }

 protected:
  /// `leaves_freely`: as in LightTraits.
  explicit DeltaLight(bool leaves_freely)
      : Light({.is_delta = true, .leaves_freely = leaves_freely}) {}
};

/// A light at infinity that rays meet when they leave the scene.
class LightBeyond : public Light {
 public:
  SolidAnglePdf pdf_li(const Receiver& receiver, const Vec3& wi) const override = 0;
  SolidAnglePdf pdf_li(const Receiver&, const SurfacePoint&) const final { return {}; }
  bool hides_itself() const final { return false; }
  Rgb le(const SurfacePoint&, const Vec3&) const final { return {}; }
  EmissionSample ray_from(const SurfacePoint&, const Vec3&, double) const final { return {}; }
  std::optional<LightBounds> bounds() const final { return std::nullopt; }

 protected:
  LightBeyond(bool leaves_freely, bool has_irradiance)
      : Light({.is_seen_beyond = true,
               .leaves_freely = leaves_freely,
               .has_irradiance = has_irradiance}) {}
};

/// `cross_section_m2` of lights at infinity: the disk that covers the scene's sphere.
inline double scene_disk_area_m2(const SceneSphere& scene) {
  return std::numbers::pi * scene.radius_m * scene.radius_m;
}

}  // namespace lucerna
