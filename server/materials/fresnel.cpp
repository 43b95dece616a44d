#include "server/materials/fresnel.h"

#include <algorithm>
#include <cmath>
#include <complex>

namespace lucerna {

double fresnel_dielectric(double cos_i, double eta) {
  cos_i = std::clamp(cos_i, -1.0, 1.0);
  if (cos_i < 0) {
    eta = 1 / eta;
    cos_i = -cos_i;
  }
  // 1 - sin^2 / eta^2 without cancellation where eta is near 1.
  const double cos2_t = (cos_i * cos_i + (eta - 1) * (eta + 1)) / (eta * eta);
  if (cos2_t <= 0) return 1;
  const double cos_t = std::sqrt(cos2_t);
  const double parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
  const double perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
  return (parallel * parallel + perpendicular * perpendicular) / 2;
}

Rgb fresnel_conductor(double cos_i, const Rgb& eta, const Rgb& k) {
  cos_i = std::clamp(cos_i, 0.0, 1.0);
  const auto channel = [&](double n, double absorption) {
    using Complex = std::complex<double>;
    const Complex index(n, absorption);
    if (index == Complex(0)) return 1.0;  // the limit of total reflection
    const Complex sine2 = (1 - cos_i * cos_i) / (index * index);
    const Complex cos_t = std::sqrt(Complex(1) - sine2);
    const Complex parallel = (index * cos_i - cos_t) / (index * cos_i + cos_t);
    const Complex perpendicular = (cos_i - index * cos_t) / (cos_i + index * cos_t);
    const double share = (std::norm(parallel) + std::norm(perpendicular)) / 2;
    return share <= 1 ? share : 1.0;  // also at 0 / 0, where all light is reflected
  };
  return {channel(eta.r, k.r), channel(eta.g, k.g), channel(eta.b, k.b)};
}

std::optional<Refracted> refract(const Vec3& w, Vec3 n, double eta) {
  double cos_i = dot(n, w);
  if (cos_i < 0) {
    eta = 1 / eta;
    cos_i = -cos_i;
    n = -n;
  }
  const double cos2_t = (cos_i * cos_i + (eta - 1) * (eta + 1)) / (eta * eta);
  if (!(cos2_t > 0)) return std::nullopt;
  const Vec3 t = w * (-1 / eta) + n * (cos_i / eta - std::sqrt(cos2_t));
  return Refracted{normalized(t), eta};
}

}  // namespace lucerna
