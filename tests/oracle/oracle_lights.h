// Lights without a surface that reach a point from one direction.
#pragma once

#include <optional>

#include "tests/oracle/world.h"

namespace lucerna::oracle {

/// Light that arrives from one direction.
struct Arrival {
  Place end;        ///< where it comes from
  Real facing = 0;  ///< illuminance on a surface that faces the light [lx]
};

/// What reaches the point from a light of one direction, as if nothing were in the way; nothing for
/// suns, skies and portals.  `reach`: infinity is farther away [m].
std::optional<Arrival> arrival(const Light& light, const Vec& at, Real reach);

/// Luminous intensity towards the unit vector in the light's axes [cd].
Real intensity(const Light& light, const Vec& w);

/// Luminous flux of a light that has a place and no surface [lm].
Real flux(const Light& light);

/// The direction of a point of the unit square in an equal-area map, and back [Clarberg08].
Vec direction_of(Real s, Real t);
std::pair<Real, Real> square_of(const Vec& direction);

}  // namespace lucerna::oracle
