#include "lights/models/light.h"

#include <algorithm>

namespace lucerna {

MostIrradiance DeltaLight::most_irradiance(const Receiver& receiver) const {
  const LightSample s = sample_li(receiver, {0.5, 0.5});
  const bool all_around = receiver.normal == Vec3{};
  const double lx =
      luminance(s.value) * (all_around ? 1 : std::max(0.0, dot(receiver.normal, s.wi)));
  return {lx, lx};
}

}  // namespace lucerna
