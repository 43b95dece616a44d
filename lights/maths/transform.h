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
  static Transform translate(const Vec3<double>& t);
  /// No factor may be 0.
  static std::optional<Transform> scale(const Vec3<double>& s);
  /// By `angle_rad` about `axis`, which is not zero; counter-clockwise seen against the axis.
  static std::optional<Transform> rotate(double angle_rad, const Vec3<double>& axis);
  /// World from camera: left-handed, +z towards `look`, +y up, as in .pbrt files.  Nothing where
  /// `eye` is `look` or `up` is parallel to their difference.
  static std::optional<Transform> look_at(const Vec3<double>& eye, const Vec3<double>& look,
                                          const Vec3<double>& up);

  /// `a * b` applies `b` first.
  Transform operator*(const Transform& b) const;
  Transform inverse() const;
  /// `translate(-origin) * *this`, with the inverse computed from the product.  The product of both
  /// inverses would have the rounding error of the distance to `origin`.
  Transform about(const Vec3<double>& origin) const;

  Vec3<double> point(const Vec3<double>& p) const;
  Vec3<double> vector(const Vec3<double>& v) const;
  /// Normals transform by the inverse transpose; the length changes.
  Vec3<double> normal(const Vec3<double>& n) const;

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
inline Frame<double> axes_of(const Transform& map) {
  return {map.vector({1, 0, 0}), map.vector({0, 1, 0}), map.vector({0, 0, 1})};
}

}  // namespace lucerna
