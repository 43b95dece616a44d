// Computes a surface point, with all data for shading, from a hit of Embree.  Embree returns
// floats; the point is computed again in double from the ray and the primitive.
#include <algorithm>
#include <cmath>
#include <limits>

#include "server/rays/error_bounds.h"
#include "server/scene/scene_geometry.h"

namespace lucerna {
namespace {

Vec3 absolute(const Vec3& v) { return {std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)}; }

Vec3 largest(const Vec3& a, const Vec3& b) {
  return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
}

/// A point in the space of its GeometrySet.
struct LocalHit {
  Vec3 position, ng, ns;  // ns zero: the same as ng
  // Errors in finding the surface by rays, without the rounding of `position`.
  double error = 0;         // of each coordinate
  double normal_error = 0;  // along ng
  double plane_error = 0;   // of a triangle: of `position` within the plane
};

LocalHit triangle_hit(const GeometrySet& set, const SurfaceTable& table, const RawHit& raw) {
  const std::uint32_t* v = &set.triangles[3 * std::size_t{raw.primitive}];
  const LargeTriangle* large = set.large.empty() ? nullptr : set.large_triangle(raw.primitive);
  const auto vertex = [&](int i) {
    return large != nullptr ? large->corners[i] : Vec3(set.vertices[v[i]]) * set.unit_m;
  };
  const Vec3 a = vertex(0), b = vertex(1), c = vertex(2);
  const Vec3 ab = b - a, ac = c - a, bc = c - b;
  const double u1 = raw.uv.x, u2 = raw.uv.y;
  LocalHit hit;
  const Vec3 from_a = ab * u1 + ac * u2;
  hit.position = a + from_a;
  const Vec3 n = cross(ab, ac);
  const double n2 = dot(n, n), n_length = std::sqrt(n2);
  hit.ng = is_safe_square(n2) ? n / n_length : normalized(n);
  // Embree takes the cross product of two edges, the shorter ones if terms would cancel.
  // In a needle, the error of n is that of their product.  Above a factor of 16, floats do not
  // define the plane of the triangle anyway.
  const double ab2 = dot(ab, ab), ac2 = dot(ac, ac), bc2 = dot(bc, bc);
  const double shorter2 = std::min({ab2 * ac2, ab2 * bc2, ac2 * bc2});
  double condition = 1;
  if (shorter2 > n2) condition = shorter2 < 256 * n2 ? std::sqrt(shorter2 / n2) : 16;
  // The largest distance of a vertex along each axis.
  const Vec3 reach =
      largest(largest(absolute(from_a), absolute(ab - from_a)), absolute(ac - from_a));
  hit.plane_error = kTraversalBound * condition * max_abs(reach);
  // The distance to the plane is the sum of n_k (v - o)_k.  Each n_k is a difference of products of
  // two edges, at most 2 (2 reach_i) (2 reach_j), and has their rounding.  So a triangle in a plane
  // of the axes has no error.
  const double along = 24 * kTraversalBound * (reach.x * reach.y * reach.z) / n_length;
  const Vec3 across = absolute(hit.ng);
  // Rays meet large triangles in double.
  const double to_double = large != nullptr ? 0x1p-53 / kFloatRoundoff : 1;
  // A triangle without area has no `along`.
  const double isotropic = hit.plane_error * (across.x + across.y + across.z);
  hit.normal_error = to_double * (along < isotropic ? along : isotropic);
  if (!table.vertex_normals.empty()) {
    const auto& normals = table.vertex_normals;
    hit.ns =
        Vec3(normals[v[0]]) * (1 - u1 - u2) + Vec3(normals[v[1]]) * u1 + Vec3(normals[v[2]]) * u2;
  }
  return hit;
}

LocalHit analytic_hit(const GeometrySet& set, const SurfaceTable& table, const RawHit& raw,
                      const Ray& ray) {
  LocalHit hit{.position = raw.position, .ng = raw.normal, .ns = {}};
  // All in double precision; the rounding error grows with the length of the ray.
  hit.error =
      64 * 0x1p-53 *
      (max_abs(Vec3(ray.origin)) + raw.t * max_abs(Vec3(ray.direction)) + max_abs(raw.position));
  if (raw.kind == HitKind::kCurve) hit.error += set.curves[raw.primitive].hit_error_m(raw.uv.x);
  if (raw.kind == HitKind::kPatch && !table.patch_normals.empty()) {
    const auto& n = table.patch_normals[raw.primitive];
    const double u = raw.uv.x, v = raw.uv.y;
    hit.ns = Vec3(n[0]) * ((1 - u) * (1 - v)) + Vec3(n[1]) * (u * (1 - v)) +
             Vec3(n[2]) * ((1 - u) * v) + Vec3(n[3]) * (u * v);
  }
  return hit;
}

/// Converts the errors of a triangle to the scene's space.  `along`: the size there of a unit of
/// length along ng.  `most`: the largest size of any unit of length.
void scale_errors(LocalHit& hit, double along, double most) {
  hit.normal_error *= along;
  hit.plane_error *= most;
}

/// Converts the hit to the scene's space and returns the error of each coordinate.
Vec3 to_scene(const Transform& scene_from_object, LocalHit& hit) {
  const auto& m = scene_from_object.matrix();
  const Transform inverse = scene_from_object.inverse();
  const auto& w = inverse.matrix();
  const auto times = [](const Transform::Matrix& a, const Vec3& v, bool point) {
    std::array<double, 3> r{};
    for (int i = 0; i < 3; ++i)
      r[i] = std::fabs(a[i][0]) * v.x + std::fabs(a[i][1]) * v.y + std::fabs(a[i][2]) * v.z +
             (point ? std::fabs(a[i][3]) : 0);
    return Vec3{r[0], r[1], r[2]};
  };
  const Vec3 local = hit.position, local_ng = hit.ng;
  hit.position = scene_from_object.point(local);
  hit.ng = normalized(scene_from_object.normal(local_ng));
  const Vec3 sizes = times(m, {1, 1, 1}, false);
  scale_errors(hit, std::fabs(dot(hit.ng, scene_from_object.vector(local_ng))), max_abs(sizes));
  if (hit.ns != Vec3{}) hit.ns = scene_from_object.normal(hit.ns);
  // Embree converts rays to the object's space in floats, with an inverse that it computes in
  // floats.
  const Vec3 rounding = times(w, absolute(hit.position), true) * kTraversalBound;
  return times(m, rounding + Vec3{hit.error, hit.error, hit.error}, false);
}

/// The same for a moving instance.
Vec3 to_scene(const GeometryInstance& instance, double time_s, LocalHit& hit) {
  const Pose pose = instance.motion->at(time_s);
  const Transform& start_from_object = instance.scene_from_object;
  // Rays are converted to the object's space in double and rounded to floats there.
  const Vec3 at_start = start_from_object.point(hit.position);
  const Vec3 object_error =
      absolute(hit.position) * kTraversalBound + Vec3{hit.error, hit.error, hit.error};
  hit.position = pose.point(at_start);
  const Vec3 start_ng = normalized(start_from_object.normal(hit.ng));
  const double along = std::fabs(dot(start_ng, start_from_object.vector(hit.ng)));
  hit.ng = pose.vector(start_ng);
  if (hit.ns != Vec3{}) hit.ns = pose.vector(start_from_object.normal(hit.ns));
  const auto& m = start_from_object.matrix();
  const auto start_row = [&](int i) { return absolute({m[i][0], m[i][1], m[i][2]}); };
  const Vec3 start_error{dot(start_row(0), object_error), dot(start_row(1), object_error),
                         dot(start_row(2), object_error)};
  const Vec3 one{1, 1, 1};
  scale_errors(
      hit, along,
      max_abs(Vec3{dot(start_row(0), one), dot(start_row(1), one), dot(start_row(2), one)}));
  const double rounding =
      16 * 0x1p-53 * (max_abs(at_start) + max_abs(pose.shift_m) + max_abs(hit.position));
  return Vec3{dot(absolute(pose.r[0]), start_error), dot(absolute(pose.r[1]), start_error),
              dot(absolute(pose.r[2]), start_error)} +
         Vec3{rounding, rounding, rounding};
}

/// Moves the hit on a triangle to the point where the ray meets the plane, in double.  Embree's
/// barycentric coordinates are floats, which in a large triangle are far apart.  Far from the
/// triangle, a ray itself is less accurate than they are.
void meet_plane(const Ray& ray, LocalHit& hit) {
  const Vec3 origin(ray.origin), direction(ray.direction);
  const double towards = dot(hit.ng, direction);
  const double t = dot(hit.ng, hit.position - origin) / towards;
  const Vec3 meeting = origin + direction * t;
  const double error = 8 * 0x1p-53 * (max_abs(origin) + std::fabs(t) * max_abs(direction)) +
                       8 * 0x1p-53 * max_abs(hit.position);
  // A ray along the plane meets it nowhere near.
  const double moved = max_abs(meeting - hit.position) * towards;
  if (!(error < hit.plane_error) ||
      !(moved * moved <= 16 * hit.plane_error * hit.plane_error * dot(direction, direction)))
    return;
  hit.position = meeting;
  hit.normal_error += error;
}

}  // namespace

