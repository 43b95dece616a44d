// What the bits of an answer depend on besides the question.
#pragma once

#include <absl/status/statusor.h>

#include <string>

namespace lucerna {

/// See NumericFingerprint in lucerna/v1/admin.proto.
struct Fingerprint {
  std::string digest, build, embree, libm;
};

/// `isa`: Embree's kernels, empty for the best.  INVALID_ARGUMENT for those that the machine lacks.
absl::StatusOr<Fingerprint> numeric_fingerprint(const std::string& isa);

}  // namespace lucerna
