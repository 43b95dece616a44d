// The random numbers of paths: the point of a sequence that each decision uses.
#pragma once

#include <cstdint>

#include "lights/sampling/sobol.h"
#include "server/estimate/methods.h"

namespace lucerna {

/// The sample points of one block of one pixel or item.
class SampleSequence {
 public:
  SampleSequence(Sampler sampler, std::uint64_t seed, std::uint64_t item, std::uint64_t block)
      : sobol_(seed, item, block),
        // Keys of different sequences differ, because each mixes in its own constant.  One that is
        // not used would take as long as that of Sobol points.
        key_(sampler == Sampler::kSobol
                 ? 0
                 : mix_bits(mix_bits(mix_bits(seed ^ kIndependent) + item) + block)),
        sampler_(sampler) {}

  /// As SobolSequence::pair.  Independent points have any two dimensions.
  Vec2f pair(std::uint32_t index, std::uint32_t pair) const {
    if (sampler_ == Sampler::kSobol) return sobol_.pair(index, pair);
    const std::uint64_t bits = mix_bits(mix_bits(key_ + pair) + index);
    return {static_cast<float>(bits >> 40) * 0x1p-24F,
            static_cast<float>(bits >> 16 & 0xFFFFFF) * 0x1p-24F};
  }

 private:
  static constexpr std::uint64_t kIndependent = 0xD1B54A32D192ED03U;

  SobolSequence sobol_;
  std::uint64_t key_;
  Sampler sampler_;
};

/// The random numbers of one path: one point of the sequence of its pixel or receiver.
struct PathSample {
  const SampleSequence& sequence;
  std::uint32_t index;

  /// The j-th of n points that replace this one.
  PathSample part(std::uint32_t j, std::uint32_t n) const { return {sequence, index * n + j}; }

  // Pairs of dimensions: four for each vertex, after those of the camera.
  enum Purpose : std::uint32_t { kLight, kLightPoint, kDirection, kSurvival };
  static constexpr std::uint32_t kFilm = 0;
  /// For the time; drawn only if something moves.
  static constexpr std::uint32_t kTime = (1u << 30) - 1;
  /// For the choice between the lobes of a surface, at each depth; drawn only if it has some.
  static constexpr std::uint32_t kFirstLobe = 1u << 29;
  /// For the point of the lens; drawn only if there is one.
  static constexpr std::uint32_t kLens = kTime - 1;
  /// For the direction towards a smooth surface that sends light to the receiver.
  static constexpr std::uint32_t kGuided = kLens - 1;
  /// For walks by way of curved smooth surfaces.
  static constexpr std::uint32_t kWalks = kGuided - 1;
  /// If every light is sampled at a vertex, each has its own pair from here on.
  static constexpr std::uint32_t kFirstVisited = 1u << 30;

  Vec2f pair(std::uint32_t dimension) const { return sequence.pair(index, dimension); }
  static std::uint32_t dimension(std::uint32_t depth, Purpose purpose) {
    return 1 + 4 * depth + purpose;
  }
  Vec2f at(std::uint32_t depth, Purpose purpose) const { return pair(dimension(depth, purpose)); }
};

}  // namespace lucerna
