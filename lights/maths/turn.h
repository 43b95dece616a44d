// Cosine and sine of a share of a full turn, without a call.
#pragma once

#include <bit>
#include <cstdint>
#include <numbers>

namespace lucerna {

struct CosSin {
  double cos, sin;
};

/// Of 2 pi `share`, for a share in [0, 1]; both are within 2^-52 of the exact values.
///
/// A share minus its nearest quarter is exact, so the angle is at most pi / 4 with one rounding.
/// There the Taylor series need eight and nine terms, whose remainders are below 2e-17.
inline CosSin cos_sin_of_turn(double share) {
  const auto quarter = static_cast<std::uint64_t>(8 * share + 1) / 2;
  const double x = 2 * std::numbers::pi * (share - 0.25 * static_cast<double>(quarter));
  const double z = x * x, z2 = z * z, z4 = z2 * z2;
  // Terms in pairs, so that the processor computes several at a time.
  // clang-format off
  constexpr double kFactorial[] = {1, 1, 2, 6, 24, 120, 720, 5040, 40320, 362880, 3628800, 39916800,
                                   479001600, 6227020800, 87178291200, 1307674368000,
                                   20922789888000};
  // clang-format on
  const auto term = [&](int n) { return 1 / kFactorial[n]; };
  const double sin = x - x * z *
                             ((term(3) - z * term(5)) + z2 * (term(7) - z * term(9)) +
                              z4 * ((term(11) - z * term(13)) + z2 * term(15)));
  const double cos = 1 - z * ((term(2) - z * term(4)) + z2 * (term(6) - z * term(8)) +
                              z4 * ((term(10) - z * term(12)) + z2 * (term(14) - z * term(16))));
  // Selected without branches, which random angles would mispredict.
  const double of_quarter[] = {cos, sin};
  const auto with_sign = [](double value, std::uint64_t negative) {
    return std::bit_cast<double>(std::bit_cast<std::uint64_t>(value) ^ (negative & 1) << 63);
  };
  return {with_sign(of_quarter[quarter & 1], (quarter + 1) >> 1),
          with_sign(of_quarter[~quarter & 1], quarter >> 1)};
}

}  // namespace lucerna
