// Tests without rays whether nothing is between a receiver and all of a light.  If so, exactly the
// light's irradiance in closed form (lights/models/irradiance.h) arrives.
//
// A shaft contains all shadow rays from the receiver to the light.  It is the pyramid from the
// receiver to the outline of the light, cut off by the receiver's horizon and by the light.  The
// planes of the shaft clip each surface.  If a part of it is left, or may be left, the shaft is
// not empty.  [Haines91]
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "server/description/scene_description.h"
#include "server/rays/ray.h"

namespace lucerna {

class Accelerator;
class Scene;
struct SceneLight;
struct SurfaceTable;

/// The outlines of a scene's lights.  Refers to boxes around its surfaces and to their geometry.
/// Immutable once built; all const members may be called from any thread.
class Shafts {
 public:
  static constexpr const char* kPartName = "shafts";
  explicit Shafts(const Scene& scene);
  ~Shafts();
  Shafts(const Shafts&) = delete;
  Shafts& operator=(const Shafts&) = delete;

  /// True only if no shadow ray from `receiver` to any point of the light on the side of
  /// `normal` meets anything.  `normal` is unit: ns or -ns, the side on which light counts.
  /// Surfaces of the receiver and of the light count as for shadow rays: not within the
  /// errors of their positions (server/rays/error_bounds.h).
  ///
  /// Also false if the answer is unknown.  It is unknown for lights without an outline
  /// (has_outline), for surfaces that move, and for a receiver in the light's plane or inside a
  /// sphere light.
  /// Also false if the shading normal differs from the geometric normal and the horizon cuts the
  /// light.
  bool is_empty(const SurfaceHit& receiver, const Vec3f& normal, std::uint32_t light) const;

  /// Whether the light with this index does not move and has an outline: a flat one, a whole
  /// sphere, a sun, a portal or the whole sky.
  bool has_outline(std::uint32_t light) const;

  std::size_t bytes() const;
  std::string why() const { return "a query used closed forms"; }

 private:
  struct Boxes;
  struct State;
  std::unique_ptr<State> state_;
};

/// The shafts of a scene, built at the first call.  LazyPart states the rules for callers.
const Shafts& shafts(const Scene& scene);

}  // namespace lucerna
