#include "server/rays/accelerator.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>

#include "proto/common/status_macros.h"
#include "server/rays/accelerator_state.h"

namespace lucerna {
namespace {

std::optional<UnitRay> unit_ray(const Ray& ray, const RaySpace& space) {
  return lucerna::unit_ray(Vec3(ray.origin), Vec3(ray.direction), ray.t_min, ray.t_max, space);
}

/// Embree reads four floats at once.  Reading bytes that were just stored in parts waits until all
/// of them are in the cache, so four floats are stored at once too.
void store(float* at, float x, float y, float z, float w) {
  using Four [[gnu::vector_size(4 * sizeof(float))]] = float;
  const Four four{x, y, z, w};
  std::memcpy(at, &four, sizeof four);
}

void set_ray(RTCRay& ray, const UnitRay& r) {
  store(&ray.org_x, r.origin.x, r.origin.y, r.origin.z, r.t_min);
  store(&ray.dir_x, r.direction.x, r.direction.y, r.direction.z, 0);
  ray.tfar = r.t_max;
  ray.mask = ~0u;
  ray.id = ray.flags = 0;
}

/// A query for surfaces near a point.
struct NearQuery {
  const GeometrySet* set;  ///< with the numbers of Embree's primitives; null: boxes decide
  Vec3 point_m;
  double radius_m;
  bool found = false;

