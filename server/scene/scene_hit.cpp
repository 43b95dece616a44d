// Computes a surface point, with all data for shading, from a hit of Embree.  Embree returns
// floats; the point is computed again in double from the primitive.
#include <algorithm>
#include <cmath>
#include <limits>

#include "server/rays/error_bounds.h"
#include "server/scene/scene.h"

namespace lucerna {
namespace {

using Vector = Vec3<double>;

Vector absolute(const Vector& v) { return {std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)}; }

/// A point in the space of its GeometrySet.
struct LocalHit {
  Vector position, ng, ns;  // ns zero: the same as ng
  double error = 0;  // error in finding the surface by rays, without the rounding of `position`
};

LocalHit triangle_hit(const GeometrySet& set, const SurfaceTable& table, const RawHit& raw) {
  const std::uint32_t* v = &set.triangles[3 * std::size_t{raw.primitive}];
  const auto vertex = [&](int i) { return Vector(set.vertices[v[i]]) * set.unit_m; };
  const Vector a = vertex(0), b = vertex(1), c = vertex(2);
  const Vector ab = b - a, ac = c - a, bc = c - b;
  const double u1 = raw.uv.x, u2 = raw.uv.y;
  LocalHit hit;
  const Vector from_a = ab * u1 + ac * u2;
  hit.position = a + from_a;
  const Vector n = cross(ab, ac);
  hit.ng = normalized(n);
  // Embree takes the cross product of two edges, the shorter ones if terms would cancel.
  // In a needle, the error of n is that of their product.  Above a factor of 16, floats do not
  // define the plane of the triangle anyway.
  const double ab2 = dot(ab, ab), ac2 = dot(ac, ac), bc2 = dot(bc, bc);
  const double longest2 = std::max({ab2, ac2, bc2});
  const double others2 = longest2 > 0 ? ab2 * (ac2 / longest2) * bc2 : 0;
  const double n2 = dot(n, n);
  const double condition = others2 < 256 * n2 ? std::sqrt(others2 / n2) : 16;
  const double reach = std::max({max_abs(from_a), max_abs(ab - from_a), max_abs(ac - from_a)});
  hit.error = kTraversalBound * std::max(1.0, condition) * reach;
  if (!table.vertex_normals.empty()) {
    const auto& normals = table.vertex_normals;
    hit.ns = Vector(normals[v[0]]) * (1 - u1 - u2) + Vector(normals[v[1]]) * u1 +
             Vector(normals[v[2]]) * u2;
  }
  return hit;
}

LocalHit analytic_hit(const SurfaceTable& table, const RawHit& raw, const Ray& ray) {
  LocalHit hit{raw.position, raw.normal, {}, 0};
  // All in double precision; the rounding error grows with the length of the ray.
  hit.error = 64 * 0x1p-53 *
              (max_abs(Vector(ray.origin)) + raw.t * max_abs(Vector(ray.direction)) +
               max_abs(raw.position));
  if (raw.kind == HitKind::kPatch && !table.patch_normals.empty()) {
    const auto& n = table.patch_normals[raw.primitive];
    const double u = raw.uv.x, v = raw.uv.y;
    hit.ns = Vector(n[0]) * ((1 - u) * (1 - v)) + Vector(n[1]) * (u * (1 - v)) +
             Vector(n[2]) * ((1 - u) * v) + Vector(n[3]) * (u * v);
  }
  return hit;
}

/// Converts the hit to the scene's space and returns the error of each coordinate.
Vector to_scene(const Transform& scene_from_object, LocalHit& hit) {
  const auto& m = scene_from_object.matrix();
  const Transform inverse = scene_from_object.inverse();
  const auto& w = inverse.matrix();
  const auto times = [](const Transform::Matrix& a, const Vector& v, bool point) {
    std::array<double, 3> r{};
    for (int i = 0; i < 3; ++i)
      r[i] = std::fabs(a[i][0]) * v.x + std::fabs(a[i][1]) * v.y + std::fabs(a[i][2]) * v.z +
             (point ? std::fabs(a[i][3]) : 0);
    return Vector{r[0], r[1], r[2]};
  };
  const Vector local = hit.position;
  hit.position = scene_from_object.point(local);
  hit.ng = normalized(scene_from_object.normal(hit.ng));
  if (hit.ns != Vector{}) hit.ns = scene_from_object.normal(hit.ns);
  // Embree converts rays to the object's space in floats, with an inverse that it computes in
  // floats.
  const Vector rounding = times(w, absolute(hit.position), true) * kTraversalBound;
  return times(m, rounding + Vector{hit.error, hit.error, hit.error}, false);
}

/// The same for a moving instance.
Vector to_scene(const GeometryInstance& instance, double time_s, LocalHit& hit) {
  const Pose pose = instance.motion->at(time_s);
  const Transform& start_from_object = instance.scene_from_object;
  // Rays are converted to the object's space in double and rounded to floats there.
  const Vector at_start = start_from_object.point(hit.position);
  const Vector object_error =
      absolute(hit.position) * kTraversalBound + Vector{hit.error, hit.error, hit.error};
  hit.position = pose.point(at_start);
  hit.ng = pose.vector(normalized(start_from_object.normal(hit.ng)));
  if (hit.ns != Vector{}) hit.ns = pose.vector(start_from_object.normal(hit.ns));
  const auto& m = start_from_object.matrix();
  const auto start_row = [&](int i) { return absolute({m[i][0], m[i][1], m[i][2]}); };
  const Vector start_error{dot(start_row(0), object_error), dot(start_row(1), object_error),
                           dot(start_row(2), object_error)};
  const double rounding =
      16 * 0x1p-53 * (max_abs(at_start) + max_abs(pose.shift_m) + max_abs(hit.position));
  return Vector{dot(absolute(pose.r[0]), start_error), dot(absolute(pose.r[1]), start_error),
                dot(absolute(pose.r[2]), start_error)} +
         Vector{rounding, rounding, rounding};
}

}  // namespace

