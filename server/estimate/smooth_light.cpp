#include "server/estimate/smooth_light.h"

#include <algorithm>
#include <cmath>

#include "server/rays/error_bounds.h"
#include "server/visibility/end_tolerance.h"

namespace lucerna {
namespace {

/// Longer sequences that leave less than this share of light are chosen at random.
constexpr double kLeastShare = 1e-3;
/// The most sequences that a receiver visits, all of those that go on in every way.
constexpr std::size_t kMostVisited = 64;
static_assert(2 * SmoothSurfaces::kFewParts <= kMostVisited);
/// Sequences of kMostSteps that leave less than this share of light are long enough.
constexpr double kLongEnough = 5e-4;
/// The most surfaces that a receiver visits as the first of a sequence if some bend light, and that
/// a vertex of a path visits.
constexpr std::size_t kMostBent = 48, kMostFirstOnPaths = 1;
/// With at most this many lights, each is sampled.
constexpr std::size_t kFewLights = 20, kFewLightsOnPaths = 3;

int sign_of(double x) { return x < 0 ? -1 : 1; }

/// A lamp without a size that lies on a mirror, up to the rounding of coordinates, shines on both
/// sides of it.  A ray may meet the mirror this much later than the lamp.  share_along() decides.
double on_mirror(const SmoothPart& part, const LightSample& lamp) {
  if (!lamp.delta || !std::isfinite(lamp.distance)) return 0;
  const double reach = max_abs(part.middle) + length(part.half_u) + length(part.half_v);
  return 8 * kFloatRoundoff * reach / std::fabs(dot(part.n, lamp.wi));
}

}  // namespace

SmoothLight::SmoothLight(const Scene& scene, const Methods& methods,
                         const LightVisibility& visibility)
    : scene_(scene),
      visibility_(visibility),
      surfaces_(smooth_surfaces(scene)),
      parts_(scene.lights().empty() ? std::span<const SmoothPart>() : surfaces_.parts()),
      samples_sizes_(methods.combination != Combination::kSurfaces) {
  for (std::uint32_t i = 0; i < parts_.size(); ++i) {
    has_steps_ |= parts_[i].reflects || parts_[i].refracts;
    tried_on_paths_ = parts_[i].refracts ? 1 : std::max(tried_on_paths_, parts_[i].reflected);
    bends_ |= parts_[i].is_sphere || (parts_[i].refracts && parts_[i].eta != 1);
    if (parts_[i].glossy_alpha > 0) glossy_.push_back(i);
  }
  tried_on_paths_ = std::min(tried_on_paths_, 1.0);
  if (parts_.empty()) return;
  for (const SceneLight& light : scene.lights()) {
    const bool is_unsized = is_delta(light) || light.is_unseen;
    const bool is_everywhere = !is_unsized && !LightAtTime(light, 0)->bounds() &&
                               dynamic_cast<const SunLight*>(light.light.get()) == nullptr;
    has_unsized_ |= is_unsized;
    has_sized_elsewhere_ |= !is_unsized && !is_everywhere;
    is_everywhere_.push_back(is_everywhere);
  }
  if (!surfaces_.tree().empty()) find_targets();
  if (glossy_.empty()) return;
  for (std::uint32_t l = 0; l < scene.lights().size(); ++l)
    if (is_delta(scene.lights()[l])) deltas_.push_back(l);
}

auto SmoothLight::after_single(const Before& before, const SurfaceHit& hit, const Vec3& wo,
                               const Vec3& wi) const -> Before {
  Before after = before;
  after.position = {}, after.pdf = 0;
  ++after.singles;
  const std::int32_t number = surfaces_.part_of(hit);
  if (number < 0) {
    after.met_unsolved = true;
    after.counted = false;
    return after;
  }
  const SmoothPart& part = parts_[static_cast<std::size_t>(number)];
  const bool passes = dot(hit.ng, wo) * dot(hit.ng, wi) < 0;
  const bool on_its_side = !part.is_sphere || dot(hit.position - part.middle, wo) > 0;
  // Of many surfaces, `sample` counts single ones only.
  const bool is_crowd = !surfaces_.tree().empty();
  after.met_unsolved |= (is_crowd && after.singles > 1) || (part.is_sphere && before.met_ball);
  after.counted = before.counted && (passes ? part.refracts : part.reflects && on_its_side) &&
                  !(part.is_sphere && before.met_ball) &&
                  after.singles <= (is_crowd ? 1 : kMostSteps);
  after.met_ball |= part.is_sphere;
  after.is_bent |= part.is_sphere || (passes && part.eta != 1);
  return after;
}

/// Whether light may continue from the last surface of `parent`, or from the vertex, to `part`.
/// `side`: the side of the part on which it arrives.
bool SmoothLight::may_follow(const Vertex& v, const Sequence& parent, const SmoothPart& part,
                             int& side) const {
  const SmoothPart* last = parent.steps.empty() ? nullptr : parent.steps.back().part;
  if (&part == last) return false;  // neither a plane nor a ball is met twice in a row
  if (last == nullptr) {
    // Light that arrives below the horizon does not count.
    if (v.scattering == nullptr || !v.scattering->transmits()) {
      SmoothPart horizon;
      horizon.n = dot(v.hit.ns, Vec3(v.wo)) < 0 ? -v.hit.ns : v.hit.ns;
      horizon.middle = v.hit.position;
      if (!(part.heights_over(horizon).second > 0)) return false;
    }
  } else if (!last->is_sphere) {
    const auto [low, high] = part.heights_over(*last);
    const double least = 1e-6 * (high - low);
    if ((parent.side > 0 && !(high > least)) || (parent.side < 0 && !(low < -least))) return false;
  }
  if (part.is_sphere) {
    // The path by two balls is not always found.
    for (const SmoothStep& step : parent.steps)
      if (step.part->is_sphere) return false;
    side = 1;
    return parent.is_bent || length(parent.image - part.middle) > part.radius_m;
  }
  if (!parent.is_bent) {
    const double height = part.height(parent.image);
    if (height == 0) return false;
    side = sign_of(height);
  }
  if (last == nullptr) return true;
  const auto [low, high] = last->heights_over(part);
  const double least = 1e-6 * (high - low);
  if (parent.is_bent) {
    side = high > least ? (low < -least ? 0 : 1) : -1;
    return high > least || low < -least;
  }
  return side > 0 ? high > least : low < -least;
}

void SmoothLight::add_next(const Vertex& v, const Sequence& parent, Nexts& to) const {
  if (parent.steps.size() >= std::min<std::size_t>(kMostSteps, v.most_steps)) return;
  for (const SmoothPart& part : parts_) add_next(v, parent, part, to);
}

void SmoothLight::add_next(const Vertex& v, const Sequence& parent, const SmoothPart& part,
                           Nexts& to) const {
  int side = 1;
  if (!may_follow(v, parent, part, side)) return;
  if (part.reflects) to.push_back({{&part, false}, side, std::max(part.reflected, 0.01)});
  if (part.refracts) to.push_back({{&part, true}, side, std::max(1 - part.reflected, 0.01)});
}

auto SmoothLight::extended(const Sequence& parent, const Next& next) -> Sequence {
  const SmoothPart& part = *next.step.part;
  Sequence child = parent;
  child.steps.push_back(next.step);
  child.share *= next.share;
  if (next.step.passes) {
    child.side = -next.side;
    child.is_bent = parent.is_bent || part.eta != 1;
    return child;
  }
  child.side = next.side;
  child.is_bent = parent.is_bent || part.is_sphere;
  if (!part.is_sphere) {
    child.image = mirror_image(part, parent.image);
    child.image_normal = mirror_vector(part, parent.image_normal);
  }
  return child;
}

void SmoothLight::sample(const Vertex& v, const PathSample& s, WorkCounts& work,
                         const AddLight& found) const {
  const bool finds_sized =
      samples_sizes_ && v.counts_sizes && (v.is_receiver || has_sized_elsewhere_);
  if (!has_steps_ || v.most_steps == 0 || !(finds_sized || has_unsized_)) return;
  Choices choices(s, v.depth);
  Sequence root;
  if (!v.is_receiver && tried_on_paths_ < 1) {
    if (choices.uniform() >= tried_on_paths_) return;
    root.weight = 1 / tried_on_paths_;
  }
  root.image = v.hit.position;
  // Without a normal, light arrives from both sides.
  if (v.scattering == nullptr || !v.scattering->transmits())
    root.image_normal = dot(v.hit.ns, Vec3(v.wo)) < 0 ? -v.hit.ns : v.hit.ns;
  if (!surfaces_.tree().empty()) return sample_crowd(v, root, choices, s, work, found);
  // Paths by balls and glass are solved, which takes as long as ten images.
  const std::size_t most = !v.is_receiver ? kMostFirstOnPaths : bends_ ? kMostBent : kMostVisited;
  Nexts nexts;
  add_next(v, root, nexts);
  Sequences open = first_sequences(v, root, nexts, most, choices);
  for (std::size_t i = 0; i < open.size(); ++i) {
    const Sequence sequence = open[i];  // `open` may move
    visit(v, sequence, static_cast<std::uint32_t>(i), s, work, found);
    nexts.clear();
    add_next(v, sequence, nexts);
    extend(v, sequence, nexts, choices, open);
  }
}

auto SmoothLight::first_sequences(const Vertex& v, const Sequence& root, const Nexts& nexts,
                                  std::size_t most, Choices& choices) const -> Sequences {
  Sequences open;
  if (nexts.size() <= most) {
    for (const Next& next : nexts) open.push_back(extended(root, next));
    return open;
  }
  std::vector<double> sums;
  double sum = 0;
  for (const Next& next : nexts) {
    const SmoothPart& part = *next.step.part;
    const Vec3 away = part.middle - v.hit.position;
    const double size2 =
        part.is_sphere ? part.radius_m * part.radius_m : length(part.half_u) * length(part.half_v);
    sums.push_back(sum += next.share * size2 / (dot(away, away) + size2));
  }
  const double offset = choices.uniform(), count = static_cast<double>(most);
  for (std::size_t k = 0; k < most; ++k) {
    const double at = (static_cast<double>(k) + offset) / count * sum;
    const auto i = std::min<std::size_t>(
        static_cast<std::size_t>(std::ranges::upper_bound(sums, at) - sums.begin()),
        sums.size() - 1);
    open.push_back(extended(root, nexts[i]));
    open.back().weight *= sum / ((sums[i] - (i > 0 ? sums[i - 1] : 0)) * count);
  }
  return open;
}

void SmoothLight::extend(const Vertex& v, const Sequence& sequence, Nexts& nexts, Choices& choices,
                         Sequences& open) const {
  const bool all =
      v.is_receiver && sequence.weight == 1 && open.size() + nexts.size() <= kMostVisited;
  double rest = 0;
  for (Next& next : nexts) {
    if (all && sequence.share * next.share >= kLeastShare) {
      open.push_back(extended(sequence, next));
      next.share = 0;
    }
    rest += next.share;
  }
  if (!(rest > 0)) return;
  // A walk gets a fair chance to go on, because few long walks carry much light of many steps.
  const double survival = std::clamp(rest, 0.25, 0.75);
  double u = choices.uniform() / survival * rest;
  for (const Next& next : nexts) {
    if (u < next.share) {
      open.push_back(extended(sequence, next));
      open.back().weight = sequence.weight * rest / (next.share * survival);
      return;
    }
    u -= next.share;
  }
}

void SmoothLight::visit(const Vertex& v, const Sequence& sequence, std::uint32_t number,
                        const PathSample& s, WorkCounts& work, const AddLight& found,
                        Lights which) const {
  const auto counts = [&](std::uint32_t light) {
    if (which == Lights::kAll) return true;
    if (which != Lights::kUnsized) return has_target_[light] == (which == Lights::kWithPlace);
    return is_delta(scene_.lights()[light]) || scene_.lights()[light].is_unseen;
  };
  const auto lights = static_cast<std::uint32_t>(scene_.lights().size());
  // A pair for the point of each light, then two for a light that is chosen.
  const std::uint32_t first = kFirstPair + v.depth * kPairsOfVertex + kPairsOfVertex / 2 +
                              number % kMostVisited * (kFewLights + 2);
  if (v.each_light || lights <= (v.is_receiver ? kFewLights : kFewLightsOnPaths)) {
    for (std::uint32_t l = 0; l < lights; ++l) {
      if (!counts(l)) continue;
      const Vec2f u = s.pair(first + l);
      sample_light(v, sequence, l, 1, {u.x, u.y}, work, found);
    }
    return;
  }
  Receiver from(sequence.image);
  from.normal = sequence.image_normal;
  // The image of a bent sequence is not where its light comes from.
  const auto choice = scene_.lights().selector().choose(
      sequence.is_bent ? LightSelection::kPower : LightSelection::kBvh, from,
      choosing_value(s.pair(first + kFewLights)));
  if (!choice || !counts(choice->light)) return;
  const Vec2f u = s.pair(first + kFewLights + 1);
  sample_light(v, sequence, choice->light, choice->probability, {u.x, u.y}, work, found);
}

Rgb SmoothLight::scattered(const Vertex& v, const Vec3& wi) const {
  if (v.scattering != nullptr) return v.scattering->value(Vec3(v.wo), wi);
  return Rgb(reflected_share(v.hit, v.wo, wi));
}

void SmoothLight::sample_light(const Vertex& v, const Sequence& sequence, std::uint32_t light,
                               double probability, Vec2f u, WorkCounts& work,
                               const AddLight& found) const {
  const LightAtTime at(scene_.lights()[light], v.hit.time_s);
  // No direction finds delta lights and unseen ones.
  if (!at->is_delta() && !at.is_unseen() &&
      (!counts_at(v.counts_sizes, v.scattering, v.wo) || (is_everywhere_[light] && !v.is_receiver)))
    return;
  if (sequence.is_bent && is_portal(light)) return;
  const Vec2 point{u.x, u.y};
  const auto arriving =
      sequence.is_bent ? by_solving(v, sequence, *at, point) : by_images(v, sequence, *at, point);
  if (!arriving) return;
  const Rgb value = arriving->value * (sequence.weight / probability);
  if (value.is_black() || !is_finite(value)) return;
  const Rgb share = share_along(v, sequence, *arriving, light, work);
  work.cut_short += !share.is_black() && sequence.steps.size() == kMostSteps &&
                    v.most_steps > kMostSteps && sequence.share > kLongEnough;
  if (share.is_black())
    found(light, {{}, value * sequence.share});
  else
    found(light, {value * share, value * share});
}

/// By flat mirrors only: the light as the mirrored vertex sees it.
auto SmoothLight::by_images(const Vertex& v, const Sequence& sequence, const Light& light,
                            Vec2 u) const -> std::optional<Arriving> {
  Receiver from(sequence.image);
  from.normal = sequence.image_normal;
  Arriving a;
  a.end = light.sample_li(from, u);
  if (a.end.reason != NoLight::kNone) return std::nullopt;
  // From the light back to the vertex.
  Vec3 p = sequence.image, w = a.end.wi;
  double later = a.end.distance + on_mirror(*sequence.steps.back().part, a.end);
  a.path.end = w;
  for (std::size_t i = sequence.steps.size(); i-- > 0;) {
    const SmoothPart& part = *sequence.steps[i].part;
    const double t = -part.height(p) / dot(part.n, w);
    if (!(t > 0 && t < later) || !std::isfinite(t)) return std::nullopt;
    later = t;
    a.path.points[i] = p + w * t;
    if (!part.may_contain(a.path.points[i])) return std::nullopt;
    if (sequence.steps[i].passes) continue;
    p = mirror_image(part, p);
    w = mirror_vector(part, w);
  }
  a.path.start = w;
  const double pdf = a.end.delta ? 1 : a.end.pdf.per_sr;
  a.value = a.end.value * scattered(v, w) / pdf;
  return a;
}

/// By surfaces that bend light: a path is solved to a point of the light, by area.
auto SmoothLight::by_solving(const Vertex& v, const Sequence& sequence, const Light& light,
                             Vec2 u) const -> std::optional<Arriving> {
  Arriving a;
  LightSample& end = a.end;
  const auto bounds = light.bounds();
  double density = 1;
  if (light.is_delta() || !bounds) {
    end = light.sample_li(Receiver(sequence.image), u);
    if (bounds) end.point = bounds->lower * 0.5 + bounds->upper * 0.5;
    if (!light.is_delta() && end.reason != NoLight::kNone) return std::nullopt;
    if (!light.is_delta()) density = end.pdf.per_sr;
  } else {
    const EmissionSample on = light.sample_le(u, {0.5, 0.5}, scene_.sphere());
    end.point = on.origin, end.normal = on.normal, end.primitive = on.primitive;
    density = on.pdf_position.per_m2;
  }
  const bool is_far = light.is_delta() ? !std::isfinite(end.distance) : !bounds;
  if (!(density > 0) || (is_far && end.wi == Vec3{})) return std::nullopt;
  const auto path = is_far ? path_to_direction(v.hit.position, sequence.steps, end.wi)
                           : path_to_point(v.hit.position, sequence.steps, end.point);
  if (!path) return std::nullopt;
  for (std::size_t i = 0; i < sequence.steps.size(); ++i)
    if (!sequence.steps[i].part->is_sphere && !sequence.steps[i].part->may_contain(path->points[i]))
      return std::nullopt;
  a.path = *path;
  const Vec3& last = path->points[sequence.steps.size() - 1];
  end.wi = path->end;
  end.reason = NoLight::kNone;
  if (light.is_delta()) {
    // A receiver 1 m before a light without a size gets its intensity as illuminance.
    const LightSample there = light.sample_li(Receiver(is_far ? last : end.point - path->end), {});
    if (there.reason != NoLight::kNone) return std::nullopt;
    end.value = there.value;
  } else if (is_far) {
    end.value = light.le_escaped(last, path->end);
  } else {
    end.value = light.le({end.point, end.normal, end.primitive}, -path->end) *
                std::fabs(dot(end.normal, path->end));
  }
  if (!is_far) end.distance = length(end.point - last);
  a.value = end.value * scattered(v, path->start) * (path->spread / density);
  return a;
}

Rgb SmoothLight::share_along(const Vertex& v, const Sequence& sequence, const Arriving& arriving,
                             std::uint32_t light, WorkCounts& work) const {
  const bool passes_panes = visibility_.transmittance().blocking() == RayFilter::kOpaque;
  SurfaceHit at = v.hit;
  Rgb share(1);
  for (std::size_t i = 0; i < sequence.steps.size(); ++i) {
    const SmoothStep& step = sequence.steps[i];
    const auto number = static_cast<std::int32_t>(step.part - parts_.data());
    const Vec3f towards(normalized(arriving.path.points[i] - at.position));
    for (bool arrived = false; !arrived;) {
      Ray ray = spawn_ray(at, towards);
      ++work.indirect_rays;
      std::optional<SurfaceHit> next = scene_.closest_hit(ray);
      if (!next) return {};
      if (scene_.geometry().has_media()) {
        ray.t_max = next->t;
        share = share * scene_.geometry().through_media(ray);
      }
      arrived = surfaces_.part_of(*next) == number;
      if (!arrived && !(passes_panes && scene_.geometry().is_pane(*next))) return {};
      const bool passes = !arrived || step.passes;
      share = share * mean_single(scene_, *next, -Vec3(towards),
                                  passes ? Side::kTransmitted : Side::kReflected);
      if (share.is_black()) return {};
      at = *next;
    }
  }
  const LightSample& end = arriving.end;
  const bool is_behind = end.delta && std::isfinite(end.distance) &&
                         dot(at.ng, end.wi) * dot(at.ng, end.point - at.position) < 0;
  if (is_behind && !lies_in_plane(end.point, at)) return {};
  const Ray ray = shadow_ray(at, end, scene_.lights()[light].reach_m());
  return share * visibility_.visible(light, at.position, at.ng, ray, work);
}

}  // namespace lucerna
