#include "server/accelerator.h"

#include <absl/status/status.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <mutex>
#include <utility>

#include "server/denormals.h"
#include "server/isa.h"
#include "server/ray_limits.h"
#include "server/user_geometry.h"

namespace lucerna {
namespace {

// Geometry numbers within an Embree scene; instances follow in the top one.
enum GeometryId : unsigned {
  kTriangles = 0,
  kPatches,
  kSpheres,
  kDisks,
  kCylinders,
  kMoving,
  kFirstInstance
};

// A ray as Embree takes it: its direction made `units` times as long, so t is in as many times the
// unit.
struct EmbreeRay {
  alignas(16) RTCRay ray;
  float units;
};

// Nothing where the ray is none.
std::optional<EmbreeRay> embree_ray(const Ray& r, const RayLimits& limits) {
  const float longest = max_abs(r.direction);
  if (!(max_abs(r.origin) < limits.max_origin) || !is_finite(r.origin) || !is_finite(r.direction) ||
      !(longest > 0) || std::isnan(r.t_min) || std::isnan(r.t_max))
    return std::nullopt;
  EmbreeRay e{};
  // Exact, in two steps: the factor itself may not fit.
  const int shift = limits.direction_exponent - std::ilogb(longest);
  const float half = std::scalbn(1.0f, shift / 2), rest = std::scalbn(1.0f, shift - shift / 2);
  e.units = half * rest;
  e.ray.org_x = r.origin.x, e.ray.org_y = r.origin.y, e.ray.org_z = r.origin.z;
  e.ray.dir_x = r.direction.x * half * rest;
  e.ray.dir_y = r.direction.y * half * rest;
  e.ray.dir_z = r.direction.z * half * rest;
  e.ray.tnear = r.t_min / half / rest;
  e.ray.tfar = r.t_max / half / rest;
  e.ray.mask = ~0u;
  return e;
}

struct SceneDeleter {
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};
struct DeviceDeleter {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
};
using SceneHandle = std::unique_ptr<std::remove_pointer_t<RTCScene>, SceneDeleter>;
using DeviceHandle = std::unique_ptr<std::remove_pointer_t<RTCDevice>, DeviceDeleter>;

}  // namespace

struct Accelerator::State {
  GeometrySet scene;
  std::vector<GeometrySet> objects;
  std::vector<GeometryInstance> instances;
  std::string isa;
  std::stop_token stop;

  std::atomic<std::ptrdiff_t> embree_bytes = 0;
  std::mutex mutex;
  RTCError error = RTC_ERROR_NONE;  // the first that Embree reported
  std::string message;

  // What callbacks point to: of the scene, then of each object.
  std::vector<std::array<AnalyticShapes, 4>> analytic;
  std::vector<MovingInstance> moving;
  DeviceHandle device;
  std::vector<SceneHandle> object_scenes;
  SceneHandle top;
  RayLimits limits;

  absl::Status open(const std::string& wanted_isa);
  SceneHandle commit(GeometrySet& set, std::array<AnalyticShapes, 4>& analytic,
                     bool with_instances);
  RTCGeometry resting(const GeometryInstance& instance) const;
  absl::Status status() const;
};

absl::Status Accelerator::State::open(const std::string& wanted) {
  std::string config;
  const InstructionSet* chosen = nullptr;
  std::string have;
  for (const InstructionSet& i : instruction_sets()) {
    if (!i.supported()) continue;
    have += fmt::format("{}\"{}\"", have.empty() ? "" : ", ", i.name);
    if (wanted.empty() || wanted == i.name) chosen = &i;
  }
  if (chosen == nullptr)
    return absl::InvalidArgumentError(
        fmt::format("isa = \"{}\", allowed on this machine: {}", wanted, have));
  // Not `isa=`, which would switch on what the machine may lack; `max_isa=` only takes away.
  config = fmt::format("max_isa={}", chosen->embree);
  device.reset(rtcNewDevice(config.c_str()));
  if (!device)
    return absl::InternalError(fmt::format("Embree opens no device (error {})",
                                           static_cast<int>(rtcGetDeviceError(nullptr))));
  // Embree may have been built without the kernels of the best instruction set: ask what it uses.
  const bool wide16 =
      rtcGetDeviceProperty(device.get(), RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED) != 0;
  const bool wide8 =
      rtcGetDeviceProperty(device.get(), RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED) != 0;
  isa = chosen->name;
  if (isa == "avx512" && !wide16) isa = "avx2";
  if (isa.starts_with("avx") && !wide8) isa = "sse4.2";
  if (!wanted.empty() && isa != wanted)
    return absl::InvalidArgumentError(
        fmt::format("isa = \"{}\" is not compiled into this Embree", wanted));
  rtcSetDeviceErrorFunction(
      device.get(),
      [](void* self, RTCError code, const char* text) {
        auto& state = *static_cast<State*>(self);
        const std::lock_guard lock(state.mutex);
        if (state.error != RTC_ERROR_NONE) return;
        state.error = code;
        state.message = text ? text : "";
      },
      this);
  rtcSetDeviceMemoryMonitorFunction(
      device.get(),
      [](void* self, ssize_t bytes, bool) {
        static_cast<State*>(self)->embree_bytes += bytes;
        return true;
      },
      this);
  return absl::OkStatus();
}

RTCGeometry Accelerator::State::resting(const GeometryInstance& instance) const {
  RTCGeometry g = rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(g, object_scenes[instance.object].get());
  std::array<float, 12> rows{};
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 4; ++c)
      rows[4 * r + c] = static_cast<float>(instance.scene_from_object.matrix()[r][c]);
  rtcSetGeometryTransform(g, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, rows.data());
  return g;
}

