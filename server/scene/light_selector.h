// Chooses the light of a scene for a sample.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "lights/models/light_tree.h"
#include "server/scene/light_distribution.h"
#include "server/scene/scene_part.h"

namespace lucerna {

/// Methods that choose a light for a sample.  The enum of the same name in
/// lucerna/v1/accuracy.proto explains the values.
enum class LightSelection { kAutomatic, kAll, kUniform, kPower, kBvh };

/// Local lights are chosen by flux or by the light tree; the query chooses which.
///
/// Infinite, distant, sun, portal and beam lights do not fall off with distance, so they do not fit
/// either method.  For most of them, the flux is that through the scene's sphere, which one distant
/// object may enlarge.  They are chosen among themselves by their illuminance.  A scene with lights
/// of both kinds gives half of the choices to each kind.
///
/// The tree is built with the scene if there are so many lights that the tree is better. Otherwise
/// it is built when a query selects it.  May be called from any thread.
class LightSelector {
 public:
  /// The properties of a light that the choice depends on.
  struct Item {
    std::uint32_t light;  ///< index; items are in ascending order
    double lumens;        ///< largest channel of the flux, finite
    double lux;           ///< largest channel of the illuminance, for lights without bounds
    /// For lights that fall off with distance; over all of their motion.
    std::optional<LightBounds> bounds;
  };

  /// With at least this many local lights, the tree is the default.
  static constexpr std::size_t kTreeFrom = 9;

  /// Builds the tree if it is the default.
  explicit LightSelector(std::vector<Item> items);

  /// A light for `u` in [0, 1).  `u` needs enough bits for the number of lights: 24 bits reach
  /// 2^24. Nothing if none of the lights that remain for `u` can reach the receiver.
  /// The probability of that is 1 minus the sum of all lights' probabilities.  `how` is not
  /// kAll.
  std::optional<LightChoice> choose(LightSelection how, const Receiver& receiver, double u) const;
  /// The probability with which `choose` returns `light`, with the same bits.
  double probability(LightSelection how, const Receiver& receiver, std::uint32_t light) const;

  /// The method of kAutomatic.
  LightSelection automatic() const;

  /// The choice among all items by flux, for rays that leave lights.
  const LightDistribution& by_flux() const { return by_flux_; }

  /// Without the tree.
  std::size_t bytes() const;
  const LazyPart<LightTree>& tree_part() const { return tree_; }

 private:
  /// Lights of one kind, by index.
  struct Group {
    std::vector<std::uint32_t> lights;  // ascending
    LightDistribution distribution;

    std::optional<std::uint32_t> index_of(std::uint32_t light) const;
    LightChoice choose(double u) const;
  };
  const LightTree& tree() const;

  LightDistribution by_flux_;
  Group beside_, local_;
  double beside_share_ = 0;             // the probability of lights that are not local
  std::vector<LightTree::Item> items_;  // local lights, until the tree is built
  LazyPart<LightTree> tree_{"light BVH"};
};

}  // namespace lucerna
