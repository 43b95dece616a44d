#include "lights/maths/transform.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lucerna {
namespace {

using Matrix = Transform::Matrix;

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

/// The linear part with rows and columns scaled by powers of two until their largest entries are
/// about 1: m[i][j] = 2^row[i] b[i][j] 2^column[j].  The determinant then does not overflow or
/// underflow for scales of 1e-200, and its size shows how near to singular the map is.
struct Balanced {
  std::array<std::array<double, 3>, 3> b;
  std::array<int, 3> row{}, column{};
};

std::optional<Balanced> balance(const Matrix& m) {
  Balanced result;
  for (int i = 0; i < 3; ++i) {
    const double largest = max_abs(Vec3{m[i][0], m[i][1], m[i][2]});
    if (!(largest > 0) || !std::isfinite(largest)) return std::nullopt;
    result.row[i] = std::ilogb(largest);
    for (int j = 0; j < 3; ++j) result.b[i][j] = std::scalbn(m[i][j], -result.row[i]);
  }
  for (int j = 0; j < 3; ++j) {
    auto& b = result.b;
    const double largest = max_abs(Vec3{b[0][j], b[1][j], b[2][j]});
    if (!(largest > 0)) return std::nullopt;
    result.column[j] = std::ilogb(largest);
    for (int i = 0; i < 3; ++i) b[i][j] = std::scalbn(b[i][j], -result.column[j]);
  }
  return result;
}

double cofactor(const Balanced& m, int i, int j) {
  // Cyclic indices carry the alternating sign.
  const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
  return m.b[i1][j1] * m.b[i2][j2] - m.b[i1][j2] * m.b[i2][j1];
}

double determinant(const Balanced& m) {
  double sum = 0;
  for (int j = 0; j < 3; ++j) sum += m.b[0][j] * cofactor(m, 0, j);
  return sum;
}

/// The sum of the absolute values of the determinant's products.  The determinant's rounding error
/// is relative to it.
double permanent_of_absolutes(const Balanced& m) {
  const auto a = [&](int i, int j) { return std::fabs(m.b[i][j]); };
  double sum = 0;
  for (int j = 0; j < 3; ++j) {
    const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
    sum += a(0, j) * (a(1, j1) * a(2, j2) + a(1, j2) * a(2, j1));
  }
  return sum;
}

std::optional<Matrix> inverse_of(const Matrix& m) {
  for (const auto& row : m) {
    for (const double entry : row) {
      if (!std::isfinite(entry)) return std::nullopt;
    }
  }
  const auto balanced = balance(m);
  if (!balanced) return std::nullopt;
  const double det = determinant(*balanced);
  // Five roundings for each product: a smaller determinant may be 0 in truth.
  if (!(std::fabs(det) > 5 * kEpsilon * permanent_of_absolutes(*balanced))) return std::nullopt;
  Matrix inverse;
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 3; ++i) {
      inverse[j][i] =
          std::scalbn(cofactor(*balanced, i, j) / det, -balanced->row[i] - balanced->column[j]);
    }
    inverse[j][3] = -(inverse[j][0] * m[0][3] + inverse[j][1] * m[1][3] + inverse[j][2] * m[2][3]);
    for (const double entry : inverse[j]) {
      if (!std::isfinite(entry)) return std::nullopt;
    }
  }
  return inverse;
}

Matrix product(const Matrix& a, const Matrix& b) {
  Matrix c;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 4; ++j) {
      c[i][j] = a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j] + (j == 3 ? a[i][3] : 0);
    }
  }
  return c;
}

Vec3 column(const Matrix& m, int j) { return {m[0][j], m[1][j], m[2][j]}; }

}  // namespace

Transform::Transform() : m_{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}}, inverse_{m_} {}

std::optional<Transform> Transform::from_matrix(const Matrix& m) {
  const auto inverse = inverse_of(m);
  if (!inverse) return std::nullopt;
  return Transform(m, *inverse);
}

Transform Transform::translate(const Vec3& t) {
  return {{{{1, 0, 0, t.x}, {0, 1, 0, t.y}, {0, 0, 1, t.z}}},
          {{{1, 0, 0, -t.x}, {0, 1, 0, -t.y}, {0, 0, 1, -t.z}}}};
}

