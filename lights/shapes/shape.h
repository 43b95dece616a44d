// Types and functions that the shapes of area lights share, including the conversion of densities
// from area to solid angle.
//
// Shapes store their numbers in `double` or double and compute in double.  A point is rounded to
// `double` first, and its density belongs to the rounded point.  So a sample's density has the same
// bits as a later call of `pdf` for its point.
#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "lights/sampling/light_sample.h"

namespace lucerna {

/// A sampled point and the density of its direction from the receiver.
struct ShapeSample {
  SurfacePoint point;
  SolidAnglePdf pdf;  ///< not positive or not finite: no direction exists for this point
  /// From the receiver to the point before rounding.  Zero: the difference of the positions is as
  /// exact.  Close to the light, rounding moves the point by more than its distance.
  Vec3 to_point{};
};

/// The same for a primitive of a mesh.
struct ChosenPoint {
  SurfacePoint point;
  SolidAnglePdf pdf;
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
/// The same in `double`.
inline SolidAnglePdf as_seen_from(const Vec3& receiver, const SurfacePoint& point, AreaPdf pdf) {
  return {pdf_seen_from(receiver, point, pdf).per_sr};
}
inline SolidAnglePdf as_seen_from(const Vec3& receiver, const SurfacePoint& point, AreaPdf pdf,
                                  double height) {
  return {pdf_seen_from(receiver, point, pdf, height).per_sr};
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

/// A band across a picture from side to side, in shares of its height, which add up to 1. All three
/// are stored, because differences would lose digits for thin bands.
struct Band {
  double above, height, below;
};

/// The part of a surface's area that a band of its picture covers.
struct BandArea {
  double share;  ///< of the whole
  double tilt;   ///< integral over the band, in shares, of a weight from -1 at its top to 1 at its
                 ///< bottom
};

/// The box {lower, upper}, wider by a rounding on each side.
inline std::pair<Vec3, Vec3> rounded_outwards(const Vec3& lower, const Vec3& upper) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const auto down = [](double v) { return std::nextafter(v, -kInfinity); };
  const auto up = [](double v) { return std::nextafter(v, kInfinity); };
  return {{down(lower.x), down(lower.y), down(lower.z)}, {up(upper.x), up(upper.y), up(upper.z)}};
}

}  // namespace lucerna
