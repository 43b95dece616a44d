// Vectors of three components.  The name of a Vec3 says whether it is a point, a direction or a
// normal, and its frame (`wi_world`, `n_light`).  Computations use double.  Embree, stored pictures
// and messages use float.
#pragma once

#include <bit>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <limits>
#include <numbers>

namespace lucerna {

inline constexpr double kPi = std::numbers::pi;

/// A point of the unit square: two sample values in [0, 1), or surface coordinates.
template <std::floating_point T>
struct BasicVec2 {
  T x{}, y{};
  bool operator==(const BasicVec2&) const = default;
};

template <std::floating_point T>
struct BasicVec3 {
  T x{}, y{}, z{};

  BasicVec3() = default;
  // Not defaulted, although this costs triviality.  GCC 12 copies 16 bytes at once.  Loading bytes
  // that were just stored in parts waits until all of them are in the cache, which takes as long as
  // a square root.
  constexpr BasicVec3(const BasicVec3& v) : x(v.x), y(v.y), z(v.z) {}
  constexpr BasicVec3& operator=(const BasicVec3& v) {
    x = v.x, y = v.y, z = v.z;
    return *this;
  }
  ~BasicVec3() = default;
  constexpr BasicVec3(T x, T y, T z) : x(x), y(y), z(z) {}
  template <std::floating_point Other>
  constexpr explicit BasicVec3(const BasicVec3<Other>& v)
      : x(static_cast<T>(v.x)), y(static_cast<T>(v.y)), z(static_cast<T>(v.z)) {}

  bool operator==(const BasicVec3&) const = default;
  T operator[](int axis) const { return axis == 0 ? x : axis == 1 ? y : z; }

