// Which light of a scene a sample is spent on.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "lights/light_tree.h"
#include "server/light_choice.h"
#include "server/methods.h"

namespace lucerna {

/// Local lights are chosen by their flux or by the light tree, according to what the question asks
/// for.  Lights without a falling off by distance (infinite, distant, sun, portal, beam) have no
/// place in either: the flux of most is that through the scene's sphere, which one far object makes
/// as large as it likes.  They are chosen among themselves by the illuminance that they give, half
/// of all times where there are lights of both kinds.
///
/// Immutable but for the tree, which is built at its first use; safe to share between threads.
class LightSelector {
 public:
  /// A light as the selector is told of it.
  struct Item {
    double lumens;  ///< the largest channel of its flux, finite
    double lux;     ///< the same of its illuminance, of lights without bounds
    /// Of lights that fall off with the distance, at all times that they move through.
    std::optional<LightBounds<double>> bounds;
  };

  /// From so many local lights on the tree is made with the scene, and chosen by unless a question
  /// says otherwise.
  static constexpr std::size_t kTreeFrom = 9;

  LightSelector() = default;
  /// Two items or more.
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

  /// By flux alone, of all lights: for rays that leave lights, wherever they go.
  const LightDistribution& by_flux() const { return by_flux_; }

  /// Without the tree.
  std::size_t bytes() const;
  void build_tree() const { tree(); }
  /// 0 while it is not built.
  std::size_t tree_bytes() const { return lazy_ ? lazy_->bytes.load() : 0; }

 private:
  /// Lights of one kind, by number.
  struct Group {
    std::vector<std::uint32_t> lights;  // ascending
    LightDistribution distribution;

    std::optional<std::uint32_t> place(std::uint32_t light) const;
    LightChoice choose(double u) const;
  };
  /// The tree, and what it is built from until it is.
  struct Lazy {
    std::once_flag once;
    std::vector<LightTree::Item> items;
    std::optional<LightTree> tree;
    std::atomic<std::size_t> bytes = 0;
  };
  const LightTree& tree() const;

  LightDistribution by_flux_;
  Group beside_, local_;
  double beside_share_ = 0;  // the probability of lights beside the local ones
  std::unique_ptr<Lazy> lazy_;
};

}  // namespace lucerna
