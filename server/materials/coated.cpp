#include "server/materials/coated.h"

#include <algorithm>

#include "lights/sampling/hash_number.h"
#include "server/materials/fresnel.h"

namespace lucerna {
namespace {

/// Random numbers that depend on two directions only, so that a value can be repeated.
class WalkNumbers {
 public:
  template <std::floating_point Real>
  WalkNumbers(const Vec3<Real>& wo, const Vec3<Real>& wi)
      : state_(hash_of({wo.x, wo.y, wo.z, wi.x, wi.y, wi.z})) {}

  double uniform() { return static_cast<double>(mix_bits(state_++) >> 11) * 0x1p-53; }
  template <std::floating_point Real>
  ScatterValues<Real> values() {
    const auto one = [&] { return static_cast<Real>(uniform()); };
    const Real choice = one(), x = one(), y = one();
    return {choice, {x, y}};
  }

 private:
  std::uint64_t state_;
};

/// The weight of a direction of density `a` that another strategy finds with density `b`.
template <std::floating_point Real>
Real power_weight(Real a, Real b) {
  const Real ratio = b / a;
  return 1 / (1 + ratio * ratio);
}

/// Roughness of a base.
template <std::floating_point Real>
Vec2<Real> alpha_of(const Conductor<Real>& base) {
  return base.alpha();
}
template <std::floating_point Real>
Vec2<Real> alpha_of(const Diffuse<Real>&) {
  return {1, 1};
}

/// Share of directions near those of a metal; the rest is cosine-weighted, for walks of many
/// reflections.
constexpr double kGuided = 0.8;

}  // namespace

// The boundary turns a facet normal's slope m into a half vector of slope eta m, and is passed
// twice.
template <std::floating_point Real, typename Base>
Coated<Real, Base>::Coated(const Params& p)
    : boundary_(p.boundary),
      base_(p.base),
      guide_(Rgb<Real>(1), Rgb<Real>(1),
             std::min(Real(1),
                      std::hypot(p.boundary.eta() * alpha_of(p.base).x, p.boundary.alpha().x)),
             std::min(Real(1),
                      std::hypot(p.boundary.eta() * alpha_of(p.base).y, p.boundary.alpha().y))),
      thickness_(p.thickness) {}

template <std::floating_point Real, typename Base>
Real Coated<Real, Base>::at_boundary(const Vec3<Real>& wo) const {
  // Most bases reflect about half of the light.
  const Real fresnel = fresnel_dielectric(std::fabs(wo.z), boundary_.eta());
  return fresnel / (fresnel + (1 - fresnel) / 2);
}

template <std::floating_point Real, typename Base>
Real Coated<Real, Base>::base_pdf(const Vec3<Real>& wo, const Vec3<Real>& wi) const {
  const Real even = std::fabs(wi.z) * std::numbers::inv_pi_v<Real>;
  if constexpr (kMetal)
    return Real(kGuided) * guide_.pdf(wo, wi).per_sr + Real(1 - kGuided) * even;
  else
    return even;
}

template <std::floating_point Real, typename Base>
SolidAnglePdf<Real> Coated<Real, Base>::pdf(const Vec3<Real>& wo, const Vec3<Real>& wi) const {
  if (all_delta() || !same_side(wo, wi)) return {};
  const Real share = at_boundary(wo);
  Vec3<Real> o = wo, i = wi;
  if (wo.z < 0) o = -o, i = -i;
  return {share * boundary_.pdf(o, i, Side::kReflected) + (1 - share) * base_pdf(o, i)};
}

template <std::floating_point Real, typename Base>
Rgb<Real> Coated<Real, Base>::value(const Vec3<Real>& wo, const Vec3<Real>& wi) const {
  if (all_delta() || !same_side(wo, wi)) return {};
  return wo.z < 0 ? walk(-wo, -wi) : walk(wo, wi);
}

template <std::floating_point Real, typename Base>
std::optional<ScatterSample<Real>> Coated<Real, Base>::sample(const Vec3<Real>& wo,
                                                              const ScatterValues<Real>& u) const {
  if (wo.z == 0) return std::nullopt;
  if (all_delta()) return mirror(wo);
  const Vec3<Real> up = wo.z < 0 ? -wo : wo;
  const Real share = at_boundary(wo);
  ScatterSample<Real> s;
  if (u.choice < share) {
    const auto reflected =
        boundary_.sample(up, {u.choice / share, u.direction}, Side::kReflected, Carries::kRadiance);
    if (!reflected) return std::nullopt;
    s.wi = reflected->wi;
    if (reflected->delta) {
      s.weight = Rgb<Real>(reflected->weight / share);
      s.delta = true;
    }
  } else {
    const Real rest = (u.choice - share) / (1 - share);
    if (kMetal && rest < Real(kGuided)) {
      const auto guided = guide_.sample(up, {0, u.direction});
      if (!guided) return std::nullopt;
      s.wi = guided->wi;
    } else {
      s.wi = sample_cosine_hemisphere(u.direction);
    }
  }
  if (!s.delta) {
    s.pdf = pdf(up, s.wi);
    if (!(s.pdf.per_sr > 0)) return std::nullopt;
    s.weight = walk(up, s.wi) / s.pdf.per_sr;
  }
  if (wo.z < 0) s.wi = -s.wi;
  return s;
}

template <std::floating_point Real, typename Base>
Rgb<Real> Coated<Real, Base>::single(const Vec3<Real>& wo, Side side) const {
  if (side != Side::kReflected || wo.z == 0) return {};
  return all_delta() ? mirror(wo).weight : boundary_.single(wo.z < 0 ? -wo : wo, side);
}

// Smooth layers send all light to the mirror direction: a geometric series.
template <std::floating_point Real, typename Base>
ScatterSample<Real> Coated<Real, Base>::mirror(const Vec3<Real>& wo) const {
  const Real fresnel = fresnel_dielectric(std::fabs(wo.z), boundary_.eta());
  Rgb<Real> all(fresnel);
  if constexpr (kMetal) {
    if (const auto inside = refract(wo.z < 0 ? -wo : wo, {0, 0, 1}, boundary_.eta())) {
      const Real cosine = std::fabs(inside->w.z), twice = passes(cosine) * passes(cosine);
      const Rgb<Real> once = base_.reflected(cosine) * twice;
      const auto series = [&](Real r) {
        return (1 - fresnel) * (1 - fresnel) * r / (1 - fresnel * r);
      };
      all += {series(once.r), series(once.g), series(once.b)};
    }
  }
  return {.wi = mirrored(wo), .weight = all, .delta = true};
}

template <std::floating_point Real, typename Base>
Rgb<Real> Coated<Real, Base>::walk(const Vec3<Real>& wo, const Vec3<Real>& wi) const {
  constexpr int kSafeDepth = 3, kMostDepth = 64;
  WalkNumbers random(wo, wi);
  // Without the cosine of wi until the end.
  Rgb<Real> sum(boundary_.value(wo, wi, Carries::kRadiance) / wi.z);
  const auto in =
      boundary_.sample(wo, random.values<Real>(), Side::kTransmitted, Carries::kRadiance);
  // Light from wi within the coat.  The walk carries radiance, so this end carries importance.
  const auto lit =
      boundary_.sample(wi, random.values<Real>(), Side::kTransmitted, Carries::kImportance);
  if (!in) return sum * wi.z;
  Vec3<Real> w = in->wi;  // down
  Rgb<Real> throughput(in->weight);
  for (int depth = 0; depth < kMostDepth; ++depth) {
    throughput = throughput * passes(w.z);
    if (lit) {
      const Rgb<Real> base = base_.value(-w, -lit->wi) / std::fabs(lit->wi.z);
      const Real weight =
          lit->delta ? Real(1) : power_weight(lit->pdf, base_.pdf(-w, -lit->wi).per_sr);
      if (!base.is_black()) sum += throughput * base * (passes(lit->wi.z) * lit->weight * weight);
    }
    const auto up = base_.sample(-w, random.values<Real>());
    if (!up) break;
    throughput = throughput * up->weight * passes(up->wi.z);
    if (!boundary_.all_delta()) {
      const Real out = boundary_.value(-up->wi, wi, Carries::kRadiance) / wi.z;
      if (out > 0) {
        const Real weight =
            up->delta
                ? Real(1)
                : power_weight(up->pdf.per_sr, boundary_.pdf(wi, -up->wi, Side::kTransmitted));
        sum += throughput * (out * weight);
      }
    }
    const auto down =
        boundary_.sample(-up->wi, random.values<Real>(), Side::kReflected, Carries::kRadiance);
    if (!down) break;
    throughput = throughput * down->weight;
    w = down->wi;
    if (depth >= kSafeDepth) {
      const Real survival = std::min(Real(0.95), throughput.max_component());
      if (!(random.uniform() < survival)) break;
      throughput = throughput / survival;
    }
  }
  return sum * wi.z;
}

template class Coated<float, Diffuse<float>>;
template class Coated<double, Diffuse<double>>;
template class Coated<float, Conductor<float>>;
template class Coated<double, Conductor<double>>;

}  // namespace lucerna
