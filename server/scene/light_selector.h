// Which light of a scene a sample is spent on.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "lights/choice/light_tree.h"
#include "server/scene/light_choice.h"
#include "server/scene/light_selection.h"
#include "server/scene/scene_part.h"

namespace lucerna {

/// Local lights are chosen by their flux or by the light tree, according to what the question asks
/// for.  Lights without a falling off by distance (infinite, distant, sun, portal, beam) have no
/// place in either: the flux of most is that through the scene's sphere, which one far object makes
/// as large as it likes.  They are chosen among themselves by the illuminance that they give, half
/// of all times where there are lights of both kinds.
///
/// The tree is built with the scene where there are enough lights for it to win, else where a
/// question names it.  Safe to share between threads.
class LightSelector {
 public:
  /// A light as the selector is told of it.
  struct Item {
    std::uint32_t light;  ///< index; items ascend by it
    double lumens;        ///< the largest channel of its flux, finite
    double lux;           ///< the same of its illuminance, of lights without bounds
    /// Of lights that fall off with the distance, at all times that they move through.
    std::optional<LightBounds<double>> bounds;
  };

  /// From so many local lights on the tree is used unless a question says otherwise.
  static constexpr std::size_t kTreeFrom = 9;

  explicit LightSelector(std::vector<Item> items);

  /// A light for `u` in [0, 1), with as many bits as the number of lights asks for: 24 bits reach
  /// 2^24 of them.  Nothing where none of those that `u` is left with can reach the receiver; that
  /// happens with the probability which those of all lights leave to 1.  `how` is not kAll.
  std::optional<LightChoice> choose(LightSelection how, const Receiver<double>& receiver,
                                    double u) const;
  /// The probability with which `choose` answers `light`, the same bits.
  double probability(LightSelection how, const Receiver<double>& receiver,
                     std::uint32_t light) const;

  /// What kAutomatic is.
  LightSelection automatic() const;

  /// By flux alone, of all items: for rays that leave lights, wherever they go.
  const LightDistribution& by_flux() const { return by_flux_; }

  /// With the tree where that is built.
  std::size_t bytes() const;
  /// Builds the tree where questions that say nothing use it.
  void build_tree_if_used();
  const LazyPart<LightTree>& tree_part() const { return tree_; }

 private:
  /// Lights of one kind, by number.
  struct Group {
    std::vector<std::uint32_t> lights;  // ascending
    LightDistribution distribution;

    std::optional<std::uint32_t> place(std::uint32_t light) const;
    LightChoice choose(double u) const;
  };
  const LightTree& tree() const;

  LightDistribution by_flux_;
  Group beside_, local_;
  double beside_share_ = 0;             // the probability of lights beside the local ones
  std::vector<LightTree::Item> items_;  // of local lights, where the tree is not built yet
  LazyPart<LightTree> tree_{"light BVH"};
};

}  // namespace lucerna
