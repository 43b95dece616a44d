// Linear RGB, Rec. 709 primaries and D65 white.  Light values are photometric: their luminance is
// in cd/m2, cd, lx or lm.  The name of a value has the unit.
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>

namespace lucerna {

template <std::floating_point T>
struct BasicRgb {
  T r{}, g{}, b{};

  BasicRgb() = default;
  // By components, for the reason given in Vec3.
  constexpr BasicRgb(const BasicRgb& c) : r(c.r), g(c.g), b(c.b) {}
  constexpr BasicRgb& operator=(const BasicRgb& c) {
    r = c.r, g = c.g, b = c.b;
    return *this;
  }
  ~BasicRgb() = default;
  constexpr BasicRgb(T r, T g, T b) : r(r), g(g), b(b) {}
  constexpr explicit BasicRgb(T grey) : r(grey), g(grey), b(grey) {}
  template <std::floating_point Other>
  constexpr explicit BasicRgb(const BasicRgb<Other>& c)
      : r(static_cast<T>(c.r)), g(static_cast<T>(c.g)), b(static_cast<T>(c.b)) {}

  bool operator==(const BasicRgb&) const = default;
  BasicRgb operator+(const BasicRgb& c) const { return {r + c.r, g + c.g, b + c.b}; }
  BasicRgb operator-(const BasicRgb& c) const { return {r - c.r, g - c.g, b - c.b}; }
  BasicRgb operator*(const BasicRgb& c) const { return {r * c.r, g * c.g, b * c.b}; }
  BasicRgb operator*(T s) const { return {r * s, g * s, b * s}; }
  BasicRgb operator/(T s) const { return {r / s, g / s, b / s}; }
  BasicRgb& operator+=(const BasicRgb& c) { return *this = *this + c; }

  bool is_black() const { return r == 0 && g == 0 && b == 0; }
  T max_component() const { return std::max({r, g, b}); }
};

/// Luminance of linear RGB: the Y row of the matrix that follows from the Rec. 709 primaries and
/// the D65 white point (0.3127, 0.3290).  [BT709]
template <std::floating_point T>
T luminance(const BasicRgb<T>& c) {
  return T(0.2126390058715104) * c.r + T(0.7151686787677559) * c.g + T(0.0721923153607337) * c.b;
}

template <std::floating_point T>
bool is_finite(const BasicRgb<T>& c) {
  // Usually one comparison, as for a Vec3.
  if (std::isfinite(c.r + c.g + c.b)) [[likely]]
    return true;
  return std::isfinite(c.r) && std::isfinite(c.g) && std::isfinite(c.b);
}

using Rgb = BasicRgb<double>;
using Rgbf = BasicRgb<float>;

}  // namespace lucerna