std::optional<Transform> Transform::scale(const Vec3& s) {
  return from_matrix({{{s.x, 0, 0, 0}, {0, s.y, 0, 0}, {0, 0, s.z, 0}}});
}

std::optional<Transform> Transform::rotate(double angle_rad, const Vec3& axis) {
  const double axis_length = length(axis);
  if (!(axis_length > 0) || !std::isfinite(axis_length) || !std::isfinite(angle_rad)) {
    return std::nullopt;
  }
  const Vec3 a = normalized(axis);
  const double sin = std::sin(angle_rad);
  const double cos = std::cos(angle_rad);
  const double half_sin = std::sin(angle_rad / 2);
  const double one_minus_cos = 2 * half_sin * half_sin;
  const auto entry = [&](double ai, double aj) { return ai * aj * one_minus_cos; };
  const Matrix m{
      {{cos + entry(a.x, a.x), entry(a.x, a.y) - a.z * sin, entry(a.x, a.z) + a.y * sin, 0},
       {entry(a.y, a.x) + a.z * sin, cos + entry(a.y, a.y), entry(a.y, a.z) - a.x * sin, 0},
       {entry(a.z, a.x) - a.y * sin, entry(a.z, a.y) + a.x * sin, cos + entry(a.z, a.z), 0}}};
  Matrix transposed{};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) transposed[i][j] = m[j][i];
  }
  return Transform(m, transposed);
}

std::optional<Transform> Transform::look_at(const Vec3& eye, const Vec3& look, const Vec3& up) {
  if (!is_finite(eye) || !is_finite(look) || !is_finite(up)) return std::nullopt;
  const Vec3 forward = normalized(look - eye);
  const Vec3 side = cross(normalized(up), forward);
  // A sine of a few roundings: the vectors are parallel, and their product has no direction.
  if (!(length(side) > 4 * kEpsilon)) return std::nullopt;
  const Vec3 right = normalized(side);
  const Vec3 above = cross(forward, right);
  return from_matrix({{{right.x, above.x, forward.x, eye.x},
                       {right.y, above.y, forward.y, eye.y},
                       {right.z, above.z, forward.z, eye.z}}});
}

Transform Transform::operator*(const Transform& b) const {
  return {product(m_, b.m_), product(b.inverse_, inverse_)};
}

Transform Transform::inverse() const { return {inverse_, m_}; }

Transform Transform::about(const Vec3& origin) const {
  const Transform product = translate(-origin) * *this;
  return from_matrix(product.m_).value_or(product);
}

Vec3 Transform::point(const Vec3& p) const { return vector(p) + column(m_, 3); }

Vec3 Transform::vector(const Vec3& v) const {
  return {m_[0][0] * v.x + m_[0][1] * v.y + m_[0][2] * v.z,
          m_[1][0] * v.x + m_[1][1] * v.y + m_[1][2] * v.z,
          m_[2][0] * v.x + m_[2][1] * v.y + m_[2][2] * v.z};
}

Vec3 Transform::normal(const Vec3& n) const {
  return {dot(column(inverse_, 0), n), dot(column(inverse_, 1), n), dot(column(inverse_, 2), n)};
}

bool Transform::swaps_handedness() const {
  const auto balanced = balance(m_);
  return balanced && determinant(*balanced) < 0;
}

std::optional<double> Transform::uniform_scale() const {
  constexpr double kTolerance = 1e-6;
  const std::array<Vec3, 3> axes{column(m_, 0), column(m_, 1), column(m_, 2)};
  std::array<double, 3> lengths{length(axes[0]), length(axes[1]), length(axes[2])};
  for (int i = 0; i < 3; ++i) {
    if (std::fabs(dot(normalized(axes[i]), normalized(axes[(i + 1) % 3]))) > kTolerance) {
      return std::nullopt;
    }
  }
  std::sort(lengths.begin(), lengths.end());
  if (lengths[2] - lengths[0] > kTolerance * lengths[1]) return std::nullopt;
  // For three equal lengths, the middle one keeps their exact value.  A mean would round it.
  return lengths[1];
}

}  // namespace lucerna
