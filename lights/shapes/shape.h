// The interface of shapes: what an area light needs from its shape.  Also types and functions that
// shapes share.  lights/shapes/all_shapes.h lists the shapes.
//
// A sample's density has the same bits as a later call of `pdf` for its point.
#pragma once

#include <absl/functional/function_ref.h>
#include <absl/status/status.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include "lights/maths/normal_cone.h"
#include "lights/pictures/image_distribution.h"
#include "lights/sampling/light_sample.h"
#include "lights/shapes/shape_picture.h"

namespace lucerna {

/// A sampled point and the density of its direction from the receiver.
struct ShapeSample {
  SurfacePoint point;
  SolidAnglePdf pdf;  ///< not positive or not finite: no direction exists for this point
  /// From the receiver to the point before rounding.  Zero: the difference of the positions is as
  /// exact.  Close to the light, rounding moves the point by more than its distance.
  Vec3 to_point{};
};

/// Where a ray meets a shape.
struct ShapeHit {
  double t{};  ///< along the ray, in units of its direction
  SurfacePoint point;
};

/// All the places where a ray meets a surface of second order, by increasing t.
struct ShapeHits {
  std::array<ShapeHit, 2> hit;
  int count = 0;

  void add(double t, const SurfacePoint& point) { hit[count++] = {t, point}; }
};

/// A shape that can be an area light.  Positions are about the scene's origin [m].  Immutable, so
/// safe to share between threads.
class Shape {
 public:
  virtual ~Shape() = default;

  /// The area, and a bound on its error, 0 where it is exact [m2].
  virtual double area() const = 0;
  virtual double area_error_m2() const = 0;
  /// OK where the shape can carry a light.
  virtual absl::Status emissive_error() const = 0;
  /// How many primitives it has.
  virtual std::size_t size() const = 0;
  /// Its memory, with its vectors.
  virtual std::size_t bytes() const = 0;

  /// A point seen from `receiver`, chosen in the way that it requests.
  virtual ShapeSample sample(const Receiver& receiver, Vec2 u) const = 0;
  /// The density of `sample` at a point of the shape.
  virtual SolidAnglePdf pdf(const Receiver& receiver, const SurfacePoint& point) const = 0;
  /// The density of points chosen by area.
  virtual AreaPdf pdf_area(const SurfacePoint& point) const = 0;

  /// Calls `f` with each point of the shape along the unit vector `wi`.
  virtual void for_each_hit(const Vec3& position, const Vec3& wi,
                            absl::FunctionRef<void(const SurfacePoint&)> f) const = 0;
  /// Whether a position lies on a primitive; of flat ones, one that sees it edge-on.
  virtual bool touches(const Vec3& position, std::uint32_t primitive) const = 0;
  /// How far a position is above the plane of the primitive of `point`.  None for curved ones.
  virtual std::optional<double> height_over(const SurfacePoint& point,
                                            const Vec3& position) const = 0;
  /// A bound on the height of its points over the plane through `p` with the unit normal `n` [m].
  virtual double height_above(const Vec3& p, const Vec3& n) const = 0;
  /// The point at `position`, if there is one to within rounding and `slack_m`; the normal that
  /// this finds at the position of `point`, on its primitive.
  virtual std::optional<SurfacePoint> locate(const Vec3& position, double slack_m) const = 0;
  virtual Vec3 located_normal(const SurfacePoint& point, double slack_m) const = 0;
  /// A cone with all normals, and the box {lower, upper}.
  virtual NormalCone normals() const = 0;
  virtual std::pair<Vec3, Vec3> bounds() const = 0;

  /// Whether `projected_solid_angle_sr` may have a closed form, and whether that is fast.
  virtual bool has_closed_form() const = 0;
  virtual bool has_fast_closed_form() const = 0;
  /// The projected solid angle [sr] of all sides that emit towards `position`, above the horizon of
  /// the unit vector `normal`, without occlusion between primitives.  Nothing without closed form.
  virtual std::optional<double> projected_solid_angle_sr(const Vec3& position, const Vec3& normal,
                                                         bool two_sided) const = 0;
  /// Whether a part of it may occlude another, if it has a closed form.
  virtual bool hides_itself() const = 0;

