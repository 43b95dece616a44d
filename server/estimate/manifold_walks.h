// Light of lamps without a size by way of curved smooth surfaces.
//
// No direction finds such a lamp, and no closed form gives its path.  A walk draws a direction from
// the receiver to such a surface and follows it.  Newton's method then turns the direction until
// the last leg meets the lamp.  [Jakob12]  Several walks make a set; each path that a set finds
// counts once.  Sets are drawn again until one finds the path again.  Their number has the mean 1 /
// probability of the path in a set, so the estimate needs no density.  [Zeltner20]
#pragma once

#include <absl/container/inlined_vector.h>
#include <absl/functional/function_ref.h>

#include <cstdint>
#include <optional>
#include <vector>

#include "server/estimate/light_visibility.h"
#include "server/estimate/path_sample.h"
#include "server/estimate/smooth_light.h"
#include "server/runtime/work_counts.h"
#include "server/scene/scene.h"

namespace lucerna {

/// Immutable; may be called from any thread.
class ManifoldWalks {
 public:
  /// All arguments must outlive this object.
  ManifoldWalks(const Scene& scene, const LightVisibility& visibility, const SmoothLight& smooth);

  /// Whether light may arrive in this way at all.
  bool any() const { return !surfaces_.empty() && !lights_.empty(); }

  /// Estimates the irradiance [lx] at a receiver for each light that a set of `walks` walks finds.
  /// `most_steps`: the most surfaces of a path.  A path that fewer than one of kMostSets sets find
  /// counts too little.
  using AddIrradiance = absl::FunctionRef<void(std::uint32_t light, const Rgb& lx)>;
  void sample(const SurfaceHit& receiver, std::uint32_t walks, std::uint32_t most_steps,
              const PathSample& s, WorkCounts& work, const AddIrradiance& found) const;
  static constexpr std::uint32_t kMostSets = 256;

 private:
  /// What a path does at one surface.
  struct Link {
    std::uint64_t shape;
    bool passes;
    bool operator==(const Link&) const = default;
  };
  using Links = absl::InlinedVector<Link, 4>;
  struct Path {
    Links links;
    Vec3 start;        ///< unit, at the receiver
    double apart = 0;  ///< paths whose starts differ by less are the same one
    Rgb lx;
  };
  /// Where a ray by way of some surfaces is at last.
  struct End {
    SurfaceHit hit;
    Vec3 along;
    Rgb share{1};
    SmoothLight::Before before;
    bool met_curved = false;
  };
  /// A lamp without a size, as a target of rays.
  struct Aim;
  /// A turn of a path's start that should bring its last leg to the lamp.
  struct Step {
    double a, b;    ///< about the two axes across the start [rad]
    double spread;  ///< the solid angle at the receiver for each m2 at the lamp, or for each sr
  };
  struct Solution {
    End end;
    double spread;
  };
  class Numbers;

  std::optional<Path> walk(const SurfaceHit& receiver, std::uint32_t light,
                           std::uint32_t most_steps, Numbers& numbers, WorkCounts& work) const;
  /// Turns the start of a path until it arrives at the lamp.  `size`: the angle of the surface
  /// [rad].
  std::optional<Solution> solve(const SurfaceHit& receiver, const Aim& aim, double size, Path& path,
                                WorkCounts& work) const;
  /// `h`: the turn for derivatives [rad].
  std::optional<Step> newton_step(const SurfaceHit& receiver, const Path& path, const Aim& aim,
                                  const End& end, double h, WorkCounts& work) const;
  /// Takes a step, or half of it and so on, that comes closer.  Nothing if none does.
  std::optional<End> closer(const SurfaceHit& receiver, Path& path, const Aim& aim, const End& end,
                            Step step, WorkCounts& work) const;
  /// Chooses what a path does along a ray.  Empty if it meets no smooth surface.
  Links choose_links(const SurfaceHit& receiver, const Vec3& start, std::uint32_t most_steps,
                     Numbers& numbers, WorkCounts& work) const;
  std::optional<End> follow(const SurfaceHit& receiver, const Vec3& start, const Links& links,
                            WorkCounts& work) const;
  /// The next surface that does more than let light pass straight on.  Multiplies `share`.
  std::optional<SurfaceHit> next_surface(const SurfaceHit& from, const Vec3& along, Rgb& share,
                                         WorkCounts& work) const;

  const Scene& scene_;
  const LightVisibility& visibility_;
  const SmoothLight& smooth_;
  const SmoothSurfaces& smooth_surfaces_;
  std::vector<Bounds> surfaces_;  ///< of smooth surfaces without computed paths
  std::vector<std::uint32_t> lights_;
};

}  // namespace lucerna
