// Whether a way meets a curved surface, over ranges of the way's ends.
#pragma once

#include <optional>

#include "tests/oracle/world.h"

namespace lucerna::oracle {

enum class Way : std::uint8_t { kFree, kBlocked, kUnsure };

/// One end of a way: all points of a box, or a point of the surface.
struct End {
  Box box{};
  bool on = false;  ///< lies on the surface; `s` and `t` are its parameters if that is a patch
  Range s{}, t{};
  Real blur = 0;  ///< obstacles within this share of the way from the end may count or not
};

/// Cylinders and patches.  `off`: how far off the surface may be along each axis.
Way past_curved(const Shape& shape, const Vec& off, const End& from, const End& to);

}  // namespace lucerna::oracle
