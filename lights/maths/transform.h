// Affine transforms in double precision, stored with their inverse.
#pragma once

#include <array>
#include <optional>

#include "lights/maths/vec.h"

namespace lucerna {

/// An invertible affine map; `m[row][column]`, the last column is the translation.
class Transform {
 public:
  using Matrix = std::array<std::array<double, 4>, 3>;

  /// The identity.
  Transform();
  /// Nothing where `m` has no finite inverse.
  static std::optional<Transform> from_matrix(const Matrix& m);
  static Transform translate(const Vec3& t);
  /// No factor may be 0.
  static std::optional<Transform> scale(const Vec3& s);
  /// By `angle_rad` about `axis`, which is not zero; counter-clockwise seen against the axis.
  static std::optional<Transform> rotate(double angle_rad, const Vec3& axis);
  /// World from camera: left-handed, +z towards `look`, +y up, as in .pbrt files.  Nothing where
  /// `eye` is `look` or `up` is parallel to their difference.
  static std::optional<Transform> look_at(const Vec3& eye, const Vec3& look, const Vec3& up);

  /// `a * b` applies `b` first.
  Transform operator*(const Transform& b) const;
  Transform inverse() const;
  /// `translate(-origin) * *this`, with the inverse computed from the product.  The product of both
  /// inverses would have the rounding error of the distance to `origin`.
  Transform about(const Vec3& origin) const;

  Vec3 point(const Vec3& p) const;
  Vec3 vector(const Vec3& v) const;
  /// Normals transform by the inverse transpose; the length changes.
  Vec3 normal(const Vec3& n) const;

  /// True if it turns a right-handed frame into a left-handed one (a mirror).
  bool swaps_handedness() const;
  /// The common factor of all lengths, to within 1e-6 (rotations, mirrors, translations and equal
  /// scales).  Nothing for any other map.
  std::optional<double> uniform_scale() const;

  const Matrix& matrix() const { return m_; }
  bool operator==(const Transform&) const = default;

 private:
  Transform(const Matrix& m, const Matrix& inverse) : m_(m), inverse_(inverse) {}
  Matrix m_, inverse_;
};

/// The images of the coordinate axes, of any lengths.
inline Frame axes_of(const Transform& map) {
  return {map.vector({1, 0, 0}), map.vector({0, 1, 0}), map.vector({0, 0, 1})};
}

}  // namespace lucerna
