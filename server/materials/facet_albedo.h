// How much light a surface of GGX microfacets reflects in all, from a table.
#pragma once

#include <concepts>

namespace lucerna {

/// Shares of the light that arrives from all directions with the same radiance.
template <std::floating_point Real>
struct FacetAlbedo {
  Real all{};      ///< if each facet reflects everything
  Real schlick{};  ///< if each facet reflects (1 - cos)^5, of the angle between light and facet

  /// If each facet reflects f0 + (f90 - f0) (1 - cos)^5.  [Schlick94]
  Real of(Real f0, Real f90) const { return f0 * (all - schlick) + f90 * schlick; }
};

/// Towards a direction whose cosine to the normal is `cosine`, in [0, 1].  `alpha`: roughness, from
/// 0 to 1.  Light that hits two facets is lost.  The table is linear between its nodes, with errors
/// below 4e-3, and below 0.02 where cosine < 0.05 and alpha < 0.01.  The first call makes it.
template <std::floating_point Real>
FacetAlbedo<Real> facet_albedo(Real cosine, Real alpha);

/// The mean of facet_albedo over directions, weighted by their cosine.  Exact for the values that
/// facet_albedo returns.
template <std::floating_point Real>
FacetAlbedo<Real> mean_facet_albedo(Real alpha);

}  // namespace lucerna
