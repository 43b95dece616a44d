// A flat shape that shines as a luminaire's photometry says, as the shape of an area light: the
// same everywhere on it, but not in all directions.
//
// An area A whose radiance L depends on the direction alone has the far field A cos(theta) L; so
// the luminous intensity I(w) of a file comes from the radiance
//
//   L(w) = I(w) / (A |cos(theta)|),   theta between w and the normal,
//
// and near the panel is what an evenly bright opening of this size gives, which is the area source
// that planning programs take a luminaire for.  How near luminaires differ from it: [Ngai87]
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

/// The photometry of a panel, and how it lies there.
struct PanelProfile {
  std::shared_ptr<const PhotometricWeb> web;  ///< not null
  /// Where photometric +x (the plane C0) points, world, of any length but 0 and not along the
  /// normal; what of it is along the normal does not count.  Photometric +z is the normal.
  Vec3<double> tangent{1, 0, 0};
  bool mirrored = false;  ///< +y is tangent x normal, else normal x tangent
  std::string file, format;
};

/// `Surface` is one of this library's shapes that can be flat.  Immutable, so safe to share between
/// threads; copies share all they hold.
template <typename Real, template <typename> typename Surface>
class Panel : public Covered<Panel<Real, Surface>, Real, Surface<Real>> {
 public:
  /// Errors: normals more than 1e-3 rad from their mean; a tangent that is none.
  static absl::StatusOr<Panel> create(Surface<Real> surface, PanelProfile profile);

  ShapeSample<Real> sample(const Receiver<Real>& receiver, Vec2<Real> u) const {
    return data_->surface.sample(receiver, u);
  }
  SolidAnglePdf<Real> pdf(const Receiver<Real>& receiver, const SurfacePoint<Real>& point) const {
    return data_->surface.pdf(receiver, point);
  }
  AreaPdf<double> pdf_area(const SurfacePoint<Real>& point) const {
    return data_->surface.pdf_area(point);
  }
  /// Without the photometric web, which lights share.
  std::size_t bytes() const { return sizeof(Data) - sizeof(Surface<Real>) + surface().bytes(); }

  /// Radiance [cd/m2] towards the unit vector `w`, world, from a point of unit normal `normal`; not
  /// finite along the surface where the file has light there.
  double radiance(const Vec3<double>& w, const Vec3<double>& normal) const;
  /// A direction by the flux of the file's cells, to both sides of the panel; and its density.
  Vec3<double> sample_direction(Vec2<double> u) const;
  SolidAnglePdf<double> pdf_direction(const Vec3<double>& w) const;
  /// Of the front, or of both sides [lm].  The front is what lies above the mean plane.
  double flux_lm(bool two_sided) const;
  /// A bound on what the front's differs from that because the shape is bent: what the file has as
  /// near the horizon as normals lean [lm].  0 of both sides, and of shapes that are flat to the
  /// rounding of their normals.
  double flux_error_lm(bool two_sided) const;
  /// A cone with all directions of the front, or of both sides.
  NormalCone<Real> directions(bool two_sided) const;

  const Surface<Real>& surface() const { return data_->surface; }
  const PanelProfile& profile() const { return data_->profile; }

 private:
  struct Data {
    Surface<Real> surface;
    PanelProfile profile;
    Frame<double> axes;  ///< photometric x, y, z
  };
  explicit Panel(Data data) : data_(std::make_shared<const Data>(std::move(data))) {}

  std::shared_ptr<const Data> data_;
};

// PanelTriangleMesh and so on.
#define LUCERNA_PANEL(Shape)                 \
  template <typename Real>                   \
  using Panel##Shape = Panel<Real, Shape>;   \
  extern template class Panel<float, Shape>; \
  extern template class Panel<double, Shape>;
LUCERNA_FLAT_SHAPES(LUCERNA_PANEL)
#undef LUCERNA_PANEL

}  // namespace lucerna
