// The ways to choose points of area lights.
#pragma once

#include <cstdint>

namespace lucerna {

/// How the points of an area light are chosen.  The first five differ on triangles alone: other
/// shapes are then sampled uniformly by area.  Each keeps its density exact; what a receiver cannot
/// use (a solid angle that no float holds, a shape without a way of its own) falls back to area, in
/// sampling and density alike.
enum class AreaSampling : std::uint8_t {
  kAutomatic = 0,     ///< by the rule in lights/area_sampling.cpp
  kSquareRoot,        ///< uniform by area, by the square root of one value
  kKraemer,           ///< uniform by area, by the order of the values
  kParallelogram,     ///< uniform by area, the far half folded back
  kRejection,         ///< uniform by area, the far half drawn again
  kLowDistortion,     ///< uniform by area, a continuous map of little distortion [Heitz19]
  kSolidAngle,        ///< uniform in solid angle at the receiver
  kCosineSolidAngle,  ///< nearly by projected solid angle: warped by the receiver's cosine; needs
                      ///< its normal, else kSolidAngle
};

/// The shapes that know other ways to be sampled than by area.
enum class SampledShape : std::uint8_t { kTriangle, kRectangle, kSphere, kInsideOfSphere };

/// How points of `shape` are chosen, where `asked` for: kAutomatic by the one rule, and the
/// cosine's way not where there is no normal, nor on a sphere, which has none.  Never kAutomatic.
AreaSampling way_to_sample(SampledShape shape, AreaSampling asked, bool has_normal);

/// Whether `way` is one of the five.
constexpr bool is_by_area(AreaSampling way) {
  return way != AreaSampling::kAutomatic && way != AreaSampling::kSolidAngle &&
         way != AreaSampling::kCosineSolidAngle;
}

/// The least that a corner of a light weighs in kCosineSolidAngle: light below the horizon of a
/// corner may be above that of the points near it.  [Pharr23, 6.5.4]
inline constexpr double kCosineFloor = 0.01;

}  // namespace lucerna
