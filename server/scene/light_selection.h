// Methods that choose a light for a sample.
#pragma once

namespace lucerna {

/// The enum of the same name in lucerna/v1/accuracy.proto explains the values.
enum class LightSelection { kAutomatic, kAll, kUniform, kPower, kBvh };

}  // namespace lucerna
