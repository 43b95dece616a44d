// The ways to choose points of area lights.
#pragma once

#include <cstdint>
#include <span>

#include "lights/maths/vec.h"

namespace lucerna {

/// How the points of an area light are chosen.  The first five differ only on triangles; other
/// shapes use uniform sampling by area for each of them.  Every way has an exact density.  If a
/// receiver cannot use a way (the solid angle does not fit a float, or the shape has no such way),
/// it uses area sampling for samples and densities.  The way has no effect where
/// a picture chooses the points (Shape::distribution).
enum class AreaSampling : std::uint8_t {
  kAutomatic = 0,     ///< by the rule in lights/sampling/area_sampling.cpp
  kSquareRoot,        ///< uniform by area, by the square root of one value
  kKraemer,           ///< uniform by area, by the order of the values
  kParallelogram,     ///< uniform by area, the far half of the parallelogram folded back
  kRejection,         ///< uniform by area, the far half of the parallelogram drawn again
  kLowDistortion,     ///< uniform by area, a continuous map of little distortion [Heitz19]
  kSolidAngle,        ///< uniform in solid angle at the receiver; on disks nearly uniform
  kCosineSolidAngle,  ///< nearly by projected solid angle: warped by the receiver's cosine; needs
                      ///< its normal and a triangle or rectangle, else kSolidAngle
};

/// The way in which points of a triangle or rectangle are chosen for a request.  Replaces
/// kAutomatic by the rule's choice, and kCosineSolidAngle if `normal` is zero.  `corners` are
/// relative to the receiver, in any unit of length.  `incomplete` as in Receiver.
AreaSampling way_for_corners(AreaSampling requested, std::span<const Vec3> corners,
                             const Vec3& normal, bool incomplete = false);
/// The same for a disk, by the points of its rim nearest to the receiver and farthest from it.
AreaSampling way_for_disk(AreaSampling requested, const Vec3& nearest, const Vec3& farthest,
                          bool incomplete = false);
/// The same for a whole sphere.
AreaSampling way_for_sphere(AreaSampling requested);

/// Whether `way` is one of the first five.
constexpr bool is_by_area(AreaSampling way) {
  return way != AreaSampling::kAutomatic && way != AreaSampling::kSolidAngle &&
         way != AreaSampling::kCosineSolidAngle;
}

/// The smallest weight of a light's corner in kCosineSolidAngle.  Light below the horizon of a
/// corner may be above the horizon of points near it.  [Pharr23, 6.5.4]
inline constexpr double kCosineFloor = 0.01;

}  // namespace lucerna
