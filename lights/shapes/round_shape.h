// How spheres, disks and cylinders show pictures: in rows around their axis.
#pragma once

#include <optional>

#include "lights/shapes/shape.h"

namespace lucerna {

/// A surface swept about an axis.  The u of a picture is the share of the sweep, and v runs along
/// the surface from one end to the other.
class RoundShape : public Shape {
 public:
  /// The part of the area in a band of a picture.
  virtual BandArea area_of(const Band& band) const = 0;
  /// The point at a share of the sweep and a share of the area below it, both in [0, 1].
  virtual SurfacePoint at_shares(Vec2 shares) const = 0;

  PaintedArea painted_area(const Picture& picture) const final;
  std::optional<ImageDistribution> distribution(const Picture& picture) const final;
  SurfacePoint sample_picture(const Picture& picture, const ImageDistribution& distribution,
                              Vec2 u) const final;
  AreaPdf pdf_picture(const Picture& picture, const ImageDistribution& distribution,
                      const SurfacePoint& point) const final;
};

}  // namespace lucerna
