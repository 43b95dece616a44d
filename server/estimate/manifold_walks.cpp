#include "server/estimate/manifold_walks.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lights/sampling/hash_number.h"
#include "server/estimate/surface_scattering.h"
#include "server/scene/light_at_time.h"

namespace lucerna {
namespace {

/// With more lights than this, each set of walks is for one of them.
constexpr std::size_t kMostLamps = 4;
/// Steps of Newton's method, and halvings of one step.
constexpr int kMostTurns = 20, kMostHalvings = 8;
/// The share of the angle of a surface by which the last step turns a path, without rounding.
constexpr double kLastTurn = 1e-4;

/// The single direction of a surface on a side.
std::optional<Vec3> single_direction(const SurfaceScattering& scattering, const SurfaceHit& hit,
                                     const Vec3& wo, bool passes) {
  for (const double choice : {0.0, 1 - 0x1p-24}) {
    const auto s = scattering.sample(wo, {choice, {0.5, 0.5}});
    if (s && s->delta && (dot(hit.ng, wo) * dot(hit.ng, s->wi) < 0) == passes) return s->wi;
  }
  return std::nullopt;
}

/// `start` after small turns about the two axes across it.
Vec3 turned(const Vec3& start, double a, double b) {
  const Frame around = Frame::around(start);
  return normalized(start + around.s * a + around.t * b);
}

}  // namespace

/// A lamp without a size, as a target of rays.
struct ManifoldWalks::Aim {
  bool is_far;
  Vec3 place;  ///< of the lamp, or the unit direction to it

  static Aim of(const Light& light) {
    if (const auto bounds = light.bounds())
      return {false, bounds->lower * 0.5 + bounds->upper * 0.5};
    return {true, light.sample_li(Receiver(Vec3{}), {}).wi};
  }
  Vec3 direction_from(const Vec3& p) const { return is_far ? place : normalized(place - p); }
};

/// Uniform numbers that depend on the sample only.
class ManifoldWalks::Numbers {
 public:
  explicit Numbers(const PathSample& s) {
    const Vec2f u = s.pair(PathSample::kWalks);
    state_ = hash_of({u.x, u.y});
  }
  double uniform() { return static_cast<double>(mix_bits(state_ += kGolden) >> 11) * 0x1p-53; }
  std::size_t below(std::size_t n) {
    return std::min(static_cast<std::size_t>(uniform() * static_cast<double>(n)), n - 1);
  }

