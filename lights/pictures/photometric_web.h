// The photometric web: luminous intensity measured on a grid of angles around a luminaire, as in
// IES LM-63 and EULUMDAT files.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "lights/maths/emission_cone.h"
#include "lights/pictures/photometric_angles.h"
#include "lights/sampling/light_sample.h"

namespace lucerna {

struct PhotometricWebParams {
  PhotometricType type = PhotometricType::kC;
  /// Ascending [degrees], as in files, and as check_vertical_angles and check_horizontal_angles
  /// have it.  all_planes() adds planes by symmetry.  Directions outside are dark.
  std::vector<double> vertical_deg, horizontal_deg;
  /// All vertical angles at the first horizontal angle, then at the next.  Finite, not negative.
  std::vector<double> intensity_cd;
};

/// Intensity, bilinear in the two angles between grid points; at a pole the mean of all planes.
/// Immutable, so lights share it.
class PhotometricWeb {
 public:
  /// Errors: angles other than those of PhotometricWebParams; a number of intensities that does not
  /// fit the grid; an intensity that is negative or not finite.
  static absl::StatusOr<std::shared_ptr<const PhotometricWeb>> create(
      const PhotometricWebParams& params);

  /// Luminous intensity [cd] towards `w`, of any length but 0, light space.
  double at(const Vec3& w) const;

  /// Luminous flux [lm]: the integral of `at` over the sphere, in closed form for each cell.
  double flux_lm() const { return flux_lm_; }
  /// The part of the flux towards +z, downwards [lm].  In closed form too.
  double downward_flux_lm() const;
  /// A bound on the flux within this angle of the horizon, on either side of it [lm]. For types A
  /// and C it equals the larger flux of the two sides.
  double horizon_flux_bound_lm(double width_rad) const;
  /// The largest intensity [cd].
  double max_cd() const { return max_cd_; }

  /// A direction, unit, light space: a cell by its flux, then uniform in solid angle within the
  /// cell.  Undefined if the flux is 0.
  Vec3 sample(Vec2 u) const;
  /// The density of `sample`: positive wherever the intensity is.
  SolidAnglePdf pdf(const Vec3& w) const;

  /// The narrowest cone of light around a pole of the grid or, for types A and B, around V = H = 0.
  const EmissionCone& cone() const { return cone_; }

  PhotometricType type() const { return type_; }
  std::uint64_t bytes() const;

 private:
  /// A place on the grid: the cell, and the position in it from 0 to 1.
  struct GridPosition {
    std::size_t row, column;
    double s, t;
    bool inside, at_pole;
  };
  explicit PhotometricWeb(const PhotometricWebParams& params);
  void write_out(const PhotometricWebParams& params);
  void integrate();
  void bound();
  GridPosition find(const Vec3& w) const;
  double value(std::size_t row, std::size_t column) const {
    return cd_[row * polar_rad_.size() + column];
  }
  /// The mean intensity of all azimuths at a polar angle [cd].
  double mean_of_column(std::size_t column) const;
  /// The flux of a cell [lm] and its solid angle [sr].
  double cell_flux(std::size_t row, std::size_t column) const;
  double solid_angle(std::size_t row, std::size_t column) const;
  /// The flux between two polar angles [lm].
  double flux_between(double from, double to) const;
  std::size_t rows() const { return azimuth_rad_.size() - 1; }
  std::size_t columns() const { return polar_rad_.size() - 1; }

  PhotometricType type_;
  std::vector<double> polar_rad_;    ///< from the pole, ascending within [0, pi]
  std::vector<double> azimuth_rad_;  ///< ascending, over 2 pi at most
  std::vector<double> cd_;           ///< all polar angles at the first azimuth, then at the next
  std::vector<double> cumulative_;   ///< flux of the cells up to and with each [lm]
  double flux_lm_ = 0, max_cd_ = 0;
  EmissionCone cone_;
};

}  // namespace lucerna
