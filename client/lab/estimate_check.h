// Checks powers, illuminances and visibility.
#pragma once

#include <vector>

#include "client/lab/finding.h"
#include "client/lab/verify_records.h"
#include "client/lab/verify_truth.h"

namespace lucerna::verify {

/// Powers of lights; one finding for each light.
std::vector<Finding> check_powers(Truth& truth, const Records& rows, const Strictness& strictness);

/// Illuminances by one light, or by all if `light` is null.
Finding check_illuminances(Truth& truth, const v1::Light* light, const Records& rows,
                           const Strictness& strictness);

Finding check_visibility(Truth& truth, const Records& rows, const Strictness& strictness);

}  // namespace lucerna::verify
