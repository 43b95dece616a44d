#include "server/materials/fresnel.h"

#include <algorithm>
#include <cmath>
#include <complex>

namespace lucerna {

template <std::floating_point Real>
Real fresnel_dielectric(Real cos_i, Real eta) {
  cos_i = std::clamp(cos_i, Real(-1), Real(1));
  if (cos_i < 0) {
    eta = 1 / eta;
    cos_i = -cos_i;
  }
  // 1 - sin^2 / eta^2 without cancellation where eta is near 1.
  const Real cos2_t = (cos_i * cos_i + (eta - 1) * (eta + 1)) / (eta * eta);
  if (cos2_t <= 0) return 1;
  const Real cos_t = std::sqrt(cos2_t);
  const Real parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
  const Real perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
  return (parallel * parallel + perpendicular * perpendicular) / 2;
}

template <std::floating_point Real>
Rgb<Real> fresnel_conductor(Real cos_i, const Rgb<Real>& eta, const Rgb<Real>& k) {
  cos_i = std::clamp(cos_i, Real(0), Real(1));
  const auto channel = [&](Real n, Real absorption) {
    using Complex = std::complex<Real>;
    const Complex index(n, absorption);
    if (index == Complex(0)) return Real(1);  // the limit of total reflection
    const Complex sine2 = (1 - cos_i * cos_i) / (index * index);
    const Complex cos_t = std::sqrt(Complex(1) - sine2);
    const Complex parallel = (index * cos_i - cos_t) / (index * cos_i + cos_t);
    const Complex perpendicular = (cos_i - index * cos_t) / (cos_i + index * cos_t);
    const Real share = (std::norm(parallel) + std::norm(perpendicular)) / 2;
    return share <= 1 ? share : Real(1);  // also at 0 / 0, where all light is reflected
  };
  return {channel(eta.r, k.r), channel(eta.g, k.g), channel(eta.b, k.b)};
}

template <std::floating_point Real>
std::optional<Refracted<Real>> refract(const Vec3<Real>& w, Vec3<Real> n, Real eta) {
  Real cos_i = dot(n, w);
  if (cos_i < 0) {
    eta = 1 / eta;
    cos_i = -cos_i;
    n = -n;
  }
  const Real cos2_t = (cos_i * cos_i + (eta - 1) * (eta + 1)) / (eta * eta);
  if (!(cos2_t > 0)) return std::nullopt;
  const Vec3<Real> t = w * (-1 / eta) + n * (cos_i / eta - std::sqrt(cos2_t));
  return Refracted<Real>{normalized(t), eta};
}

#define LUCERNA_INSTANTIATE(Real)                                                 \
  template Real fresnel_dielectric(Real, Real);                                   \
  template Rgb<Real> fresnel_conductor(Real, const Rgb<Real>&, const Rgb<Real>&); \
  template std::optional<Refracted<Real>> refract(const Vec3<Real>&, Vec3<Real>, Real);
LUCERNA_INSTANTIATE(float)
LUCERNA_INSTANTIATE(double)
#undef LUCERNA_INSTANTIATE

}  // namespace lucerna
