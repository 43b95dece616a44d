// Whether nothing stands between a receiver and all of a light, found without rays: the light's
// irradiance in closed form (lights/models/irradiance.h) is then all that arrives.
//
// What shadow rays to the light pass through is a shaft: the pyramid from the receiver to the
// outline of the light, cut off by the receiver's horizon and by the light.  A surface is clipped
// by the planes of the shaft; if a part of it is left, or may be left, the shaft is not empty.
// [Haines91]
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "server/description/scene_description.h"
#include "server/rays/ray.h"

namespace lucerna {

class Accelerator;
class Scene;
struct SceneLight;
struct SurfaceTable;

/// Boxes about all surfaces of a scene and the outlines of its lights.  Refers to the scene's
/// geometry.  Immutable once built; all const members may be called from any thread.
class Shafts {
 public:
  explicit Shafts(const Scene& scene);
  ~Shafts();
  Shafts(const Shafts&) = delete;
  Shafts& operator=(const Shafts&) = delete;

  /// True only where no shadow ray from `receiver` to any point of the light on the side of
  /// `normal` (unit: the one that light is counted on, ns or -ns) meets anything.  The surfaces
  /// that the receiver and the light are on count as shadow rays see them: not within the errors
  /// of their positions (server/rays/error_bounds.h).
  ///
  /// False also where that is not known: of lights without an outline (has_outline), of surfaces
  /// that move, at a receiver in the light's plane or inside of a sphere light, where the shading
  /// normal is not the geometric one and the horizon cuts the light.
  bool is_empty(const SurfaceHit& receiver, const Vec3<float>& normal, std::uint32_t light) const;

  /// Whether the light of this index has an outline, flat or that of a whole sphere, a sun, a
  /// portal or the whole sky, and rests.
  bool has_outline(std::uint32_t light) const;

  std::size_t bytes() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The shafts of a scene, built by whoever uses them first: LazyPart says what callers must keep
/// to.
const Shafts& shafts(const Scene& scene);

}  // namespace lucerna