 private:
  static constexpr std::uint64_t kGolden = 0x9E3779B97F4A7C15U;
  std::uint64_t state_;
};

ManifoldWalks::ManifoldWalks(const Scene& scene, const LightVisibility& visibility,
                             const SmoothLight& smooth)
    : scene_(scene),
      visibility_(visibility),
      smooth_(smooth),
      smooth_surfaces_(smooth_surfaces(scene)) {
  for (std::uint32_t l = 0; l < scene.lights().size(); ++l)
    if (is_delta(scene.lights()[l])) lights_.push_back(l);
  if (lights_.empty()) return;
  using Kind = UnsolvedSurface::Kind;
  for (const UnsolvedSurface& s : smooth_surfaces_.unsolved())
    if (s.kind == Kind::kSmooth || (s.kind == Kind::kCrowd && smooth_surfaces_.tree().empty()))
      if (!s.bounds_m.empty()) surfaces_.push_back(s.bounds_m);
}

void ManifoldWalks::sample(const SurfaceHit& receiver, std::uint32_t walks,
                           std::uint32_t most_steps, const PathSample& s, WorkCounts& work,
                           const AddIrradiance& found) const {
  Numbers numbers(s);
  const bool each = lights_.size() <= kMostLamps;
  const std::size_t chosen = each ? 0 : numbers.below(lights_.size());
  for (std::size_t i = chosen; i < (each ? lights_.size() : chosen + 1); ++i) {
    const std::uint32_t light = lights_[i];
    const auto is_same = [](const Path& a, const Path& b) {
      return a.links == b.links && length(a.start - b.start) < std::fmax(a.apart, b.apart);
    };
    absl::InlinedVector<Path, 4> paths;
    for (std::uint32_t k = 0; k < walks; ++k) {
      const auto path = walk(receiver, light, most_steps, numbers, work);
      if (path && std::ranges::none_of(paths, [&](const Path& p) { return is_same(p, *path); }))
        paths.push_back(*path);
    }
    Rgb sum;
    for (const Path& path : paths) {
      std::uint32_t sets = 0;
      for (bool is_found = false; !is_found && sets < kMostSets; ++sets)
        for (std::uint32_t k = 0; !is_found && k < walks; ++k) {
          const auto again = walk(receiver, light, most_steps, numbers, work);
          is_found = again && is_same(path, *again);
        }
      sum += path.lx * double(sets);
    }
    if (!sum.is_black()) found(light, each ? sum : sum * static_cast<double>(lights_.size()));
  }
}

std::optional<SurfaceHit> ManifoldWalks::next_surface(const SurfaceHit& from, const Vec3& along,
                                                      Rgb& share, WorkCounts& work) const {
  const bool passes_panes = visibility_.transmittance().blocking() == RayFilter::kOpaque;
  SurfaceHit at = from;
  for (;;) {
    Ray ray = spawn_ray(at, Vec3f(along));
    ++work.indirect_rays;
    std::optional<SurfaceHit> next = scene_.closest_hit(ray);
    if (!next) return std::nullopt;
    if (scene_.geometry().has_media()) {
      ray.t_max = next->t;
      share = share * scene_.geometry().through_media(ray);
    }
    if (!(passes_panes && scene_.geometry().is_pane(*next))) return next;
    share = share * SurfaceScattering(scene_, *next).single(-along, Side::kTransmitted);
    at = *next;
  }
}

auto ManifoldWalks::choose_links(const SurfaceHit& receiver, const Vec3& start,
                                 std::uint32_t most_steps, Numbers& numbers, WorkCounts& work) const
    -> Links {
  Links links;
  SurfaceHit at = receiver;
  Vec3 along = start;
  Rgb share(1);
  while (links.size() < most_steps) {
    std::optional<SurfaceHit> next = next_surface(at, along, share, work);
    if (!next || scene_.geometry().plain_diffuse(next->material) != nullptr) break;
    const SurfaceScattering scattering(scene_, *next);
    const double reflected = scattering.single(-along, Side::kReflected).max_component(),
                 passed = scattering.single(-along, Side::kTransmitted).max_component();
    if (!(reflected + passed > 0)) break;
    // Light may go on to the lamp although this ray meets another surface.
    constexpr double kEnds = 0.2;
    if (!links.empty() && numbers.uniform() < kEnds) break;
    const bool passes = numbers.uniform() * (reflected + passed) < passed;
    const auto wi = single_direction(scattering, *next, -along, passes);
    if (!wi) break;
    links.push_back({next->shape, passes});
    at = *next, along = *wi;
  }
  return links;
}

auto ManifoldWalks::follow(const SurfaceHit& receiver, const Vec3& start, const Links& links,
                           WorkCounts& work) const -> std::optional<End> {
  End end{.hit = receiver, .along = start};
  end.before.counted = end.before.is_receiver = true;
  for (const Link& link : links) {
    std::optional<SurfaceHit> next = next_surface(end.hit, end.along, end.share, work);
    if (!next || next->shape != link.shape) return std::nullopt;
    const SurfaceScattering scattering(scene_, *next);
    const auto wi = single_direction(scattering, *next, -end.along, link.passes);
    if (!wi) return std::nullopt;
    end.share = end.share *
                scattering.single(-end.along, link.passes ? Side::kTransmitted : Side::kReflected);
    end.met_curved |= smooth_surfaces_.part_of(*next) == SmoothSurfaces::kNone;
    end.before = smooth_.after_single(end.before, *next, -end.along, *wi);
    end.hit = *next, end.along = *wi;
  }
  return end;
}

auto ManifoldWalks::newton_step(const SurfaceHit& receiver, const Path& path, const Aim& aim,
                                const End& end, double h, WorkCounts& work) const
    -> std::optional<Step> {
  // The last leg has to have the direction `wanted`.
  const Vec3 wanted = aim.direction_from(end.hit.position);
  const Frame across = Frame::around(wanted);
  const auto off = [&](const End& e) {
    const Vec3 d = e.along - aim.direction_from(e.hit.position);
    return Vec2{dot(d, across.s), dot(d, across.t)};
  };
  Vec2 columns[2];
  for (int k = 0; k < 2; ++k) {
    const double a = k == 0 ? h : 0, b = h - a;
    const auto more = follow(receiver, turned(path.start, a, b), path.links, work),
               less = follow(receiver, turned(path.start, -a, -b), path.links, work);
    if (!more || !less) return std::nullopt;
    const Vec2 p = off(*more), m = off(*less);
    columns[k] = {(p.x - m.x) / (2 * h), (p.y - m.y) / (2 * h)};
  }
  const Vec2 f = off(end);
  const double determinant = columns[0].x * columns[1].y - columns[1].x * columns[0].y;
  const double distance = aim.is_far ? 1 : length(aim.place - end.hit.position);
  return Step{.a = (columns[1].x * f.y - columns[1].y * f.x) / determinant,
              .b = (columns[0].y * f.x - columns[0].x * f.y) / determinant,
              .spread = 1 / (std::fabs(determinant) * distance * distance)};
}

auto ManifoldWalks::closer(const SurfaceHit& receiver, Path& path, const Aim& aim, const End& end,
                           Step step, WorkCounts& work) const -> std::optional<End> {
  const double before = length(end.along - aim.direction_from(end.hit.position));
  for (int half = 0; half < kMostHalvings; ++half, step.a /= 2, step.b /= 2) {
    const Vec3 start = turned(path.start, step.a, step.b);
    std::optional<End> next = follow(receiver, start, path.links, work);
    if (!next || !(length(next->along - aim.direction_from(next->hit.position)) < before)) continue;
    path.start = start;
    return next;
  }
  return std::nullopt;
}

auto ManifoldWalks::solve(const SurfaceHit& receiver, const Aim& aim, double size, Path& path,
                          WorkCounts& work) const -> std::optional<Solution> {
  // Rays start at floats.  So their ends are off by about this share of the surface.
  const double blur = kFloatRoundoff / size;
  const double last_turn = (kLastTurn + 10 * blur) * size;
  path.apart = 10 * last_turn;
  // The square of the step is about its error by rounding.
  const double h = std::cbrt(blur) * size;
  std::optional<End> end = follow(receiver, path.start, path.links, work);
  for (int turn = 0; end && turn < kMostTurns; ++turn) {
    std::optional<Step> step = newton_step(receiver, path, aim, *end, h, work);
    const double angle = step ? std::hypot(step->a, step->b) : 0;
    if (!step || !std::isfinite(angle)) return std::nullopt;
    if (angle < last_turn) {
      if (!(dot(end->along, aim.direction_from(end->hit.position)) > 0)) return std::nullopt;
      path.start = turned(path.start, step->a, step->b);
      end = follow(receiver, path.start, path.links, work);
      if (!end) return std::nullopt;
      return Solution{*end, step->spread};
    }
    if (angle > size / 8) step->a *= size / 8 / angle, step->b *= size / 8 / angle;
    end = closer(receiver, path, aim, *end, *step, work);
  }
  return std::nullopt;
}

auto ManifoldWalks::walk(const SurfaceHit& receiver, std::uint32_t light, std::uint32_t most_steps,
                         Numbers& numbers, WorkCounts& work) const -> std::optional<Path> {
  // Points of the box show a flat one, such as water, as well as a ball.
  const Bounds& box = surfaces_[numbers.below(surfaces_.size())];
  const Vec3 extent = box.upper - box.lower;
  const Vec3 within{extent.x * numbers.uniform(), extent.y * numbers.uniform(),
                    extent.z * numbers.uniform()};
  const Vec3 to = box.lower + within - receiver.position;
  Path path;
  path.start = normalized(to);
  if (!is_finite(path.start) || !(dot(receiver.ns, path.start) > 0)) return std::nullopt;
  path.links = choose_links(receiver, path.start, most_steps, numbers, work);
  if (path.links.empty()) return std::nullopt;

  const LightAtTime at(scene_.lights()[light], receiver.time_s);
  const Aim aim = Aim::of(*at);
  const auto solved =
      solve(receiver, aim, std::fmin(1, length(extent) / 2 / length(to)), path, work);
  if (!solved) return std::nullopt;
  const End& end = solved->end;
  // SmoothLight counts paths by way of parts alone.
  if (!end.met_curved && (!smooth_surfaces_.tree().empty() || smooth_.counts(end.before, light)))
    return std::nullopt;
  const double cosine = dot(receiver.ns, path.start);
  if (!(cosine > 0)) return std::nullopt;
  // A receiver 1 m before a light without a size gets its intensity as illuminance.
  const Vec3 last = end.hit.position, along = aim.direction_from(last);
  LightSample sample = at->sample_li(Receiver(aim.is_far ? last : aim.place - along), {});
  if (sample.reason != NoLight::kNone) return std::nullopt;
  sample.wi = along, sample.point = aim.place;
  sample.distance = aim.is_far ? std::numeric_limits<double>::infinity() : length(aim.place - last);
  path.lx = sample.value * end.share * (cosine * solved->spread);
  const Ray ray = shadow_ray(end.hit, sample, scene_.lights()[light].reach_m());
  path.lx = path.lx * visibility_.visible(light, last, end.hit.ng, ray, work);
  if (path.lx.is_black() || !is_finite(path.lx)) return std::nullopt;
  return path;
}

}  // namespace lucerna
