// A picture around the sphere of directions, and directions drawn by its luminance.
#pragma once

#include <absl/status/statusor.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "lights/maths/transform.h"
#include "lights/pictures/image.h"
#include "lights/pictures/image_distribution.h"

namespace lucerna {

/// How a picture covers the sphere.  Directions are unit vectors in the map's own axes.
enum class SphereMapping : std::uint8_t {
  /// Equal areas are equal solid angles. +z is in the middle, -z at all four corners, +x to the
  /// right, +y downwards, as in pbrt-v4.  Square pictures only.  [Clarberg08]
  kEqualArea,
  /// +y at the top.  Longitude runs to the right, from +x at the left edge through +z.  Seen from
  /// inside in a right-handed frame, the picture is not mirrored.
  kLatitudeLongitude,
};

/// The point of the closed unit square that shows the direction `w`, a unit vector.
Vec2 square_from_direction(SphereMapping mapping, const Vec3& w);
/// The unit vector at a point of the closed unit square.
Vec3 direction_from_square(SphereMapping mapping, Vec2 p);

/// Immutable, so lights share it.
class SphereMap {
 public:
  /// Errors: no image; a picture that is not square for the equal-area mapping.
  static absl::StatusOr<std::shared_ptr<const SphereMap>> create(std::shared_ptr<const Image> image,
                                                                 SphereMapping mapping,
                                                                 ImageFilter filter);

  /// The value towards the unit vector `w`.  Across seams and poles, the filter uses the texels
  /// that are neighbours on the sphere.  At the poles of a latitude-longitude picture of odd width,
  /// these are half a texel off.
  Rgb lookup(const Vec3& w) const;
  /// The value at a point of the square.
  Rgb lookup(Vec2 p) const { return image_->lookup(p, filter_, border()); }

  /// Integral of `lookup` over all directions [sr]: closed form, 4 pi for a picture of 1.
  Rgb integral() const { return integral_; }
  /// The largest value of each channel over all texels.
  Rgb brightest() const { return image_->brightest(); }

  /// A bound of the height of lit directions over the plane with the unit normal `n`, in the map's
  /// axes.  0 only if the map is black above the plane, to within 1e-12 rad.
  double lit_height(const Vec3& n) const;

  const Image& image() const { return *image_; }
  SphereMapping mapping() const { return mapping_; }
  ImageFilter filter() const { return filter_; }
  ImageBorder border() const;
  std::size_t bytes() const { return sizeof(*this) + image_->bytes(); }

 private:
  SphereMap(std::shared_ptr<const Image> image, SphereMapping mapping, ImageFilter filter);
  std::shared_ptr<const Image> image_;
  SphereMapping mapping_;
  ImageFilter filter_;
  Rgb integral_;
  /// The lowest and the highest cosine between the mapping's axis and a lit direction.
  double low_ = 1, high_ = -1;
};

/// A map's own axes in the world, of unit length and at right angles.
class MapAxes {
 public:
  /// Rotation, mirror and equal scale of `world_from_map`; its translation is not used.
  explicit MapAxes(const Transform& world_from_map);
  /// The unit direction in the map's axes; NaN where `w` is not finite.
  Vec3 map_from_world(const Vec3& w) const {
    return normalized(Vec3{dot(x_, w), dot(y_, w), dot(z_, w)});
  }
  Vec3 world_from_map(const Vec3& w) const { return x_ * w.x + y_ * w.y + z_ * w.z; }

 private:
  Vec3 x_, y_, z_;
};

/// Directions with a density that is positive wherever the map's luminance exceeds `subtract`.  For
/// the nearest filter it is proportional to the luminance, with respect to solid angle.  For the
/// bilinear filter it is linear within the strips between rows of centres.  The coordinate is the
/// square's height (equal-area) or the cosine of the polar angle (latitude-longitude).  So it stays
/// bounded at the poles.  Immutable.
class SphereDistribution {
 public:
  struct Sample {
    Vec3 direction;  ///< unit, in the map's axes
    Vec2 position;   ///< the point of the square that shows it
    double per_sr;   ///< density with respect to solid angle; 0: nothing to sample
  };

  /// By the luminance minus `subtract`, where that is positive.
  explicit SphereDistribution(const SphereMap& map, double subtract = 0);

  Sample sample(Vec2 u) const;
  double per_sr(const Vec3& w) const;
  bool empty() const { return !(squares_.integral() > 0); }
  std::size_t bytes() const { return sizeof(*this) + squares_.bytes(); }

 private:
  int row_of(double y) const;

  SphereMapping mapping_;
  ImageFilter filter_;
  int height_;
  ImageDistribution squares_;
};

}  // namespace lucerna
