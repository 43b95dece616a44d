// Arrays for an answer of sample_li().
#pragma once

#include <cstdint>
#include <vector>

#include "server/estimate/queries/queries.h"

namespace lucerna::testing {

struct LiRoom {
  explicit LiRoom(std::size_t samples)
      : vectors(12 * samples),
        numbers(2 * samples),
        bits(2 * (samples / 8 + 1)),
        ids(samples),
        probability(samples),
        status(samples) {}

  SampleLiAnswer answer() {
    const std::size_t n = status.size();
    return {.value = vectors.data(),
            .wi = vectors.data() + 3 * n,
            .distance_m = numbers.data(),
            .light_offsets_m = vectors.data() + 6 * n,
            .light_normals = vectors.data() + 9 * n,
            .pdf_per_sr = numbers.data() + n,
            .delta = bits.data(),
            .visible = bits.data() + bits.size() / 2,
            .light_ids = ids.data(),
            .selection_probability = probability.data(),
            .status = status.data()};
  }

  std::vector<float> vectors, numbers;
  std::vector<std::uint8_t> bits;
  std::vector<std::uint64_t> ids;
  std::vector<double> probability;
  std::vector<int> status;
};

}  // namespace lucerna::testing
