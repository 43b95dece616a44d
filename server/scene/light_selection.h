// How a light is chosen for a sample.
#pragma once

namespace lucerna {

/// lucerna/v1/accuracy.proto says what each means, at the enum of the same name.
enum class LightSelection { kAutomatic, kAll, kUniform, kPower, kBvh };

}  // namespace lucerna
