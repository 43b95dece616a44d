#include "server/materials/metallic_roughness.h"

#include <algorithm>

#include "server/materials/diffuse.h"

namespace lucerna {
namespace {

/// Of a clear coat of index 1.5.  [glTF2, KHR_materials_clearcoat]
constexpr double kCoatF0 = 0.04;
/// The mean of (1 - cos)^5 over directions, weighted by their cosine.
constexpr double kMeanSchlick = 1.0 / 21;

double schlick_weight(double cosine) {
  const double x = std::clamp(1 - cosine, 0.0, 1.0);
  return x * x * x * x * x;
}

double mean_of(const Rgb& c) { return (c.r + c.g + c.b) / 3; }

double coat_reflected(double schlick) { return kCoatF0 + (1 - kCoatF0) * schlick; }

Vec3 below(const Vec3& w) { return {w.x, w.y, -w.z}; }

}  // namespace

MetallicRoughness::MetallicRoughness(const MetallicRoughnessParams& p, Side sides)
    : sides_(sides),
      f0_(p.base * p.metallic + p.f0 * (1 - p.metallic)),
      f90_(Rgb(p.metallic + p.f90 * (1 - p.metallic))),
      diffuse_(p.base * (1 - p.metallic)),
      left_f0_(p.f0.max_component()),
      left_f90_(p.f90),
      facets_(Microfacets::rough(p.alpha.x), Microfacets::rough(p.alpha.y)),
      cos_turn_(p.turn_rad == 0 ? 1.0 : std::cos(p.turn_rad)),
      sin_turn_(p.turn_rad == 0 ? 0.0 : std::sin(p.turn_rad)),
      coat_(p.coat),
      coat_facets_(Microfacets::rough(p.coat_alpha), Microfacets::rough(p.coat_alpha)),
      smooth_(Microfacets::is_smooth(p.alpha.x, p.alpha.y)),
      coat_smooth_(Microfacets::is_smooth(p.coat_alpha, p.coat_alpha)) {
  if (transmits()) {
    passed_ = diffuse_ * p.transmission;
    diffuse_ = diffuse_ * (1 - p.transmission);
  }
  if (diffuse_.is_black()) return;
  // The diffuse part between two directions is the product of what facets leave on both ways,
  // over its mean.  The mean is not below the true one, also if the axes differ in roughness.
  const auto mean_left = [&](double alpha) {
    if (smooth_) return left(kMeanSchlick);
    return 1 - mean_facet_albedo(alpha).of(left_f0_, left_f90_);
  };
  const Vec2 alpha = facets_.alpha();
  const double mean =
      alpha.x == alpha.y ? mean_left(alpha.x) : std::max(mean_left(alpha.x), mean_left(alpha.y));
  diffuse_ = mean > 0 ? diffuse_ / mean : Rgb{};
}

Vec3 MetallicRoughness::turned(const Vec3& w) const {
  return {w.x * cos_turn_ + w.y * sin_turn_, w.y * cos_turn_ - w.x * sin_turn_, w.z};
}

Vec3 MetallicRoughness::turned_back(const Vec3& w) const {
  return {w.x * cos_turn_ - w.y * sin_turn_, w.y * cos_turn_ + w.x * sin_turn_, w.z};
}

double MetallicRoughness::left_in_all(const Vec3& w) const {
  if (left_f90_ == 0) return 1;
  if (smooth_) return left(schlick_weight(std::fabs(w.z)));
  const Vec2 a = facets_.alpha();
  // Roughness as `w` sees it, and the mean of both axes along the normal.
  const double alpha = a.x == a.y ? a.x
                                  : std::sqrt(a.x * a.x * (w.x * w.x + w.z * w.z / 2) +
                                              a.y * a.y * (w.y * w.y + w.z * w.z / 2));
  return 1 - facet_albedo(std::fabs(w.z), alpha).of(left_f0_, left_f90_);
}

double MetallicRoughness::below_coat(double cosine) const {
  if (coat_smooth_) return 1 - coat_ * coat_reflected(schlick_weight(cosine));
  return 1 - coat_ * facet_albedo(cosine, coat_facets_.alpha().x).of(kCoatF0, 1.0);
}

auto MetallicRoughness::shares(double cosine) const -> Shares {
  const double schlick = schlick_weight(cosine);
  // Facets that face away from the normal reflect more than those along it.
  const double of_facets = std::max(schlick, kMeanSchlick);
  Shares s{.coat = coat_ * coat_reflected(of_facets),
           .reflected = mean_of(reflected(of_facets)),
           .passed = mean_of(passed_) * left(schlick),
           .diffuse = mean_of(diffuse_) * left(schlick)};
  const double below = 1 - s.coat, sum = s.reflected + s.passed + s.diffuse;
  const double all = s.coat + below * sum;
  if (!(all > 0)) return {};
  s.coat /= all;
  s.reflected *= below / all;
  s.passed *= below / all;
  s.diffuse *= below / all;
  return s;
}

auto MetallicRoughness::facets_between(const Microfacets& facets, const Vec3& wo, const Vec3& wi)
    -> Facets {
  const Vec3 m = normalized(wo + wi);
  // The reflection stretches solid angles by 4 cos, and the density of visible normals has a cos.
  const double pdf = facets.seen_per_cosine(wo) * facets.density(m) / 4;
  return {pdf * facets.also_seen(wo, wi), pdf, schlick_weight(dot(wo, m))};
}

auto MetallicRoughness::evaluate(const Vec3& given_wo, const Vec3& given_wi) const -> Evaluation {
  Evaluation e;
  if (given_wo.z * given_wi.z == 0) return e;
  const bool reflects = same_side(given_wo, given_wi);
  if (!reflects && !transmits()) return e;
  const Vec3 wo = turned(given_wo.z < 0 ? -given_wo : given_wo);
  Vec3 wi = turned(given_wo.z < 0 ? -given_wi : given_wi);
  // Light through a sheet is that of a reflection, on the other side.
  if (!reflects) wi = below(wi);
  const Shares share = shares(wo.z);
  if (!smooth_ && (reflects || !passed_.is_black())) {
    const Facets f = facets_between(facets_, wo, wi);
    e.value = (reflects ? reflected(f.schlick) : passed_ * left(f.schlick)) * f.value;
    e.pdf = (reflects ? share.reflected : share.passed) * f.pdf;
  }
  if (reflects && !diffuse_.is_black()) {
    const double even = wi.z * std::numbers::inv_pi;
    e.value += diffuse_ * (left_in_all(wo) * left_in_all(wi) * even);
    e.pdf += share.diffuse * even;
  }
  if (coat_ == 0) return e;
  // The lesser of both ways, so that the coat and what is below it never add up to more than 1.
  e.value = e.value * std::min(below_coat(wo.z), below_coat(wi.z));
  if (reflects && !coat_smooth_) {
    const Facets f = facets_between(coat_facets_, wo, wi);
    e.value += Rgb(coat_ * coat_reflected(f.schlick) * f.value);
    e.pdf += share.coat * f.pdf;
  }
  return e;
}

bool MetallicRoughness::is_single(Lobe lobe) const {
  return lobe == Lobe::kCoat ? coat_smooth_ : smooth_ && lobe != Lobe::kDiffuse;
}

Rgb MetallicRoughness::single(Lobe lobe, const Vec3& wo) const {
  const double cosine = std::fabs(wo.z), schlick = schlick_weight(cosine);
  Rgb light(coat_ * coat_reflected(schlick));
  if (lobe != Lobe::kCoat) {
    light = lobe == Lobe::kReflected ? reflected(schlick) : passed_ * left(schlick);
    if (coat_ > 0) light = light * below_coat(cosine);
  }
  return light;
}

Rgb MetallicRoughness::single(const Vec3& wo, Side side) const {
  Rgb sum;
  const auto add = [&](Lobe lobe) {
    if (is_single(lobe)) sum += single(lobe, wo);
  };
  if (wo.z == 0) return sum;
  if (side == Side::kTransmitted) {
    if (transmits()) add(Lobe::kPassed);
    return sum;
  }
  add(Lobe::kReflected);
  if (coat_ > 0) add(Lobe::kCoat);
  return sum;
}

std::optional<ScatterSample> MetallicRoughness::sample(const Vec3& wo,
                                                       const ScatterValues& u) const {
  if (wo.z == 0) return std::nullopt;
  const Vec3 up = turned(wo.z < 0 ? -wo : wo);
  const Shares all = shares(up.z);
  // Choose a lobe.  The last one takes what rounding leaves.
  Lobe lobe = Lobe::kDiffuse;
  double share = all.diffuse, before = 0;
  for (const auto& [l, s] : {std::pair(Lobe::kCoat, all.coat),
                             {Lobe::kReflected, all.reflected},
                             {Lobe::kPassed, all.passed}}) {
    before += s;
    if (u.choice >= before || !(s > 0)) continue;
    lobe = l;
    share = s;
    break;
  }
  if (!(share > 0)) return std::nullopt;
  if (is_single(lobe))
    return ScatterSample{.wi = lobe == Lobe::kPassed ? -wo : mirrored(wo),
                         .weight = single(lobe, wo) / share,
                         .delta = true};
  ScatterSample s;
  if (lobe == Lobe::kDiffuse) {
    s.wi = sample_cosine_hemisphere(u.direction);
  } else {
    const Vec3 m = (lobe == Lobe::kCoat ? coat_facets_ : facets_).sample(up, u.direction);
    s.wi = m * (2 * dot(up, m)) - up;
    if (!(s.wi.z > 0)) return std::nullopt;  // hits another facet, which is not modelled
    if (lobe == Lobe::kPassed) s.wi = below(s.wi);
  }
  s.wi = turned_back(s.wi);
  if (wo.z < 0) s.wi = -s.wi;
  const Evaluation e = evaluate(wo, s.wi);
  if (!(e.pdf > 0)) return std::nullopt;
  s.weight = e.value / e.pdf;
  s.pdf = {e.pdf};
  return s;
}

}  // namespace lucerna
