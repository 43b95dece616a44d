// Vectors of 113 bits, 34 digits: exact references for inputs in double.
#pragma once

#include "lights/maths/vec.h"

namespace lucerna::testing {

__extension__ typedef __float128 Quad;

struct Quad3 {
  Quad x, y, z;
  Quad3() = default;
  Quad3(Quad x, Quad y, Quad z) : x(x), y(y), z(z) {}
  explicit Quad3(const Vec3& v) : x(v.x), y(v.y), z(v.z) {}
  Quad3 operator-(const Quad3& v) const { return {x - v.x, y - v.y, z - v.z}; }
};

inline Quad dot(const Quad3& a, const Quad3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Quad3 cross(const Quad3& a, const Quad3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
/// The length as a double.
inline double length(const Quad3& v) { return std::sqrt(static_cast<double>(dot(v, v))); }

}  // namespace lucerna::testing
