// What rays meet, worked out in double for one primitive after the other and by other formulas than
// the server's; with it what nobody can tell who has rays and vertices in floats: what passes an
// edge, a silhouette or an end within the error bounds that server/rays/error_bounds.h states.
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

using Point = Vec3<double>;

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

/// Primitives, about the scene's origin.  Triangles that have two corners in common are
/// neighbours: a ray between them meets one of both, however near to the edge it passes.
class ExactGeometry {
 public:
  /// `largest`: coordinate of the scene [m], of which vertices are rounded.
  explicit ExactGeometry(double largest) : rounding_(largest * kFloatRoundoff) {}

  /// What is added from here on is an instance, whose rays are taken into its space in floats: its
  /// surface is known less well by this [m].
  void begin_instance(double error) { instance_error_ = error; }

  void triangle(const Point& a, const Point& b, const Point& c);
  void sphere(const Point& centre, double radius);
  /// `normal` unit.
  void disk(const Point& centre, const Point& normal, double radius);
  /// From `centre` by half the height along the unit vector `axis` to both sides.
  void cylinder(const Point& centre, const Point& axis, double radius, double half_height);
  void patch(const Point& p00, const Point& p10, const Point& p01, const Point& p11);
  /// Once all are there: who is whose neighbour.
  void finish();

  int size() const { return static_cast<int>(primitives_.size()); }
  bool is_triangle(int i) const { return primitives_[i].kind == Kind::kTriangle; }

  struct OnSurface {
    Point position, normal;  // unit
  };
  /// A point of primitive `i`: of triangles and patches at the shares `u`, which may lie on their
  /// border.
  OnSurface point(int i, Vec2<double> u) const;

  ExactAnswer along(const ExactRay& ray) const;

 private:
  /// In roundings of a coordinate, more than the traversal's error is.
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
    Point w;  // the direction, unit
    double length_d, error;
    int primitive;
    std::vector<ExactCrossing>& out;

    /// `normal`: unit, there; `plane_error`: how well the surface is known [m].
    void add(double t, const Point& normal, bool sure, double plane_error,
             bool on_edge = false) const {
      const double cosine = std::fabs(dot(normal, w));
      out.push_back(
          {t, plane_error / (length_d * std::max(cosine, 1e-300)), sure, on_edge, primitive});
    }
  };

  void add(Primitive p, const Point& centre, double reach);

  /// Whether a ray leaves a round surface that it starts on outwards.
  static bool is_convex(const Primitive& p, const ExactRay& ray);
  /// Of a round surface that an end lies on, leaves out the crossing that is that end; where none
  /// is near it (the end lies at the border) the others are unsure.
  static void drop_nearest(ExactAnswer& answer, std::size_t first, double t);

  enum class Side : std::uint8_t { kFar, kEdge, kBorder };
  /// Where a ray passes edge `e` of a triangle, which it sees from above or below: kEdge near an
  /// edge to a neighbour that is seen from the same side, kBorder near any other.  By Pluecker
  /// coordinates, each edge from the lesser to the greater of its corners, so that two neighbours
  /// see their edge from opposite sides of the same number.
  Side side_of(const Primitive& p, int e, const Meeting& m, double& value) const;
  /// Whether a border lies near the ray, which passes near an edge of triangle `i`: of that or of
  /// those that it may pass instead, all around a corner.
  bool is_near_border(int i, const Meeting& m) const;

  void meet_triangle(const Primitive& p, const Meeting& m) const;
  /// A flat surface that one end lies on cannot be met again, unless the other end lies within its
  /// plane: then all of the way may.
  static void meet_end(const Primitive& p, const Meeting& m);
  static void meet_disk(const Primitive& p, const Meeting& m);
  static void meet_sphere(const Primitive& p, const Meeting& m);
  static void meet_cylinder(const Primitive& p, const Meeting& m);
  static void meet_patch(const Primitive& p, const Meeting& m);

  double rounding_, instance_error_ = 0;
  std::vector<Primitive> primitives_;
};

}  // namespace lucerna::testing
