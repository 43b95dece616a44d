#include "server/visibility/specular_path.h"

#include <cmath>

namespace lucerna {
namespace {

/// A ray with its derivatives by two parameters of its start.
struct Differential {
  Vec3 p, w;
  std::array<Vec3, 2> dp{}, dw{};

  /// Moves it to where its distance is `t`, on a surface with the unit normal `n`.
  void transfer(double t, const Vec3& n) {
    const double towards = dot(n, w);
    p += w * t;
    for (int k = 0; k < 2; ++k) {
      const Vec3 moved = dp[k] + dw[k] * t;
      dp[k] = moved - w * (dot(n, moved) / towards);
    }
  }
};

/// Meets the whole plane, before or behind the ray, or the outside of the sphere.  Returns the
/// normal there, or nothing.  `is_ahead` becomes false if the plane is behind.
std::optional<Vec3> meet(const SmoothPart& part, Differential& ray, bool& is_ahead) {
  if (!part.is_sphere) {
    const double t = -part.height(ray.p) / dot(part.n, ray.w);
    if (!std::isfinite(t)) return std::nullopt;
    is_ahead = is_ahead && t > 0;
    ray.transfer(t, part.n);
    return part.n;
  }
  const Vec3 from = ray.p - part.middle;
  const double b = dot(from, ray.w);
  // Of the closest point, without the cancellation of b^2 - c.
  const Vec3 nearest = from - ray.w * b;
  const double root2 = (part.radius_m - length(nearest)) * (part.radius_m + length(nearest));
  if (!(root2 > 0)) return std::nullopt;
  const double t = -b - std::sqrt(root2);
  if (!(t > 0)) return std::nullopt;
  const Vec3 n = (from + ray.w * t) / part.radius_m;
  ray.transfer(t, n);
  return n;
}

/// Sends the ray on.  Returns false where light is totally reflected and must pass.
bool send_on(const SmoothStep& step, const Vec3& n, Differential& ray) {
  const double towards = dot(ray.w, n);
  std::array<Vec3, 2> dn{};
  if (step.part->is_sphere)
    for (int k = 0; k < 2; ++k) dn[k] = ray.dp[k] / step.part->radius_m;
  const auto d_towards = [&](int k) { return dot(ray.dw[k], n) + dot(ray.w, dn[k]); };
  if (!step.passes) {
    for (int k = 0; k < 2; ++k)
      ray.dw[k] = ray.dw[k] - n * (2 * d_towards(k)) - dn[k] * (2 * towards);
    ray.w = ray.w - n * (2 * towards);
    return true;
  }
  if (step.part->eta == 1) return true;
  // The index of this side over that of the other one.
  const double ratio = towards < 0 ? 1 / step.part->eta : step.part->eta;
  const double cos2 = 1 - ratio * ratio * (1 - towards * towards);
  if (!(cos2 > 0)) return false;
  const double beyond = std::copysign(std::sqrt(cos2), towards), turn = beyond - ratio * towards;
  for (int k = 0; k < 2; ++k) {
    const double d_turn = (ratio * ratio * towards / beyond - ratio) * d_towards(k);
    ray.dw[k] = ray.dw[k] * ratio + n * d_turn + dn[k] * turn;
  }
  ray.w = ray.w * ratio + n * turn;
  return true;
}

struct Traced {
  Differential end;
  std::array<Vec3, kMostSteps> points;
  bool is_ahead = true;  ///< whether each surface is ahead of the one before
};

std::optional<Traced> trace(const Vec3& from, const Vec3& start,
                            std::span<const SmoothStep> steps) {
  Traced t;
  const Frame frame = Frame::around(start);
  t.end = {from, start, {}, {frame.s, frame.t}};
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const std::optional<Vec3> n = meet(*steps[i].part, t.end, t.is_ahead);
    if (!n) return std::nullopt;
    t.points[i] = t.end.p;
    if (!send_on(steps[i], *n, t.end)) return std::nullopt;
  }
  return t;
}

/// How far a traced ray is from its target, in two coordinates, and their derivatives.
struct Miss {
  double a, b;
  double aa, ab, ba, bb;  // d(a, b) / d(parameters)
  double size;            // of the distance that counts as 1
  bool is_ahead;          // whether the target is ahead of the last surface
};

double squared(const Miss& m) { return m.a * m.a + m.b * m.b; }

/// Newton's method from `start`.  `miss(traced)`: nothing if the ray cannot reach the target.
template <typename F>
std::optional<SpecularPath> solve(const Vec3& from, Vec3 start, std::span<const SmoothStep> steps,
                                  const F& miss) {
  constexpr int kMostIterations = 16, kMostHalvings = 6;
  constexpr double kClose = 1e-12;
  std::optional<Traced> traced = trace(from, start, steps);
  // Beyond the angle of total reflection, the way is steeper than the first direction.
  for (int k = 0; !traced && k < 8 && !steps[0].part->is_sphere; ++k) {
    const Vec3& n = steps[0].part->n;
    start = normalized(start + n * std::copysign(0.5, dot(start, n)));
    traced = trace(from, start, steps);
  }
  if (!traced) return std::nullopt;
  std::optional<Miss> m = miss(*traced);
  for (int i = 0; m && i < kMostIterations; ++i) {
    const double det = m->aa * m->bb - m->ab * m->ba;
    if (!(std::fabs(det) > 0)) return std::nullopt;
    const auto found = [&]() -> std::optional<SpecularPath> {
      if (!traced->is_ahead || !m->is_ahead) return std::nullopt;
      return SpecularPath{traced->points, start, traced->end.w, 1 / std::fabs(det)};
    };
    if (squared(*m) <= kClose * kClose * m->size * m->size) return found();
    const double x = -(m->bb * m->a - m->ab * m->b) / det, y = -(m->aa * m->b - m->ba * m->a) / det;
    const Frame frame = Frame::around(start);
    // Halves the step while it does not lead closer.
    double share = 1;
    bool moved = false;
    for (int half = 0; half < kMostHalvings && !moved; ++half, share /= 2) {
      const Vec3 next = normalized(start + (frame.s * x + frame.t * y) * share);
      const std::optional<Traced> there = trace(from, next, steps);
      if (!there) continue;
      const std::optional<Miss> then = miss(*there);
      if (!then || !(squared(*then) < squared(*m))) continue;
      start = next, traced = there, m = then, moved = true;
    }
    if (!moved) {
      // Rounding allows no less.
      constexpr double kRounded = 1e-9;
      if (!(squared(*m) <= kRounded * kRounded * m->size * m->size)) return std::nullopt;
      return found();
    }
  }
  return std::nullopt;
}

/// The first direction to try: that of a path that passes refracting planes straight on.
Vec3 first_direction(const Vec3& from, std::span<const SmoothStep> steps, Vec3 target,
                     bool is_direction) {
  for (std::size_t i = steps.size(); i-- > 0;) {
    const SmoothPart& part = *steps[i].part;
    if (part.is_sphere) {
      // Its point whose normal halves the angle between both ends.
      Vec3 before = from;
      for (std::size_t k = 0; k < i; ++k)
        if (!steps[k].passes && !steps[k].part->is_sphere)
          before = mirror_image(*steps[k].part, before);
      const Vec3 onwards = is_direction ? target : normalized(target - part.middle);
      const Vec3 half = normalized(before - part.middle) + onwards;
      target = part.middle + normalized(half) * part.radius_m;
      is_direction = false;
    } else if (!steps[i].passes) {
      target = is_direction ? mirror_vector(part, target) : mirror_image(part, target);
    }
  }
  return is_direction ? target : normalized(target - from);
}

}  // namespace