  bool touches(const std::array<Vec3, 3>& corners) const {
    for (int axis = 0; axis < 3; ++axis) {
      const auto [least, most] =
          std::minmax({corners[0][axis], corners[1][axis], corners[2][axis]});
      if (point_m[axis] < least - radius_m || point_m[axis] > most + radius_m) return false;
    }
    const Vec3 n = cross(corners[1] - corners[0], corners[2] - corners[0]);
    return !(std::fabs(dot(n, point_m - corners[0])) > radius_m * length(n));
  }
};

/// Embree calls it for surfaces whose boxes are near.  Returns whether the query ends.
bool check_near(RTCPointQueryFunctionArguments* args) {
  auto& query = *static_cast<NearQuery*>(args->userPtr);
  const GeometrySet* set = args->context->instStackSize == 0 ? query.set : nullptr;
  bool touches = true;
  if (set != nullptr && args->geomID == static_cast<unsigned>(HitKind::kTriangle)) {
    std::array<Vec3, 3> corners;
    for (std::size_t k = 0; k < 3; ++k)
      corners.at(k) =
          Vec3(set->vertices[set->triangles[3 * std::size_t{args->primID} + k]]) * set->unit_m;
    touches = query.touches(corners);
  } else if (set != nullptr && args->geomID == kWide) {
    touches = query.touches(set->large[args->primID].corners);
  }
  if (!touches) return false;
  query.found = true;
  args->query->radius = 0;
  return true;
}

}  // namespace

Accelerator::Accelerator(std::unique_ptr<State> state) : state_(std::move(state)) {}
Accelerator::~Accelerator() = default;

std::optional<RawHit> Accelerator::closest_hit(const Ray& ray, RayFilter filter) const {
  const State& state = *state_;
  if (state.rays == nullptr) return std::nullopt;
  const std::optional<UnitRay> start = unit_ray(ray, state.space);
  if (!start) return std::nullopt;
  alignas(16) RTCRayHit query;
  set_ray(query.ray, *start);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  QueryContext context(ray.time_s, start->t_max, filter, state.placed);
  if (state.moved_scene == nullptr) [[likely]]
    rtcIntersect1(state.rays, &context.embree, &query);
  else
    state.intersect_all(context, query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  RawHit hit;
  hit.t = static_cast<float>(query.ray.tfar * start->units + start->start);
  hit.kind = static_cast<HitKind>(query.hit.geomID);
  hit.primitive = query.hit.primID;
  if (query.hit.instID[0] != RTC_INVALID_GEOMETRY_ID)
    hit.instance = static_cast<std::int32_t>(query.hit.instID[0] - kFirstInstance);
  hit.uv = {query.hit.u, query.hit.v};
  if (hit.kind != HitKind::kTriangle) hit.position = context.position, hit.normal = context.normal;
  return hit;
}

/// Meets the surfaces that are shared, then those that are elsewhere.
void Accelerator::State::intersect_all(QueryContext& context, RTCRayHit& query) const {
  context.hidden = &moved;
  rtcIntersect1(rays, &context.embree, &query);
  context.hidden = nullptr;
  const float before = query.ray.tfar;
  const RTCHit shared_hit = query.hit;
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(moved_scene.get(), &context.embree, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) {
    query.ray.tfar = before;
    query.hit = shared_hit;
  } else if (query.hit.geomID >= kFirstInstance) {  // else a large triangle, with its number
    const PrimitiveRange& range = moved[query.hit.geomID - kFirstInstance];
    query.hit.geomID = static_cast<unsigned>(range.kind);
    query.hit.primID += range.first;
  }
}

std::vector<RawHit> Accelerator::all_hits(const Ray& ray, RayFilter filter) const {
  const State& state = *state_;
  std::vector<RawHit> hits;
  if (state.rays == nullptr) return hits;
  const std::optional<UnitRay> start = unit_ray(ray, state.space);
  if (!start) return hits;
  alignas(16) RTCRayHit query;
  set_ray(query.ray, *start);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  QueryContext context(ray.time_s, start->t_max, filter, state.placed);
  context.kept = &hits;
  if (state.moved_scene == nullptr)
    rtcIntersect1(state.rays, &context.embree, &query);
  else
    state.intersect_all(context, query);
  return hits;
}

bool Accelerator::occluded(const Ray& ray, RayFilter filter) const {
  return obstacle(ray, {}, filter) != Obstacle::kNone;
}

Obstacle Accelerator::obstacle(const Ray& ray, const EndTolerances& ends, RayFilter filter) const {
  const State& state = *state_;
  if (state.rays == nullptr) return Obstacle::kNone;
  const std::optional<UnitRay> start = unit_ray(ray, state.space);
  if (!start) return Obstacle::kNone;
  alignas(16) RTCRay query;
  set_ray(query, *start);
  QueryContext context(ray.time_s, start->t_max, filter, state.placed);
  if (ends.any()) context.ends = &ends;
  if (state.moved_scene != nullptr) [[unlikely]] {
    rtcOccluded1(state.moved_scene.get(), &context.embree, &query);
    if (query.tfar < 0) return Obstacle::kOther;
    context.hidden = &state.moved;
  }
  rtcOccluded1(state.rays, &context.embree, &query);
  if (query.tfar < 0) return Obstacle::kOther;  // Embree sets it to minus infinity
  return context.may_be_own ? Obstacle::kPerhapsOwn : Obstacle::kNone;
}

bool Accelerator::may_touch(const Vec3& point, double radius_m) const {
  const State& state = *state_;
  NearQuery near{&state.shared().scene, point, radius_m};
  const auto search = [&](RTCScene scene) {
    const Vec3f at(point * state.space.per_unit);
    // The point is rounded.
    const double radius = radius_m * state.space.per_unit + 0x1p-22 * max_abs(at);
    RTCPointQuery query{at.x, at.y, at.z, 0, static_cast<float>(radius)};
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(scene, &query, &context, check_near, &near);
  };
  if (state.rays != nullptr) search(state.rays);
  near.set = nullptr;
  if (state.moved_scene != nullptr && !near.found) search(state.moved_scene.get());
  return near.found;
}

const GeometrySet& Accelerator::scene() const { return state_->scene; }
const GeometrySet& Accelerator::object(std::uint32_t i) const {
  return state_->shared().objects[i];
}
const GeometryInstance& Accelerator::instance(std::uint32_t i) const {
  return state_->shared().instances[i];
}

std::uint32_t Accelerator::object_count() const {
  return static_cast<std::uint32_t>(state_->shared().objects.size());
}

std::uint32_t Accelerator::instance_count() const {
  return static_cast<std::uint32_t>(state_->shared().instances.size());
}

// Tests Embree's scene and not its memory, which may be 0 bytes with a scene too.
bool Accelerator::empty() const { return state_->rays == nullptr; }

std::size_t Accelerator::bytes() const {
  std::size_t sum = static_cast<std::size_t>(state_->embree_bytes.load()) + state_->scene.bytes() +
                    state_->instances.capacity() * sizeof(GeometryInstance) +
                    state_->moving.capacity() * sizeof(MovingInstance);
  for (const GeometrySet& o : state_->objects) sum += o.bytes();
  return sum;
}

std::string Accelerator::isa() const { return state_->isa; }

absl::StatusOr<std::string> embree_kernels(const std::string& isa) {
  LUCERNA_ASSIGN_OR_RETURN(const auto empty, Accelerator::build({}, {}, {}, isa, {}));
  return fmt::format("{} {}", LUCERNA_EMBREE_VERSION, empty->isa());
}

}  // namespace lucerna
