#include "lights/sampling/sampling.h"

#include <bit>
#include <cstdint>

#include "lights/sampling/sobol.h"

namespace lucerna {

Vec3 sample_triangle_square_root(Vec2 u) {
  const double root = std::sqrt(u.x);
  return {1 - root, root * (1 - u.y), root * u.y};
}

Vec3 sample_triangle_kraemer(Vec2 u) {
  const double low = std::min(u.x, u.y);
  const double high = std::max(u.x, u.y);
  return {low, high - low, 1 - high};
}

Vec3 sample_triangle_parallelogram(Vec2 u) {
  const double beyond = u.x + u.y - 1;
  return beyond > 0 ? Vec3{beyond, 1 - u.x, 1 - u.y} : Vec3{-beyond, u.x, u.y};
}

Vec3 sample_triangle_rejection(Vec2 u) {
  // Half of the draws are in the far half.  The 64th draw has a chance of 2^-64; it is folded back.
  constexpr int kDraws = 64;
  // Hashes the values as floats, so that floats and doubles give the same draws.
  const auto bits_of = [](double v) { return std::bit_cast<std::uint32_t>(static_cast<float>(v)); };
  std::uint64_t bits = (std::uint64_t{bits_of(u.x)} << 32) | bits_of(u.y);
  for (int i = 0; i < kDraws && u.x + u.y > 1; ++i) {
    bits = mix_bits(bits + 0x9e3779b97f4a7c15);  // the increment: no value maps to itself
    u = {std::ldexp(static_cast<double>(bits >> 32), -32),
         std::ldexp(static_cast<double>(bits & 0xffffffff), -32)};
  }
  return sample_triangle_parallelogram(u);
}

Vec3 sample_triangle(AreaSampling way, Vec2 u) {
  switch (way) {
    case AreaSampling::kSquareRoot:
      return sample_triangle_square_root(u);
    case AreaSampling::kKraemer:
      return sample_triangle_kraemer(u);
    case AreaSampling::kParallelogram:
      return sample_triangle_parallelogram(u);
    case AreaSampling::kRejection:
      return sample_triangle_rejection(u);
    default:
      return sample_uniform_triangle(u);
  }
}

}  // namespace lucerna
