// The shadow map of one light: a depth for each texel of its image planes.  [Williams78]
//
// The planes of a light at a point are one square about the axis of its cone, or the six faces
// of a cube.  A distant light has one square that contains the scene's sphere.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "lights/maths/vec.h"
#include "lights/sampling/light_sample.h"
#include "server/scene/scene.h"

namespace lucerna {

/// The image planes of a light, about the scene's origin.
struct ShadowMapView {
  /// Position of the light [m]; of a distant light the centre of the scene's sphere [m].
  Vec3 from;
  struct Face {
    Vec3 right, up, forward;  ///< unit, at right angles to each other
  };
  std::array<Face, 6> faces;
  std::uint32_t face_count;
  /// Half of a face's side at distance 1; of a distant light half of the square's side [m].
  double half;
  bool is_distant;
};

/// The image planes of `light`.  Nothing for lights without maps: those with an extent, beams,
/// and lights that move.
std::optional<ShadowMapView> shadow_map_view(const SceneLight& light, const SceneSphere& sphere);

/// Immutable; all members may be called from any thread.
class ShadowMap {
 public:
  /// Traces a ray for each of the side x side texels of each face, on the threads of the
  /// caller's arena.
  ShadowMap(const Scene& scene, const ShadowMapView& view, std::uint32_t side);

  /// Whether the map has an obstacle between the light and `position`.  `normal`: of the surface
  /// there, or zero without a surface.  Nothing if `position` is outside of the image planes.
  std::optional<bool> is_occluded(const Vec3& position, const Vec3& normal) const;

  std::uint64_t bytes() const { return sizeof *this + depths_.capacity() * sizeof depths_[0]; }

 private:
  /// A texel, and its centre on the face in [-1, 1]^2.
  struct Texel {
    std::size_t number;
    double x, y;
  };
  std::optional<Texel> texel(std::uint32_t face, double x, double y) const;

  ShadowMapView view_;
  std::uint32_t side_;
  double rounding_m_;  // error of rays near the light
  // Along `forward`, face by face, row by row [m]; infinite if nothing is hit.
  std::vector<float> depths_;
};

}  // namespace lucerna
