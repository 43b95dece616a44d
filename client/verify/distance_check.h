// Checks distances to one light.
#pragma once

#include "client/verify/finding.h"
#include "client/verify/records.h"
#include "client/verify/truth.h"

namespace lucerna::verify {

/// Checks the distances of samples of one light.
Finding check_distances(Truth& truth, const v1::Light& light, const Records& rows,
                        const Strictness& strictness);

}  // namespace lucerna::verify
