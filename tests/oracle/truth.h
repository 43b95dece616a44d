// Right answers by brute force: one shape at a time, in extended precision.
//
// An answer is unsure where the floats of scene and request cannot decide it.  The server keeps
// surfaces and points as floats about the middle of the scene, so each coordinate may be off by its
// rounding there.  The rule knows nothing of the server's answer.
#pragma once

#include <cstdint>

#include "tests/oracle/world.h"

namespace lucerna::oracle {

enum class Way : std::uint8_t { kFree, kBlocked, kUnsure };

struct Amount {
  Real value = 0;  ///< [lx]
  Real bound = 0;  ///< of the error of `value`
  bool sure = true;
  int cells = 0;  ///< parts of emitters that were looked at
};

class Truth {
 public:
  explicit Truth(const World& world);

  /// Whether any surface lies between the two places.
  Way way(const Place& from, const Place& to) const;
  /// Direct illuminance on the side of the place's normal.
  Amount illuminance(const Place& at) const;

 private:
  /// How far off each coordinate of a point may be.
  Vec rounding(const Vec& point) const;
  Vec rounding(const Shape& shape) const;
  Way past(const Shape& shape, const Place& from, const Place& to) const;
  Way past_flat(const Shape& shape, const Place& from, const Place& to) const;
  Way past_sphere(const Shape& shape, const Place& from, const Place& to) const;

  Amount from_light(const Light& light, const Place& at) const;
  Amount from_shape(int emitter, const Place& at) const;
  /// The same without the error of rounded places.
  Amount once(int emitter, const Place& at) const;
  Amount from_sphere(int emitter, const Place& at) const;
  Amount from_disk(int emitter, const Place& at, const Vec& centre, const Vec& normal,
                   Real radius) const;

  struct Cell;
  /// The share of a convex quadrangle of a flat emitter, given in the emitter's parameters.
  void add_cell(const Cell& cell, int depth, Amount& sum) const;

  const World& world_;
  Vec centre_;
};

}  // namespace lucerna::oracle
