// Finds the angle by which the map of a light is rotated.
#pragma once

#include <functional>
#include <vector>

#include "client/lab/mistakes.h"
#include "client/lab/variation.h"

namespace lucerna::verify {

/// Adds the hypothesis that the map is rotated about axis z of the light, with the angle that fits
/// best.  For a map of directions, also about its other axes.  `predict` returns the numbers of a
/// variation.  Adds nothing for lights without a map.
void add_rotation(const v1::Light& light, const std::vector<double>& theirs,
                  const std::function<std::vector<double>(const Variation&)>& predict,
                  std::vector<Hypothesis>* hypotheses);

}  // namespace lucerna::verify
