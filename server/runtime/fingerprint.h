// A fingerprint of everything except scene and request that affects the bits of an answer.
#pragma once

#include <string>

namespace lucerna {

/// See NumericFingerprint in lucerna/v1/admin.proto.
struct Fingerprint {
  std::string digest, build, embree, libm;
};

/// `embree`: Embree's version and kernels (embree_kernels() of server/rays/accelerator.h).
Fingerprint numeric_fingerprint(const std::string& embree);

}  // namespace lucerna