SceneHandle Accelerator::State::commit(GeometrySet& set, std::array<AnalyticShapes, 4>& shapes,
                                       bool with_instances) {
  SceneHandle handle(rtcNewScene(device.get()));
  RTCScene s = handle.get();
  rtcSetSceneFlags(s, RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(s, RTC_BUILD_QUALITY_HIGH);
  const auto attach = [&](RTCGeometry geometry, unsigned id) {
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(s, geometry, id);
    rtcReleaseGeometry(geometry);
  };
  if (!set.triangles.empty()) {
    // Embree reads 16 bytes of each 12-byte vertex: the last one needs room behind it.
    set.vertices.reserve(set.vertices.size() + 1);
    RTCGeometry g = rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, set.vertices.data(),
                               0, sizeof(Vec3<float>), set.vertices.size());
    rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, set.triangles.data(),
                               0, 3 * sizeof(std::uint32_t), set.triangles.size() / 3);
    attach(g, kTriangles);
  }
  shapes = {{{&set, HitKind::kPatch},
             {&set, HitKind::kSphere},
             {&set, HitKind::kDisk},
             {&set, HitKind::kCylinder}}};
  const std::array<std::size_t, 4> counts{set.patches.size(), set.spheres.size(), set.disks.size(),
                                          set.cylinders.size()};
  for (unsigned i = 0; i < 4; ++i) {
    if (counts[i] > 0) attach(analytic_geometry(device.get(), &shapes[i], counts[i]), kPatches + i);
  }
  for (std::size_t i = 0; with_instances && i < instances.size(); ++i) {
    const GeometryInstance& instance = instances[i];
    const unsigned number = kFirstInstance + static_cast<unsigned>(i);
    if (instance.motion == nullptr) {
      attach(resting(instance), number);
      continue;
    }
    RTCBounds bounds;
    rtcGetSceneBounds(object_scenes[instance.object].get(), &bounds);
    moving.emplace_back(instance, object_scenes[instance.object].get(), bounds, number);
  }
  if (with_instances && !moving.empty()) attach(moving_geometry(device.get(), &moving), kMoving);
  rtcSetSceneProgressMonitorFunction(
      s, [](void* self, double) { return !static_cast<State*>(self)->stop.stop_requested(); },
      this);
  rtcCommitScene(s);
  return handle;
}

absl::Status Accelerator::State::status() const {
  if (stop.stop_requested() || error == RTC_ERROR_CANCELLED)
    return absl::CancelledError("the build of the scene was cancelled");
  if (error == RTC_ERROR_OUT_OF_MEMORY)
    return absl::ResourceExhaustedError("no memory for the bounding volume hierarchy");
  if (error != RTC_ERROR_NONE) return absl::InternalError(fmt::format("Embree: {}", message));
  return absl::OkStatus();
}

Accelerator::Accelerator(std::unique_ptr<State> state) : state_(std::move(state)) {}
Accelerator::~Accelerator() = default;

