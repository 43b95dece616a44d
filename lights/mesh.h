// Meshes as the shape of an area light: primitives chosen by area, then sampled by area.
#pragma once

#include <absl/status/statusor.h>

#include <cstddef>
#include <vector>

#include "lights/bilinear_patch.h"
#include "lights/light_sample.h"
#include "lights/sphere.h"
#include "lights/triangle.h"

namespace lucerna {

/// `Primitive<Real>` is Triangle or BilinearPatch.  Winding decides the emitting side: cross of the
/// first two edges.  Primitives of zero area are kept (their numbers are the caller's) and never
/// sampled.
template <typename Real, template <typename> typename Primitive>
class Mesh {
 public:
  /// Primitives already about the scene's origin.  Errors: none, not finite, no area at all.
  static absl::StatusOr<Mesh> create(std::vector<Primitive<Real>> primitives);

  double area() const { return cumulative_area_.back(); }
  absl::Status emissive_error() const { return absl::OkStatus(); }
  ShapeSample<Real> sample(const Vec3<Real>& receiver, Vec2<Real> u) const;
  SolidAnglePdf<Real> pdf(const Vec3<Real>& receiver, const SurfacePoint<Real>& point) const;
  template <typename F>
  void for_each_hit(const Vec3<Real>& receiver, const Vec3<Real>& wi, F&& f) const;
  std::pair<Vec3<Real>, Vec3<Real>> bounds() const;
  std::size_t bytes() const;
  std::size_t size() const { return primitives_.size(); }

 private:
  explicit Mesh(std::vector<Primitive<Real>> primitives, std::vector<double> cumulative_area);
  std::vector<Primitive<Real>> primitives_;
  std::vector<double> cumulative_area_;  ///< running sums [m2]
};

template <typename Real>
using TriangleMesh = Mesh<Real, Triangle>;
template <typename Real>
using PatchMesh = Mesh<Real, BilinearPatch>;

}  // namespace lucerna
