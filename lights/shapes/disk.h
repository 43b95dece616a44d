// The disk, an annulus or a sector, under any affine map.  Points uniform on the disk stay uniform
// on its ellipse.
#pragma once

#include <absl/status/statusor.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>

#include "lights/maths/normal_cone.h"
#include "lights/maths/transform.h"
#include "lights/sampling/light_sample.h"
#include "lights/shapes/quadric.h"

namespace lucerna {

/// Object space: in the plane z = height, normal +z.  [Pharr23, 6.4]
struct DiskParams {
  double height_m = 0;
  double radius_m = 1;                     ///< > 0
  double inner_radius_m = 0;               ///< [0, radius)
  double phi_max_rad = 6.283185307179586;  ///< swept about +z from +x; (0, 2 pi]
  bool reverse_orientation = false;        ///< the normal points to -z
  Transform world_from_object = {};
};

/// The normal stays on the side of object space's +z, also under mirrors, unless
/// `reverse_orientation` is set.  Immutable, so safe to share between threads.  Calls allocate only
/// for error messages.
class Disk final : public Quadric<Disk, DiskParams> {
 public:
  static constexpr std::string_view kName = "disk";

  /// Errors: a field out of its domain; bounds that `double` cannot hold.
  static absl::StatusOr<Disk> create(const DiskParams& params, const Vec3& origin_m = {});

  absl::Status emissive_error() const override { return absl::OkStatus(); }

  /// A point chosen in the way that `receiver` requests.  kSolidAngle applies to a whole disk under
  /// a map of equal scale, if lights/sampling/spherical_ellipse.h has a density at the receiver.
  /// All other cases are uniform by area.  [Pharr23, 6.4.3; Guillen17]
  ShapeSample sample(const Receiver& receiver, Vec2 u) const override;
  /// The density of `sample` at a point of the surface.
  SolidAnglePdf pdf(const Receiver& receiver, const SurfacePoint& point) const override;

  /// How far `p` is above the plane, on the side of the normal [m]; as in Triangle.
  double height_of(const Vec3& p) const;
  std::optional<double> height_over(const SurfacePoint&, const Vec3& p) const override {
    return height_of(p);
  }
  /// Whether `p`, which is in the plane, is within the disk or on its edges to 1e-14.
  bool touches(const Vec3& p, std::uint32_t primitive = 0) const override;

  bool has_closed_form() const override { return true; }
  /// Where the horizon cuts a disk, the form takes too long.
  bool has_fast_closed_form() const override { return false; }
  /// The projected solid angle [sr] of the sides that emit towards `position`, above the horizon of
  /// the unit vector `normal`.  Nothing for shapes that are not a whole circle.
  std::optional<double> projected_solid_angle_sr(const Vec3& position, const Vec3& normal,
                                                 bool two_sided) const override;
  bool hides_itself() const override { return false; }

  /// The single normal.
  NormalCone normals() const override;

  /// The mapping of pictures: u is the share of the sweep, v runs from the rim (0) to the inner
  /// edge (1).  [Pharr23, 6.4.2]
  Vec2 uv(const SurfacePoint& point) const override;
  BandArea area_of(const Band& band) const override;
  SurfacePoint at_shares(Vec2 shares) const override;

  /// World bounds about the origin, {lower, upper}. A sector has the bounds of the whole disk.
  std::pair<Vec3, Vec3> bounds() const override;

  /// The whole ellipse, as a prism of height 0.
  RoundEnclosure enclosure() const {
    const Transform& t = this->world_from_object();
    const double r = this->params().radius_m;
    return {t.point({0, 0, this->params().height_m}),
            t.vector({r, 0, 0}),
            t.vector({0, r, 0}),
            {},
            true};
  }

 private:
  Disk(const DiskParams& params, const Vec3& origin_m);
  /// Rays within the plane do not hit.
  int roots(const Vec3& origin, const Vec3& direction, double t_min, double t_max,
            QuadricRoots& out) const;
  struct Seen;
  Seen seen_from(const Receiver& receiver) const;
  SolidAnglePdf pdf(const Seen& seen, const Receiver& receiver, const SurfacePoint& point) const;

  std::optional<Vec3> nearest(const Vec3& q) const;
  Vec3 normal_at(const Vec3&) const { return normal_; }

  using Base = Quadric<Disk, DiskParams>;
  friend Base;
  using Base::area_m2_, Base::object_from_world_, Base::params_, Base::world_from_object_;
  using Base::on_ring, Base::surface_point;

  Vec3 normal_;
  bool is_circle_;  // whole, and a circle in the world
};

}  // namespace lucerna
