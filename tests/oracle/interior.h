// Rooms with mirrors, panes and grey walls, as the oracle knows them.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/oracle/numbers.h"
#include "tests/oracle/world.h"

namespace lucerna::oracle {

/// In the room's own frame and unit of length.
using Vector = VecOf<double>;

/// A rectangle.
struct Sheet {
  enum class Kind : std::uint8_t { kGrey, kMirror, kPane };
  Kind kind = Kind::kGrey;
  Vector corner, u, v;  ///< the edges start at the corner, at right angles
  double value = 0;     ///< grey, mirror: the reflectance; pane: the index of refraction
  // Set by `finished`.
  Vector along_u{}, along_v{}, n{};  ///< unit; n: along u x v
  double width = 0, height = 0;      ///< the lengths of u and v
  bool is_black() const { return kind == Kind::kGrey && value == 0; }
  bool is_smooth() const { return kind != Kind::kGrey; }
};
Sheet finished(Sheet sheet);

inline double size(const Vector& v) { return std::sqrt(dot(v, v)); }
inline Vector unit(const Vector& v) { return v * (1 / size(v)); }

struct Lamp {
  enum class Kind : std::uint8_t { kPoint, kSpot, kDistant, kRectangle, kSphere };
  Kind kind = Kind::kPoint;
  Vector at{};    ///< of a point or a spot; of a sphere its middle
  Vector axis{};  ///< unit; a spot shines along it; it points to a distant light
  /// [cd] in the room's unit, of a spot along its axis; [lx] of a distant light; else [cd/m2]
  double level = 1;
  double angle = 0, edge = 0;  ///< of spots: half angle, and width of the smooth edge [rad]
  double radius = 0;           ///< of spheres
  Sheet sheet{};               ///< of rectangles, which shine along the normal and reflect nothing
  bool has_size() const { return kind == Kind::kRectangle || kind == Kind::kSphere; }
};

struct Interior {
  std::vector<Sheet> sheets;
  std::vector<Lamp> lamps;
  struct Receiver {
    Vector at, n;  ///< n: unit
  };
  std::vector<Receiver> receivers;
  /// The frame in the world: axes, place and unit of length [m].
  std::array<Vec, 3> axes{Vec{1, 0, 0}, Vec{0, 1, 0}, Vec{0, 0, 1}};
  Vec origin{};
  double unit_m = 1;

  bool has_grey() const;
  int smooth_sheets() const;
  Vec world_vector(const Vector& v) const { return axes[0] * v.x + axes[1] * v.y + axes[2] * v.z; }
  /// Rounded to doubles.
  Vec world_point(const Vector& p) const { return doubles(origin + world_vector(p) * unit_m); }
  /// The receiver as a request names it.
  Place place_of(const Receiver& r) const;
};

/// The scene as a .pbrt file.
std::string pbrt_text(const Interior& interior);

/// The random room with this number.
Interior random_interior(std::uint64_t number);

}  // namespace lucerna::oracle
