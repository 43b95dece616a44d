// Checks distances to one light.
#pragma once

#include "client/lab/finding.h"
#include "client/lab/verify_records.h"
#include "client/lab/verify_truth.h"

namespace lucerna::verify {

/// Checks the distances of samples of one light.
Finding check_distances(Truth& truth, const v1::Light& light, const Records& rows,
                        const Strictness& strictness);

}  // namespace lucerna::verify
