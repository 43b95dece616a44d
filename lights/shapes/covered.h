// The members that a shape with a picture or with photometry takes from the underlying shape.
#pragma once

#include <absl/status/status.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>

#include "lights/maths/normal_cone.h"
#include "lights/shapes/shape.h"

namespace lucerna {

/// `Shape` has `surface()`, a `Surface` of `double`.
template <typename Shape, typename Surface>
class Covered {
 public:
  static constexpr bool kHasProjectedSolidAngle = false;

  double area() const { return under().area(); }
  double area_error_m2() const { return under().area_error_m2(); }
  absl::Status emissive_error() const { return under().emissive_error(); }
  template <typename F>
  void for_each_hit(const Vec3& receiver, const Vec3& wi, F&& f) const {
    under().for_each_hit(receiver, wi, std::forward<F>(f));
  }
  std::optional<double> height_over(const SurfacePoint& point, const Vec3& p) const {
    return under().height_over(point, p);
  }
  double height_above(const Vec3& p, const Vec3& n) const { return under().height_above(p, n); }
  std::optional<SurfacePoint> locate(const Vec3& position, double slack_m = 0) const {
    return under().locate(position, slack_m);
  }
  Vec3 located_normal(const SurfacePoint& p, double slack_m) const {
    return under().located_normal(p, slack_m);
  }
  bool touches(const Vec3& p, std::uint32_t primitive) const {
    return under().touches(p, primitive);
  }
  NormalCone normals() const { return under().normals(); }
  std::pair<Vec3, Vec3> bounds() const { return under().bounds(); }
  std::size_t size() const { return under().size(); }

 private:
  const Surface& under() const { return static_cast<const Shape&>(*this).surface(); }
};

}  // namespace lucerna
