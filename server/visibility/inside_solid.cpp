#include "server/visibility/inside_solid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <optional>

#include "server/runtime/parallel.h"
#include "server/scene/light_at_time.h"

namespace lucerna {
namespace {

constexpr std::size_t kRays = 16;
constexpr std::size_t kLeastLeaving = 4;
// If none of this many rays leaves a shape, the point is outside of all shapes.
constexpr std::size_t kFirstRays = 8;
// A ray through more surfaces is not followed to its end.
constexpr int kMostCrossings = 64;
constexpr int kMostLights = 64;
// A place just before a surface, as a part of the way to it.
constexpr float kJustBefore = 0.999F;
constexpr std::size_t kPointsPerChunk = 8;
// How far before its surface a receiver looks for a solid, in errors of its position.  A thousandth
// of this is more than the rounding of a ray's start.
constexpr double kBeforeSurface = 4096;

/// Spread evenly over the sphere (a Fibonacci lattice), none along an axis; directions that follow
/// each other are far apart.
std::array<Vec3f, kRays> spread_directions() {
  std::array<Vec3f, kRays> directions;
  for (std::size_t i = 0; i < kRays; ++i) {
    const auto k = static_cast<double>(i * 7 % kRays);
    const double z = 1 - (2 * k + 1) / kRays;
    const double phi = 0.3 + k * std::numbers::pi * (3 - std::sqrt(5.0));
    const double r = std::sqrt(1 - z * z);
    directions[i] = Vec3f(Vec3{r * std::cos(phi), r * std::sin(phi), z});
  }
  return directions;
}

/// The surfaces that a ray crosses.
struct Crossings {
  struct OfShape {
    std::uint64_t shape;
    int leaving;         // crossings from back to front, minus those from front to back
    std::int32_t light;  // of the shape; -1: none
  };
  std::vector<OfShape> shapes;
  std::optional<SurfaceHit> first;

  int leaving(std::uint64_t shape) const {
    for (const OfShape& s : shapes)
      if (s.shape == shape) return s.leaving;
    return 0;
  }
};

/// The crossings of a ray; nothing if there are too many.
std::optional<Crossings> crossings(const Scene& scene, const Vec3& from, const Vec3f& direction,
                                   double time_s,
                                   float t_max = std::numeric_limits<float>::infinity()) {
  Crossings found;
  Ray ray{Vec3f(from), direction, 0, t_max, time_s};
  for (int i = 0; i < kMostCrossings; ++i) {
    const auto hit = scene.closest_hit(ray);
    if (!hit) return found;
    const int leaving = dot(hit->ng, Vec3(direction)) > 0 ? 1 : -1;
    const auto known =
        std::find_if(found.shapes.begin(), found.shapes.end(),
                     [&](const Crossings::OfShape& s) { return s.shape == hit->shape; });
    if (known != found.shapes.end()) {
      known->leaving += leaving;
    } else {
      found.shapes.push_back({hit->shape, leaving, hit->light});
    }
    if (!found.first) found.first = hit;
    // Continue behind the rounding of t, so that an edge of two triangles counts once.
    ray.t_min = next_up(hit->t * (1 + 4 * std::numeric_limits<float>::epsilon()));
    if (!(ray.t_min < ray.t_max)) return found;
  }
  return std::nullopt;
}

/// Whether the point lies in the plane of the hit, within the errors.
bool is_on(const SurfaceHit& hit, const Vec3& point, double error) {
  return std::fabs(dot(hit.ng, hit.position - point)) <= 2 * (error + max_abs(hit.position_error));
}

/// The rays from one point, and the shapes that they cross.
class Surroundings {
 public:
  Surroundings(const Scene& scene, const Vec3& from, double error, double time_s)
      : scene_(scene), from_(from), time_s_(time_s) {
    for (const Vec3f& direction : directions()) {
      auto along = crossings(scene, from_, direction, time_s);
      if (!along || (along->first && is_on(*along->first, from_, error))) return;
      along_.push_back(*std::move(along));
      if (along_.size() == kFirstRays && !leaves_any()) return;
    }
    complete_ = true;
  }

