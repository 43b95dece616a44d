#include "server/gltf/matrix.h"

#include <cmath>

namespace lucerna::gltf {

Matrix multiply(const Matrix& a, const Matrix& b) {
  Matrix result{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 4; ++j) {
      result[i][j] = j == 3 ? a[i][3] : 0;
      for (std::size_t k = 0; k < 3; ++k) result[i][j] += a[i][k] * b[k][j];
    }
  }
  return result;
}

Vec3 vector(const Matrix& m, const Vec3& v) {
  const auto row = [&](std::size_t i) { return m[i][0] * v.x + m[i][1] * v.y + m[i][2] * v.z; };
  return {row(0), row(1), row(2)};
}

Vec3 point(const Matrix& m, const Vec3& p) {
  return vector(m, p) + Vec3{m[0][3], m[1][3], m[2][3]};
}

Matrix from_parts(const Vec3& translation, const Quaternion& rotation, const Vec3& scale) {
  const double size = std::sqrt(rotation[0] * rotation[0] + rotation[1] * rotation[1] +
                                rotation[2] * rotation[2] + rotation[3] * rotation[3]);
  const double x = rotation[0] / size, y = rotation[1] / size, z = rotation[2] / size,
               w = rotation[3] / size;
  const double r[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                          {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                          {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
  Matrix m{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) m[i][j] = r[i][j] * scale[static_cast<int>(j)];
    m[i][3] = translation[static_cast<int>(i)];
  }
  return m;
}

Matrix from_columns(const double* columns) {
  Matrix m{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 4; ++j) m[i][j] = columns[4 * j + i];
  return m;
}

Matrix without_scale(const Matrix& m) {
  const auto column = [&](std::size_t j) { return Vec3{m[0][j], m[1][j], m[2][j]}; };
  const auto has_direction = [](const Vec3& v) { return is_finite(v) && max_abs(v) > 0; };
  Vec3 z = normalized(column(2));
  Vec3 x = normalized(cross(column(1), z));
  if (!has_direction(z) || !has_direction(x)) {
    x = {1, 0, 0};
    z = {0, 0, 1};
  }
  const Vec3 y = cross(z, x);
  return {{{x.x, y.x, z.x, m[0][3]}, {x.y, y.y, z.y, m[1][3]}, {x.z, y.z, z.z, m[2][3]}}};
}

}  // namespace lucerna::gltf
