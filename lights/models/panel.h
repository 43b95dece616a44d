// A flat shape of an area light that emits by a luminaire's photometry: equal at all points, but
// not in all directions.
//
// An area A whose radiance L depends only on the direction has the far field A cos(theta) L. The
// luminous intensity I(w) of a file therefore comes from the radiance
//
//   L(w) = I(w) / (A |cos(theta)|),   theta between w and the normal.
//
// Near the panel, the light is that of an evenly bright opening of this size.  Planning programs
// use this area source for a luminaire.  Close to a real luminaire the light differs from it:
// [Ngai87]
#pragma once

#include <absl/status/statusor.h>

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "lights/pictures/photometric_web.h"
#include "lights/shapes/area_shape.h"
#include "lights/shapes/covered.h"

namespace lucerna {

/// The photometry of a panel and its orientation.
struct PanelProfile {
  std::shared_ptr<const PhotometricWeb> web;  ///< not null
  /// The direction of photometric +x (the plane C0), world, of any length but 0 and not along the
  /// normal.  Its component along the normal is ignored.  Photometric +z is the normal.
  Vec3 tangent{1, 0, 0};
  bool mirrored = false;  ///< +y is tangent x normal, else normal x tangent
  std::string file, format;
  std::string web_unit{}, flux_unit{};  ///< as GoniometricLightParams has them
};

/// `Surface` is one of this library's shapes that can be flat.  Immutable, so safe to share between
/// threads.  Copies share all data.
template <typename Surface>
class Panel : public Covered<Panel<Surface>, Surface> {
 public:
  /// Errors: normals more than 1e-3 rad from their mean; a tangent that is zero or along the
  /// normal.
  static absl::StatusOr<Panel> create(Surface surface, PanelProfile profile);

  ShapeSample sample(const Receiver& receiver, Vec2 u) const {
    return data_->surface.sample(receiver, u);
  }
  SolidAnglePdf pdf(const Receiver& receiver, const SurfacePoint& point) const {
    return data_->surface.pdf(receiver, point);
  }
  AreaPdf pdf_area(const SurfacePoint& point) const { return data_->surface.pdf_area(point); }
  /// Memory without the photometric web, which lights share.
  std::size_t bytes() const { return sizeof(Data) - sizeof(Surface) + surface().bytes(); }

  /// Radiance [cd/m2] towards the unit vector `w`, world, from a point of unit normal `normal`. Not
  /// finite along the surface if the file has light in that direction.
  double radiance(const Vec3& w, const Vec3& normal) const;
  /// A direction chosen by the flux of the file's cells, to both sides of the panel, and its
  /// density.
  Vec3 sample_direction(Vec2 u) const;
  SolidAnglePdf pdf_direction(const Vec3& w) const;
  /// Flux of the front or of both sides [lm].  The front is above the mean plane.
  double flux_lm(bool two_sided) const;
  /// A bound on the error of the front's flux for a bent shape [lm].  It is the file's flux within
  /// the largest tilt of a normal from the horizon.  0 for both sides together, and for shapes that
  /// are flat up to the rounding of their normals.
  double flux_error_lm(bool two_sided) const;
  /// A cone with all directions of the front or of both sides.
  NormalCone directions(bool two_sided) const;

  const Surface& surface() const { return data_->surface; }
  const PanelProfile& profile() const { return data_->profile; }

 private:
  struct Data {
    Surface surface;
    PanelProfile profile;
    Frame axes;  ///< photometric x, y, z
  };
  explicit Panel(Data data) : data_(std::make_shared<const Data>(std::move(data))) {}

  std::shared_ptr<const Data> data_;
};

// PanelTriangleMesh and so on.
#define LUCERNA_PANEL(Shape)         \
  using Panel##Shape = Panel<Shape>; \
  extern template class Panel<Shape>;
LUCERNA_FLAT_SHAPES(LUCERNA_PANEL)
#undef LUCERNA_PANEL

}  // namespace lucerna