std::optional<SpecularPath> path_to_point(const Vec3& from, std::span<const SmoothStep> steps,
                                          const Vec3& to) {
  return solve(from, first_direction(from, steps, to, false), steps,
               [&](const Traced& traced) -> std::optional<Miss> {
                 Differential ray = traced.end;
                 const double t = dot(to - ray.p, ray.w);
                 ray.transfer(t, ray.w);
                 const Frame across = Frame::around(ray.w);
                 const Vec3 off = ray.p - to;
                 return Miss{dot(off, across.s),       dot(off, across.t),
                             dot(ray.dp[0], across.s), dot(ray.dp[1], across.s),
                             dot(ray.dp[0], across.t), dot(ray.dp[1], across.t),
                             length(to - from),        t > 0};
               });
}

std::optional<SpecularPath> path_to_direction(const Vec3& from, std::span<const SmoothStep> steps,
                                              const Vec3& w) {
  return solve(from, first_direction(from, steps, w, true), steps,
               [&](const Traced& traced) -> std::optional<Miss> {
                 const Differential& ray = traced.end;
                 if (!(dot(ray.w, w) > 0)) return std::nullopt;
                 const Frame across = Frame::around(w);
                 return Miss{dot(ray.w, across.s),
                             dot(ray.w, across.t),
                             dot(ray.dw[0], across.s),
                             dot(ray.dw[1], across.s),
                             dot(ray.dw[0], across.t),
                             dot(ray.dw[1], across.t),
                             1,
                             true};
               });
}

}  // namespace lucerna
