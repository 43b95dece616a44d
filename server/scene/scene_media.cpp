// What panes and media leave of light along a ray.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "server/scene/scene_builder.h"

namespace lucerna {
namespace {

/// A ray through a pile of panes or interfaces passes at most this many.
constexpr int kMostPassed = 1024;

}  // namespace

void Scene::Builder::simplify_media() {
  const auto kept = [&](std::int32_t medium) {
    return medium >= 0 && in_.media[static_cast<std::size_t>(medium)].absorption_per_m.is_black()
               ? -1
               : medium;
  };
  const auto simplify = [&](std::vector<ShapeDescription>& shapes) {
    for (ShapeDescription& s : shapes) {
      if (!s.media) continue;
      s.media = MediumSides{kept(s.media->inside), kept(s.media->outside)};
      if (s.media->inside == s.media->outside) s.media.reset();
    }
    std::erase_if(shapes, [](const auto& s) { return s.is_interface && !s.media; });
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
  return std::ranges::all_of(media_, [](const Medium& m) {
    const Rgb<double>& a = m.absorption_per_m;
    return a.r == a.g && a.g == a.b;
  });
}

const Surface& Scene::surface_of(const SurfaceHit& hit) const {
  const auto instance = static_cast<std::int32_t>(hit.shape >> 32) - 1;
  const SurfaceTable& table =
      instance >= 0 ? object_surfaces_[accelerator_->instance(instance).object] : surfaces_;
  return table.surfaces[static_cast<std::uint32_t>(hit.shape)];
}

double Scene::alpha_of(const Surface& surface, const SurfaceHit& hit) const {
  if (surface.alpha.is_constant()) return surface.alpha.constant;
  return textures_(surface.alpha, shading_point(hit).texture);
}

double Scene::through_panes(Ray ray) const {
  double share = 1;
  for (int i = 0; i < kMostPassed && has_panes_; ++i) {
    const auto hit = closest_hit(ray, Meets::kPanes);
    if (!hit) break;
    const double cosine = std::fabs(dot(hit->ng, normalized(Vec3<double>(ray.direction))));
    const TexturePoint at = shading_point(*hit).texture;
    share *= pane_transmittance(*surface_of(*hit).pane_eta, textures_, at, std::fmin(cosine, 1));
    ray.t_min = std::nextafter(hit->t, INFINITY);
    if (!(ray.t_min < ray.t_max)) break;
  }
  return share;
}

Rgb<double> Scene::through_media(const Ray& ray) const {
  if (!has_media()) return Rgb<double>(1);
  const Vec3<double> origin(ray.origin), direction(ray.direction);
  const double metres_per_t = length(direction);
  // The t of a hit in double, since layers may be thinner than floats can tell along the ray.
  const auto t_of = [&](const SurfaceHit& hit) {
    return dot(hit.position - origin, direction) / metres_per_t / metres_per_t;
  };
  // The medium from which a ray in this direction meets the surface, and the one beyond it.
  const auto sides = [&](const SurfaceHit& hit, const Vec3<float>& direction) {
    const MediumSides& media = *surface_of(hit).media;
    return dot(hit.ng, Vec3<double>(direction)) < 0 ? std::pair{media.outside, media.inside}
                                                    : std::pair{media.inside, media.outside};
  };
  Rgb<double> depth;
  const auto add = [&](std::int32_t medium, double t_from, double t_to) {
    if (medium < 0 || !(t_from < t_to)) return;
    const Rgb<double>& absorption = media_[static_cast<std::size_t>(medium)].absorption_per_m;
    // Without absorption, nothing is lost on an endless way either.
    const auto lost = [&](double per_m) {
      return per_m > 0 ? per_m * ((t_to - t_from) * metres_per_t) : 0;
    };
    depth += Rgb<double>(lost(absorption.r), lost(absorption.g), lost(absorption.b));
  };
  Ray rest = ray;
  rest.t_max = INFINITY;  // what lies beyond the end tells the medium before it
  std::int32_t medium = surrounding_medium_;
  bool is_known = false;
  double from = ray.t_min;
  for (int i = 0; i < kMostPassed && from < ray.t_max; ++i) {
    const auto hit = closest_hit(rest, Meets::kBoundaries);
    if (!hit) break;
    const auto [before, beyond] = sides(*hit, ray.direction);
    const double t = t_of(*hit);
    add(before, from, std::fmin(t, double{ray.t_max}));
    from = t;
    medium = beyond;
    is_known = true;
    rest.t_min = std::nextafter(hit->t, INFINITY);
  }
  if (!is_known) {
    Ray back{ray.origin, -ray.direction, 0, INFINITY, ray.time_s};
    if (const auto hit = closest_hit(back, Meets::kBoundaries))
      medium = sides(*hit, back.direction).first;
  }
  add(medium, from, ray.t_max);
  return {std::exp(-depth.r), std::exp(-depth.g), std::exp(-depth.b)};
}

}  // namespace lucerna
