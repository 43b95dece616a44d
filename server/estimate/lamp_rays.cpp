#include "server/estimate/lamp_rays.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "lights/sampling/sampling.h"
#include "server/estimate/path_sample.h"
#include "server/estimate/surface_scattering.h"
#include "server/scene/light_at_time.h"
#include "server/visibility/smooth_surfaces.h"

namespace lucerna {
namespace {

/// Rays are followed until so many were kept or tried.
constexpr std::size_t kMostKept = 8192, kMostTried = 32768;
constexpr int kMostSurfaces = 16;

/// The start of a ray from a light towards a sphere.  Nothing if no light leaves there.
std::optional<Ray> start_of(const Light& light, const Vec3& middle, double radius, Vec2 u, Vec2 v,
                            const Scene& scene) {
  const bool is_near = light.bounds().has_value();
  const EmissionSample e = is_near ? light.sample_le(u, {0.5, 0.5}, scene.sphere())
                                   : light.sample_le(u, v, SceneSphere{middle, radius});
  if (!is_near) {
    if (e.value.is_black()) return std::nullopt;
    return Ray{Vec3f(e.origin), Vec3f(e.direction)};
  }
  const Vec3 to = middle - e.origin;
  const double distance = length(to), sine = radius / distance;
  const Vec3 w = sine < 1 ? Frame::around(to / distance)
                                .world_from_local(sample_uniform_cone(
                                    v, sine * sine / (1 + std::sqrt(1 - sine * sine))))
                          : sample_uniform_sphere(v);
  if (!is_finite(w) || light.le({e.origin, e.normal, e.primitive}, w).is_black())
    return std::nullopt;
  // The ray must not meet the light's own surface.
  constexpr double kOff = 1e-5;
  return Ray{Vec3f(e.origin + w * (kOff * distance)), Vec3f(w)};
}

/// Follows a ray to where it leaves the last smooth surface.  Nothing if it meets none without
/// computed paths.
std::optional<LampRay> follow(const Scene& scene, const SmoothSurfaces& surfaces, Ray ray,
                              const PathSample& s) {
  LampRay last{};
  bool met_unsolved = false, met_ball = false;
  for (std::uint32_t k = 0; k < kMostSurfaces; ++k) {
    std::optional<SurfaceHit> hit = scene.closest_hit(ray);
    if (!hit || scene.geometry().plain_diffuse(hit->material) != nullptr) break;
    const SurfaceScattering scattering(scene, *hit);
    const auto on =
        scattering.sample(-Vec3(ray.direction),
                          {s.pair(PathSample::kFirstLobe + k).x,
                           {s.at(k, PathSample::kDirection).x, s.at(k, PathSample::kDirection).y}});
    if (!on || !(on->delta || on->pdf.per_sr > kNarrow)) break;
    if (on->weight.is_black() || !is_finite(on->weight)) return std::nullopt;
    const std::int32_t part = surfaces.part_of(*hit);
    const bool is_ball = part >= 0 && surfaces.parts()[static_cast<std::size_t>(part)].is_sphere;
    met_unsolved |= part == SmoothSurfaces::kNone || (is_ball && met_ball) ||
                    (k > 0 && !surfaces.tree().empty());
    met_ball |= is_ball;
    last = {Vec3f(hit->position), Vec3f(on->wi)};
    ray = spawn_ray(*hit, last.along);
  }
  if (!met_unsolved) return std::nullopt;
  return last;
}

class AttachedLampRays final : public AttachedPart {
 public:
  explicit AttachedLampRays(const Scene& scene) : scene_(scene) {}

  const LampRays& get() const {
    return part_.get([this] { return std::make_unique<const LampRays>(scene_); },
                     [](const LampRays& r) {
                       return fmt::format("{} rays of lamps by way of curved smooth surfaces",
                                          r.rays().size());
                     });
  }
  std::optional<ScenePart> report() const override { return part_.report(); }
  std::uint64_t bytes() const override { return part_.bytes(); }

