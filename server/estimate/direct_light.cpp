#include "server/estimate/direct_light.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "server/scene/light_at_time.h"
#include "server/visibility/shaft.h"

namespace lucerna {
namespace {

/// The sample of an area light that counts as a point.  Nothing if the distance is below `radii`
/// times the light's radius, or if the light has no closed form.
std::optional<LightSample> far_sample(const Light& light, const Receiver& receiver, double radii) {
  if (!light.has_surface() || !light.has_irradiance()) return std::nullopt;
  const auto bounds = light.bounds();
  if (!bounds || light.hides_itself()) return std::nullopt;
  const Vec3 middle = bounds->lower * 0.5 + bounds->upper * 0.5;
  const Vec3 away = receiver.position - middle;
  const double distance = length(away);
  if (!(distance > std::fmax(radii, 1) * length(bounds->upper - middle))) return std::nullopt;
  // At 2^10 times the distance, the light's size changes the value by less than a millionth.
  // The squared factor is applied again below.
  constexpr double kFarther = 1024;
  Receiver from = receiver;
  from.position = middle + away * kFarther;
  from.normal = away * (-1 / distance);
  const auto lx = light.irradiance(from);
  if (!lx) return std::nullopt;
  // The shadow ray ends at this point of the light.
  LightSample s = light.sample_li(receiver, {0.5, 0.5});
  s.delta = true;
  s.pdf = {};
  s.wi = from.normal;
  s.value = *lx * (kFarther * kFarther);
  if (s.reason == NoLight::kNone && s.value.is_black()) s.reason = NoLight::kBlack;
  return s;
}

/// The share of a sample's light that a surface of reflectance 1 sends towards `wo`; 0 without
/// light.
double reflected_share(const SurfaceHit& hit, const Vec3f& wo, const LightSample& sample) {
  return sample.reason == NoLight::kNone ? reflected_share(hit, wo, sample.wi) : 0;
}

/// From this number of lights with a size on, one of them is drawn after a reflection
/// (docs/decisions/054-lights-after-a-reflection.md).
constexpr std::size_t kFewestDrawn = 3;

/// Whether a light with a size is near and shines evenly.  The light tree then knows nearly what it
/// contributes.
bool is_even_lamp(const Light& light) {
  return light.shared_data().empty() && light.bounds().has_value();
}

}  // namespace

MostIrradiance most_of(const LightAtTime& light, const Receiver& receiver, double probability) {
  // The probability is 0 only if the bounds of the light's cluster exclude light.
  if (!(probability > 0)) return {};
  MostIrradiance most = light->most_irradiance(receiver);
  // No part of a light that rays do not meet hides another part.
  if (light.is_unseen() && most.lx > 0) most.lx = most.sample_lx;
  return {most.lx, most.sample_lx / probability};
}

DirectLight::DirectLight(const Scene& scene, const Methods& methods, std::uint32_t candidates)
    : scene_(scene), methods_(methods), visibility_(scene, methods) {
  const auto& lights = scene.lights();
  for (const SceneLight& l : lights) deltas_ += is_delta(l) ? 1 : 0;
  const LightSelection how = methods.light_selection;
  const bool automatic = how == LightSelection::kAutomatic;
  const auto draw = [&](bool areas_only) -> std::unique_ptr<const LightStrategy> {
    if (automatic && candidates > 1)
      return std::make_unique<ResampledLights>(how, areas_only, candidates);
    return std::make_unique<OneLight>(how, areas_only);
  };
  drawn_ = draw(false);
  areas_drawn_ = draw(true);
  // With one light, there is nothing to choose.
  const bool all = how == LightSelection::kAll || lights.size() <= (automatic ? kFewLights : 1);
  first_ = all ? &all_ : drawn_.get();
  later_ = first_;
  if (automatic && all && lights.size() - deltas_ >= kFewestDrawn &&
      std::ranges::all_of(
          lights, [](const SceneLight& l) { return is_delta(l) || is_even_lamp(*l.light); }))
    later_ = &one_area_;
}

double DirectLight::weight(double a, double b) const {
  if (!(a > 0)) return 0;
  const double ratio = b / a;  // without overflow
  return 1 / (1 + (methods_.combination == Combination::kBalanceHeuristic ? ratio : ratio * ratio));
}

Receiver DirectLight::receiver(const SurfaceHit& hit, const Vec3f& wo,
                               const SurfaceScattering* scattering) const {
  Receiver r(hit.position);
  // Without a normal, light arrives from both sides.
  if (scattering == nullptr || !scattering->transmits())
    r.normal = dot(hit.ns, Vec3(wo)) < 0 ? -hit.ns : hit.ns;
  r.area_sampling = methods_.area_sampling;
  // Each vertex samples lights and a direction of the surface, and weights both.
  r.incomplete = methods_.combination != Combination::kLights;
  return r;
}

Combination DirectLight::combination(std::uint32_t light) const {
  return scene_.lights()[light].is_unseen ? Combination::kLights : methods_.combination;
}

std::uint32_t DirectLight::points_on(std::uint32_t light) const {
  const std::uint32_t points = methods_.samples_per_light.value_or(scene_.lights()[light].samples);
  return points == 1 || is_delta(scene_.lights()[light]) ? 1 : points;
}

std::uint64_t DirectLight::samples_for_exact_deltas() const {
  if (scene_.lights().size() <= kFewLights) return 0;
  return (deltas_ + kDeltasPerSample - 1) / kDeltasPerSample;
}

const LightStrategy& DirectLight::strategy_at_receiver(std::uint64_t samples) const {
  if (methods_.light_selection != LightSelection::kAutomatic) return *first_;
  if (samples < samples_for_exact_deltas()) return *drawn_;
  if (scene_.lights().size() - deltas_ <= kFewAreas) return all_;
  return *areas_drawn_;
}

LightSample DirectLight::light_sample(const LightVertex& v, std::uint32_t light,
                                      const PathSample& at, std::uint32_t dimension) const {
  const LightAtTime l(scene_.lights()[light], v.hit.time_s);
  Receiver r = receiver(v.hit, v.wo, v.scattering);
  r.incomplete = r.incomplete && !l.is_unseen();
  if (methods_.far_light_radii)
    if (const auto s = far_sample(*l, r, *methods_.far_light_radii)) return *s;
  if (l->is_delta()) return l->sample_li(r, {});  // has one sample, so it needs no random numbers
  const Vec2f u = at.pair(dimension);
  return l->sample_li(r, {u.x, u.y});
}

DirectLight::Candidate DirectLight::candidate(const LightVertex& v, const LightChoice& choice,
                                              std::uint32_t points, const PathSample& at,
                                              std::uint32_t dimension) const {
  Candidate c{light_sample(v, choice.light, at, dimension), {}, {}};
  const LightSample& s = c.sample;
  if (v.scattering != nullptr) {
    scatter(v, choice, points, c);
    return c;
  }
  const double f = reflected_share(v.hit, v.wo, s);  // equals the density of cosine_direction
  if (!(f > 0)) return c;
  if (s.delta) {
    c.value = s.value * (f / choice.probability);
    return c;
  }
  const double light_pdf = s.pdf.per_sr * choice.probability;
  switch (combination(choice.light)) {
    case Combination::kSurfaces:
      c.found = s.value;
      break;
    case Combination::kLights:
      c.value = s.value * (f / light_pdf);
      break;
    default:
      c.value = s.value * (f * weight(points * light_pdf, f) / light_pdf);
  }
  return c;
}

void DirectLight::scatter(const LightVertex& v, const LightChoice& choice, std::uint32_t points,
                          Candidate& c) const {
  const LightSample& s = c.sample;
  if (s.reason != NoLight::kNone) return;
  const Vec3 wo(v.wo);
  const Rgb f = v.scattering->value(wo, s.wi);
  if (f.is_black()) return;
  if (s.delta) {
    c.value = s.value * f * (1 / choice.probability);
    return;
  }
  const double light_pdf = s.pdf.per_sr * choice.probability;
  const double direction_pdf = v.scattering->pdf(wo, s.wi);
  switch (combination(choice.light)) {
    case Combination::kSurfaces:
      if (direction_pdf > 0) c.found = s.value * f / direction_pdf;
      break;
    case Combination::kLights:
      c.value = s.value * f / light_pdf;
      break;
    default:
      c.value = s.value * f * (weight(points * light_pdf, direction_pdf) / light_pdf);
  }
}

LightEstimate DirectLight::shadowed(const SurfaceHit& hit, std::uint32_t light, const Candidate& c,
                                    WorkCounts& work) const {
  if (c.value.is_black()) return {};
  if (scene_.geometry().is_clear())
    return {c.value, c.value};  // no ray is needed, and none is counted
  const Ray ray = shadow_ray(hit, c.sample, scene_.lights()[light].reach_m());
  return {c.value * visibility_.visible(light, hit.position, hit.ng, ray, work), c.value};
}

std::optional<LightEstimate> DirectLight::from_point_light(const SurfaceHit& hit, const Vec3f& wo,
                                                           const LightChoice& choice,
                                                           WorkCounts& work) const {
  const PointLight* const point = resting_point_light(scene_.lights()[choice.light]);
  if (point == nullptr) return std::nullopt;
  const auto plain = point->plain_sample_li(hit.position);
  if (!plain) return std::nullopt;
  const double f = reflected_share(hit, wo, plain->wi);
  if (!(f > 0)) return LightEstimate{};
  const Rgb value = plain->value * (f / choice.probability);
  if (value.is_black() || scene_.geometry().is_clear()) return LightEstimate{value, value};
  const Ray ray = ray_to_point(hit, plain->wi, Vec3f(point->position()));
  return LightEstimate{value * visibility_.visible(choice.light, hit.position, hit.ng, ray, work),
                       value};
}

std::optional<Rgb> DirectLight::from_one_direction(const SurfaceHit& hit, const Vec3f& wo,
                                                   std::uint32_t light, WorkCounts& work) const {
  if (const auto e = from_point_light(hit, wo, {light, 1}, work)) return e->value;
  const LightAtTime l(scene_.lights()[light], hit.time_s);
  const auto arriving = [&](const LightSample& s) {
    const double share = reflected_share(hit, wo, s);
    return share > 0 ? shadowed(hit, light, {s, s.value * share, {}}, work).value : Rgb{};
  };
  if (methods_.far_light_radii)
    if (const auto s = far_sample(*l, receiver(hit, wo), *methods_.far_light_radii))
      return arriving(*s);
  if (!l->is_delta()) return std::nullopt;
  return arriving(l->sample_li(receiver(hit, wo), {}));
}

bool DirectLight::uses_closed_forms(bool at_receiver) const {
  if (methods_.closed_forms != ClosedForms::kAutomatic)
    return methods_.closed_forms != ClosedForms::kOff;
  return at_receiver && scene_.lights().size() - deltas_ <= kFewAreas;
}

std::optional<Rgb> DirectLight::in_closed_form(const SurfaceHit& hit, const Vec3f& wo,
                                               std::uint32_t light) const {
  const SceneLight& of = scene_.lights()[light];
  if (of.moving != nullptr || scene_.geometry().has_media()) return std::nullopt;
  const LightAtTime l(of, hit.time_s);
  if (!l->has_irradiance() || l->hides_itself()) return std::nullopt;
  const Receiver r = receiver(hit, wo);
  if (!shafts(scene_).is_empty(hit, Vec3f(r.normal), light)) return std::nullopt;
  const std::optional<Rgb> lx = l->irradiance(r);
  if (!lx) return std::nullopt;
  return *lx * std::numbers::inv_pi;
}

void DirectLight::sample_light(const LightVertex& v, const LightChoice& choice, const PathSample& s,
                               std::uint32_t dimension) const {
  if (v.scattering == nullptr)
    if (const auto e = from_point_light(v.hit, v.wo, choice, v.work))
      return v.add(choice.light, *e);
  const std::uint32_t points = points_on(choice.light);
  LightEstimate sum;
  for (std::uint32_t j = 0; j < points; ++j) {
    const Candidate c = candidate(v, choice, points, s.part(j, points), dimension);
    sum += shadowed(v.hit, choice.light, c, v.work);
    sum.unshadowed += c.found;
  }
  const double share = 1.0 / points;
  v.add(choice.light, {sum.value * share, sum.unshadowed * share});
}

MostIrradiance DirectLight::most(const LightStrategy& strategy, const SurfaceHit& hit,
                                 const Vec3f& wo, std::uint32_t light) const {
  const Receiver r = receiver(hit, wo);
  return most_of(LightAtTime(scene_.lights()[light], hit.time_s), r,
                 strategy.probability(scene_, r, light));
}

double DirectLight::found_weight(const LightStrategy& strategy, const SurfaceHit& from,
                                 const Vec3f& wo, const Ray& ray,
                                 const std::optional<SurfaceHit>& hit, std::uint32_t light,
                                 double direction_pdf, const SurfaceScattering* scattering) const {
  if (methods_.combination == Combination::kSurfaces && !methods_.far_light_radii) return 1;
  const Receiver r = receiver(from, wo, scattering);
  const LightAtTime l(scene_.lights()[light], ray.time_s);
  // Directions do not find a light that counts as a point.
  if (methods_.far_light_radii && far_sample(*l, r, *methods_.far_light_radii)) return 0;
  SolidAnglePdf pdf{};
  if (!l->has_surface())
    pdf = l->pdf_li(r, Vec3(ray.direction));
  else if (hit)
    pdf = l->pdf_li(r, hit->on_light());
  // A density of infinity marks a light that directions cannot find.
  if (pdf.per_sr == std::numeric_limits<double>::infinity()) return 0;
  if (methods_.combination == Combination::kSurfaces) return 1;
  double times = strategy.probability(scene_, r, light);  // points on the light, equally likely
  if (strategy.takes_all_points()) times *= points_on(light);
  return weight(direction_pdf, pdf.per_sr * times);
}

}  // namespace lucerna