std::optional<SurfaceHit> SceneGeometry::closest_hit(const Ray& ray, RayFilter filter) const {
  const std::optional<RawHit> raw = accelerator().closest_hit(ray, filter);
  if (!raw) return std::nullopt;
  // Made in place, because a copy would wait for the bytes just stored.
  struct Made {
    const SceneGeometry& geometry;
    const RawHit& raw;
    const Ray& ray;
    operator SurfaceHit() const { return geometry.surface_hit(raw, ray); }  // NOLINT
  };
  return std::optional<SurfaceHit>(std::in_place, Made{*this, *raw, ray});
}

SurfaceHit SceneGeometry::surface_hit(const RawHit& raw, const Ray& ray) const {
  const auto& [instance, set, table] = primitives_of(raw.instance);
  LocalHit local = raw.kind == HitKind::kTriangle ? triangle_hit(set, table, raw)
                                                  : analytic_hit(set, table, raw, ray);
  Vec3 error{local.error, local.error, local.error};
  if (instance)
    error = instance->motion ? to_scene(*instance, ray.time_s, local)
                             : to_scene(instance->scene_from_object, local);

  if (raw.kind == HitKind::kTriangle) meet_plane(ray, local);

  SurfaceHit hit;
  hit.t = raw.t;
  hit.time_s = ray.time_s;
  hit.position = local.position;
  error += absolute(local.ng) * local.normal_error;
  // Adds the rounding of the position at the start of rays, and the rounding error of doubles.
  error += absolute(local.position) * (kFloatRoundoff * (1 + 1e-6));
  error += Vec3{kLeastError, kLeastError, kLeastError};
  // Rounded up, so that it stays a bound.
  hit.position_error = Vec3f(error * (1 + 1e-6));
  hit.ng = local.ng;
  hit.ns = local.ng;
  if (local.ns != Vec3{}) {
    const Vec3 ns = normalized(local.ns);
    if (ns != Vec3{}) hit.ns = dot(ns, local.ng) < 0 ? -ns : ns;
  }
  const PrimitiveRun& run = table.run(raw.kind, raw.primitive);
  const Surface& surface = table.surfaces[run.surface];
  hit.material = surface.material;
  hit.light = surface.light;
  // Instance -1 is the scene's own geometry.
  hit.shape = (static_cast<std::uint64_t>(raw.instance + 1) << 32) | run.surface;
  hit.kind = raw.kind;
  hit.primitive = raw.primitive;
  hit.uv = raw.uv;
  hit.light_primitive =
      run.first_light_primitive + (raw.primitive - run.first) / run.per_light_primitive;
  return hit;
}

}  // namespace lucerna
