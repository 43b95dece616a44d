// SmoothLight: light by way of planes that are nearly mirrors.  Directions of surfaces meet the
// small spot where such a plane shines by chance only.  For delta lights, points are drawn about
// the point of the mirror image.  For lights with a size, directions are drawn about the image.
// The balance heuristic weights each with the directions of surfaces.  [Veach95]
#include <algorithm>
#include <cmath>

#include "server/estimate/smooth_light.h"

namespace lucerna {
namespace {

/// With at most this many pairs of a plane and a light, a receiver visits each.
constexpr std::size_t kFewPairs = 16;
/// Pairs of random numbers, apart from those of smooth_light.cpp.
constexpr std::uint32_t kFirstGlossyPair = 5U << 29;
constexpr std::uint32_t kGlossyPairsOfVertex = 64;

}  // namespace

/// The part of a plane that mirrors a light towards a point.
struct SmoothLight::GlossySpot {
  Vec3 middle;         ///< where a mirror would show the light
  Vec3 along, across;  ///< in the plane, unit: along the plane of incidence, and across it
  double per_along, per_across;  ///< slope of the facets that mirror, over the distance [1/m]
  double alpha;

  /// GGX of slopes: alpha^2 / (pi (alpha^2 + slope^2)^2).
  Vec3 point(const Vec2f& u) const {
    const double r = alpha * std::sqrt(double{u.x} / (1 - double{u.x})), turn = 2 * kPi * u.y;
    return middle + along * (r * std::cos(turn) / per_along) +
           across * (r * std::sin(turn) / per_across);
  }
  /// Density of `point` [1/m2].
  double pdf(const Vec3& p) const {
    const double a = dot(p - middle, along) * per_along, b = dot(p - middle, across) * per_across;
    const double q = alpha * alpha + a * a + b * b;
    return alpha * alpha / (kPi * q * q) * per_along * per_across;
  }
};

auto SmoothLight::glossy_spot(const SmoothPart& part, const Vec3& from, std::uint32_t light,
                              double time_s) const -> std::optional<GlossySpot> {
  const LightAtTime at(scene_.lights()[light], time_s);
  const double height = part.height(from);
  if (height == 0) return std::nullopt;
  // The light as the mirrored point sees it.
  const Vec3 image = mirror_image(part, from);
  Vec3 w;
  double distance = std::numeric_limits<double>::infinity();
  if (const auto bounds = at->bounds()) {
    const Vec3 away = bounds->lower * 0.5 + bounds->upper * 0.5 - image;
    distance = length(away);
    w = away / distance;
  } else {
    w = at->sample_li(Receiver(image), {}).wi;
  }
  const double towards = dot(part.n, w), t = height / towards;
  if (!(t > 0 && t < distance)) return std::nullopt;
  // To the point, and to the light.
  const double curvature = 1 / t + 1 / (distance - t), cosine = std::fabs(towards);
  GlossySpot spot{.middle = image + w * t, .alpha = part.glossy_alpha};
  const Vec3 in_plane = w - part.n * towards;
  spot.along = length(in_plane) > 1e-6 ? normalized(in_plane) : Frame::around(part.n).s;
  spot.across = cross(part.n, spot.along);
  spot.per_along = curvature * cosine / 2;
  spot.per_across = curvature / (2 * cosine);
  if (!std::isfinite(spot.per_across) || !(spot.per_along > 0)) return std::nullopt;
  return spot;
}

void SmoothLight::guide(const SurfaceHit& receiver, GuidedDirections& to) const {
  if (glossy_.size() * scene_.lights().size() > SmoothSurfaces::kMostGuidedPairs) return;
  for (const std::uint32_t g : glossy_) {
    const SmoothPart& part = parts_[g];
    for (const SceneLight& light : scene_.lights()) {
      if (is_delta(light) || light.is_unseen) continue;
      const auto place = target_of(light);
      if (!place) continue;
      const Vec3 image = place->is_direction
                             ? mirror_vector(part, place->middle)
                             : mirror_image(part, place->middle) - receiver.position;
      const Vec3 axis = normalized(image);
      const double t = -part.height(receiver.position) / dot(part.n, axis);
      if (!(t > 0) || !(dot(receiver.ns, axis) > 0)) continue;
      const double sine = place->radius / length(image);
      // Most facets turn light by less than this.
      const double angle = std::asin(std::fmin(sine, 1)) + 4 * part.glossy_alpha;
      SmoothPart reached = part;
      const double more = 1 + t * std::tan(std::fmin(angle, 1)) /
                                  std::fmin(length(part.half_u), length(part.half_v));
      reached.half_u = part.half_u * more, reached.half_v = part.half_v * more;
      if (reached.may_contain(receiver.position + axis * t)) to.add(axis, angle);
    }
  }
}

double SmoothLight::glossy_choice(bool is_receiver) const {
  const std::size_t pairs = glossy_.size() * deltas_.size();
  const double tried = is_receiver ? 1 : tried_on_paths_;
  return is_receiver && pairs <= kFewPairs ? 1 : tried / static_cast<double>(pairs);
}

double SmoothLight::glossy_weight(const Before& before, const SurfaceHit& hit,
                                  std::uint32_t light) const {
  if (deltas_.empty() || !(before.pdf > 0) || !is_delta(scene_.lights()[light])) return 1;
  const std::int32_t number = surfaces_.part_of(hit);
  if (number < 0) return 1;
  const SmoothPart& part = parts_[static_cast<std::size_t>(number)];
  if (!(part.glossy_alpha > 0)) return 1;
  const auto spot = glossy_spot(part, before.position, light, hit.time_s);
  if (!spot) return 1;
  const Vec3 away = hit.position - before.position;
  const double distance2 = dot(away, away);
  const double by_direction =
      before.pdf * std::fabs(dot(hit.ng, away)) / (distance2 * std::sqrt(distance2));
  return by_direction /
         (by_direction + glossy_choice(before.is_receiver) * spot->pdf(hit.position));
}

void SmoothLight::sample_glossy(const Vertex& v, const PathSample& s, WorkCounts& work,
                                const AddLight& found) const {
  if (deltas_.empty() || v.most_steps == 0) return;
  const std::size_t pairs = glossy_.size() * deltas_.size();
  const double probability = glossy_choice(v.is_receiver);
  const std::uint32_t first = kFirstGlossyPair + v.depth * kGlossyPairsOfVertex;
  const auto visit = [&](std::size_t pair, const Vec2f& u) {
    const std::uint32_t number = glossy_[pair / deltas_.size()];
    const std::uint32_t light = deltas_[pair % deltas_.size()];
    const SmoothPart& part = parts_[number];
    const auto spot = glossy_spot(part, v.hit.position, light, v.hit.time_s);
    if (!spot) return;
    const Vec3 p = spot->point(u);
    const double density = probability * spot->pdf(p);
    if (!(density > 0) || !part.may_contain(p)) return;
    const Vec3 away = p - v.hit.position;
    const double distance = length(away);
    const Vec3 w = away / distance;
    const Rgb f = scattered(v, w);
    if (f.is_black()) return;
    const Ray ray = spawn_ray(v.hit, Vec3f(w));
    ++work.indirect_rays;
    auto hit = scene_.closest_hit(ray, visibility_.transmittance().met());
    if (!hit || surfaces_.part_of(*hit) != static_cast<std::int32_t>(number)) return;
    const SurfaceScattering scattering(scene_, *hit);
    const LightAtTime at(scene_.lights()[light], v.hit.time_s);
    const LightSample sample = at->sample_li(Receiver(hit->position), {});
    if (sample.reason != NoLight::kNone) return;
    const double per_area = std::fabs(dot(part.n, w)) / (distance * distance);
    const double direction_pdf = v.scattering != nullptr
                                     ? v.scattering->pdf(Vec3(v.wo), w)
                                     : std::fabs(dot(v.hit.ns, w)) * std::numbers::inv_pi;
    const Rgb value = f * scattering.value(-w, sample.wi) * sample.value *
                      (per_area / (density + direction_pdf * per_area));
    if (value.is_black() || !is_finite(value)) return;
    Rgb share(1);
    if (scene_.geometry().has_media()) {
      Ray way = ray;
      way.t_max = hit->t;
      share = scene_.geometry().through_media(way);
    }
    const Ray last = shadow_ray(*hit, sample, scene_.lights()[light].reach_m());
    share = share * visibility_.visible(light, hit->position, hit->ng, last, work);
    found(light, {value * share, value});
  };
  if (probability == 1) {
    for (std::size_t pair = 0; pair < pairs; ++pair)
      visit(pair, s.pair(first + static_cast<std::uint32_t>(pair)));
    return;
  }
  const auto chosen = static_cast<std::size_t>(choosing_value(s.pair(first)) / probability);
  if (chosen < pairs) visit(chosen, s.pair(first + 1));
}

}  // namespace lucerna
