#include "server/visibility/shadow_map.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <type_traits>

#include "lights/maths/stop_poll.h"
#include "server/rays/error_bounds.h"
#include "server/runtime/parallel.h"

namespace lucerna {
namespace {

/// Wider cones use a cube.  In a square around a cone of this angle, texels at the centre are 3
/// times as wide as those at the corners.
constexpr double kWidestCone = std::numbers::pi / 3;
/// A square is slightly wider than its cone, so that no light falls on its edge.
constexpr double kMargin = 1 + 0x1p-10;

/// The least distance of an obstacle in front of the surface that it shadows, in widths of a
/// texel there.  A texel has the depth at its centre, up to 0.71 widths away from the look-up.
/// The effect on a plane is computed exactly.  So this bias is only for edges between faces, and
/// for curves that rise by 55 degrees or less over this distance.
constexpr double kBiasTexels = 1;
/// The same without the surface's normal: the rise over one texel of a plane that the light
/// meets at 76 degrees from its normal.
constexpr double kBiasTexelsWithoutNormal = 4;

constexpr std::size_t kRaysPerChunk = 2048;

ShadowMapView::Face face_about(const Vec3& forward) {
  const auto frame = Frame::around(forward);
  return {frame.s, frame.t, forward};
}

}  // namespace

std::optional<ShadowMapView> shadow_map_view(const SceneLight& light, const SceneSphere& sphere) {
  if (light.moving != nullptr) return std::nullopt;
  ShadowMapView view{};
  if (const auto* distant = dynamic_cast<const DistantLight*>(light.light.get())) {
    if (!(sphere.radius_m > 0)) return std::nullopt;
    view.from = sphere.center_m;
    view.faces[0] = face_about(-normalized(distant->params().to_light));
    view.face_count = 1;
    view.half = sphere.radius_m * kMargin;
    view.is_distant = true;
    return view;
  }
  const auto bounds = light.light->bounds();
  if (!light.light->is_delta() || !bounds || bounds->lower != bounds->upper) return std::nullopt;
  view.from = bounds->lower;
  if (bounds->cone_rad <= kWidestCone) {
    view.faces[0] = face_about(bounds->axis);
    view.face_count = 1;
    view.half = std::tan(bounds->cone_rad) * kMargin;
    return view;
  }
  for (const Vec3& forward :
       {Vec3{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}})
    view.faces[view.face_count++] = face_about(forward);
  view.half = kMargin;
  return view;
}

ShadowMap::ShadowMap(const Scene& scene, const ShadowMapView& view, std::uint32_t side)
    : view_(view), side_(side) {
  rounding_m_ = 4 * kTraversalBound * (max_abs(view.from) + (view.is_distant ? view.half : 0));
  const std::size_t per_face = std::size_t{side} * side;
  depths_.resize(view.face_count * per_face);
  parallel_chunks(
      depths_.size(), kRaysPerChunk, StopScope::token(), [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
          const ShadowMapView::Face& f = view.faces[i / per_face];
          const std::size_t in_face = i % per_face;
          const auto centre = [&](std::size_t k) {
            return view.half * ((2 * static_cast<double>(k) + 1) / side - 1);
          };
          const Vec3 across = f.right * centre(in_face % side) + f.up * centre(in_face / side);
          Ray ray;
          if (view.is_distant) {
            ray.origin = Vec3f(view.from + across - f.forward * view.half);
            ray.direction = Vec3f(f.forward);
          } else {
            // The direction has a step of 1 along `forward`, so that t is the depth.
            ray.origin = Vec3f(view.from);
            ray.direction = Vec3f(f.forward + across);
          }
          const auto hit = scene.geometry().accelerator().closest_hit(ray);
          depths_[i] = hit ? hit->t : std::numeric_limits<float>::infinity();
        }
      });
  StopScope::check();  // else the map lacks chunks
}

std::optional<ShadowMap::Texel> ShadowMap::texel(std::uint32_t face, double x, double y) const {
  if (!(std::fabs(x) <= 1 && std::fabs(y) <= 1)) return std::nullopt;
  const auto number = [&](double c) {
    return std::min(static_cast<std::uint32_t>((c + 1) / 2 * side_), side_ - 1);
  };
  const auto centre = [&](std::uint32_t k) { return (2.0 * k + 1) / side_ - 1; };
  const std::uint32_t i = number(x), j = number(y);
  return Texel{(std::size_t{face} * side_ + j) * side_ + i, centre(i), centre(j)};
}

std::optional<bool> ShadowMap::is_occluded(const Vec3& position, const Vec3& normal) const {
  const Vec3 w = position - view_.from;
  const bool has_normal = normal != Vec3{};
  // `plane`: the depth at which the ray of the texel meets the plane of the surface.  The map has
  // this depth if the surface is a plane without obstacles.  If it is farther away than the
  // receiver, or the ray is parallel to the plane, obstacles in front of the receiver count.
  // [Isidoro06]
  const auto before = [&](double map, double depth, double plane, double texel_m) {
    const double texels = has_normal ? kBiasTexels : kBiasTexelsWithoutNormal;
    return map <
           std::fmin(plane, depth) - texels * texel_m - rounding_m_ - 4 * kTraversalBound * depth;
  };
  if (view_.is_distant) {
    const ShadowMapView::Face& f = view_.faces[0];
    const double x = dot(w, f.right), y = dot(w, f.up);
    const auto at = texel(0, x / view_.half, y / view_.half);
    if (!at) return std::nullopt;
    const double depth = dot(w, f.forward) + view_.half;
    const double rise = dot(normal, f.right) * (at->x * view_.half - x) +
                        dot(normal, f.up) * (at->y * view_.half - y);
    const double facing = dot(normal, f.forward);
    const double plane = facing != 0 ? depth - rise / facing : depth;
    return before(depths_[at->number], depth, plane, 2 * view_.half / side_);
  }
  std::uint32_t face = 0;
  double depth = dot(w, view_.faces[0].forward);
  for (std::uint32_t f = 1; f < view_.face_count; ++f) {
    const double along = dot(w, view_.faces[f].forward);
    if (along > depth) face = f, depth = along;
  }
  if (!(depth > 0)) return std::nullopt;
  const ShadowMapView::Face& f = view_.faces[face];
  const double scale = 1 / (depth * view_.half);
  const auto at = texel(face, dot(w, f.right) * scale, dot(w, f.up) * scale);
  if (!at) return std::nullopt;
  const Vec3 ray = f.forward + f.right * (at->x * view_.half) + f.up * (at->y * view_.half);
  const double facing = dot(normal, ray);
  // Below 0 if the ray of the texel does not meet the plane.
  const double plane = facing != 0 ? dot(normal, w) / facing : depth;
  return before(depths_[at->number], depth, plane > 0 ? plane : depth,
                2 * view_.half / side_ * depth);
}

}  // namespace lucerna
