// Intersections of rays, computed in double, one primitive at a time, by other formulas than the
// server's.  A result is unsure where rays and vertices in floats cannot decide it.  This is within
// the error bounds of server/rays/error_bounds.h around an edge, a silhouette or an end.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "lights/maths/vec.h"
#include "server/rays/error_bounds.h"

namespace lucerna::testing {

using Point = Vec3;

/// A ray from `origin`, t in units of `direction`; segments end at t = 1.
struct ExactRay {
  Point origin, direction;
  double t_max = std::numeric_limits<double>::infinity();
  double start_error = 0;  ///< how far off the origin may be [m]
  double end_error = 0;    ///< of a segment, its end [m]
  int from = -1, to = -1;  ///< numbers of the primitives that its ends lie on
  Point from_normal{};     ///< of `from`, on the side that the ray leaves to
};

struct ExactCrossing {
  double t;
  double slack_t;  ///< how far off t may be
  bool sure;       ///< or near a border
  bool on_edge;    ///< near an edge to a neighbour: the hit may be on either
  int primitive;
};

struct ExactAnswer {
  std::vector<ExactCrossing> crossings;
  bool sure() const {
    return std::ranges::any_of(crossings, [](const auto& c) { return c.sure; });
  }
};

/// Primitives, about the origin of the scene.  Triangles that share two corners are neighbours: a
/// ray between them meets one of the two, however near to the edge it passes.
class ExactGeometry {
 public:
  /// `largest`: the largest coordinate of the scene [m], which sets the rounding of vertices.
  explicit ExactGeometry(double largest) : rounding_(largest * kFloatRoundoff) {}

  /// Everything added after this call is an instance.  Its rays are transformed into its space in
  /// floats, so its surface is only known to within this distance [m].
  void begin_instance(double error) { instance_error_ = error; }

  void triangle(const Point& a, const Point& b, const Point& c);
  void sphere(const Point& centre, double radius);
  /// `normal` is a unit vector.
  void disk(const Point& centre, const Point& normal, double radius);
  /// Extends from `centre` by half the height in both directions along the unit vector `axis`.
  void cylinder(const Point& centre, const Point& axis, double radius, double half_height);
  void patch(const Point& p00, const Point& p10, const Point& p01, const Point& p11);
  /// Finds the neighbours.  Call it after the last primitive is added.
  void finish();

  int size() const { return static_cast<int>(primitives_.size()); }
  bool is_triangle(int i) const { return primitives_[i].kind == Kind::kTriangle; }

  struct OnSurface {
    Point position, normal;  // unit vector
  };
  /// A point of primitive `i`.  Triangles and patches take it at the shares `u`, which may lie on
  /// their border.
  OnSurface point(int i, Vec2 u) const;

  ExactAnswer along(const ExactRay& ray) const;

 private:
  /// In roundings of a coordinate.  This is more than the error of the traversal.
  static constexpr double kFar = 200;

  enum class Kind : std::uint8_t { kTriangle, kSphere, kDisk, kCylinder, kPatch };
  struct Primitive {
    Kind kind;
    std::array<Point, 4> at{};
    Point normal{0, 0, 1};
    double radius = 0, half_height = 0, slack = 1, shortest = 0;
    std::array<bool, 3> edge_up{};
    std::array<int, 3> neighbour{-1, -1, -1};
    Point centre{};
    double reach = 0, error = 0;
  };
  struct Meeting {
    const ExactRay& ray;
    Point w;  // the direction, a unit vector
    double length_d, error;
    int primitive;
    std::vector<ExactCrossing>& out;

    /// `normal`: a unit vector at that point; `plane_error`: how well the surface is known [m].
    void add(double t, const Point& normal, bool sure, double plane_error,
             bool on_edge = false) const {
      const double cosine = std::fabs(dot(normal, w));
      out.push_back(
          {t, plane_error / (length_d * std::max(cosine, 1e-300)), sure, on_edge, primitive});
    }
  };

  void add(Primitive p, const Point& centre, double reach);

  /// Whether a ray that starts on a round surface leaves it outwards.
  static bool is_convex(const Primitive& p, const ExactRay& ray);
  /// Leaves out the crossing that is an end of the ray on a round surface.  Where no crossing is
  /// near that end (it lies at the border), the other crossings are unsure.
  static void drop_nearest(ExactAnswer& answer, std::size_t first, double t);

  enum class Side : std::uint8_t { kFar, kEdge, kBorder };
  /// The side on which a ray passes edge `e` of a triangle, as seen from above or below.  The
  /// result is kEdge near an edge to a neighbour that is seen from the same side, kBorder near any
  /// other.  Uses Pluecker coordinates.  Each edge runs from the lesser to the greater of its
  /// corners.  So two neighbours see their edge from opposite sides of the same number.
  Side side_of(const Primitive& p, int e, const Meeting& m, double& value) const;
  /// Whether a border lies near a ray that passes near an edge of triangle `i`.  The border may be
  /// that triangle's, or that of any triangle around the corner that the ray may pass instead.
  bool is_near_border(int i, const Meeting& m) const;

  void meet_triangle(const Primitive& p, const Meeting& m) const;
  /// A ray cannot meet again a flat surface that one of its ends lies on.  The exception is an
  /// other end in the same plane: then the whole ray may meet it.
  static void meet_end(const Primitive& p, const Meeting& m);
  static void meet_disk(const Primitive& p, const Meeting& m);
  static void meet_sphere(const Primitive& p, const Meeting& m);
  static void meet_cylinder(const Primitive& p, const Meeting& m);
  static void meet_patch(const Primitive& p, const Meeting& m);

  double rounding_, instance_error_ = 0;
  std::vector<Primitive> primitives_;
};

}  // namespace lucerna::testing
