#include "lights/area_sampling.h"

namespace lucerna {

AreaSampling way_to_sample(SampledShape shape, AreaSampling asked, bool has_normal) {
  const bool has_corners = shape == SampledShape::kTriangle || shape == SampledShape::kRectangle;
  if (asked == AreaSampling::kAutomatic)
    return shape == SampledShape::kSphere ? AreaSampling::kSolidAngle
                                          : AreaSampling::kLowDistortion;
  if (asked == AreaSampling::kCosineSolidAngle && !(has_normal && has_corners))
    return AreaSampling::kSolidAngle;
  return asked;
}

}  // namespace lucerna
