// The ways to choose points of area lights.
#pragma once

#include <cstdint>
#include <span>

#include "lights/maths/vec.h"

namespace lucerna {

/// How the points of an area light are chosen.  The first five differ on triangles alone: other
/// shapes are then sampled uniformly by area.  Each keeps its density exact; what a receiver cannot
/// use (a solid angle that no float holds, a shape without a way of its own) falls back to area, in
/// sampling and density alike.  None has an effect where Painted::is_by_picture().
enum class AreaSampling : std::uint8_t {
  kAutomatic = 0,     ///< by the rule in lights/sampling/area_sampling.cpp
  kSquareRoot,        ///< uniform by area, by the square root of one value
  kKraemer,           ///< uniform by area, by the order of the values
  kParallelogram,     ///< uniform by area, the far half folded back
  kRejection,         ///< uniform by area, the far half drawn again
  kLowDistortion,     ///< uniform by area, a continuous map of little distortion [Heitz19]
  kSolidAngle,        ///< uniform in solid angle at the receiver; on disks nearly
  kCosineSolidAngle,  ///< nearly by projected solid angle: warped by the receiver's cosine; needs
                      ///< its normal and a triangle or rectangle, else kSolidAngle
};

/// How points of a triangle or rectangle are chosen, where `asked` for: kAutomatic by the one rule,
/// the cosine's way not where there is no normal (zero).  Never kAutomatic.  `corners` relative to
/// the receiver, in any unit of length.  `incomplete` as in Receiver.
AreaSampling way_for_corners(AreaSampling asked, std::span<const Vec3<double>> corners,
                             const Vec3<double>& normal, bool incomplete = false);
/// The same for a disk, by the points of its rim nearest to the receiver and farthest from it.
AreaSampling way_for_disk(AreaSampling asked, const Vec3<double>& nearest,
                          const Vec3<double>& farthest, bool incomplete = false);
/// The same for a whole sphere.
AreaSampling way_for_sphere(AreaSampling asked);

/// Whether `way` is one of the five.
constexpr bool is_by_area(AreaSampling way) {
  return way != AreaSampling::kAutomatic && way != AreaSampling::kSolidAngle &&
         way != AreaSampling::kCosineSolidAngle;
}

/// The least that a corner of a light weighs in kCosineSolidAngle: light below the horizon of a
/// corner may be above that of the points near it.  [Pharr23, 6.5.4]
inline constexpr double kCosineFloor = 0.01;

}  // namespace lucerna
