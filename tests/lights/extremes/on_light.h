// Row 7: the answers to receivers exactly on a light.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "lights/sampling/light_sample.h"
#include "tests/extremes_sweep.h"
#include "tests/lights/extremes/area_extremes.h"

namespace lucerna::testing {

/// A size and an offset that keep whole numbers exact.
struct Place {
  double size;
  Vec3 offset;
  Vec3 point(double x, double y, double z) const { return offset + Vec3{x, y, z} * size; }
};

inline std::vector<Place> frames() {
  std::vector<Place> all;
  for (const int exponent : {-80, -20, 0, 20, 60}) {
    const double size = std::ldexp(1.0, exponent);
    for (const Vec3& shift : {Vec3{0, 0, 0}, {1, -2, 3}, {4096, -65536, 1048576}})
      all.push_back({size, shift * size});
  }
  return all;
}
inline constexpr char kSwept[] = "sizes 2^-80 ... 2^60 m, offsets 0 ... 1e6 sizes";

/// Samples the light many times from a receiver that lies on it, and records the answers.
template <typename Light>
void record_samples(const Light& light, const Vec3& position, Sweep& sweep) {
  for (int way = 0; way <= static_cast<int>(AreaSampling::kCosineSolidAngle); ++way)
    for (const double x : {0.0, 0.125, 0.4, 0.75, 1.0})
      for (const double y : {0.0, 0.3, 0.5, 0.9, 1.0}) {
        Receiver receiver(position);
        receiver.normal = {0, 0, 1};
        receiver.area_sampling = static_cast<AreaSampling>(way);
        const auto sample = light.sample_li(receiver, {x, y});
        sweep.answer(sample.reason);
        EXPECT_EQ(sample.value.max_component(), 0);
        EXPECT_TRUE(std::isfinite(sample.pdf.per_sr));
        // The density of the direction must be 0 too.
        if (sample.wi != Vec3{}) {
          EXPECT_EQ(light.pdf_li(receiver, sample.wi).per_sr, 0);
        }
      }
}

/// L A cos / d^2 for a light of radiance 1, or I / d^2 where the receiver is the point, in floats.
inline void textbook(const Vec3f& to_light, const Vec3f& normal, float area, Sweep& sweep) {
  const float d2 = dot(to_light, to_light);
  const float cos = dot(normal, to_light) / std::sqrt(d2);
  const float value = area * cos / d2;
  sweep.textbook_answer(std::isnan(value)   ? "NaN"
                        : std::isinf(value) ? "infinite"
                        : value == 0        ? "0"
                                            : "a number");
}

}  // namespace lucerna::testing
