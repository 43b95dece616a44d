// Affine matrices that may have no inverse, as nodes may.
#pragma once

#include <array>
#include <vector>

#include "lights/maths/transform.h"

namespace lucerna::gltf {

using Matrix = Transform::Matrix;

inline constexpr Matrix kIdentity{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};

/// `a * b` applies `b` first.
Matrix multiply(const Matrix& a, const Matrix& b);
Vec3 point(const Matrix& m, const Vec3& p);
Vec3 vector(const Matrix& m, const Vec3& v);

using Quaternion = std::array<double, 4>;  ///< x, y, z, w, as in glTF

/// Translation, rotation and scale, in this order from the left.  The quaternion has any length
/// but 0.
Matrix from_parts(const Vec3& translation, const Quaternion& rotation, const Vec3& scale);

/// The first 12 of 16 numbers by columns, without the row (0, 0, 0, 1).
Matrix from_columns(const double* columns);

/// Position and orthogonal unit axes of a frame, without its scale and shear: z keeps its
/// direction.  Right-handed.  Identity axes where they have no direction.
Matrix without_scale(const Matrix& m);

}  // namespace lucerna::gltf
