// Tests whether directions of samples follow densities.
#pragma once

#include <vector>

#include "client/lab/finding.h"
#include "client/lab/verify_records.h"
#include "client/lab/verify_truth.h"

namespace lucerna::verify {

/// The findings "directions" (against the claimed density), "integral" (of the claimed density) and
/// "Lucerna's directions" (against its density).  Without claimed densities only the last one,
/// which then decides, under the name "directions".  `q`: Lucerna's densities of the rows by `way`.
std::vector<Finding> check_directions(Truth& truth, const v1::Light& light, const Records& rows,
                                      const Way& way, const std::vector<double>& q,
                                      const Strictness& strictness);

}  // namespace lucerna::verify
