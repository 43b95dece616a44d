// How much light a surface of GGX microfacets reflects in all, from a table.
#pragma once

namespace lucerna {

/// Shares of the light that arrives from all directions with the same radiance.
struct FacetAlbedo {
  double all{};      ///< if each facet reflects everything
  double schlick{};  ///< if each facet reflects (1 - cos)^5, of the angle between light and facet

  /// If each facet reflects f0 + (f90 - f0) (1 - cos)^5.  [Schlick94]
  double of(double f0, double f90) const { return f0 * (all - schlick) + f90 * schlick; }
};

/// Towards a direction whose cosine to the normal is `cosine`, in [0, 1].  `alpha`: roughness, from
/// 0 to 1.  Light that hits two facets is lost.  The table is linear between its nodes, with errors
/// below 4e-3, and below 0.02 where cosine < 0.05 and alpha < 0.01.  The first call makes it.
FacetAlbedo facet_albedo(double cosine, double alpha);

/// The mean of facet_albedo over directions, weighted by their cosine.  Exact for the values that
/// facet_albedo returns.
FacetAlbedo mean_facet_albedo(double alpha);

}  // namespace lucerna
