// How far one light sees: a depth for each texel of the planes that it looks through.  [Williams78]
//
// A light at a point looks through one square about the axis of its cone, or through the six faces
// of a cube; a distant light through one square that holds the scene's sphere.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "lights/maths/vec.h"
#include "lights/sampling/light_sample.h"
#include "server/scene/scene.h"

namespace lucerna {

/// Through which planes a light looks; about the scene's origin.
struct ShadowMapView {
  Vec3<double> from;  ///< the light's position; of a distant light the scene sphere's centre [m]
  struct Face {
    Vec3<double> right, up, forward;  ///< unit, at right angles
  };
  std::array<Face, 6> faces;
  std::uint32_t face_count;
  /// Half a face's side at a distance of 1; of a distant light that of the square itself [m].
  double half;
  bool is_distant;
};

/// How `light` looks at the scene.  Nothing for lights that keep rays: those with an extent, beams,
/// those that move.
std::optional<ShadowMapView> shadow_map_view(const SceneLight& light, const SceneSphere& sphere);

/// Immutable; all members may be called from any thread.
class ShadowMap {
 public:
  /// Asks a ray for each of the side x side texels of each face, by the threads of the caller's
  /// arena.
  ShadowMap(const Scene& scene, const ShadowMapView& view, std::uint32_t side);

  /// Whether the map says that something stands between the light and `position`; `normal`: of the
  /// surface there, or zero where it has none.  Nothing where the light does not look there.
  std::optional<bool> is_occluded(const Vec3<double>& position, const Vec3<double>& normal) const;

  std::uint64_t bytes() const { return sizeof *this + depths_.capacity() * sizeof depths_[0]; }

 private:
  /// Where a face's plane is looked through: the texel, and its centre in [-1, 1]^2.
  struct Texel {
    std::size_t number;
    double x, y;
  };
  std::optional<Texel> texel(std::uint32_t face, double x, double y) const;

  ShadowMapView view_;
  std::uint32_t side_;
  double rounding_m_;          // by what rays are off near the light
  std::vector<float> depths_;  // along `forward`, face by face, row by row [m]; infinite: nothing
};

}  // namespace lucerna
