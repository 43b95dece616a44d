// Light that arrives from lamps by way of mirrors, panes and glass.
//
// A path from a receiver to a point of a lamp by given smooth surfaces is computed, and its rays
// test that nothing is in the way.  Sequences of surfaces form a tree.  Receivers visit the short
// ones, as far as they are not too many, and random walks choose the others.  So the estimate has
// the right mean for any number of surfaces up to kMostSteps.
//
// `counts` is the rule by which paths that find lamps by chance leave this light out.
#pragma once

#include <absl/container/inlined_vector.h>

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "server/estimate/lamp_rays.h"
#include "server/estimate/light_strategy.h"
#include "server/estimate/light_visibility.h"
#include "server/estimate/path_sample.h"
#include "server/estimate/surface_scattering.h"
#include "server/runtime/work_counts.h"
#include "server/scene/light_at_time.h"
#include "server/scene/scene.h"
#include "server/visibility/smooth_surfaces.h"
#include "server/visibility/specular_path.h"

namespace lucerna {

/// Immutable; may be called from any thread.
class SmoothLight {
 public:
  /// All arguments must outlive this object.
  SmoothLight(const Scene& scene, const Methods& methods, const LightVisibility& visibility);

  /// Whether light may arrive in this way at all.
  bool any() const { return has_steps_ || !deltas_.empty(); }

  /// A point that scatters light in more than single directions.
  struct Vertex {
    const SurfaceHit& hit;
    const Vec3f& wo;
    /// Null: diffuse with reflectance 1.
    const SurfaceScattering* scattering;
    std::uint32_t depth;  ///< reflections between the vertex and the camera or receiver
    bool is_receiver;     ///< whether a query asks for its light; else it is on a path
    /// The most surfaces between the vertex and the lamp.
    std::uint32_t most_steps;
    /// Whether light of lamps with a size is sampled too (`counts_at`).
    bool counts_sizes = true;
    /// Whether each light is sampled.  Else one is chosen if there are many.
    bool each_light = false;
  };
  /// Estimates the radiance [cd/m2] that the surface sends towards `wo`.  Calls `found` for each
  /// light that was sampled; the estimates add up.
  void sample(const Vertex& v, const PathSample& s, WorkCounts& work, const AddLight& found) const;

  /// The same for light of delta lights by way of planes that are nearly mirrors: a part of the
  /// light that these reflect.  Directions find the rest (`glossy_weight`).
  void sample_glossy(const Vertex& v, const PathSample& s, WorkCounts& work,
                     const AddLight& found) const;

  /// Adds the directions from which planes that are nearly mirrors send light of lamps with a size.
  void guide(const SurfaceHit& receiver, GuidedDirections& to) const;

  /// A vertex from which a direction led to another one.
  struct Before {
    Vec3 position;
    double pdf = 0;  ///< of the direction [1/sr]; 0: it was a single one, or a camera's
    // Of the last vertex that is not left in a single direction.
    bool is_receiver = false;
    bool counted = false;  ///< `counts_at`, and then whether all steps since are those of `sample`
    // Of the single directions since then.
    std::uint32_t singles = 0;
    bool is_bent = false, met_ball = false;
    bool met_unsolved = false;  ///< a smooth surface that is no part
  };
  /// The same after a single direction of the surface at `hit`, from `wi` to `wo`.
  Before after_single(const Before& before, const SurfaceHit& hit, const Vec3& wo,
                      const Vec3& wi) const;
  /// Whether `sample` at the last vertex counts the light that single directions found there.
  bool counts(const Before& before, std::uint32_t light) const {
    return before.counted && !(before.is_bent && is_portal(light)) &&
           (before.is_receiver || !is_everywhere_[light]);
  }
  /// The weight of light from a delta light at `hit`, which a direction of the vertex before it
  /// found.  Below 1 on glossy surfaces: `sample_glossy` at that vertex may have found this point
  /// too.
  double glossy_weight(const Before& before, const SurfaceHit& hit, std::uint32_t light) const;

  /// Whether `sample` counts lights with a size at a vertex with `counts_sizes`.
  bool counts_at(bool counts_sizes, const SurfaceScattering* scattering, const Vec3f& wo) const {
    return counts_sizes && any() && samples_sizes_ &&
           (scattering == nullptr || scattering->is_wide(Vec3(wo)));
  }

 private:
  /// A portal's light has another window for each point, so bent paths to it are left to chance.
  bool is_portal(std::uint32_t light) const {
    return dynamic_cast<const PortalLight*>(scene_.lights()[light].light.get()) != nullptr;
  }
  /// Random numbers of the choices, apart from those of direct light and of directions.
  static constexpr std::uint32_t kFirstPair = 3U << 30;
  static constexpr std::uint32_t kPairsOfVertex = 1U << 20;
  /// Uniform numbers that depend on the path and the vertex only.
  class Choices {
   public:
    Choices(const PathSample& s, std::uint32_t depth)
        : s_(s), next_(kFirstPair + depth * kPairsOfVertex) {}
    double uniform() { return s_.pair(next_++).x; }