  BasicVec3 operator-() const { return {-x, -y, -z}; }
  BasicVec3 operator+(const BasicVec3& v) const { return {x + v.x, y + v.y, z + v.z}; }
  BasicVec3 operator-(const BasicVec3& v) const { return {x - v.x, y - v.y, z - v.z}; }
  BasicVec3 operator*(T s) const { return {x * s, y * s, z * s}; }
  BasicVec3 operator/(T s) const { return {x / s, y / s, z / s}; }
  BasicVec3& operator+=(const BasicVec3& v) { return *this = *this + v; }
};

template <std::floating_point T>
BasicVec3<T> operator*(T s, const BasicVec3<T>& v) {
  return v * s;
}

template <std::floating_point T>
T dot(const BasicVec3<T>& a, const BasicVec3<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

template <std::floating_point T>
BasicVec3<T> cross(const BasicVec3<T>& a, const BasicVec3<T>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Largest absolute component; NaN components do not count, and 0 where all are NaN.
template <std::floating_point T>
T max_abs(const BasicVec3<T>& v) {
  // With this order of operands it usually compiles to x86's own maximum. std::fmax is a call, and
  // a branch here is unpredictable.
  const auto larger = [](T a, T most) { return a > most ? a : most; };
  return larger(std::fabs(v.x), larger(std::fabs(v.y), larger(std::fabs(v.z), 0)));
}

template <std::floating_point T>
bool is_finite(const BasicVec3<T>& v) {
  // Usually one comparison: a sum is finite only where all terms are, but may overflow.
  if (std::isfinite(v.x + v.y + v.z)) [[likely]]
    return true;
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// The relative rounding of input from rays and requests, which are floats.
/// Positions and directions may be off by this, relative to their largest coordinate.
inline constexpr double kInputRounding = std::numeric_limits<float>::epsilon();

/// std::ilogb of a finite number > 0; without a call for normal numbers.
inline int exponent_of(double x) {
  const auto biased = static_cast<int>(std::bit_cast<std::uint64_t>(x) >> 52);
  return biased > 0 ? biased - 1023 : std::ilogb(x);
}

/// Whether 2^exponent is a normal double.
inline bool is_normal_power(int exponent) { return exponent >= -1022 && exponent <= 1023; }

/// 2^exponent, which must be a normal double.
inline double power_of_two(int exponent) {
  return std::bit_cast<double>(static_cast<std::uint64_t>(exponent + 1023) << 52);
}

/// `x` times 2^exponent: the bits of std::scalbn, usually without a call.
inline double scaled(double x, int exponent) {
  return is_normal_power(exponent) ? x * power_of_two(exponent) : std::scalbn(x, exponent);
}

/// The same for a vector.
template <std::floating_point T>
BasicVec3<T> scaled(const BasicVec3<T>& v, int exponent) {
  if constexpr (sizeof(T) == sizeof(double)) {
    if (is_normal_power(exponent)) return v * power_of_two(exponent);
  }
  return {std::scalbn(v.x, exponent), std::scalbn(v.y, exponent), std::scalbn(v.z, exponent)};
}

/// The smallest sum of squares whose rounding does not change if terms underflow.
template <std::floating_point T>
inline constexpr T kSafeSquare = std::numeric_limits<T>::min() /
                                 (std::numeric_limits<T>::epsilon() *
                                  std::numeric_limits<T>::epsilon());

template <std::floating_point T>
bool is_safe_square(T squared) {
  return squared >= kSafeSquare<T> && squared <= std::numeric_limits<T>::max();
}

/// length() where the square is not safe.  Not inlined, so that the common case can be.
template <std::floating_point T>
[[gnu::noinline]] T scaled_length(const BasicVec3<T>& v) {
  const T largest = max_abs(v);
  if (!(largest > 0) || !is_finite(v)) return std::fabs(v.x) + std::fabs(v.y) + std::fabs(v.z);
  const int exponent = std::ilogb(largest);
  const BasicVec3<T> s = scaled(v, -exponent);
  return std::scalbn(std::sqrt(dot(s, s)), exponent);
}

/// normalized() of a vector that is not zero and whose square is not safe.  Not inlined either.
template <std::floating_point T>
[[gnu::noinline]] BasicVec3<T> scaled_direction(const BasicVec3<T>& v) {
  if (!is_finite(v)) return v * std::numeric_limits<T>::quiet_NaN();
  const BasicVec3<T> s = scaled(v, -std::ilogb(max_abs(v)));
  return s / std::sqrt(dot(s, s));
}

/// Euclidean length. Squares of any float fit a double; a double is scaled by a power of two first.
/// So no square overflows or underflows, and scaling by 2^k changes only the exponent of the
/// result.
template <std::floating_point T>
T length(const BasicVec3<T>& v) {
  if constexpr (sizeof(T) < sizeof(double)) {
    const BasicVec3<double> wide(v);
    return static_cast<T>(std::sqrt(dot(wide, wide)));
  } else {
    // Uses the plain sum if it cannot overflow and lost terms are too small to change its rounding.
    // It has the same bits at a tenth of the cost.
    const T squared = dot(v, v);
    return is_safe_square(squared) ? std::sqrt(squared) : scaled_length(v);
  }
}

/// `v` divided by its length.  Zero where `v` is zero, NaN where `v` is not finite.
template <std::floating_point T>
BasicVec3<T> normalized(const BasicVec3<T>& v) {
  if (v == BasicVec3<T>{}) return {};
  if constexpr (sizeof(T) < sizeof(double)) {
    const BasicVec3<double> wide(v);
    return BasicVec3<T>(wide * (1 / std::sqrt(dot(wide, wide))));
  } else {
    // As in `length`.
    const T squared = dot(v, v);
    return is_safe_square(squared) ? v / std::sqrt(squared) : scaled_direction(v);
  }
}

/// An orthonormal right-handed frame (s, t, n).
template <std::floating_point T>
struct BasicFrame {
  BasicVec3<T> s, t, n;

  /// Any frame about the unit vector `n`.  [Duff17]
  static BasicFrame around(const BasicVec3<T>& n) {
    const T sign = std::copysign(T(1), n.z);
    const T a = -1 / (sign + n.z);
    const T b = n.x * n.y * a;
    return {{1 + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}, n};
  }

  BasicVec3<T> world_from_local(const BasicVec3<T>& v) const { return s * v.x + t * v.y + n * v.z; }
  BasicVec3<T> local_from_world(const BasicVec3<T>& v) const {
    return {dot(v, s), dot(v, t), dot(v, n)};
  }
};

using Vec2 = BasicVec2<double>;
using Vec2f = BasicVec2<float>;
using Vec3 = BasicVec3<double>;
using Vec3f = BasicVec3<float>;
using Frame = BasicFrame<double>;
using Framef = BasicFrame<float>;

}  // namespace lucerna
