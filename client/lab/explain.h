// The hypotheses about numbers of one light.
#pragma once

#include <cstddef>
#include <vector>

#include "client/lab/finding.h"
#include "client/lab/light_values.h"
#include "client/lab/mistakes.h"
#include "client/lab/verify_records.h"
#include "client/lab/verify_truth.h"

namespace lucerna::verify {

/// All variations of a light: other sizes, other angles, mirrored and rotated maps.
std::vector<Variation> variations(Truth& truth, const v1::Light& light);

/// Names the mistake in the values of samples.  `ours`: luminances.
void explain_values(Truth& truth, const v1::Light& light, const Records& rows,
                    const std::vector<double>& ours, Finding* finding);

/// Names the mistake in densities.  `ways`: the ways by which Lucerna samples this light.
void explain_densities(Truth& truth, const v1::Light& light, const Records& rows,
                       const std::vector<Way>& ways, Finding* finding);

/// A factor that the claimed densities have and the right ones have not, one number per row.
struct MissingFactor {
  std::string mistake, sentence;
  std::vector<double> factor;
};
/// What a renderer that samples in a way of its own may forget: sin(theta) of a map by latitude and
/// longitude, or the cosine of directions that follow it.
std::vector<MissingFactor> missing_factors(const v1::Light& light, const Records& rows);

/// Cosines and distances of rows.  A vector is empty if the file does not have what it needs.
/// Cosines are at least 0.  NaN for rays that miss the light, and for lights at infinity.
struct Geometry {
  std::vector<double> cos_receiver, cos_geometric, cos_light, cos_given_light, distance;
  bool behind = false;
};
Geometry geometry_of(Truth& truth, const v1::Light& light, const Records& rows);

/// What the colour [r, g, b] would be if sRGB-encoded texels were taken for linear ones.  `level`
/// is the colour of a texel of 1.
Double3 not_linearised(const Double3& rgb, const Double3& level);
/// What it would be if linear texels were decoded as sRGB.
Double3 linearised_twice(const Double3& rgb, const Double3& level);
/// The level of a texel of 1, or of a light without a picture its brightest channel.
Double3 texel_level(const v1::Light& light);

/// Adds hypotheses about the colour of a light that has one colour.
void add_colours(const v1::Light& light, const std::vector<double>& ours,
                 std::vector<Hypothesis>* all);

/// Sets the sentence and the mistake of the finding.
void name_mistake(const std::optional<Mistake>& mistake, Finding* finding);

}  // namespace lucerna::verify
