#include "server/estimate/missed_light.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "server/scene/light_at_time.h"

namespace lucerna {
namespace {

/// As many finds show how the others scatter.
constexpr std::uint64_t kEnough = 8;

/// Whether a part of a box is above the receiver's horizon.
bool reaches_above(const Bounds& box, const SurfaceHit& receiver) {
  if (box.empty()) return false;
  const Vec3& n = receiver.ns;
  const Vec3 highest{n.x > 0 ? box.upper.x : box.lower.x, n.y > 0 ? box.upper.y : box.lower.y,
                     n.z > 0 ? box.upper.z : box.lower.z};
  const double error = double{max_abs(receiver.position_error)} + 1e-6 * max_abs(highest);
  return dot(n, highest - receiver.position) > error;
}

/// The projected solid angle of a box is at most this [sr].
double most_projected_sr(const Bounds& box, const SurfaceHit& receiver) {
  const Vec3 middle = box.lower * 0.5 + box.upper * 0.5;
  const double radius = length(box.upper - middle), distance = length(middle - receiver.position);
  return distance > radius ? kPi * (radius / distance) * (radius / distance) : kPi;
}

/// The luminance that a light with a size has at most [cd/m2]; infinite if it is not known.
double most_luminance(const SceneLight& light) {
  const auto* surface = dynamic_cast<const AreaLight*>(light.light.get());
  if (surface == nullptr || !surface->shared_data().empty())
    return std::numeric_limits<double>::infinity();
  return luminance(surface->emission().radiance_cd_m2);
}

}  // namespace

std::vector<std::uint32_t> portal_lights(const Scene& scene) {
  std::vector<std::uint32_t> portals;
  for (std::uint32_t l = 0; l < scene.lights().size(); ++l)
    if (dynamic_cast<const PortalLight*>(scene.lights()[l].light.get()) != nullptr)
      portals.push_back(l);
  return portals;
}

MissedLightRule::MissedLightRule(const Scene& scene, std::optional<std::uint32_t> bounces)
    : scene_(scene), portals_(portal_lights(scene)), once_(bounces && *bounces == 1) {
  if (bounces.value_or(1) == 0 || scene.geometry().empty() || scene.lights().empty()) return;
  surfaces_ = &smooth_surfaces(scene);
  // A direction that leaves the scene meets all lights at infinity.
  double beyond_cd_m2 = 0;
  for (const SceneLight& light : scene.lights()) {
    if (is_delta(light) || light.is_unseen)
      has_deltas_ = true;
    else if (LightAtTime(light, 0)->bounds())
      most_cd_m2_ = std::fmax(most_cd_m2_, most_luminance(light));
    else
      beyond_cd_m2 += most_luminance(light);
  }
  most_cd_m2_ = std::fmax(most_cd_m2_, beyond_cd_m2);
}

bool MissedLightRule::is_outdoors(const SurfaceHit& receiver) const {
  const bool is_behind = std::ranges::any_of(portals_, [&](std::uint32_t l) {
    const LightAtTime portal(scene_.lights()[l], receiver.time_s);
    return portal->sample_li(receiver.position, {0.5, 0.5}).reason == NoLight::kBehind;
  });
  if (!is_behind || scene_.geometry().empty()) return is_behind;
  const Frame frame = Frame::around(normalized(receiver.ns));
  // Along the normal, and 60 degrees away from it.
  constexpr int kAround = 8;
  for (int i = 0; i <= kAround; ++i) {
    const double phi = 2 * kPi * i / kAround, sine = i == kAround ? 0 : std::sqrt(0.75);
    const Vec3 w = frame.s * (sine * std::cos(phi)) + frame.t * (sine * std::sin(phi)) +
                   frame.n * (i == kAround ? 1 : 0.5);
    if (!scene_.closest_hit(spawn_ray(receiver, Vec3f(w)))) return true;
  }
  return false;
}

MissedLight MissedLightRule::at(const SurfaceHit& receiver, const FoundLight& found,
                                const IntervalRule& rule) const {
  if (surfaces_ == nullptr) return {};
  if (found.cut_short > 0) return {MissedLight::Kind::kByWay, 0};
  using Kind = UnsolvedSurface::Kind;
  double projected_sr = 0;
  for (const UnsolvedSurface& s : surfaces_->unsolved())
    // After another reflection, light may come from surfaces below the horizon.
    if (!once_ || (s.kind != Kind::kCrowd && s.kind != Kind::kNearlySmoothChain &&
                   reaches_above(s.bounds_m, receiver)))
      projected_sr = std::fmin(kPi, projected_sr + most_projected_sr(s.bounds_m, receiver));
  if (projected_sr > 0 && (has_deltas_ || found.by_chance < kEnough)) {
    MissedLight missed{MissedLight::Kind::kByWay, 0};
    if (has_deltas_ || !std::isfinite(most_cd_m2_)) return missed;
    // A direction brings no more than this.  The few that found any are part of the scatter.
    const double sample_lx = kPi * most_cd_m2_;
    missed.bound_lx = rule.interval({.largest = sample_lx}).upper;
    if (once_) missed.bound_lx = std::fmin(missed.bound_lx, most_cd_m2_ * projected_sr);
    return missed;
  }
  if (found.reflected > 0 || !surfaces_->has_rough_surfaces()) return {};
  Bounds all = scene_.geometry().world_m();
  all.lower = all.lower - scene_.origin();
  all.upper = all.upper - scene_.origin();
  if (!reaches_above(all, receiver)) return {};
  return {MissedLight::Kind::kReflected, 0};
}

}  // namespace lucerna
