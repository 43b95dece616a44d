#include "server/materials/coated.h"

#include <algorithm>

#include "lights/sampling/hash_number.h"
#include "server/materials/fresnel.h"

namespace lucerna {
namespace {

/// Random numbers that depend on two directions only, so that a value can be repeated.
class WalkNumbers {
 public:
  WalkNumbers(const Vec3& wo, const Vec3& wi)
      : state_(hash_of({wo.x, wo.y, wo.z, wi.x, wi.y, wi.z})) {}

  double uniform() { return static_cast<double>(mix_bits(state_++) >> 11) * 0x1p-53; }
  ScatterValues values() {
    const double choice = uniform(), x = uniform(), y = uniform();
    return {choice, {x, y}};
  }

 private:
  std::uint64_t state_;
};

/// The weight of a direction of density `a` that another strategy finds with density `b`.
double power_weight(double a, double b) {
  const double ratio = b / a;
  return 1 / (1 + ratio * ratio);
}

/// Roughness of a base.
Vec2 alpha_of(const Conductor& base) { return base.alpha(); }
Vec2 alpha_of(const Diffuse&) { return {1, 1}; }

/// Share of directions near those of a metal; the rest is cosine-weighted, for walks of many
/// reflections.
constexpr double kGuided = 0.8;

}  // namespace

// The boundary turns a facet normal's slope m into a half vector of slope eta m, and is passed
// twice.
template <typename Base>
Coated<Base>::Coated(const Params& p)
    : boundary_(p.boundary),
      base_(p.base),
      guide_(
          Rgb(1), Rgb(1),
          std::min(1.0, std::hypot(p.boundary.eta() * alpha_of(p.base).x, p.boundary.alpha().x)),
          std::min(1.0, std::hypot(p.boundary.eta() * alpha_of(p.base).y, p.boundary.alpha().y))),
      thickness_(p.thickness) {}

template <typename Base>
double Coated<Base>::at_boundary(const Vec3& wo) const {
  // Most bases reflect about half of the light.
  const double fresnel = fresnel_dielectric(std::fabs(wo.z), boundary_.eta());
  return fresnel / (fresnel + (1 - fresnel) / 2);
}

template <typename Base>
double Coated<Base>::base_pdf(const Vec3& wo, const Vec3& wi) const {
  const double even = std::fabs(wi.z) * std::numbers::inv_pi;
  if constexpr (kMetal)
    return kGuided * guide_.pdf(wo, wi).per_sr + (1 - kGuided) * even;
  else
    return even;
}

template <typename Base>
SolidAnglePdf Coated<Base>::pdf(const Vec3& wo, const Vec3& wi) const {
  if (all_delta() || !same_side(wo, wi)) return {};
  const double share = at_boundary(wo);
  Vec3 o = wo, i = wi;
  if (wo.z < 0) o = -o, i = -i;
  return {share * boundary_.pdf(o, i, Side::kReflected) + (1 - share) * base_pdf(o, i)};
}

template <typename Base>
Rgb Coated<Base>::value(const Vec3& wo, const Vec3& wi) const {
  if (all_delta() || !same_side(wo, wi)) return {};
  return wo.z < 0 ? walk(-wo, -wi) : walk(wo, wi);
}

template <typename Base>
std::optional<ScatterSample> Coated<Base>::sample(const Vec3& wo, const ScatterValues& u) const {
  if (wo.z == 0) return std::nullopt;
  if (all_delta()) return mirror(wo);
  const Vec3 up = wo.z < 0 ? -wo : wo;
  const double share = at_boundary(wo);
  ScatterSample s;
  if (u.choice < share) {
    const auto reflected =
        boundary_.sample(up, {u.choice / share, u.direction}, Side::kReflected, Carries::kRadiance);
    if (!reflected) return std::nullopt;
    s.wi = reflected->wi;
    if (reflected->delta) {
      s.weight = Rgb(reflected->weight / share);
      s.delta = true;
    }
  } else {
    const double rest = (u.choice - share) / (1 - share);
    if (kMetal && rest < kGuided) {
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

template <typename Base>
Rgb Coated<Base>::single(const Vec3& wo, Side side) const {
  if (side != Side::kReflected || wo.z == 0) return {};
  return all_delta() ? mirror(wo).weight : boundary_.single(wo.z < 0 ? -wo : wo, side);
}

// Smooth layers send all light to the mirror direction: a geometric series.
template <typename Base>
ScatterSample Coated<Base>::mirror(const Vec3& wo) const {
  const double fresnel = fresnel_dielectric(std::fabs(wo.z), boundary_.eta());
  Rgb all(fresnel);
  if constexpr (kMetal) {
    if (const auto inside = refract(wo.z < 0 ? -wo : wo, {0, 0, 1}, boundary_.eta())) {
      const double cosine = std::fabs(inside->w.z), twice = passes(cosine) * passes(cosine);
      const Rgb once = base_.reflected(cosine) * twice;
      const auto series = [&](double r) {
        return (1 - fresnel) * (1 - fresnel) * r / (1 - fresnel * r);
      };
      all += {series(once.r), series(once.g), series(once.b)};
    }
  }
  return {.wi = mirrored(wo), .weight = all, .delta = true};
}

template <typename Base>
Rgb Coated<Base>::walk(const Vec3& wo, const Vec3& wi) const {
  constexpr int kSafeDepth = 3, kMostDepth = 64;
  WalkNumbers random(wo, wi);
  // Without the cosine of wi until the end.
  Rgb sum(boundary_.value(wo, wi, Carries::kRadiance) / wi.z);
  const auto in = boundary_.sample(wo, random.values(), Side::kTransmitted, Carries::kRadiance);
  // Light from wi within the coat.  The walk carries radiance, so this end carries importance.
  const auto lit = boundary_.sample(wi, random.values(), Side::kTransmitted, Carries::kImportance);
  if (!in) return sum * wi.z;
  Vec3 w = in->wi;  // down
  Rgb throughput(in->weight);
  for (int depth = 0; depth < kMostDepth; ++depth) {
    throughput = throughput * passes(w.z);
    if (lit) {
      const Rgb base = base_.value(-w, -lit->wi) / std::fabs(lit->wi.z);
      const double weight =
          lit->delta ? 1.0 : power_weight(lit->pdf, base_.pdf(-w, -lit->wi).per_sr);
      if (!base.is_black()) sum += throughput * base * (passes(lit->wi.z) * lit->weight * weight);
    }
    const auto up = base_.sample(-w, random.values());
    if (!up) break;
    throughput = throughput * up->weight * passes(up->wi.z);
    if (!boundary_.all_delta()) {
      const double out = boundary_.value(-up->wi, wi, Carries::kRadiance) / wi.z;
      if (out > 0) {
        const double weight =
            up->delta
                ? 1.0
                : power_weight(up->pdf.per_sr, boundary_.pdf(wi, -up->wi, Side::kTransmitted));
        sum += throughput * (out * weight);
      }
    }
    const auto down =
        boundary_.sample(-up->wi, random.values(), Side::kReflected, Carries::kRadiance);
    if (!down) break;
    throughput = throughput * down->weight;
    w = down->wi;
    if (depth >= kSafeDepth) {
      const double survival = std::min(0.95, throughput.max_component());
      if (!(random.uniform() < survival)) break;
      throughput = throughput / survival;
    }
  }
  return sum * wi.z;
}

template class Coated<Diffuse>;
template class Coated<Conductor>;

}  // namespace lucerna