std::optional<SurfaceHit> Scene::closest_hit(const Ray& ray) const {
  const std::optional<RawHit> raw = accelerator_->closest_hit(ray);
  if (!raw) return std::nullopt;
  const GeometryInstance* instance =
      raw->instance >= 0 ? &accelerator_->instance(raw->instance) : nullptr;
  const GeometrySet& set =
      instance ? accelerator_->object(instance->object) : accelerator_->scene();
  const SurfaceTable& table = instance ? object_surfaces_[instance->object] : surfaces_;

  LocalHit local = raw->kind == HitKind::kTriangle ? triangle_hit(set, table, *raw)
                                                   : analytic_hit(table, *raw, ray);
  Vector error{local.error, local.error, local.error};
  if (instance)
    error = instance->motion ? to_scene(*instance, ray.time_s, local)
                             : to_scene(instance->scene_from_object, local);

  SurfaceHit hit;
  hit.t = raw->t;
  hit.time_s = ray.time_s;
  hit.position = local.position;
  // Adds the rounding of the position at the start of rays, and the rounding error of doubles.
  error += absolute(local.position) * (kFloatRoundoff * (1 + 1e-6));
  error += Vector{kLeastError, kLeastError, kLeastError};
  // Rounded up, so that it stays a bound.
  hit.position_error = Vec3<float>(error * (1 + 1e-6));
  hit.ng = local.ng;
  Vector ns = local.ns;
  if (ns != Vector{}) ns = normalized(ns);
  if (ns == Vector{}) ns = local.ng;
  hit.ns = Vec3<float>(dot(ns, local.ng) < 0 ? -ns : ns);
  const PrimitiveRun& run = table.run(raw->kind, raw->primitive);
  const Surface& surface = table.surfaces[run.surface];
  hit.material = surface.material;
  hit.light = surface.light;
  // Instance -1 is the scene's own geometry.
  hit.shape = (static_cast<std::uint64_t>(raw->instance + 1) << 32) | run.surface;
  hit.light_primitive =
      run.first_light_primitive + (raw->primitive - run.first) / run.per_light_primitive;
  return hit;
}

}  // namespace lucerna
