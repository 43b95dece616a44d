// The random numbers of paths: which point of which sequence each decision takes.
#pragma once

#include <cstdint>

#include "lights/sampling/sobol.h"
#include "server/estimate/lights/methods.h"

namespace lucerna {

/// The sample points of one replicate of one pixel or item.
class SampleSequence {
 public:
  SampleSequence(Sampler sampler, std::uint64_t seed, std::uint64_t item, std::uint64_t replicate)
      : sobol_(seed, item, replicate),
        // Of no use to the other: keys differ by what they are mixed with.
        key_(mix_bits(mix_bits(mix_bits(seed ^ kIndependent) + item) + replicate)),
        sampler_(sampler) {}

  /// As SobolSequence; of independent points any two are.
  Vec2<float> pair(std::uint32_t index, std::uint32_t pair) const {
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

/// The random numbers of one path: a point of its pixel's (or receiver's) sequence.
struct PathSample {
  const SampleSequence& sequence;
  std::uint32_t index;

  /// The j-th of n points that stand in for this one.
  PathSample part(std::uint32_t j, std::uint32_t n) const { return {sequence, index * n + j}; }

  // Pairs of dimensions, four a vertex after the camera's own.
  enum Purpose : std::uint32_t { kLight, kLightPoint, kDirection, kSurvival };
  static constexpr std::uint32_t kFilm = 0;
  /// Of the moment: drawn only where something moves.
  static constexpr std::uint32_t kTime = (1u << 30) - 1;
  /// Where many lights are visited at one vertex, each has a pair of its own from here on.
  static constexpr std::uint32_t kFirstVisited = 1u << 30;

  Vec2<float> pair(std::uint32_t dimension) const { return sequence.pair(index, dimension); }
  Vec2<float> at(std::uint32_t depth, Purpose purpose) const {
    return pair(1 + 4 * depth + purpose);
  }
};

}  // namespace lucerna
