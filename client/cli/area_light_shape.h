// Describes the shapes of area lights in words.
#pragma once

#include <string>

#include "lucerna/v1/light.pb.h"

namespace lucerna::cli {

/// The shape with its size.  Examples: "rectangle 1.2 x 0.6 m", "disk of diameter 0.8 m, hole of
/// 0.2 m", "cylinder of diameter 0.1 m, length 2 m, 90 deg of it".
std::string describe_shape(const v1::DiffuseAreaLight& area);

}  // namespace lucerna::cli
