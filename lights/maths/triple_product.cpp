#include "lights/maths/triple_product.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lucerna {

namespace {

/// hi + lo, where lo is no more than half of the last digit of hi.
struct Two {
  double hi = 0, lo = 0;
};

/// a + b, with its rounding error.
Two two_sum(double a, double b) {
  const double sum = a + b;
  const double of_b = sum - a;
  return {sum, (a - (sum - of_b)) + (b - of_b)};
}

/// The same for |a| >= |b|.
Two normal(double a, double b) {
  const double sum = a + b;
  return {sum, b - (sum - a)};
}

Two operator+(Two a, Two b) {
  const Two hi = two_sum(a.hi, b.hi), lo = two_sum(a.lo, b.lo);
  const Two sum = normal(hi.hi, hi.lo + lo.hi);
  return normal(sum.hi, sum.lo + lo.lo);
}

Two operator-(Two a, Two b) { return a + Two{-b.hi, -b.lo}; }

Two operator*(Two a, Two b) {
  const double product = a.hi * b.hi;
  return normal(product, std::fma(a.hi, b.hi, -product) + (a.hi * b.lo + a.lo * b.hi));
}

struct TwoVec {
  Two x, y, z;
};

TwoVec difference(const Vec3& a, const Vec3& b) {
  return {two_sum(a.x, -b.x), two_sum(a.y, -b.y), two_sum(a.z, -b.z)};
}

double triple_product_in_twos(const TwoVec& a, const TwoVec& e, const TwoVec& f) {
  return (a.x * (e.y * f.z - e.z * f.y) + a.y * (e.z * f.x - e.x * f.z) +
          a.z * (e.x * f.y - e.y * f.x))
      .hi;
}

/// Whether the plain product is exact enough.  Each difference and each later step has an error of
/// half an epsilon, in all less than six of each of six terms.
bool is_good(double product, const Vec3& a, const Vec3& e, const Vec3& f) {
  constexpr double kAllowed = 1e-11;
  constexpr double kOff = 36 * std::numeric_limits<double>::epsilon() / kAllowed;
  return std::fabs(product) >= kOff * max_abs(a) * max_abs(e) * max_abs(f);
}

/// A power of two that scales the longest vector to about 1, so that products of three do not
/// overflow or underflow.  1 if they would not, which gives the same bits and takes less time.
double unit_for(const Vec3& a, const Vec3& e, const Vec3& f) {
  const double largest = std::max({max_abs(a), max_abs(e), max_abs(f)});
  constexpr double kSafe = 0x1p80;
  if (largest > 1 / kSafe && largest < kSafe) return 1;
  if (!(largest > 0) || !std::isfinite(largest)) return 1;
  return std::ldexp(1.0, std::clamp(-std::ilogb(largest), -1000, 1000));
}

}  // namespace

double triple_product(const Vec3& p, const Vec3& a, const Vec3& e, const Vec3& f) {
  const Vec3 to_a = a - p;
  const double plain = dot(to_a, cross(e, f));
  if (is_good(plain, to_a, e, f)) return plain;
  const auto exact = [](const Vec3& v) { return TwoVec{{v.x}, {v.y}, {v.z}}; };
  return triple_product_in_twos(difference(a, p), exact(e), exact(f));
}

double triple_product_of_corners(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 to_a = a - p, e = b - a, f = c - a;
  const double plain = dot(to_a, cross(e, f));
  if (is_good(plain, to_a, e, f)) return plain;
  if (p == b || p == c) return 0;  // two doubles would leave a rounding error
  return triple_product_in_twos(difference(a, p), difference(b, a), difference(c, a));
}

double height_over(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 to_a = a - p, e = b - a, f = c - a;
  const double unit = unit_for(to_a, e, f);
  if (unit == 1) {
    const Vec3 normal = cross(e, f);
    const double plain = dot(to_a, normal);
    if (plain != 0 && is_good(plain, to_a, e, f)) return -plain / length(normal);
  }
  const double volume = triple_product_of_corners(p * unit, a * unit, b * unit, c * unit);
  return volume == 0 ? 0 : -volume / length(cross(e * unit, f * unit)) / unit;
}

double height_over_edges(const Vec3& p, const Vec3& a, const Vec3& e, const Vec3& f) {
  const double unit = unit_for(a - p, e, f);
  const double volume = triple_product(p * unit, a * unit, e * unit, f * unit);
  return volume == 0 ? 0 : -volume / length(cross(e * unit, f * unit)) / unit;
}

}  // namespace lucerna
