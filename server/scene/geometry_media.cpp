// What panes and media leave of light along a ray.
#include <algorithm>
#include <cmath>
#include <utility>

#include "server/scene/scene_geometry.h"

namespace lucerna {

bool SceneGeometry::media_are_grey() const {
  return std::ranges::all_of(data_.fixed->media, [](const Medium& m) {
    const Rgb& a = m.absorption_per_m;
    return a.r == a.g && a.g == a.b;
  });
}

const Surface& SceneGeometry::surface_of(const SurfaceHit& hit) const {
  const auto instance = static_cast<std::int32_t>(hit.shape >> 32) - 1;
  return primitives_of(instance).table.surfaces[static_cast<std::uint32_t>(hit.shape)];
}

double SceneGeometry::alpha_of(const Surface& surface, const SurfaceHit& hit) const {
  if (surface.alpha.is_constant()) return surface.alpha.constant;
  return textures()(surface.alpha, shading_point(hit).texture);
}

std::vector<SceneGeometry::Crossing> SceneGeometry::crossings(const Ray& ray,
                                                              RayFilter filter) const {
  const Vec3 origin(ray.origin), direction(ray.direction);
  const double metres_per_t = length(direction);
  std::vector<Crossing> all;
  for (const RawHit& raw : accelerator().all_hits(ray, filter)) {
    Crossing c{.hit = surface_hit(raw, ray)};
    c.t = dot(c.hit.position - origin, direction) / metres_per_t / metres_per_t;
    c.error_t = max_abs(c.hit.position_error) / metres_per_t;
    c.is_front = dot(c.hit.ng, direction) < 0;
    all.push_back(c);
  }
  std::ranges::sort(all, {}, &Crossing::t);
  // A ray through an edge meets both triangles.
  const auto repeats = [](const Crossing& a, const Crossing& b) {
    return a.hit.shape == b.hit.shape && a.is_front == b.is_front && b.t - a.t <= a.error_t;
  };
  std::vector<Crossing> once;
  for (const Crossing& c : all) {
    bool is_new = true;
    for (std::size_t k = once.size(); is_new && k > 0 && c.t - once[k - 1].t <= c.error_t; --k)
      is_new = !repeats(once[k - 1], c);
    if (is_new) once.push_back(c);
  }
  return once;
}

double SceneGeometry::through_panes(const Ray& ray) const {
  double share = 1;
  if (!has_panes()) return share;
  for (const Crossing& c : crossings(ray, RayFilter::kPanes))
    share *= through_pane(c.hit, ray.direction);
  return share;
}

double SceneGeometry::through_pane(const SurfaceHit& hit, const Vec3f& direction) const {
  const Surface& surface = surface_of(hit);
  const double met = surface.is_sheet() ? surface.alpha.constant : 1;
  if (!surface.pane_eta) return 1 - met;
  const double cosine = std::fabs(dot(hit.ng, normalized(Vec3(direction))));
  return 1 - met +
         met * pane_transmittance(*surface.pane_eta, textures(), shading_point(hit).texture,
                                  std::fmin(cosine, 1));
}

Rgb SceneGeometry::through_media(const Ray& ray) const {
  if (!has_media()) return Rgb(1);
  const double metres_per_t = length(Vec3(ray.direction));
  // The medium from which a ray meets the surface, and the one beyond it.
  const auto sides = [&](const Crossing& c) {
    const MediumSides& media = *surface_of(c.hit).media;
    return c.is_front ? std::pair{media.outside, media.inside}
                      : std::pair{media.inside, media.outside};
  };
  Rgb depth;
  const auto add = [&](std::int32_t medium, double t_from, double t_to) {
    if (medium < 0 || !(t_from < t_to)) return;
    const Rgb& absorption = data_.fixed->media[static_cast<std::size_t>(medium)].absorption_per_m;
    // Without absorption, nothing is lost on an endless way either.
    const auto lost = [&](double per_m) {
      return per_m > 0 ? per_m * ((t_to - t_from) * metres_per_t) : 0;
    };
    depth += Rgb(lost(absorption.r), lost(absorption.g), lost(absorption.b));
  };
  Ray line = ray;
  line.t_max = INFINITY;  // what lies beyond the end tells the medium before it
  std::vector<Crossing> all = crossings(line, RayFilter::kBoundaries);
  std::int32_t medium = data_.fixed->surrounding_medium;
  if (all.empty()) {
    const Ray back{ray.origin, -ray.direction, 0, INFINITY, ray.time_s};
    const std::vector<Crossing> behind = crossings(back, RayFilter::kBoundaries);
    if (!behind.empty()) medium = sides(behind.front()).first;
  }
  double from = ray.t_min;
  for (std::size_t i = 0; i < all.size() && from < ray.t_max; ++i) {
    // Of surfaces in one place, the one comes first whose medium the ray is in.  At the ray's first
    // surfaces that is the one to whose medium no other of them leads.
    std::size_t end = i + 1;
    while (end < all.size() && all[end].t - all[i].t <= all[i].error_t) ++end;
    const auto comes_first = [&](std::size_t k) {
      if (i > 0) return sides(all[k]).first == medium;
      for (std::size_t other = i; other < end; ++other)
        if (other != k && sides(all[other]).second == sides(all[k]).first) return false;
      return true;
    };
    for (std::size_t k = i; k < end; ++k) {
      if (!comes_first(k)) continue;
      const auto at = [&](std::size_t n) { return all.begin() + static_cast<std::ptrdiff_t>(n); };
      std::rotate(at(i), at(k), at(k + 1));
      break;
    }
    const auto [before, beyond] = sides(all[i]);
    add(before, from, std::fmin(all[i].t, double{ray.t_max}));
    from = std::fmax(from, all[i].t);
    medium = beyond;
  }
  add(medium, from, ray.t_max);
  return {std::exp(-depth.r), std::exp(-depth.g), std::exp(-depth.b)};
}

}  // namespace lucerna