  bool are_solid() const {
    if (!complete_) return false;
    std::vector<std::uint64_t> seen;
    for (const Crossings& along : along_) {
      for (const Crossings::OfShape& s : along.shapes) {
        if (s.leaving < 1 || std::find(seen.begin(), seen.end(), s.shape) != seen.end()) continue;
        seen.push_back(s.shape);
        if (encloses(s.shape) && !holds_light(s.shape)) return true;
      }
    }
    return false;
  }

 private:
  static const std::array<Vec3f, kRays>& directions() {
    static const auto kDirections = spread_directions();
    return kDirections;
  }

  bool leaves_any() const {
    return std::any_of(along_.begin(), along_.end(), [](const Crossings& along) {
      return std::any_of(along.shapes.begin(), along.shapes.end(),
                         [](const Crossings::OfShape& s) { return s.leaving > 0; });
    });
  }

  bool encloses(std::uint64_t shape) const {
    std::vector<std::size_t> leaving, open;
    for (std::size_t i = 0; i < kRays; ++i) {
      const int n = along_[i].leaving(shape);
      if (n < 0) return false;
      (n > 0 ? leaving : open).push_back(i);
    }
    if (leaving.size() < kLeastLeaving) return false;
    return std::all_of(open.begin(), open.end(),
                       [&](std::size_t i) { return ends_inside(shape, i, leaving); });
  }

  /// Whether ray `i`, which did not meet the shape's own surface, is inside of the shape when it
  /// meets another surface.  Most of the rays that lead away from that place decide.
  bool ends_inside(std::uint64_t shape, std::size_t i,
                   const std::vector<std::size_t>& leaving) const {
    if (!along_[i].first) return false;
    const Vec3 end = from_ + Vec3(directions()[i]) * double{kJustBefore * along_[i].first->t};
    // Use only rays that lead away from the surface.  Others may meet it too, or one beside it.
    const Vec3 normal = along_[i].first->ng;
    const double side = dot(normal, Vec3(directions()[i]));
    std::size_t away = 0, inside = 0;
    for (const std::size_t k : leaving) {
      if (dot(normal, Vec3(directions()[k])) * side >= 0) continue;
      const auto along = crossings(scene_, end, directions()[k], time_s_);
      if (!along || along->leaving(shape) < 0) return false;
      ++away;
      if (along->leaving(shape) > 0) ++inside;
    }
    return away > 0 && 2 * inside > away;
  }

  bool holds_light(std::uint64_t shape) const {
    const SceneLights& lights = scene_.lights();
    int placed = 0;
    for (std::size_t l = 0; l < lights.size() && placed < kMostLights; ++l) {
      const auto bounds = LightAtTime(lights[l], time_s_)->bounds();
      if (!bounds) continue;
      ++placed;
      if (is_light_of(shape, static_cast<std::int32_t>(l))) continue;
      const Vec3 middle = (Vec3(bounds->lower) + Vec3(bounds->upper)) * 0.5;
      const auto along = crossings(scene_, from_, Vec3f(middle - from_), time_s_, kJustBefore);
      if (!along || along->leaving(shape) < 1) return true;
    }
    return false;
  }

  bool is_light_of(std::uint64_t shape, std::int32_t light) const {
    return std::any_of(along_.begin(), along_.end(), [&](const Crossings& along) {
      return std::any_of(along.shapes.begin(), along.shapes.end(),
                         [&](const auto& s) { return s.shape == shape && s.light == light; });
    });
  }

