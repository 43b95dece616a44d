// The arrays of an answer to SampleLi, for the benchmarks that call it in process.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "server/queries/queries.h"

namespace lucerna {

/// Of `count` samples, without visibility.
struct SampleLiArrays {
  explicit SampleLiArrays(std::size_t count)
      : value(3 * count),
        wi(3 * count),
        distance_m(count),
        light_offsets_m(3 * count),
        light_normals(3 * count),
        pdf_per_sr(count),
        delta(count / 8),
        light_ids(count),
        selection_probability(count),
        status(count) {}

  SampleLiAnswer answer() {
    return {.value = value.data(),
            .wi = wi.data(),
            .distance_m = distance_m.data(),
            .light_offsets_m = light_offsets_m.data(),
            .light_normals = light_normals.data(),
            .pdf_per_sr = pdf_per_sr.data(),
            .delta = delta.data(),
            .visible = nullptr,
            .light_ids = light_ids.data(),
            .selection_probability = selection_probability.data(),
            .status = status.data()};
  }

  std::vector<float> value, wi, distance_m, light_offsets_m, light_normals, pdf_per_sr;
  std::vector<std::uint8_t> delta;
  std::vector<std::uint64_t> light_ids;
  std::vector<double> selection_probability;
  std::vector<int> status;
};

}  // namespace lucerna
