#include "lights/maths/cie.h"

#include <algorithm>
#include <cmath>

namespace lucerna::cie {

const Illuminant* find_illuminant(std::string_view name) {
  const auto found = std::ranges::find(illuminants(), name, &Illuminant::name);
  return found == illuminants().end() ? nullptr : &*found;
}

double value_at(const Illuminant& illuminant, double nm) {
  const double x = (nm - illuminant.first_nm) / illuminant.step_nm;
  const auto last = static_cast<double>(illuminant.values.size() - 1);
  if (!(x >= 0 && x <= last)) return 0;
  const auto below = static_cast<std::size_t>(x);
  const std::size_t above = std::min(below + 1, illuminant.values.size() - 1);
  return std::lerp(illuminant.values[below], illuminant.values[above],
                   x - static_cast<double>(below));
}

}  // namespace lucerna::cie
