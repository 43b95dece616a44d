// The accuracy that a query requests.
#pragma once

#include <cstdint>

#include "proto/common/confidence.h"

namespace lucerna {

/// The accuracy at which an estimate is good enough.
struct TargetError {
  double relative = 0;        ///< of the estimate, > 0
  double absolute_floor = 0;  ///< the error does not have to be smaller; in the estimate's unit
  double confidence = kConfidence;  ///< of the interval, in (0, 1)
  std::uint64_t max_samples = 1U << 16;
};

}  // namespace lucerna
