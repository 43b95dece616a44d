#include "server/materials/dielectric.h"

#include "server/materials/fresnel.h"

namespace lucerna {
namespace {

/// The facet normal that scatters `wi` to `wo`.
struct Facet {
  Vec3 m;  ///< on the side of +z; zero if there is none
  bool reflects{};
  double eta = 1;  ///< index on the side of `wi` over that on the side of `wo`
};

Facet facet_between(const Vec3& wo, const Vec3& wi, double eta) {
  Facet f;
  if (wo.z == 0 || wi.z == 0) return f;
  f.reflects = same_side(wo, wi);
  if (!f.reflects) f.eta = wo.z > 0 ? eta : 1 / eta;
  Vec3 m = normalized(wi * f.eta + wo);
  if (m.z < 0) m = -m;
  // Facets that face away scatter nothing.
  if (dot(m, wi) * wi.z > 0 && dot(m, wo) * wo.z > 0) f.m = m;
  return f;
}

}  // namespace

double Dielectric::value(const Vec3& wo, const Vec3& wi, Carries carries) const {
  if (smooth_) return 0;
  const Facet f = facet_between(wo, wi, eta_);
  if (!(f.m.z > 0)) return 0;
  const double fresnel = fresnel_dielectric(dot(wo, f.m), eta_);
  const double of_facets =
      facets_.seen_per_cosine(wo) * facets_.density(f.m) * facets_.also_seen(wo, wi);
  if (f.reflects) return of_facets * fresnel / 4;
  const double root = dot(wi, f.m) + dot(wo, f.m) / f.eta;
  const double stretch = std::fabs(dot(wi, f.m) * dot(wo, f.m)) / (root * root);
  const double value = of_facets * (1 - fresnel) * stretch;
  return carries == Carries::kRadiance ? value / (f.eta * f.eta) : value;
}

double Dielectric::pdf(const Vec3& wo, const Vec3& wi, Side sides) const {
  if (smooth_) return 0;
  const Facet f = facet_between(wo, wi, eta_);
  if (!(f.m.z > 0) || !has(sides, f.reflects ? Side::kReflected : Side::kTransmitted)) return 0;
  const double fresnel = fresnel_dielectric(dot(wo, f.m), eta_);
  const double reflected = has(sides, Side::kReflected) ? fresnel : 0,
               passed = has(sides, Side::kTransmitted) ? 1 - fresnel : 0;
  const double share = (f.reflects ? reflected : passed) / (reflected + passed);
  const double of_facets = facets_.seen_per_cosine(wo) * facets_.density(f.m);
  if (f.reflects) return share * of_facets / 4;
  const double root = dot(wi, f.m) + dot(wo, f.m) / f.eta;
  return share * of_facets * std::fabs(dot(wi, f.m) * dot(wo, f.m)) / (root * root);
}

Rgb Dielectric::single(const Vec3& wo, Side side) const {
  if (!smooth_ || wo.z == 0) return {};
  const double reflected = fresnel_dielectric(wo.z, eta_);
  if (side == Side::kReflected) return Rgb(reflected);
  const double eta = wo.z > 0 ? eta_ : 1 / eta_;
  return Rgb((1 - reflected) / (eta * eta));
}

auto Dielectric::sample(const Vec3& wo, const ScatterValues& u, Side sides, Carries carries) const
    -> std::optional<Sample> {
  if (wo.z == 0) return std::nullopt;
  const Vec3 up = wo.z < 0 ? -wo : wo;
  const Vec3 m = smooth_ ? Vec3{0, 0, 1} : facets_.sample(up, u.direction);
  const Vec3 n = wo.z < 0 ? -m : m;  // the facet's normal on the side of wo
  const double fresnel = fresnel_dielectric(dot(wo, m), eta_);
  const double reflected = has(sides, Side::kReflected) ? fresnel : 0,
               passed = has(sides, Side::kTransmitted) ? 1 - fresnel : 0;
  const double all = reflected + passed;
  if (!(all > 0)) return std::nullopt;
  const bool reflects = u.choice * all < reflected;
  Sample s;
  double eta = 1;
  if (reflects) {
    s.wi = n * (2 * dot(wo, n)) - wo;
    if (!same_side(wo, s.wi)) return std::nullopt;  // hits another facet, which is not modelled
  } else {
    const auto refracted = refract(wo, m, eta_);
    if (!refracted || same_side(wo, refracted->w) || refracted->w.z == 0) return std::nullopt;
    s.wi = refracted->w;
    eta = refracted->eta;
  }
  // The probability of the choice cancels against the share, except for the sides left out.
  s.weight = all;
  if (!reflects && carries == Carries::kRadiance) s.weight /= eta * eta;
  s.delta = smooth_;
  if (smooth_) return s;
  s.pdf = pdf(wo, s.wi, sides);
  if (!(s.pdf > 0)) return std::nullopt;
  s.weight *= facets_.also_seen(wo, s.wi);
  return s;
}

std::optional<ScatterSample> Dielectric::sample(const Vec3& wo, const ScatterValues& u) const {
  const auto s = sample(wo, u, Side::kBoth, Carries::kRadiance);
  if (!s) return std::nullopt;
  return ScatterSample{.wi = s->wi, .weight = Rgb(s->weight), .pdf = {s->pdf}, .delta = s->delta};
}

double ThinDielectric::passed(double cosine) const {
  const double once = fresnel_dielectric(std::fabs(cosine), eta_);
  // The series of reflections within the pane.
  return once < 1 ? (1 - once) / (1 + once) : 0.0;
}

std::optional<ScatterSample> ThinDielectric::sample(const Vec3& wo, const ScatterValues& u) const {
  if (wo.z == 0) return std::nullopt;
  const bool passes = u.choice < passed(wo.z);
  return ScatterSample{.wi = passes ? -wo : mirrored(wo), .weight = Rgb(1), .delta = true};
}

}  // namespace lucerna