absl::StatusOr<std::unique_ptr<Accelerator>> Accelerator::build(
    GeometrySet scene, std::vector<GeometrySet> objects, std::vector<GeometryInstance> instances,
    const std::string& isa, std::stop_token stop) {
  const DenormalsAreZero denormals;
  auto state = std::make_unique<State>();
  state->scene = std::move(scene);
  state->objects = std::move(objects);
  state->instances = std::move(instances);
  state->stop = std::move(stop);
  double magnified = 1;
  for (std::size_t i = 0; i < state->instances.size(); ++i) {
    const double m = magnification(state->instances[i].scene_from_object);
    if (!(m < 0x1p40))
      return absl::InvalidArgumentError(
          fmt::format("instance {} shrinks its object by {:g}, allowed up to {:g}", i, m, 0x1p40));
    // A rotation turns the diagonal of a box into an axis.
    magnified = std::max(magnified, state->instances[i].motion == nullptr ? m : 2 * m);
  }
  if (absl::Status s = state->open(isa); !s.ok()) return s;
  state->analytic.resize(1 + state->objects.size());
  for (std::size_t i = 0; i < state->objects.size(); ++i) {
    state->object_scenes.push_back(state->commit(state->objects[i], state->analytic[1 + i], false));
    if (absl::Status s = state->status(); !s.ok()) return s;
  }
  state->top = state->commit(state->scene, state->analytic[0], true);
  if (absl::Status s = state->status(); !s.ok()) return s;
  RTCBounds bounds;
  rtcGetSceneBounds(state->top.get(), &bounds);
  const float extent = std::max({bounds.upper_x - bounds.lower_x, bounds.upper_y - bounds.lower_y,
                                 bounds.upper_z - bounds.lower_z});
  state->limits = limits_for(extent, magnified);
  return std::unique_ptr<Accelerator>(new Accelerator(std::move(state)));
}

std::optional<RawHit> Accelerator::closest_hit(const Ray& ray) const {
  const std::optional<EmbreeRay> start = embree_ray(ray, state_->limits);
  if (!start) return std::nullopt;
  alignas(16) RTCRayHit query;
  query.ray = start->ray;
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  QueryContext context(ray.time_s);
  rtcIntersect1(state_->top.get(), &context.embree, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  RawHit hit;
  hit.t = query.ray.tfar * start->units;
  hit.kind = static_cast<HitKind>(query.hit.geomID);
  hit.primitive = query.hit.primID;
  if (query.hit.instID[0] != RTC_INVALID_GEOMETRY_ID)
    hit.instance = static_cast<std::int32_t>(query.hit.instID[0] - kFirstInstance);
  hit.uv = {query.hit.u, query.hit.v};
  if (hit.kind != HitKind::kTriangle) hit.position = context.position, hit.normal = context.normal;
  return hit;
}

bool Accelerator::occluded(const Ray& ray) const {
  std::optional<EmbreeRay> query = embree_ray(ray, state_->limits);
  if (!query) return false;
  QueryContext context(ray.time_s);
  rtcOccluded1(state_->top.get(), &context.embree, &query->ray);
  return query->ray.tfar < 0;  // Embree sets it to minus infinity
}

void Accelerator::occluded(std::span<const Ray> rays, std::span<std::uint8_t> bits) const {
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const auto bit = static_cast<std::uint8_t>(1u << (i % 8));
    if (i % 8 == 0) bits[i / 8] = 0;
    if (occluded(rays[i])) bits[i / 8] |= bit;
  }
}

const GeometrySet& Accelerator::scene() const { return state_->scene; }
const GeometrySet& Accelerator::object(std::uint32_t i) const { return state_->objects[i]; }
const GeometryInstance& Accelerator::instance(std::uint32_t i) const {
  return state_->instances[i];
}

bool Accelerator::empty() const { return state_->scene.empty() && state_->instances.empty(); }

std::size_t Accelerator::bytes() const {
  std::size_t sum = static_cast<std::size_t>(state_->embree_bytes.load()) + state_->scene.bytes() +
                    state_->instances.capacity() * sizeof(GeometryInstance) +
                    state_->moving.capacity() * sizeof(MovingInstance);
  for (const GeometrySet& o : state_->objects) sum += o.bytes();
  return sum;
}

std::string Accelerator::isa() const { return state_->isa; }

}  // namespace lucerna
