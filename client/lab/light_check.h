// Checks samples and densities of one light.
#pragma once

#include <vector>

#include "client/lab/finding.h"
#include "client/lab/verify_records.h"
#include "client/lab/verify_truth.h"

namespace lucerna::verify {

/// The ways by which Lucerna samples a light.  Only area lights have several.
std::vector<Way> ways_of(const v1::Light& light, bool normals);

/// Checks rows of samples of one light: density, directions, integral, value and distance.
std::vector<Finding> check_samples(Truth& truth, const v1::Light& light, const Records& rows,
                                   const Strictness& strictness);

/// Checks densities for given directions: density and, with the column `drawn`, integral.
std::vector<Finding> check_densities(Truth& truth, const v1::Light& light, const Records& rows,
                                     const Strictness& strictness);

/// Checks the probabilities with which lights were chosen, over all rows of samples.
std::vector<Finding> check_selection(Truth& truth, const Records& rows,
                                     const Strictness& strictness);

}  // namespace lucerna::verify
