// Right answers by brute force: one shape at a time, in extended precision.
//
// An answer is unsure where the floats of scene and request cannot decide it.  The server keeps
// surfaces and points as floats about the middle of the scene, so each coordinate may be off by its
// rounding there.  The rule knows nothing of the server's answer.
#pragma once

#include <cstdint>
#include <optional>

#include "tests/oracle/cells.h"
#include "tests/oracle/curved.h"
#include "tests/oracle/world.h"

namespace lucerna::oracle {

struct Integral;

struct Amount {
  Real value = 0;
  Real bound = 0;  ///< of the error of `value`
  bool sure = true;
  int cells = 0;  ///< parts of emitters that were looked at

  Amount& operator+=(const Amount& other);
};

class Truth {
 public:
  explicit Truth(const World& world);
  Truth(const Truth&) = delete;
  Truth& operator=(const Truth&) = delete;

  /// At the world's time.
  const World& world() const { return world_; }
  /// Whether one of the world's shapes lies between the two places.
  Way past(const Shape& shape, const Place& from, const Place& to) const;
  /// The place as an end of a way past a curved shape.  `other`: the other end.
  End end(const Place& place, const Shape& shape, const Place& other) const;
  /// Whether any surface lies between the two places.
  Way way(const Place& from, const Place& to) const;

  /// Direct illuminance on the side of the place's normal [lx].
  Amount illuminance(const Place& at) const;
  /// The same from one light.  `source`: first World::lights, then the shapes that emit.
  Amount illuminance(int source, const Place& at) const;
  /// The solid angle of a surface's emitting side as if nothing were in the way [sr].
  Amount solid_angle(int shape, const Place& at) const;
  /// Luminous flux [lm]; nothing for lights at infinity, since it depends on the sphere that the
  /// server puts around the scene.
  std::optional<Amount> power(int source) const;
  /// Whether a point of a request may count as a point on the surface.
  bool may_lie_on(const Shape& shape, const Place& place) const;
  /// How far off each coordinate of a point may be.
  Vec rounding(const Vec& point) const;
  Vec rounding(const Shape& shape) const;
  /// Infinity is farther away than this from the point [m].
  Real reach(const Vec& at) const;

 private:
  /// A request's point lies on surfaces that are nearer than this [m].
  Real near(const Place& place) const;
  /// Obstacles within this distance of a request's point without a normal may count or not [m].
  Real blur(const Place& place) const;
  /// A way from a request's point begins up to this far from it, along its normal [m].
  Real shift(const Place& place) const;
  Way past_flat(const Shape& shape, const Place& from, const Place& to) const;
  Way past_sphere(const Shape& shape, const Place& from, const Place& to) const;

  Amount from_light(const Light& light, const Place& at) const;
  Amount from_sky(const Light& light, const Place& at) const;
  Amount from_shape(int shape, const Integral& integral) const;

  /// How far a way from a point on the shape may begin from its plane [m].
  Real start(const Shape& shape, const Vec& p) const;

  World world_;
  Vec centre_;
  Real detail_ = 0;  ///< the extent of the smallest shape [m]
};

}  // namespace lucerna::oracle
