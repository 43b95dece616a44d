// Checks rays that leave lights.
#pragma once

#include <vector>

#include "client/lab/finding.h"
#include "client/lab/verify_records.h"
#include "client/lab/verify_truth.h"

namespace lucerna::verify {

/// Checks rays of one light: their values, both densities, and the power that they add up to.
std::vector<Finding> check_emission(Truth& truth, const v1::Light& light, const Records& rows,
                                    const Strictness& strictness);

}  // namespace lucerna::verify
