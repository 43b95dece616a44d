// What panes and media leave of light along a ray.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "lights/maths/stop_poll.h"
#include "server/scene/scene_builder.h"

namespace lucerna {

void Scene::Builder::simplify_media() {
  const auto kept = [&](std::int32_t medium) {
    return medium >= 0 && in_.media[static_cast<std::size_t>(medium)].absorption_per_m.is_black()
               ? -1
               : medium;
  };
  const auto simplify = [&](ShapeList& shapes) {
    StopPoll poll;
    for (ShapeDescription& s : shapes) {
      poll();
      if (!s.media) continue;
      s.media = MediumSides{kept(s.media->inside), kept(s.media->outside)};
      if (s.media->inside == s.media->outside) s.media.reset();
    }
    const auto bounds_nothing = [](const auto& s) { return s.is_interface && !s.media; };
    shapes.erase(std::remove_if(shapes.begin(), shapes.end(), bounds_nothing), shapes.end());
    return std::ranges::any_of(shapes, [](const auto& s) { return s.media.has_value(); });
  };
  bool has_media = simplify(in_.shapes);
  for (ObjectDefinition& o : in_.objects) has_media = simplify(o.shapes) || has_media;
  scene_->surrounding_medium_ = kept(in_.surrounding_medium);
  if (!has_media && scene_->surrounding_medium_ < 0) return;
  scene_->media_ = std::move(in_.media);
  part("media", scene_->media_.capacity() * sizeof(Medium), Stopwatch(),
       fmt::format("{} media that absorb light", scene_->media_.size()));
}

bool Scene::media_are_grey() const {
  return std::ranges::all_of(base_->media_, [](const Medium& m) {
    const Rgb& a = m.absorption_per_m;
    return a.r == a.g && a.g == a.b;
  });
}

const Surface& Scene::surface_of(const SurfaceHit& hit) const {
  const auto instance = static_cast<std::int32_t>(hit.shape >> 32) - 1;
  const SurfaceTable& table =
      instance >= 0 ? base_->object_surfaces_[placed_->accelerator->instance(instance).object]
                    : placed_->surfaces;
  return table.surfaces[static_cast<std::uint32_t>(hit.shape)];
}

double Scene::alpha_of(const Surface& surface, const SurfaceHit& hit) const {
  if (surface.alpha.is_constant()) return surface.alpha.constant;
  return base_->textures_(surface.alpha, shading_point(hit).texture);
}

std::vector<Scene::Crossing> Scene::crossings(const Ray& ray, Meets meets) const {
  const Vec3 origin(ray.origin), direction(ray.direction);
  const double metres_per_t = length(direction);
  std::vector<Crossing> all;
  for (const RawHit& raw : placed_->accelerator->all_hits(ray, meets)) {
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

double Scene::through_panes(const Ray& ray) const {
  double share = 1;
  if (!base_->has_panes_) return share;
  for (const Crossing& c : crossings(ray, Meets::kPanes))
    share *= through_pane(c.hit, ray.direction);
  return share;
}

double Scene::through_pane(const SurfaceHit& hit, const Vec3f& direction) const {
  const Surface& surface = surface_of(hit);
  const double met = surface.is_sheet() ? surface.alpha.constant : 1;
  if (!surface.pane_eta) return 1 - met;
  const double cosine = std::fabs(dot(hit.ng, normalized(Vec3(direction))));
  return 1 - met +
         met * pane_transmittance(*surface.pane_eta, base_->textures_, shading_point(hit).texture,
                                  std::fmin(cosine, 1));
}

Rgb Scene::through_media(const Ray& ray) const {
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
    const Rgb& absorption = base_->media_[static_cast<std::size_t>(medium)].absorption_per_m;
    // Without absorption, nothing is lost on an endless way either.
    const auto lost = [&](double per_m) {
      return per_m > 0 ? per_m * ((t_to - t_from) * metres_per_t) : 0;
    };
    depth += Rgb(lost(absorption.r), lost(absorption.g), lost(absorption.b));
  };
  Ray line = ray;
  line.t_max = INFINITY;  // what lies beyond the end tells the medium before it
  std::vector<Crossing> all = crossings(line, Meets::kBoundaries);
  std::int32_t medium = base_->surrounding_medium_;
  if (all.empty()) {
    const Ray back{ray.origin, -ray.direction, 0, INFINITY, ray.time_s};
    const std::vector<Crossing> behind = crossings(back, Meets::kBoundaries);
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
