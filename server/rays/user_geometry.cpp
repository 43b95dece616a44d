#include "server/rays/user_geometry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "server/rays/ray_limits.h"

namespace lucerna {
namespace {

Vec3 origin_of(const RTCRay& ray) { return {ray.org_x, ray.org_y, ray.org_z}; }
Vec3 direction_of(const RTCRay& ray) { return {ray.dir_x, ray.dir_y, ray.dir_z}; }

struct AnalyticHit {
  ShapeHit hit;
  Vec2 uv;
};

std::optional<AnalyticHit> intersect(const PrimitivesOfSet& shapes, unsigned primitive,
                                     const RTCRay& ray, double t_min, double t_max) {
  const double unit_m = shapes.set->unit_m;
  const Vec3 o = origin_of(ray) * unit_m;
  const Vec3 d = direction_of(ray) * unit_m;
  AnalyticHit found;
  const auto hit = shapes.set->visit_surface(
      shapes.kind, primitive, [&](const auto& surface) -> std::optional<ShapeHit> {
        if constexpr (QuadricShape<std::decay_t<decltype(surface)>>)
          return surface.intersect(o, d, t_min, t_max);
        else
          return surface.intersect(o, d, t_min, t_max, &found.uv);
      });
  if (!hit || !(hit->t > t_min && hit->t < t_max)) return std::nullopt;
  found.hit = *hit;
  return found;
}

const QueryContext& query_of(const RTCIntersectContext* context) {
  return *reinterpret_cast<const QueryContext*>(context);
}

/// Cosine of the angle between a ray and a normal of an object, in the scene; at least 0.
double cosine_in_scene(const RTCIntersectContext* context, const Vec3& normal,
                       const Vec3& direction) {
  Vec3 n = normal, d = direction;
  if (context->instID[0] != RTC_INVALID_GEOMETRY_ID) {
    // The motion of an instance keeps angles.
    const Transform& to_scene =
        query_of(context).instances[context->instID[0] - kFirstInstance].scene_from_object;
    n = to_scene.normal(n), d = to_scene.vector(d);
  }
  return std::fmin(std::fabs(dot(normalized(n), normalized(d))), 1);
}

/// Whether the query looks for this primitive elsewhere.
bool is_hidden(const RTCIntersectContext* context, HitKind kind, std::uint32_t primitive) {
  const std::vector<PrimitiveRange>* hidden = query_of(context).hidden;
  if (hidden == nullptr || context->instID[0] != RTC_INVALID_GEOMETRY_ID) [[likely]]
    return false;
  const PrimitiveRange one{kind, primitive, 1};
  const auto after = std::ranges::upper_bound(*hidden, one, is_before);
  if (after == hidden->begin()) return false;
  const PrimitiveRange& range = *(after - 1);
  return range.kind == kind && primitive - range.first < range.count;
}

/// Whether any surface of the set lets a ray of this query pass.
bool may_pass(const GeometrySet& set, RayFilter filter) {
  return set.non_opaque != nullptr || filter >= RayFilter::kPanes;
}

/// Whether the ray passes through the surface at this hit.
bool passes(const PrimitivesOfSet& shapes, unsigned primitive, const RTCRay& ray,
            const RTCIntersectContext* context, const AnalyticHit& found) {
  const RayFilter filter = query_of(context).filter;
  if (!may_pass(*shapes.set, filter)) return false;
  const SurfaceTable* table = shapes.set->non_opaque;
  if (table == nullptr) return true;
  TexturePoint at{.uv = {}, .position = found.hit.point.position, .normal = found.hit.point.normal};
  at.uv = shapes.set->visit_surface(shapes.kind, primitive, [&](const auto& surface) -> Vec2 {
    if constexpr (QuadricShape<std::decay_t<decltype(surface)>>)
      return surface.uv({at.position});
    else
      return table->patch_uv_at(primitive, found.uv.x, found.uv.y);
  });
  const Vec3 d = direction_of(ray);
  return table->lets_pass(shapes.kind, primitive, filter,
                          {at, origin_of(ray), d, cosine_in_scene(context, at.normal, d)});
}

/// Whether the query wants all hits.  Then it has taken this one, and the ray goes on.
bool keeps(const RTCIntersectContext* context, HitKind kind, std::uint32_t primitive,
           const Vec2& uv, const SurfacePoint& point = {}) {
  std::vector<RawHit>* kept = query_of(context).kept;
  if (kept == nullptr) return false;
  RawHit hit{.kind = kind,
             .primitive = primitive,
             .uv = {static_cast<float>(uv.x), static_cast<float>(uv.y)},
             .position = point.position,
             .normal = point.normal};
  if (context->instID[0] != RTC_INVALID_GEOMETRY_ID)
    hit.instance = static_cast<std::int32_t>(context->instID[0] - kFirstInstance);
  kept->push_back(hit);
  return true;
}

/// Whether an end of the ray may lie on the surface with this plane [m], which then does not stop
/// the ray.  `size`: bounds its coordinates, its extent and those of the ray [m].
bool may_be_own(RTCIntersectContext* context, const Vec3& normal, const Vec3& position,
                double size) {
  auto& query = *reinterpret_cast<QueryContext*>(context);
  if (query.ends == nullptr) [[likely]]
    return false;
  // Far more than the rounding of a hit, so that no surface of an end stops a ray here.
  constexpr double kRounding = 0x1p-14;
  const auto is_near = [&](const EndTolerance& end) {
    const double away = dot(normal, end.position - position);
    const double most = 4 * (double{end.error} + kRounding * size + kLeastError);
    return end.error >= 0 && !(away * away > most * most * dot(normal, normal));
  };
  // The planes of instances are in another space.
  const bool own = context->instID[0] != RTC_INVALID_GEOMETRY_ID || is_near(query.ends->start) ||
                   is_near(query.ends->end);
  query.may_be_own |= own;
  return own;
}

/// As `intersect`, past hits that the ray passes or the query keeps.
std::optional<AnalyticHit> first_hit(const PrimitivesOfSet& shapes, unsigned primitive,
                                     const RTCRay& ray, const RTCIntersectContext* context) {
  if (is_hidden(context, shapes.kind, primitive)) return std::nullopt;
  double t_min = ray.tnear;
  // A ray meets a patch or a quadric twice at most.
  for (int i = 0; i < 3; ++i) {
    const auto found = intersect(shapes, primitive, ray, t_min, ray.tfar);
    if (!found) return found;
    if (!passes(shapes, primitive, ray, context, *found) &&
        !keeps(context, shapes.kind, primitive, found->uv, found->hit.point))
      return found;
    t_min = query_of(context).kept != nullptr
                ? std::nextafter(found->hit.t, INFINITY)
                : std::nextafter(static_cast<float>(found->hit.t), INFINITY);
  }
  return std::nullopt;
}

/// The box in units of `unit_m`, rounded outwards.
RTCBounds rounded(const std::pair<Vec3, Vec3>& box, double unit_m) {
  const auto down = [&](double v) {
    return std::nextafter(static_cast<float>(v / unit_m), -INFINITY);
  };
  const auto up = [&](double v) {
    return std::nextafter(static_cast<float>(v / unit_m), INFINITY);
  };
  RTCBounds out{};
  out.lower_x = down(box.first.x), out.lower_y = down(box.first.y), out.lower_z = down(box.first.z);
  out.upper_x = up(box.second.x), out.upper_y = up(box.second.y), out.upper_z = up(box.second.z);
  return out;
}

void analytic_bounds(const RTCBoundsFunctionArguments* args) {
  const auto& shapes = *static_cast<const PrimitivesOfSet*>(args->geometryUserPtr);
  const std::pair<Vec3, Vec3> box =
      shapes.set->visit_surface(shapes.kind, shapes.first + args->primID,
                                [](const auto& surface) { return surface.bounds(); });
  *args->bounds_o = rounded(box, shapes.set->unit_m);
}

// Queries are single rays, so N is 1.
void intersect_analytic(const RTCIntersectFunctionNArguments* args) {
  if (args->valid[0] == 0) return;
  const auto& shapes = *static_cast<const PrimitivesOfSet*>(args->geometryUserPtr);
  auto& query = *reinterpret_cast<RTCRayHit*>(args->rayhit);
  const auto found = first_hit(shapes, shapes.first + args->primID, query.ray, args->context);
  if (!found) return;
  query.ray.tfar = static_cast<float>(found->hit.t);
  query.hit.u = static_cast<float>(found->uv.x);
  query.hit.v = static_cast<float>(found->uv.y);
  query.hit.geomID = args->geomID;
  query.hit.primID = args->primID;
  query.hit.instID[0] = args->context->instID[0];
  auto& context = *reinterpret_cast<QueryContext*>(args->context);
  context.position = found->hit.point.position;
  context.normal = found->hit.point.normal;
}

void occluded_analytic(const RTCOccludedFunctionNArguments* args) {
  if (args->valid[0] == 0) return;
  const auto& shapes = *static_cast<const PrimitivesOfSet*>(args->geometryUserPtr);
  auto& ray = *reinterpret_cast<RTCRay*>(args->ray);
  const auto found = first_hit(shapes, shapes.first + args->primID, ray, args->context);
  if (!found) return;
  const auto& [position, normal, primitive] = found->hit.point;
  // A curve is found with an error of its own.
  const double size =
      shapes.kind == HitKind::kCurve
          ? INFINITY
          : max_abs(position) + 0x1p-20 * max_abs(origin_of(ray)) * shapes.set->unit_m;
  if (may_be_own(args->context, normal, position, size)) return;
  ray.tfar = -INFINITY;
}

/// The same for a triangle with these barycentric coordinates.
bool passes(const GeometrySet& set, std::uint32_t triangle, const Vec2& uv, const RTCRay& ray,
            const RTCIntersectContext* context) {
  const RayFilter filter = query_of(context).filter;
  if (!may_pass(set, filter)) return false;
  if (set.non_opaque == nullptr) return true;
  const auto vertex = [&](std::size_t k) {
    return Vec3(set.vertices[set.triangles[3 * std::size_t{triangle} + k]]) * set.unit_m;
  };
  const Vec3 a = vertex(0), ab = vertex(1) - a, ac = vertex(2) - a;
  const TexturePoint at{.uv = set.non_opaque->triangle_uv_at(triangle, uv.x, uv.y),
                        .position = a + ab * uv.x + ac * uv.y,
                        .normal = normalized(cross(ab, ac))};
  const Vec3 d = direction_of(ray);
  return set.non_opaque->lets_pass(HitKind::kTriangle, triangle, filter,
                                   {at, origin_of(ray), d, cosine_in_scene(context, at.normal, d)});
}

/// The same for a triangle [m].
bool plane_may_be_own(RTCIntersectContext* context, const std::array<Vec3, 3>& corners) {
  const Vec3 ab = corners[1] - corners[0], ac = corners[2] - corners[0];
  return may_be_own(context, cross(ab, ac), corners[0],
                    max_abs(corners[0]) + max_abs(ab) + max_abs(ac));
}

std::optional<WideHit> intersect_large(const GeometrySet& set, const LargeTriangle& triangle,
                                       const RTCRay& ray, const RTCIntersectContext* context) {
  if (is_hidden(context, HitKind::kTriangle, triangle.triangle)) return std::nullopt;
  const auto found = intersect(triangle, origin_of(ray) * set.unit_m,
                               direction_of(ray) * set.unit_m, ray.tnear, ray.tfar);
  if (found && (passes(set, triangle.triangle, found->uv, ray, context) ||
                keeps(context, HitKind::kTriangle, triangle.triangle, found->uv)))
    return std::nullopt;
  return found;
}

void large_bounds(const RTCBoundsFunctionArguments* args) {
  const auto& of = *static_cast<const PrimitivesOfSet*>(args->geometryUserPtr);
  Bounds box;
  for (const Vec3& corner : of.set->large[of.first + args->primID].corners) box.add(corner);
  *args->bounds_o = rounded({box.lower, box.upper}, of.set->unit_m);
}

void intersect_large(const RTCIntersectFunctionNArguments* args) {
  if (args->valid[0] == 0) return;
  const auto& of = *static_cast<const PrimitivesOfSet*>(args->geometryUserPtr);
  const LargeTriangle& triangle = of.set->large[of.first + args->primID];
  auto& query = *reinterpret_cast<RTCRayHit*>(args->rayhit);
  const auto found = intersect_large(*of.set, triangle, query.ray, args->context);
  if (!found) return;
  query.ray.tfar = static_cast<float>(found->t);
  query.hit.u = static_cast<float>(found->uv.x);
  query.hit.v = static_cast<float>(found->uv.y);
  query.hit.geomID = static_cast<unsigned>(HitKind::kTriangle);
  query.hit.primID = triangle.triangle;
  query.hit.instID[0] = args->context->instID[0];
}

void occluded_large(const RTCOccludedFunctionNArguments* args) {
  if (args->valid[0] == 0) return;
  const auto& of = *static_cast<const PrimitivesOfSet*>(args->geometryUserPtr);
  const LargeTriangle& triangle = of.set->large[of.first + args->primID];
  auto& ray = *reinterpret_cast<RTCRay*>(args->ray);
  if (!intersect_large(*of.set, triangle, ray, args->context)) return;
  if (plane_may_be_own(args->context, triangle.corners)) return;
  ray.tfar = -INFINITY;
}

/// Whether the ray runs along the triangle that it hits.
bool is_along(const RTCRay& ray, const RTCHit& hit) {
  const Vec3f n{hit.Ng_x, hit.Ng_y, hit.Ng_z}, d{ray.dir_x, ray.dir_y, ray.dir_z};
  // A cosine.  Above it, the error of the hit is below 2^-10 of the triangle's size.
  constexpr float kAlong = 0x1p-12F;
  const float cosine = dot(n, d);
  return cosine * cosine < kAlong * kAlong * dot(n, n) * dot(d, d);
}

/// check_hit() for all rays.  Not inlined, so that the common case is short.
[[gnu::noinline]] void check_any_hit(const RTCFilterFunctionNArguments* args) {
  const auto& ray = *reinterpret_cast<const RTCRay*>(args->ray);  // N is 1
  const auto& hit = *reinterpret_cast<const RTCHit*>(args->hit);
  const auto& of = *static_cast<const PrimitivesOfSet*>(args->geometryUserPtr);
  const GeometrySet& set = *of.set;
  const std::uint32_t number = of.first + hit.primID;
  if (is_hidden(args->context, HitKind::kTriangle, number) ||
      passes(set, number, {hit.u, hit.v}, ray, args->context)) [[unlikely]] {
    args->valid[0] = 0;
    return;
  }
  if (is_along(ray, hit)) [[unlikely]] {
    LargeTriangle triangle;
    for (std::size_t k = 0; k < 3; ++k)
      triangle.corners[k] = Vec3(set.vertices[set.triangles[3 * std::size_t{number} + k]]);
    if (!intersect(triangle, origin_of(ray), direction_of(ray), ray.tnear,
                   query_of(args->context).t_max)) {
      args->valid[0] = 0;
      return;
    }
  }
  if (keeps(args->context, HitKind::kTriangle, number, {hit.u, hit.v})) [[unlikely]]
    args->valid[0] = 0;
  if (query_of(args->context).ends != nullptr) {
    std::array<Vec3, 3> corners;
    for (std::size_t k = 0; k < 3; ++k)
      corners.at(k) = Vec3(set.vertices[set.triangles[3 * std::size_t{number} + k]]) * set.unit_m;
    if (plane_may_be_own(args->context, corners)) args->valid[0] = 0;
  }
}

/// For a ray along a triangle, Embree divides two numbers that are rounding errors.  It may then
/// find a hit beyond the triangle.  Such hits are checked in double.
void check_hit(const RTCFilterFunctionNArguments* args) {
  const QueryContext& query = query_of(args->context);
  const GeometrySet& set = *static_cast<const PrimitivesOfSet*>(args->geometryUserPtr)->set;
  const bool takes_any = query.hidden == nullptr && query.kept == nullptr &&
                         query.ends == nullptr && !may_pass(set, query.filter);
  if (!takes_any || is_along(*reinterpret_cast<const RTCRay*>(args->ray),
                             *reinterpret_cast<const RTCHit*>(args->hit)))
    check_any_hit(args);
}

/// A ray of the scene in the object's space, in Embree's form.
struct ObjectRay {
  RTCRay ray;
  double units, start;  // as in UnitRay
};

/// Nothing if the ray misses the object.
std::optional<ObjectRay> to_object(const MovingInstance& instance,
                                   const RTCIntersectContext* context, const RTCRay& ray) {
  const Pose pose = instance.motion->at(query_of(context).time_s);
  const double unit_m = instance.scene_unit_m;
  const Vec3 o = origin_of(ray) * unit_m;
  const Vec3 d = direction_of(ray) * unit_m;
  const std::optional<UnitRay> there =
      unit_ray(instance.object_from_start.point(pose.inverse_point(o)),
               instance.object_from_start.vector(pose.inverse_vector(d)), ray.tnear, ray.tfar,
               instance.space);
  if (!there) return std::nullopt;
  ObjectRay r{ray, there->units, there->start};
  r.ray.org_x = there->origin.x, r.ray.org_y = there->origin.y, r.ray.org_z = there->origin.z;
  r.ray.dir_x = there->direction.x, r.ray.dir_y = there->direction.y;
  r.ray.dir_z = there->direction.z;
  r.ray.tnear = there->t_min, r.ray.tfar = there->t_max;
  return r;
}

void moving_bounds(const RTCBoundsFunctionArguments* args) {
  const auto& instances = *static_cast<const std::vector<MovingInstance>*>(args->geometryUserPtr);
  *args->bounds_o = instances[args->primID].swept;
}

void intersect_moving(const RTCIntersectFunctionNArguments* args) {
  if (args->valid[0] == 0) return;
  const auto& instance =
      (*static_cast<const std::vector<MovingInstance>*>(args->geometryUserPtr))[args->primID];
  auto& query = *reinterpret_cast<RTCRayHit*>(args->rayhit);
  const std::optional<ObjectRay> start = to_object(instance, args->context, query.ray);
  if (!start) return;
  alignas(16) RTCRayHit local;
  local.ray = start->ray;
  local.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  local.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  args->context->instID[0] = instance.number;
  auto& context = *reinterpret_cast<QueryContext*>(args->context);
  const float t_max = std::exchange(context.t_max, local.ray.tfar);
  rtcIntersect1(instance.object, args->context, &local);
  context.t_max = t_max;
  args->context->instID[0] = RTC_INVALID_GEOMETRY_ID;
  if (local.hit.geomID == RTC_INVALID_GEOMETRY_ID) return;
  query.ray.tfar = static_cast<float>(local.ray.tfar * start->units + start->start);
  query.hit = local.hit;
  query.hit.instID[0] = instance.number;
}

void occluded_moving(const RTCOccludedFunctionNArguments* args) {
  if (args->valid[0] == 0) return;
  const auto& instance =
      (*static_cast<const std::vector<MovingInstance>*>(args->geometryUserPtr))[args->primID];
  auto& ray = *reinterpret_cast<RTCRay*>(args->ray);
  const std::optional<ObjectRay> start = to_object(instance, args->context, ray);
  if (!start) return;
  alignas(16) RTCRay local = start->ray;
  auto& context = *reinterpret_cast<QueryContext*>(args->context);
  args->context->instID[0] = instance.number;
  const float t_max = std::exchange(context.t_max, local.tfar);
  rtcOccluded1(instance.object, args->context, &local);
  context.t_max = t_max;
  args->context->instID[0] = RTC_INVALID_GEOMETRY_ID;
  if (local.tfar < 0) ray.tfar = -INFINITY;
}

RTCGeometry user_geometry(RTCDevice device, std::size_t count, void* data, RTCBoundsFunction bounds,
                          RTCIntersectFunctionN intersect, RTCOccludedFunctionN occluded) {
  RTCGeometry g = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(g, static_cast<unsigned>(count));
  rtcSetGeometryUserData(g, data);
  rtcSetGeometryBoundsFunction(g, bounds, nullptr);
  rtcSetGeometryIntersectFunction(g, intersect);
  rtcSetGeometryOccludedFunction(g, occluded);
  return g;
}

}  // namespace

MovingInstance::MovingInstance(const GeometryInstance& instance, RTCScene object,
                               const RaySpace& space, const Bounds& box, double scene_unit_m,
                               unsigned number)
    : object(object),
      number(number),
      motion(instance.motion),
      object_from_start(instance.scene_from_object.inverse()),
      space(space),
      scene_unit_m(scene_unit_m) {
  Bounds placed;
  for (const Vec3& corner : box.corners()) placed.add(instance.scene_from_object.point(corner));
  swept = rounded(motion->bounds(placed.lower, placed.upper), scene_unit_m);
}

void check_along(RTCGeometry geometry, PrimitivesOfSet* triangles) {
  rtcSetGeometryUserData(geometry, triangles);
  rtcSetGeometryIntersectFilterFunction(geometry, check_hit);
  rtcSetGeometryOccludedFilterFunction(geometry, check_hit);
}

RTCGeometry analytic_geometry(RTCDevice device, PrimitivesOfSet* shapes, std::size_t count) {
  return user_geometry(device, count, shapes, analytic_bounds, intersect_analytic,
                       occluded_analytic);
}

RTCGeometry large_geometry(RTCDevice device, PrimitivesOfSet* large, std::size_t count) {
  return user_geometry(device, count, large, large_bounds, intersect_large, occluded_large);
}

RTCGeometry moving_geometry(RTCDevice device, std::vector<MovingInstance>* instances) {
  return user_geometry(device, instances->size(), instances, moving_bounds, intersect_moving,
                       occluded_moving);
}

}  // namespace lucerna
