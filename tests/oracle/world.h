// The scenes of the oracle, as it knows them.  Nothing here comes from the server's code.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "tests/oracle/oracle_vec.h"

namespace lucerna::oracle {

/// A grey picture, row by row from the top.  Its values are floats.  Empty: none.
struct Texels {
  int width = 0, height = 0;
  std::vector<Real> values;
  Real at(int x, int y) const { return values[static_cast<std::size_t>(y * width + x)]; }
  bool empty() const { return values.empty(); }
};

enum class ShapeKind : std::uint8_t {
  kTriangle,
  kParallelogram,
  kPatch,
  kDisk,
  kSphere,
  kCylinder
};
inline constexpr std::array<const char*, 6> kShapeNames{"triangle", "parallelogram", "patch",
                                                        "disk",     "sphere",        "cylinder"};

/// A surface, in metres.
struct Shape {
  ShapeKind kind = ShapeKind::kTriangle;
  /// All are doubles.
  /// - Triangle: its corners.
  /// - Parallelogram, patch: the corners at (s, t) = (0, 0), (1, 0), (0, 1), and of a patch (1, 1).
  /// - Disk, cylinder: the middle, and its axis, a unit vector.
  /// - Sphere: the centre.
  std::array<Vec, 4> at{};
  Real radius = 0;         ///< of disks, spheres and cylinders
  Real half_height = 0;    ///< of cylinders
  Real radiance = 0;       ///< [cd/m2], white; 0: does not emit
  bool two_sided = false;  ///< emits on both sides
  Texels picture{};        ///< factors of the radiance, over a parallelogram; nearest texel
  Vec moves{};             ///< from time 0 to time 1
};

enum class LightKind : std::uint8_t {
  kPoint,
  kSpot,
  kPicture,
  kWeb,
  kProjection,
  kBeam,
  kDistant,
  kSun,
  kSky,
  kPortal
};
inline constexpr std::array<const char*, 10> kLightNames{
    "point", "spot", "picture", "web", "projection", "beam", "distant", "sun", "sky", "portal"};

/// A light without a surface.
struct Light {
  LightKind kind = LightKind::kPoint;
  Vec at;  ///< the middle; of a portal a corner
  /// Unit vectors at right angles.  Spots, projections and beams shine along the third, it is the
  /// downward axis of a web, and it points to the distant light or to the sun.  The first two are
  /// the sides of a portal.
  std::array<Vec, 3> axes{Vec{1, 0, 0}, Vec{0, 1, 0}, Vec{0, 0, 1}};
  /// [cd], where a picture is 1.  Beam, distant, sun: illuminance on a surface that faces it [lx].
  /// Sky, portal: radiance [cd/m2], where the picture is 1.
  Real level = 0;
  /// Radians.  Spot: the half angle.  Projection: the field of view of the shorter side.  Sun: the
  /// diameter.
  Real angle = 0;
  Real edge = 0;  ///< radians, of a spot: the width of the smooth edge
  /// [m]  Beam: half of the shorter side.  Portal: the sides.
  std::array<Real, 2> extent{};
  /// Picture, sky: equal-area map of all directions.  Projection, beam: the picture.
  Texels picture{};
  /// Web: candela at angles from the downward axis, ascending, and at equal steps of azimuth.  The
  /// azimuths go from 0 to `sweep` [degrees]; the web repeats in mirrors beyond.
  std::vector<Real> gammas{}, candela{};
  int planes = 1, sweep = 0;
  Vec moves{};  ///< from time 0 to time 1
};

/// A point that a question names.
struct Place {
  Vec at{};            ///< doubles
  Vec normal{};        ///< floats, not normalised; zero in free space
  int on = -1;         ///< the shape that it lies on; -1: none
  Real s = 0, t = 0;   ///< the parameters of the point if `on` is a patch
  bool far = false;    ///< stands for infinity in its direction
  bool asked = false;  ///< a point of a request, whose coordinates have an error by the contract
};

struct World {
  std::vector<Shape> shapes;
  std::vector<Light> lights;
  Real time = 0;
  std::vector<Place> receivers;  ///< each has a normal
  struct Segment {
    Place from, to;
  };
  std::vector<Segment> segments;
};

/// The numbers of light sources: first `World::lights`, then the shapes that emit.
inline std::vector<int> emitting_shapes(const World& world) {
  std::vector<int> numbers;
  for (std::size_t i = 0; i < world.shapes.size(); ++i) {
    if (world.shapes[i].radiance > 0) numbers.push_back(static_cast<int>(i));
  }
  return numbers;
}

/// Where things are at the world's time.
Shape at_time(const Shape& shape, Real time);
World at_its_time(const World& world);

/// The scene as a .pbrt file.  Numbers keep all bits of a double.
std::string pbrt_text(const World& world);
/// The pictures and luminaire files that it names: names and contents.
std::vector<std::pair<std::string, std::string>> pbrt_files(const World& world);

/// The random scene with this number.
World random_world(std::uint64_t number);

}  // namespace lucerna::oracle