 private:
  const Scene& scene_;
  LazyPart<LampRays> part_{"lamp rays"};
};

}  // namespace

LampRays::LampRays(const Scene& scene) {
  const SmoothSurfaces& surfaces = smooth_surfaces(scene);
  const std::span<const UnsolvedSurface> unsolved = surfaces.unsolved();
  std::vector<std::uint32_t> lights;
  for (std::uint32_t l = 0; l < scene.lights().size(); ++l)
    if (!is_delta(scene.lights()[l]) && !scene.lights()[l].is_unseen) lights.push_back(l);
  if (unsolved.empty() || lights.empty()) return;
  const auto chosen = [](float u, std::size_t n) {
    return std::min(static_cast<std::size_t>(u * static_cast<float>(n)), n - 1);
  };
  const SampleSequence sequence(Sampler::kIndependent, 0, 0, 0);
  for (std::uint32_t i = 0; i < kMostTried && rays_.size() < kMostKept; ++i) {
    const PathSample s{sequence, i};
    const Vec2f choice = s.pair(PathSample::kFilm);
    const Bounds& box = unsolved[chosen(choice.x, unsolved.size())].bounds_m;
    if (box.empty()) continue;
    const Vec3 middle = box.lower * 0.5 + box.upper * 0.5;
    const LightAtTime light(scene.lights()[lights[chosen(choice.y, lights.size())]], 0);
    const Vec2f u = s.at(0, PathSample::kLight), v = s.at(0, PathSample::kLightPoint);
    const auto start =
        start_of(*light, middle, length(box.upper - middle), {u.x, u.y}, {v.x, v.y}, scene);
    if (!start) continue;
    if (const auto ray = follow(scene, surfaces, *start, s)) rays_.push_back(*ray);
  }
}

std::span<const LampRay> lamp_rays(const Scene& scene) {
  if (scene.lights().empty() || smooth_surfaces(scene).unsolved().empty()) return {};
  return scene.attached<AttachedLampRays>().get().rays();
}

GuidedDirections::GuidedDirections(std::span<const LampRay> rays, const Vec3& receiver,
                                   const Vec3& n) {
  // The squared distances at which rays pass the receiver.
  std::vector<std::pair<float, const LampRay*>> passing;
  const Vec3f x(receiver), up(n);
  for (const LampRay& ray : rays) {
    const Vec3f to = x - ray.from;
    const float t = dot(to, ray.along);
    if (!(t > 0) || !(dot(to, up) < 0)) continue;
    const Vec3f off = to - ray.along * t;
    passing.emplace_back(dot(off, off), &ray);
  }
  const std::size_t n_cones = std::min(kCones, passing.size());
  std::ranges::nth_element(passing, passing.begin() + static_cast<std::ptrdiff_t>(n_cones), {},
                           &std::pair<float, const LampRay*>::first);
  std::vector<Vec3f> axes;
  for (std::size_t i = 0; i < n_cones; ++i) {
    const Vec3f to = passing[i].second->from - x;
    if (length(to) > 0) axes.push_back(normalized(to));
  }
  // Each cone reaches to the fourth neighbour of its axis; one holds all.
  constexpr std::size_t kNeighbour = 4;
  constexpr float kLeast2 = 1e-6F, kMost2 = 2;  // squared chords
  const auto add = [&](const Vec3f& axis, float chord2) {
    cones_.push_back({axis, std::clamp(chord2, kLeast2, kMost2) / 2});
  };
  Vec3f sum{};
  for (const Vec3f& axis : axes) {
    std::vector<float> chords2;
    for (const Vec3f& other : axes) chords2.push_back(dot(other - axis, other - axis));
    std::ranges::sort(chords2);
    add(axis, chords2[std::min(kNeighbour, chords2.size() - 1)]);
    sum += axis;
  }
  if (!(length(sum) > 0)) return;
  const Vec3f middle = normalized(sum);
  float widest2 = 0;
  for (const Vec3f& axis : axes) widest2 = std::max(widest2, dot(axis - middle, axis - middle));
  add(middle, widest2);
}

void GuidedDirections::add(const Vec3& axis, double angle_rad) {
  const double sine = std::sin(angle_rad / 2);
  cones_.push_back({Vec3f(axis), static_cast<float>(2 * sine * sine)});
}

Vec3f GuidedDirections::sample(Vec2f u) const {
  const float at = u.x * static_cast<float>(cones_.size());
  const std::size_t k = std::min(static_cast<std::size_t>(at), cones_.size() - 1);
  const Vec2f within{at - static_cast<float>(k), u.y};
  return Framef::around(cones_[k].axis)
      .world_from_local(sample_uniform_cone(within, cones_[k].one_minus_cos));
}

double GuidedDirections::pdf(const Vec3f& w) const {
  double sum = 0;
  for (const Cone& cone : cones_) {
    const Vec3f off = w - cone.axis;
    if (dot(off, off) <= 2 * cone.one_minus_cos)
      sum += uniform_cone_pdf(double{cone.one_minus_cos}).per_sr;
  }
  return cones_.empty() ? 0 : sum / static_cast<double>(cones_.size());
}

}  // namespace lucerna
