#include "server/user_geometry.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "server/ray_limits.h"

namespace lucerna {
namespace {

struct AnalyticHit {
  ShapeHit<double> hit;
  Vec2<double> uv;
};

std::optional<AnalyticHit> intersect(const AnalyticShapes& shapes, unsigned primitive,
                                     const RTCRay& ray, double t_max) {
  const Vec3<double> o{ray.org_x, ray.org_y, ray.org_z}, d{ray.dir_x, ray.dir_y, ray.dir_z};
  AnalyticHit found;
  std::optional<ShapeHit<double>> hit;
  switch (shapes.kind) {
    case HitKind::kPatch:
      hit = shapes.set->patches[primitive].intersect(o, d, ray.tnear, t_max, &found.uv);
      break;
    case HitKind::kSphere:
      hit = shapes.set->spheres[primitive].intersect(o, d, ray.tnear, t_max);
      break;
    case HitKind::kDisk:
      hit = shapes.set->disks[primitive].intersect(o, d, ray.tnear, t_max);
      break;
    case HitKind::kCylinder:
      hit = shapes.set->cylinders[primitive].intersect(o, d, ray.tnear, t_max);
      break;
    case HitKind::kTriangle:
      break;
  }
  if (!hit || !(hit->t > ray.tnear && hit->t < t_max)) return std::nullopt;
  found.hit = *hit;
  return found;
}

RTCBounds rounded(const std::pair<Vec3<double>, Vec3<double>>& box) {
  const auto down = [](double v) { return std::nextafter(static_cast<float>(v), -INFINITY); };
  const auto up = [](double v) { return std::nextafter(static_cast<float>(v), INFINITY); };
  RTCBounds out{};
  out.lower_x = down(box.first.x), out.lower_y = down(box.first.y), out.lower_z = down(box.first.z);
  out.upper_x = up(box.second.x), out.upper_y = up(box.second.y), out.upper_z = up(box.second.z);
  return out;
}

void analytic_bounds(const RTCBoundsFunctionArguments* args) {
  const auto& shapes = *static_cast<const AnalyticShapes*>(args->geometryUserPtr);
  std::pair<Vec3<double>, Vec3<double>> box;
  switch (shapes.kind) {
    case HitKind::kPatch:
      box = shapes.set->patches[args->primID].bounds();
      break;
    case HitKind::kSphere:
      box = shapes.set->spheres[args->primID].bounds();
      break;
    case HitKind::kDisk:
      box = shapes.set->disks[args->primID].bounds();
      break;
    case HitKind::kCylinder:
      box = shapes.set->cylinders[args->primID].bounds();
      break;
    case HitKind::kTriangle:
      break;
  }
  *args->bounds_o = rounded(box);
}

// Queries are single rays, so N is 1 here.
void intersect_analytic(const RTCIntersectFunctionNArguments* args) {
  if (args->valid[0] == 0) return;
  const auto& shapes = *static_cast<const AnalyticShapes*>(args->geometryUserPtr);
  auto& query = *reinterpret_cast<RTCRayHit*>(args->rayhit);
  const auto found = intersect(shapes, args->primID, query.ray, query.ray.tfar);
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
  const auto& shapes = *static_cast<const AnalyticShapes*>(args->geometryUserPtr);
  auto& ray = *reinterpret_cast<RTCRay*>(args->ray);
  if (intersect(shapes, args->primID, ray, ray.tfar)) ray.tfar = -INFINITY;
}

/// A ray in the object's space: t there is in so many times the unit that it had.
struct ObjectRay {
  RTCRay ray;
  double units;
};

/// Nothing where Embree could not take it.
std::optional<ObjectRay> to_object(const MovingInstance& instance,
                                   const RTCIntersectContext* context, const RTCRay& ray) {
  const Pose pose = instance.motion->at(reinterpret_cast<const QueryContext*>(context)->time_s);
  const Vec3<double> o =
      instance.object_from_start.point(pose.inverse_point({ray.org_x, ray.org_y, ray.org_z}));
  const Vec3<double> d =
      instance.object_from_start.vector(pose.inverse_vector({ray.dir_x, ray.dir_y, ray.dir_z}));
  const double longest = max_abs(d);
  if (!(max_abs(o) < 0x1p60) || !(longest > 0) || !std::isfinite(longest)) return std::nullopt;
  ObjectRay r{ray, std::scalbn(1.0, instance.direction_exponent - std::ilogb(longest))};
  const Vec3<float> origin(o), direction(d * r.units);
  r.ray.org_x = origin.x, r.ray.org_y = origin.y, r.ray.org_z = origin.z;
  r.ray.dir_x = direction.x, r.ray.dir_y = direction.y, r.ray.dir_z = direction.z;
  r.ray.tnear = static_cast<float>(ray.tnear / r.units);
  r.ray.tfar = static_cast<float>(ray.tfar / r.units);
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
  rtcIntersect1(instance.object, args->context, &local);
  args->context->instID[0] = RTC_INVALID_GEOMETRY_ID;
  if (local.hit.geomID == RTC_INVALID_GEOMETRY_ID) return;
  query.ray.tfar = static_cast<float>(local.ray.tfar * start->units);
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
  rtcOccluded1(instance.object, args->context, &local);
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
                               const RTCBounds& b, unsigned number)
    : object(object),
      number(number),
      motion(instance.motion),
      object_from_start(instance.scene_from_object.inverse()),
      direction_exponent(
          limits_for(
              std::max({b.upper_x - b.lower_x, b.upper_y - b.lower_y, b.upper_z - b.lower_z}), 1)
              .direction_exponent) {
  Vec3<double> low{INFINITY, INFINITY, INFINITY}, high = -low;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3<double> p = instance.scene_from_object.point({corner & 1 ? b.upper_x : b.lower_x,
                                                             corner & 2 ? b.upper_y : b.lower_y,
                                                             corner & 4 ? b.upper_z : b.lower_z});
    low = {std::fmin(low.x, p.x), std::fmin(low.y, p.y), std::fmin(low.z, p.z)};
    high = {std::fmax(high.x, p.x), std::fmax(high.y, p.y), std::fmax(high.z, p.z)};
  }
  swept = rounded(motion->bounds(low, high));
}

RTCGeometry analytic_geometry(RTCDevice device, AnalyticShapes* shapes, std::size_t count) {
  return user_geometry(device, count, shapes, analytic_bounds, intersect_analytic,
                       occluded_analytic);
}

RTCGeometry moving_geometry(RTCDevice device, std::vector<MovingInstance>* instances) {
  return user_geometry(device, instances->size(), instances, moving_bounds, intersect_moving,
                       occluded_moving);
}

}  // namespace lucerna
