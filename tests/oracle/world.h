// The scenes of the oracle, as it knows them.  Nothing here comes from the server's code.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

namespace lucerna::oracle {

/// Extended precision: 64 bits of mantissa on x86-64.
using Real = long double;

struct Vec {
  Real x = 0, y = 0, z = 0;
};
inline Vec operator+(const Vec& a, const Vec& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec operator-(const Vec& a, const Vec& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec operator-(const Vec& a) { return {-a.x, -a.y, -a.z}; }
inline Vec operator*(const Vec& a, Real s) { return {a.x * s, a.y * s, a.z * s}; }
inline Real dot(const Vec& a, const Vec& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec cross(const Vec& a, const Vec& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Real length(const Vec& a) { return std::sqrt(dot(a, a)); }
inline Vec unit(const Vec& a) { return a * (1 / length(a)); }
inline Vec absolute(const Vec& a) { return {std::fabs(a.x), std::fabs(a.y), std::fabs(a.z)}; }
/// A unit vector across the unit vector `n`.
inline Vec across(const Vec& n) {
  return unit(cross(std::fabs(n.x) < 0.6L ? Vec{1, 0, 0} : Vec{0, 1, 0}, n));
}

enum class ShapeKind : std::uint8_t { kTriangle, kParallelogram, kDisk, kSphere };
inline constexpr int kShapeKinds = 4;

/// A surface, in metres.
struct Shape {
  ShapeKind kind = ShapeKind::kTriangle;
  /// Triangle: its corners.  Parallelogram: a corner and its two neighbours.  Disk: the centre, and
  /// a point on its axis at a distance of 1.  Sphere: the centre.  All are doubles.
  std::array<Vec, 3> at{};
  Real radius = 0;    ///< of disks and spheres
  Real radiance = 0;  ///< [cd/m2], white; 0: does not emit
  bool two_sided = false;
};

enum class LightKind : std::uint8_t { kPoint, kDistant };
inline constexpr int kLightKinds = 2;

/// A light without a surface.
struct Light {
  LightKind kind = LightKind::kPoint;
  Vec at;          ///< distant light: the unit vector towards the light
  Real level = 0;  ///< [cd]; distant light: illuminance on a surface that faces it [lx]
};

/// A point that a question names.
struct Place {
  Vec at;            ///< doubles
  Vec normal;        ///< floats, not normalised; zero in free space
  int on = -1;       ///< the shape that it lies on; -1: none
  bool far = false;  ///< stands for infinity in its direction
};

struct World {
  std::vector<Shape> shapes;
  std::vector<Light> lights;
  std::vector<Place> receivers;  ///< each has a normal
  struct Segment {
    Place from, to;
  };
  std::vector<Segment> segments;
};

/// The scene as a .pbrt file.  Numbers keep all bits of a double.
std::string pbrt_text(const World& world);

/// The random scene with this number.
World random_world(std::uint64_t number);

}  // namespace lucerna::oracle
