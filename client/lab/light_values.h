// Lucerna's values of one light, in the way that fits the kind of the light.
#pragma once

#include <vector>

#include "client/lab/verify_records.h"
#include "client/lab/verify_truth.h"

namespace lucerna::verify {

/// Radiances [cd/m2]; for delta lights illuminances on surfaces that face them [lx].
class LightValues {
 public:
  LightValues(Truth& truth, const v1::Light& light) : truth_(truth), light_(light) {}

  /// Values without occlusion, RGB.  `distances` [m] may be empty or have NaN.  NaN for rows whose
  /// light is hidden by another surface, in lights whose radiance varies over their surface.
  std::vector<Double3> at(const std::vector<Double3>& points,
                          const std::vector<Double3>& directions,
                          const std::vector<double>& distances,
                          const Variation& variation = {}) const;

 private:
  /// One radiance for all directions; nothing if it varies.
  std::optional<Double3> constant() const;
  std::vector<Double3> of_sky(const std::vector<Double3>& directions,
                              const Variation& variation) const;

  Truth& truth_;
  const v1::Light& light_;
  mutable std::optional<Double3> sun_;
};

/// Rows whose point lies on the back of a closed surface.  The light shines from its front, which
/// hides the point, so the value of 0 is right.
std::vector<bool> on_back(const v1::Light& light, const Records& rows);

/// Where rays meet a light.  NaN for rays that do not, and for lights at infinity.
struct Hits {
  std::vector<double> distance;   ///< [m]
  std::vector<double> cos_light;  ///< of the angle at the light, at least 0
  std::vector<Double3> normals;   ///< of the light there
  bool behind = false;            ///< some receiver is behind a one-sided light
};

/// Finds the places by the planes of nearby samples: exact on flat surfaces, and nearly so on
/// curved ones.
Hits hits(Truth& truth, const v1::Light& light, const std::vector<Double3>& points,
          const std::vector<Double3>& directions);

/// Whether the surface lies in one plane, so that hits() are exact.
bool is_plane(const v1::DiffuseAreaLight& area);

}  // namespace lucerna::verify
