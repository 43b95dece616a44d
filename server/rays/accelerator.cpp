#include "server/rays/accelerator.h"

#include <fmt/format.h>

#include <cstring>
#include <utility>

#include "proto/common/status_macros.h"
#include "server/rays/accelerator_state.h"

namespace lucerna {
namespace {

std::optional<UnitRay> unit_ray(const Ray& ray, const RaySpace& space) {
  return lucerna::unit_ray(Vec3<double>(ray.origin), Vec3<double>(ray.direction), ray.t_min,
                           ray.t_max, space);
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

}  // namespace

Accelerator::Accelerator(std::unique_ptr<State> state) : state_(std::move(state)) {}
Accelerator::~Accelerator() = default;

std::optional<RawHit> Accelerator::closest_hit(const Ray& ray, Meets meets) const {
  const State& state = *state_;
  if (state.rays == nullptr) return std::nullopt;
  const std::optional<UnitRay> start = unit_ray(ray, state.space);
  if (!start) return std::nullopt;
  alignas(16) RTCRayHit query;
  set_ray(query.ray, *start);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  QueryContext context(ray.time_s, start->t_max, meets, state.placed);
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
  } else if (query.hit.geomID >= kFirstInstance) {  // else a wide triangle, with its number
    const PrimitiveRange& range = moved[query.hit.geomID - kFirstInstance];
    query.hit.geomID = static_cast<unsigned>(range.kind);
    query.hit.primID += range.first;
  }
}

std::vector<RawHit> Accelerator::all_hits(const Ray& ray, Meets meets) const {
  const State& state = *state_;
  std::vector<RawHit> hits;
  if (state.rays == nullptr) return hits;
  const std::optional<UnitRay> start = unit_ray(ray, state.space);
  if (!start) return hits;
  alignas(16) RTCRayHit query;
  set_ray(query.ray, *start);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  QueryContext context(ray.time_s, start->t_max, meets, state.placed);
  context.kept = &hits;
  if (state.moved_scene == nullptr)
    rtcIntersect1(state.rays, &context.embree, &query);
  else
    state.intersect_all(context, query);
  return hits;
}

bool Accelerator::occluded(const Ray& ray, Meets meets) const {
  return obstacle(ray, {}, meets) != Obstacle::kNone;
}

Obstacle Accelerator::obstacle(const Ray& ray, const LooseEnds& ends, Meets meets) const {
  const State& state = *state_;
  if (state.rays == nullptr) return Obstacle::kNone;
  const std::optional<UnitRay> start = unit_ray(ray, state.space);
  if (!start) return Obstacle::kNone;
  alignas(16) RTCRay query;
  set_ray(query, *start);
  QueryContext context(ray.time_s, start->t_max, meets, state.placed);
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