  const Scene& scene_;
  Vec3 from_;
  double time_s_;
  std::vector<Crossings> along_;
  bool complete_ = false;  // false: the point is on a surface, outside, or not decided
};

/// Whether all rays above a point end close to a box, at surfaces that send no light back: the box
/// and a rim around it, as of a panel in a housing, leave no opening.
bool is_enclosed(const Scene& scene, const Vec3& from, const Vec3& normal, const LightBounds& box,
                 double margin_m, double time_s) {
  constexpr int kDirections = 256;
  const Frame frame = Frame::around(normal);
  for (int i = 0; i < kDirections; ++i) {
    // More of them graze, because light enters at the sides.
    const double s = (i + 0.5) / kDirections, z = s * s, r = std::sqrt(1 - z * z);
    const double phi = i * std::numbers::pi * (3 - std::sqrt(5.0));
    const Vec3 w = frame.s * (r * std::cos(phi)) + frame.t * (r * std::sin(phi)) + frame.n * z;
    const auto hit = scene.closest_hit(
        Ray{Vec3f(from), Vec3f(w), 0, std::numeric_limits<float>::infinity(), time_s});
    if (!hit) return false;
    for (int axis = 0; axis < 3; ++axis)
      if (hit->position[axis] < box.lower[axis] - margin_m ||
          hit->position[axis] > box.upper[axis] + margin_m)
        return false;
    if (hit->light < 0) continue;
    const LightAtTime light(scene.lights()[static_cast<std::size_t>(hit->light)], time_s);
    if (!light->le(hit->on_light(), -w).is_black()) return false;
  }
  return true;
}

/// Whether the back of a lamp covers a point with this normal: a ray along the normal meets it
/// first, except for surfaces through the point itself.  `from`, `before`: just behind the point,
/// and just before it.
bool is_covered(const Scene& scene, const Vec3& point, const Vec3& from, const Vec3& before,
                const Vec3& normal, double error, double time_s) {
  // The largest gap, relative to the diagonal of the lamp's box.  More light enters wider ones,
  // unless a rim closes them.
  constexpr double kGap = 1.0 / 16, kClosedGap = 1.0 / 4;
  Ray ray{Vec3f(from), Vec3f(normal), 0, std::numeric_limits<float>::infinity(), time_s};
  for (int i = 0; i < kMostCrossings; ++i) {
    const auto hit = scene.closest_hit(ray);
    if (!hit) return false;
    if (hit->light >= 0 && dot(hit->ng, normal) > 0) {
      const LightAtTime light(scene.lights()[static_cast<std::size_t>(hit->light)], time_s);
      const auto bounds = light->bounds();
      const double gap = dot(hit->position - point, normal);
      if (!bounds || !light->le(hit->on_light(), -normal).is_black()) return false;
      const double diagonal = length(bounds->upper - bounds->lower);
      return gap <= kGap * diagonal ||
             (gap <= kClosedGap * diagonal &&
              is_enclosed(scene, before, normal, *bounds, 1.1 * gap, time_s));
    }
    if (!is_on(*hit, point, error)) return false;
    ray.t_min = next_up(hit->t);
  }
  return false;
}

}  // namespace

bool is_inside_solid(const Scene& scene, const SurfaceHit& receiver) {
  if (scene.geometry().empty()) return false;
  const Vec3& point = receiver.position;
  const double time_s = receiver.time_s, error = max_abs(receiver.position_error);
  // A ray from a point on a surface may miss that surface.  One that begins before it does not.
  const double rounding = max_abs(point) * std::numeric_limits<float>::epsilon();
  const Vec3 normal = normalized(receiver.ns);
  const double distance = kBeforeSurface * std::max(error, rounding);
  const Vec3 before = point + normal * distance;
  const auto surface = scene.closest_hit(
      Ray{Vec3f(before), Vec3f(-normal), 0, static_cast<float>(2 * distance), time_s});
  const bool is_on_surface = surface && is_on(*surface, point, error + rounding);
  if (is_covered(scene, point, point - normal * distance, before, normal, error + rounding, time_s))
    return true;
  return Surroundings(scene, is_on_surface ? before : point, error, time_s).are_solid();
}

std::vector<std::uint8_t> inside_solids(const Scene& scene, std::span<const SurfaceHit> receivers,
                                        const std::stop_token& stop) {
  std::vector<std::uint8_t> inside(receivers.size());
  parallel_chunks(receivers.size(), kPointsPerChunk, stop, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      inside[i] = is_inside_solid(scene, receivers[i]) ? 1 : 0;
  });
  return inside;
}

}  // namespace lucerna
