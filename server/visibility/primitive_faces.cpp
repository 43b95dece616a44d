#include "server/visibility/primitive_faces.h"

#include <array>
#include <cmath>

#include "lights/maths/stop_poll.h"

namespace lucerna {
namespace {

Vec3 vertex(const GeometrySet& set, std::uint32_t triangle, int i) {
  if (const LargeTriangle* wide = set.large.empty() ? nullptr : set.large_triangle(triangle))
    return wide->corners[i];
  return Vec3(set.vertices[set.triangles[3 * std::size_t{triangle} + i]]) * set.unit_m;
}

}  // namespace

std::optional<FacePlane> whole_sphere(const Sphere& sphere, const GeometryInstance* placed,
                                      SmoothPart part) {
  const auto& p = sphere.params();
  if (p.z_min_m > -p.radius_m || p.z_max_m < p.radius_m || p.phi_max_rad < 2 * kPi)
    return std::nullopt;
  const RoundEnclosure e = sphere.enclosure();
  std::array<Vec3, 3> axes{e.x, e.y, e.z};
  part.middle = e.center;
  if (placed) {
    part.middle = placed->scene_from_object.point(e.center);
    for (Vec3& a : axes) a = placed->scene_from_object.vector(a);
  }
  part.is_sphere = true;
  part.radius_m = length(axes[0]);
  for (int i = 0; i < 3; ++i) {
    const double across = std::fabs(dot(axes[i], axes[(i + 1) % 3]));
    if (std::fabs(length(axes[i]) - part.radius_m) > 1e-6 * part.radius_m ||
        across > 1e-6 * part.radius_m * part.radius_m)
      return std::nullopt;
  }
  return FacePlane(part);
}

Face face_of(const GeometrySet& set, HitKind kind, std::uint32_t i) {
  if (kind == HitKind::kTriangle) return {vertex(set, i, 0), vertex(set, i, 1), vertex(set, i, 2)};
  if (kind == HitKind::kPatch) {
    // Files with seven digits bend flat faces by their rounding.
    constexpr double kNearlyFlat = 3e-5;  // of the face's size
    const BilinearPatch& p = set.patches[i];
    const Vec3 across = p.p11 - p.p00, n = face_normal(set, kind, i);
    if (!(std::fabs(dot(p.p10 - p.p00, n)) <= kNearlyFlat * length(across))) return {};
    return {p.p00, p.p10, p.p11, p.p01};
  }
  if (kind != kHitKind<Disk>) return {};
  const RoundEnclosure e = set.of<Disk>()[i].enclosure();
  return {e.center - e.x - e.y, e.center + e.x - e.y, e.center + e.x + e.y, e.center - e.x + e.y};
}

Vec3 face_normal(const GeometrySet& set, HitKind kind, std::uint32_t i) {
  if (kind == kHitKind<Disk>) return set.of<Disk>()[i].normals().axis;
  if (kind == HitKind::kPatch) {
    const BilinearPatch& p = set.patches[i];
    return normalized(cross(p.p11 - p.p00, p.p01 - p.p10));  // of the diagonals
  }
  const Vec3 a = vertex(set, i, 0);
  return normalized(cross(vertex(set, i, 1) - a, vertex(set, i, 2) - a));
}

bool has_other_normals(const GeometrySet& set, const SurfaceTable& table, HitKind kind,
                       std::uint32_t i) {
  if (kind == HitKind::kPatch)
    return i < table.patch_normals.size() && table.patch_normals[i][0] != Vec3f{};
  if (kind != HitKind::kTriangle || table.vertex_normals.empty()) return false;
  const Vec3 n = face_normal(set, kind, i);
  for (int k = 0; k < 3; ++k) {
    const std::uint32_t v = set.triangles[3 * std::size_t{i} + k];
    if (v >= table.vertex_normals.size()) continue;
    const Vec3 ns(table.vertex_normals[v]);
    constexpr double kSame = 1e-5;  // of unit normals in floats
    if (ns != Vec3{} && !(length(cross(n, normalized(ns))) < kSame)) return true;
  }
  return false;
}

void add_bounds(const GeometrySet& set, const GeometryInstance* placed, const PrimitiveRange& run,
                Bounds& to) {
  Bounds own;
  StopPoll poll;
  for (std::uint32_t i = run.first; i < run.first + run.count; ++i, poll()) {
    if (run.kind == HitKind::kTriangle) {
      for (int k = 0; k < 3; ++k) own.add(vertex(set, i, k));
    } else {
      set.visit_surface(run.kind, i, [&](const auto& surface) {
        const auto [lower, upper] = surface.bounds();
        own.add(Vec3(lower)), own.add(Vec3(upper));
      });
    }
  }
  if (own.empty()) return;
  for (int corner = 0; corner < 8; ++corner) {
    Vec3 p{corner & 1 ? own.upper.x : own.lower.x, corner & 2 ? own.upper.y : own.lower.y,
           corner & 4 ? own.upper.z : own.lower.z};
    if (placed) p = placed->scene_from_object.point(p);
    to.add(p);
  }
}

}  // namespace lucerna
