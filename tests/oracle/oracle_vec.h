// Vectors and ranges of numbers in extended precision.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <type_traits>

namespace lucerna::oracle {

/// Extended precision: 64 bits of mantissa on x86-64.
using Real = long double;

inline constexpr Real kPi = std::numbers::pi_v<Real>;

template <typename T>
struct VecOf {
  T x{}, y{}, z{};
};
using Vec = VecOf<Real>;

template <typename T>
VecOf<T> operator+(const VecOf<T>& a, const VecOf<T>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <typename T>
VecOf<T> operator-(const VecOf<T>& a, const VecOf<T>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <typename T>
VecOf<T> operator*(const VecOf<T>& a, const std::type_identity_t<T>& s) {
  return {a.x * s, a.y * s, a.z * s};
}
template <typename T>
T dot(const VecOf<T>& a, const VecOf<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <typename T>
VecOf<T> cross(const VecOf<T>& a, const VecOf<T>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Vec operator-(const Vec& a) { return {-a.x, -a.y, -a.z}; }
inline Real length(const Vec& a) { return std::sqrt(dot(a, a)); }
inline Vec unit(const Vec& a) { return a * (1 / length(a)); }
inline Vec absolute(const Vec& a) { return {std::fabs(a.x), std::fabs(a.y), std::fabs(a.z)}; }
/// A unit vector across the unit vector `n`.
inline Vec across(const Vec& n) {
  return unit(cross(std::fabs(n.x) < 0.6L ? Vec{1, 0, 0} : Vec{0, 1, 0}, n));
}

/// All numbers from `lo` to `hi`.  The rounding of extended precision is neglected: it is 2^40
/// times finer than that of the floats that ranges stand for.
struct Range {
  Real lo = 0, hi = 0;
  Range() = default;
  Range(Real x) : lo(x), hi(x) {}
  Range(Real a, Real b) : lo(a), hi(b) {}
  /// From x - reach to x + reach.
  static Range about(Real x, Real reach) { return {x - reach, x + reach}; }
  bool has(Real x) const { return lo <= x && x <= hi; }
  /// Surely in (a, b).
  bool within(Real a, Real b) const { return lo > a && hi < b; }
  /// Surely not in (a, b).
  bool apart(Real a, Real b) const { return hi <= a || lo >= b; }
};
inline Range operator+(const Range& a, const Range& b) { return {a.lo + b.lo, a.hi + b.hi}; }
inline Range operator-(const Range& a, const Range& b) { return {a.lo - b.hi, a.hi - b.lo}; }
inline Range operator-(const Range& a) { return {-a.hi, -a.lo}; }
inline Range operator*(const Range& a, const Range& b) {
  const Real p = a.lo * b.lo, q = a.lo * b.hi, r = a.hi * b.lo, s = a.hi * b.hi;
  return {std::min(std::min(p, q), std::min(r, s)), std::max(std::max(p, q), std::max(r, s))};
}
/// `b` does not hold 0.
inline Range operator/(const Range& a, const Range& b) { return a * Range{1 / b.hi, 1 / b.lo}; }
inline Range squared(const Range& a) {
  const Real p = a.lo * a.lo, q = a.hi * a.hi;
  return {a.has(0) ? 0 : std::min(p, q), std::max(p, q)};
}
/// Of the part of the range that is not negative.
inline Range root_of(const Range& a) {
  return {std::sqrt(std::max(a.lo, Real{0})), std::sqrt(std::max(a.hi, Real{0}))};
}

/// A box of points.
using Box = VecOf<Range>;
inline Box box_about(const Vec& middle, const Vec& reach) {
  return {Range::about(middle.x, reach.x), Range::about(middle.y, reach.y),
          Range::about(middle.z, reach.z)};
}

}  // namespace lucerna::oracle