   private:
    const PathSample& s_;
    std::uint32_t next_;
  };
  /// A sequence of surfaces, as seen from a vertex.
  struct Sequence {
    absl::InlinedVector<SmoothStep, 4> steps;
    Vec3 image, image_normal;  ///< the vertex and its normal, mirrored by the steps
    double share = 1;          ///< of light that the steps leave, about
    double weight = 1;         ///< 1 / probability of the choice
    /// Of the last plane on which light continues: the sign of n; 0: on either.
    int side = 0;
    bool is_bent = false;  ///< whether the image is not where light seems to come from
  };
  /// A step that may follow a sequence.
  struct Next {
    SmoothStep step;
    int side;      ///< on which light arrives
    double share;  ///< of light that it leaves, about
  };
  using Nexts = absl::InlinedVector<Next, 16>;
  using Sequences = absl::InlinedVector<Sequence, 8>;

  /// `sample` where parts are many.
  void sample_crowd(const Vertex& v, const Sequence& root, Choices& choices, const PathSample& s,
                    WorkCounts& work, const AddLight& found) const;
  /// Whether a light may reach the vertex by a flat mirror of the node alone.
  bool may_mirror(const Vertex& v, const PartTree::Node& node) const;
  void add_next(const Vertex& v, const Sequence& parent, Nexts& to) const;
  void add_next(const Vertex& v, const Sequence& parent, const SmoothPart& part, Nexts& to) const;
  static Sequence extended(const Sequence& parent, const Next& next);
  /// The sequences of one step: at most `most`, chosen by the share of light and the size that they
  /// seem to have.
  Sequences first_sequences(const Vertex& v, const Sequence& root, const Nexts& nexts,
                            std::size_t most, Choices& choices) const;
  /// Adds those after `sequence` that leave enough light, and one of the others.
  void extend(const Vertex& v, const Sequence& sequence, Nexts& nexts, Choices& choices,
              Sequences& open) const;
  bool may_follow(const Vertex& v, const Sequence& parent, const SmoothPart& part, int& side) const;
  enum class Lights : std::uint8_t { kAll, kWithPlace, kWithoutPlace, kUnsized };
  void visit(const Vertex& v, const Sequence& sequence, std::uint32_t number, const PathSample& s,
             WorkCounts& work, const AddLight& found, Lights which = Lights::kAll) const;
  void sample_light(const Vertex& v, const Sequence& sequence, std::uint32_t light,
                    double probability, Vec2f u, WorkCounts& work, const AddLight& found) const;
  /// The path of a sample, and what it brings without the losses on its way.
  struct Arriving {
    SpecularPath path;
    LightSample end;  ///< the sample of the light as the last surface sees it
    Rgb value;        ///< radiance that the vertex sends on
  };
  std::optional<Arriving> by_images(const Vertex& v, const Sequence& sequence, const Light& light,
                                    Vec2 u) const;
  std::optional<Arriving> by_solving(const Vertex& v, const Sequence& sequence, const Light& light,
                                     Vec2 u) const;
  /// The share of light that arrives along a path.
  Rgb share_along(const Vertex& v, const Sequence& sequence, const Arriving& arriving,
                  std::uint32_t light, WorkCounts& work) const;
  Rgb scattered(const Vertex& v, const Vec3& wi) const;

  struct GlossySpot;
  std::optional<GlossySpot> glossy_spot(const SmoothPart& part, const Vec3& from,
                                        std::uint32_t light, double time_s) const;
  /// The probability with which a vertex chooses each pair of a glossy plane and a delta light.
  double glossy_choice(bool is_receiver) const;

  const Scene& scene_;
  const LightVisibility& visibility_;
  const SmoothSurfaces& surfaces_;
  std::span<const SmoothPart> parts_;
  /// Where light comes from.
  struct LightTarget {
    bool is_direction;
    Vec3 middle;    ///< or the direction, unit
    double radius;  ///< [m], or [rad] about the direction
  };
  static std::optional<LightTarget> target_of(const SceneLight& light);
  void find_targets();
  /// If parts are many: the places of lights, and which of the lights these are.
  std::vector<LightTarget> targets_;
  std::vector<bool> has_target_;
  /// Whether vertices of paths sample lights by way of one part only, and all of these have places.
  bool paths_use_targets_ = false;
  bool has_unsized_ = false;  ///< lights that no direction finds
  /// Lights that most directions find, such as a sky.  Only receivers sample them.
  std::vector<bool> is_everywhere_;
  bool has_sized_elsewhere_ = false;  ///< other lights that directions find
  bool samples_sizes_;
  /// The share of vertices of paths that sample.  Where all parts reflect little, it is small.
  double tried_on_paths_ = 0.25;
  bool has_steps_ = false;             ///< whether a part mirrors or refracts
  bool bends_ = false;                 ///< whether paths by way of a part are solved
  std::vector<std::uint32_t> glossy_;  ///< numbers of parts
  std::vector<std::uint32_t> deltas_;  ///< delta lights, if there are glossy parts
};

}  // namespace lucerna
