// Parts of emitters, for adaptive quadrature.
#pragma once

#include <array>
#include <vector>

#include "tests/oracle/world.h"

namespace lucerna::oracle {

/// An emitter as seen from a point.
struct Emitter {
  enum class Kind : std::uint8_t {
    kFlat,      ///< corner + s u + t v
    kTriangle,  ///< corner + s u + t (1 - s) v
    kDisk,      ///< middle, radius s, angle 2 pi t; u and v are as long as the radius
    kPatch,
    kSphere,    ///< height s below the point nearest to the eye, angle 2 pi t; axis w
    kCylinder,  ///< angle 2 pi s from the direction of the eye; corner + t w
    kSky,       ///< directions about the receiver's normal w: sine s, angle 2 pi t
    kMap        ///< directions of an equal-area map
  };
  Kind kind = Kind::kFlat;
  int shape = -1;  ///< number of the shape; -1: a light without one
  Vec eye;
  Vec corner{}, u{}, v{}, w{};
  const Shape* surface = nullptr;  ///< null: a light without one
  bool two_sided = false;
  bool far = false;  ///< the light is at infinity behind the surface
  Real reach = 0;    ///< infinity is farther away [m]
};

/// The part of an emitter over a rectangle of its parameters.
struct Cell {
  const Emitter* emitter = nullptr;
  Real radiance = 0;
  Real s0 = 0, s1 = 1, t0 = 0, t1 = 1;

  Vec point(Real s, Real t) const;
  /// Points whose convex hull holds the cell: `count` of them.
  struct Hull {
    std::array<Vec, 8> points;
    int count;
  };
  Hull hull() const;
  /// What the emitter has at a point, per s and t.
  struct Element {
    Vec at{};
    Vec area{};      ///< towards the side that emits, unless it is at infinity
    Real angle = 0;  ///< solid angle of an emitter at infinity
  };
  Element element(Real s, Real t) const;
  /// Per s and t: the solid angle at the eye, of the side that emits, or zero.  `d`: from the eye
  /// to the point.
  Real solid_angle(const Element& element, const Vec& d) const;
  /// Whether the eye sees only the side that does not emit.
  bool faces_away() const;
};

/// The whole emitter, divided into cells of at most an eighth of a turn.
std::vector<Cell> cells_of(const Emitter& emitter, Real radiance, const Texels& picture);

}  // namespace lucerna::oracle
