// Linear RGB, Rec. 709 primaries and D65 white.  Light values are photometric: their luminance is
// in cd/m2, cd, lx or lm.  The name of a value has the unit.
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>

namespace lucerna {

template <std::floating_point Real>
struct Rgb {
  Real r{}, g{}, b{};

  Rgb() = default;
  // By components, for the reason given in Vec3.
  constexpr Rgb(const Rgb& c) : r(c.r), g(c.g), b(c.b) {}
  constexpr Rgb& operator=(const Rgb& c) {
    r = c.r, g = c.g, b = c.b;
    return *this;
  }
  ~Rgb() = default;
  constexpr Rgb(Real r, Real g, Real b) : r(r), g(g), b(b) {}
  constexpr explicit Rgb(Real grey) : r(grey), g(grey), b(grey) {}
  template <std::floating_point Other>
  constexpr explicit Rgb(const Rgb<Other>& c)
      : r(static_cast<Real>(c.r)), g(static_cast<Real>(c.g)), b(static_cast<Real>(c.b)) {}

  bool operator==(const Rgb&) const = default;
  Rgb operator+(const Rgb& c) const { return {r + c.r, g + c.g, b + c.b}; }
  Rgb operator-(const Rgb& c) const { return {r - c.r, g - c.g, b - c.b}; }
  Rgb operator*(const Rgb& c) const { return {r * c.r, g * c.g, b * c.b}; }
  Rgb operator*(Real s) const { return {r * s, g * s, b * s}; }
  Rgb operator/(Real s) const { return {r / s, g / s, b / s}; }
  Rgb& operator+=(const Rgb& c) { return *this = *this + c; }

  bool is_black() const { return r == 0 && g == 0 && b == 0; }
  Real max_component() const { return std::max({r, g, b}); }
};

/// Luminance of linear RGB: the Y row of the matrix that follows from the Rec. 709 primaries and
/// the D65 white point (0.3127, 0.3290).  [BT709]
template <std::floating_point Real>
Real luminance(const Rgb<Real>& c) {
  return Real(0.2126390058715104) * c.r + Real(0.7151686787677559) * c.g +
         Real(0.0721923153607337) * c.b;
}

template <std::floating_point Real>
bool is_finite(const Rgb<Real>& c) {
  // Usually one comparison, as for a Vec3.
  if (std::isfinite(c.r + c.g + c.b)) [[likely]]
    return true;
  return std::isfinite(c.r) && std::isfinite(c.g) && std::isfinite(c.b);
}

}  // namespace lucerna