  /// The (u, v) of a picture at a point of the shape.
  virtual Vec2 uv(const SurfacePoint& point) const = 0;
  /// The integral of a picture over the shape.
  virtual PaintedArea painted_area(const Picture& picture) const = 0;
  /// From which the next two choose points by a picture's luminance, for
  /// - disks and spheres, up to the curvature within a row of texels, and cylinders;
  /// - meshes of unfolded patches that each show the whole picture, in (u, v);
  /// - two triangles that show the whole picture together.
  /// None for others and for black pictures: choose points as if there were no picture.
  virtual std::optional<ImageDistribution> distribution(const Picture& picture) const = 0;
  virtual SurfacePoint sample_picture(const Picture& picture, const ImageDistribution& distribution,
                                      Vec2 u) const = 0;
  /// The density, which is exact in every case.
  virtual AreaPdf pdf_picture(const Picture& picture, const ImageDistribution& distribution,
                              const SurfacePoint& point) const = 0;

 protected:
  Shape() = default;
  Shape(const Shape&) = default;
  Shape& operator=(const Shape&) = default;
};

/// `distribution`, or nothing if it is that of a black picture, which may show at any point.
inline std::optional<ImageDistribution> if_not_black(ImageDistribution distribution) {
  if (!(distribution.integral() > 0)) return std::nullopt;
  return distribution;
}

/// The density by solid angle at `receiver` for a `point` with the density `pdf` by area. Infinite
/// if the receiver is in the plane of the point.  0 if the receiver is the point or not finite.
inline SolidAnglePdf pdf_seen_from(const Vec3& receiver, const SurfacePoint& point, AreaPdf pdf) {
  const Vec3 to_receiver = receiver - point.position;
  const double distance = length(to_receiver);
  if (!(distance > 0) || !std::isfinite(distance)) return {0};
  const double cos_light = std::fabs(dot(point.normal, to_receiver)) / distance;
  return to_solid_angle(pdf, distance, cos_light);
}
/// The same for a flat shape with the receiver at `height` above its plane, to either side.  Close
/// to the plane, a height from the rounded point would not be exact enough.
inline SolidAnglePdf pdf_seen_from(const Vec3& receiver, const SurfacePoint& point, AreaPdf pdf,
                                   double height) {
  const double distance = length(receiver - point.position);
  if (!(distance > 0) || !std::isfinite(distance)) return {0};
  return to_solid_angle(pdf, distance, std::fabs(height) / distance);
}
/// The weight of a light's corner in kCosineSolidAngle.  `to_corner` starts at a receiver with
/// `normal`.
inline double cosine_weight(const Vec3& normal, const Vec3& to_corner) {
  return std::fmax(kCosineFloor, dot(normalized(to_corner), normal));
}

inline constexpr double kTurnRad = 2 * std::numbers::pi;

/// The angle of `p` about +z from +x, in [0, 2 pi].
inline double azimuth(const Vec3& p) {
  const double phi = std::atan2(p.y, p.x);
  return phi < 0 ? phi + kTurnRad : phi;
}
/// Whether a sweep of `phi_max_rad` about +z from +x contains `p`.
inline bool is_swept(const Vec3& p, double phi_max_rad) {
  return !(phi_max_rad < kTurnRad) || azimuth(p) <= phi_max_rad;
}
/// Whether an angle outside of the sweep is nearer to its last edge than to its first.
inline bool is_nearer_to_last(double azimuth_rad, double phi_max_rad) {
  return azimuth_rad - phi_max_rad < kTurnRad - azimuth_rad;
}
/// `p` if the sweep contains it.  Else the point of the nearer edge at the same height and distance
/// from the axis.
inline Vec3 nearest_swept(const Vec3& p, double phi_max_rad) {
  if (is_swept(p, phi_max_rad)) return p;
  const double edge = is_nearer_to_last(azimuth(p), phi_max_rad) ? phi_max_rad : 0;
  const double across = std::hypot(p.x, p.y);
  return {across * std::cos(edge), across * std::sin(edge), p.z};
}
/// The angle of `p` as a share of a sweep.  If rounding leads out of the sweep: the share of the
/// nearer edge.
inline double share_of_sweep(const Vec3& p, double phi_max_rad) {
  const double phi = azimuth(p);
  if (phi <= phi_max_rad) return phi / phi_max_rad;
  return is_nearer_to_last(phi, phi_max_rad) ? 1 : 0;
}

/// The box {lower, upper}, wider by a rounding on each side.
inline std::pair<Vec3, Vec3> rounded_outwards(const Vec3& lower, const Vec3& upper) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const auto down = [](double v) { return std::nextafter(v, -kInfinity); };
  const auto up = [](double v) { return std::nextafter(v, kInfinity); };
  return {{down(lower.x), down(lower.y), down(lower.z)}, {up(upper.x), up(upper.y), up(upper.z)}};
}

}  // namespace lucerna
