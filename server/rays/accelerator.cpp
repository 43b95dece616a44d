#include "server/rays/accelerator.h"

#include <absl/status/status.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <mutex>
#include <utility>

#include "proto/common/status_macros.h"
#include "server/rays/ray_limits.h"
#include "server/rays/surface_table.h"
#include "server/rays/user_geometry.h"
#include "server/runtime/bits.h"
#include "server/runtime/denormals.h"
#include "server/runtime/isa.h"

namespace lucerna {
namespace {

std::optional<UnitRay> unit_ray(const Ray& ray, const RaySpace& space) {
  return lucerna::unit_ray(Vec3<double>(ray.origin), Vec3<double>(ray.direction), ray.t_min,
                           ray.t_max, space);
}

RTCRay embree_ray(const UnitRay& r) {
  RTCRay ray{};
  ray.org_x = r.origin.x, ray.org_y = r.origin.y, ray.org_z = r.origin.z;
  ray.dir_x = r.direction.x, ray.dir_y = r.direction.y, ray.dir_z = r.direction.z;
  ray.tnear = r.t_min, ray.tfar = r.t_max;
  ray.mask = ~0u;
  return ray;
}

/// The box of the set [m]; empty if the set is empty.
Bounds box_of(const GeometrySet& set) {
  Bounds box;
  for (const std::uint32_t v : set.triangles) box.add(Vec3<double>(set.vertices[v]));
  set.for_each_kind_of_surface([&](const auto& surfaces) {
    for (const auto& surface : surfaces) {
      const auto [lower, upper] = surface.bounds();
      box.add(lower), box.add(upper);
    }
  });
  return box;
}

double reach_of(const Bounds& box) {
  return box.empty() ? 0 : std::fmax(max_abs(box.lower), max_abs(box.upper));
}

/// Converts an object's units to the scene's units.
Transform in_units(const Transform& scene_from_object, double scene_unit_m, double object_unit_m) {
  const auto times = [](double s) { return *Transform::scale({s, s, s}); };
  return times(1 / scene_unit_m) * scene_from_object * times(object_unit_m);
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
  LoadBudget* budget = nullptr;  // only while it is built

  std::atomic<std::ptrdiff_t> embree_bytes = 0;
  std::mutex mutex;
  RTCError error = RTC_ERROR_NONE;  // the first error of Embree
  std::string message;

  // The data that callbacks point to: of the scene, then of each object.
  std::vector<std::array<AnalyticShapes, kHitKinds>> analytic;
  std::vector<MovingInstance> moving;
  DeviceHandle device;
  std::vector<SceneHandle> object_scenes;
  SceneHandle top;
  RaySpace space;  // of the scene
  std::vector<RaySpace> object_spaces;
  std::vector<Bounds> object_boxes;  // [m]

  absl::Status open(const std::string& wanted_isa);
  bool count(ssize_t bytes);
  absl::Status measure();
  SceneHandle commit(GeometrySet& set, std::array<AnalyticShapes, kHitKinds>& analytic,
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
  // Uses `max_isa=`, which only disables instructions.  `isa=` would enable instructions that the
  // machine may lack.
  config = fmt::format("max_isa={}", chosen->embree);
  device.reset(rtcNewDevice(config.c_str()));
  if (!device)
    // Each device takes keys of threads, and a process has 1024 of them.
    return absl::ResourceExhaustedError(
        fmt::format("Embree cannot open one more device (error {}), allowed: about 1000 scenes in "
                    "memory at once; release some",
                    static_cast<int>(rtcGetDeviceError(nullptr))));
  // Embree may be built without the kernels of the best instruction set, so check its properties.
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
      [](void* self, ssize_t bytes, bool) { return static_cast<State*>(self)->count(bytes); },
      this);
  return absl::OkStatus();
}

/// Counts memory that Embree is about to allocate, or has freed.  Returns false if the budget does
/// not have it: then Embree ends the build.
bool Accelerator::State::count(ssize_t bytes) {
  if (budget != nullptr && bytes > 0 && !budget->claim(static_cast<std::uint64_t>(bytes)).ok())
    return false;
  if (budget != nullptr && bytes < 0) budget->release(static_cast<std::uint64_t>(-bytes));
  embree_bytes += bytes;
  return true;
}

/// Computes the spaces of scene and objects, and scales vertices to their units.
absl::Status Accelerator::State::measure() {
  const auto rescale = [](GeometrySet& set, const RaySpace& in) {
    set.unit_m = in.unit_m;
    if (in.unit_m == 1) return;
    for (Vec3<float>& v : set.vertices) v = Vec3<float>(Vec3<double>(v) / in.unit_m);
  };
  for (GeometrySet& object : objects) {
    object_spaces.emplace_back(reach_of(object_boxes.emplace_back(box_of(object))));
    rescale(object, object_spaces.back());
  }
  Bounds all = box_of(scene);
  for (const GeometryInstance& instance : instances) {
    const Bounds& box = object_boxes[instance.object];
    Bounds placed;
    for (int corner = 0; corner < 8 && !box.empty(); ++corner)
      placed.add(instance.scene_from_object.point({corner & 1 ? box.upper.x : box.lower.x,
                                                   corner & 2 ? box.upper.y : box.lower.y,
                                                   corner & 4 ? box.upper.z : box.lower.z}));
    if (placed.empty()) continue;
    const auto [lower, upper] = instance.motion
                                    ? instance.motion->bounds(placed.lower, placed.upper)
                                    : std::pair{placed.lower, placed.upper};
    all.add(lower), all.add(upper);
  }
  space = RaySpace(reach_of(all));
  rescale(scene, space);
  double magnified = 1;
  for (std::size_t i = 0; i < instances.size(); ++i) {
    if (instances[i].motion) continue;
    const double m = magnification(in_units(instances[i].scene_from_object, space.unit_m,
                                            object_spaces[instances[i].object].unit_m));
    if (!(m < 0x1p40))
      return absl::InvalidArgumentError(
          fmt::format("instance {} has {:g} times the size of the scene, allowed: at least {:g}", i,
                      1 / m, 0x1p-40));
    magnified = std::max(magnified, m);
  }
  // Keeps directions below Embree's 1.8e18 in every object's space.
  space.direction_exponent = std::min(space.direction_exponent, 57 - std::ilogb(magnified));
  return absl::OkStatus();
}

RTCGeometry Accelerator::State::resting(const GeometryInstance& instance) const {
  RTCGeometry g = rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(g, object_scenes[instance.object].get());
  const Transform to_scene =
      in_units(instance.scene_from_object, space.unit_m, object_spaces[instance.object].unit_m);
  std::array<float, 12> rows{};
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 4; ++c) rows[4 * r + c] = static_cast<float>(to_scene.matrix()[r][c]);
  rtcSetGeometryTransform(g, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, rows.data());
  return g;
}

SceneHandle Accelerator::State::commit(GeometrySet& set,
                                       std::array<AnalyticShapes, kHitKinds>& shapes,
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
    // Embree reads 16 bytes of each 12-byte vertex, so the last one needs room after it.
    set.vertices.reserve(set.vertices.size() + 1);
    RTCGeometry g = rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, set.vertices.data(),
                               0, sizeof(Vec3<float>), set.vertices.size());
    if (set.wide.empty()) {
      rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                 set.triangles.data(), 0, 3 * sizeof(std::uint32_t),
                                 set.triangles.size() / 3);
    } else {
      // Wide triangles keep their numbers here, but shrink to points, which no ray meets.
      auto* indices = static_cast<std::uint32_t*>(
          rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                  3 * sizeof(std::uint32_t), set.triangles.size() / 3));
      if (indices != nullptr) {  // else Embree has no memory, which status() reports
        std::ranges::copy(set.triangles, indices);
        for (const WideTriangle& w : set.wide)
          std::fill_n(indices + 3 * std::size_t{w.triangle}, 3,
                      indices[3 * std::size_t{w.triangle}]);
      }
    }
    check_along(g, &set);
    attach(g, static_cast<unsigned>(HitKind::kTriangle));
    if (!set.wide.empty()) attach(wide_geometry(device.get(), &set), kWide);
  }
  const auto counts = set.counts();
  for (unsigned kind = 1; kind < kHitKinds; ++kind) {
    if (counts[kind] == 0) continue;
    shapes[kind] = {&set, static_cast<HitKind>(kind)};
    attach(analytic_geometry(device.get(), &shapes[kind], counts[kind]), kind);
  }
  for (std::size_t i = 0; with_instances && i < instances.size(); ++i) {
    const GeometryInstance& instance = instances[i];
    const unsigned number = kFirstInstance + static_cast<unsigned>(i);
    if (instance.motion == nullptr) {
      attach(resting(instance), number);
      continue;
    }
    moving.emplace_back(instance, object_scenes[instance.object].get(),
                        object_spaces[instance.object], object_boxes[instance.object], space.unit_m,
                        number);
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
  if (error == RTC_ERROR_OUT_OF_MEMORY && budget != nullptr && !budget->refusal().ok())
    return budget->refusal();
  if (error == RTC_ERROR_OUT_OF_MEMORY)
    return absl::ResourceExhaustedError("no memory for the bounding volume hierarchy");
  if (error != RTC_ERROR_NONE) return absl::InternalError(fmt::format("Embree: {}", message));
  return absl::OkStatus();
}

Accelerator::Accelerator(std::unique_ptr<State> state) : state_(std::move(state)) {}
Accelerator::~Accelerator() = default;

absl::StatusOr<std::unique_ptr<Accelerator>> Accelerator::build(
    GeometrySet scene, std::vector<GeometrySet> objects, std::vector<GeometryInstance> instances,
    const std::string& isa, std::stop_token stop, LoadBudget* budget) {
  const DenormalsAreZero denormals;
  auto state = std::make_unique<State>();
  state->scene = std::move(scene);
  state->objects = std::move(objects);
  state->instances = std::move(instances);
  state->stop = std::move(stop);
  state->budget = budget;
  LUCERNA_RETURN_IF_ERROR(state->measure());
  LUCERNA_RETURN_IF_ERROR(state->open(isa));
  if (state->scene.empty() && state->instances.empty()) {
    // Without geometry, only the name of the kernels is needed.
    state->device.reset();
    LUCERNA_RETURN_IF_ERROR(state->status());
    state->budget = nullptr;
    return std::unique_ptr<Accelerator>(new Accelerator(std::move(state)));
  }
  state->analytic.resize(1 + state->objects.size());
  for (std::size_t i = 0; i < state->objects.size(); ++i) {
    auto& scene = state->object_scenes.emplace_back();
    if (state->objects[i].empty()) continue;  // no instance uses it
    scene = state->commit(state->objects[i], state->analytic[1 + i], false);
    LUCERNA_RETURN_IF_ERROR(state->status());
  }
  state->top = state->commit(state->scene, state->analytic[0], true);
  LUCERNA_RETURN_IF_ERROR(state->status());
  state->budget = nullptr;
  return std::unique_ptr<Accelerator>(new Accelerator(std::move(state)));
}

std::optional<RawHit> Accelerator::closest_hit(const Ray& ray, Meets meets) const {
  if (state_->top == nullptr) return std::nullopt;
  const std::optional<UnitRay> start = unit_ray(ray, state_->space);
  if (!start) return std::nullopt;
  alignas(16) RTCRayHit query;
  query.ray = embree_ray(*start);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  QueryContext context(ray.time_s, start->t_max, meets, state_->instances.data());
  rtcIntersect1(state_->top.get(), &context.embree, &query);
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

std::vector<RawHit> Accelerator::all_hits(const Ray& ray, Meets meets) const {
  std::vector<RawHit> hits;
  if (state_->top == nullptr) return hits;
  const std::optional<UnitRay> start = unit_ray(ray, state_->space);
  if (!start) return hits;
  alignas(16) RTCRayHit query;
  query.ray = embree_ray(*start);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  QueryContext context(ray.time_s, start->t_max, meets, state_->instances.data());
  context.kept = &hits;
  rtcIntersect1(state_->top.get(), &context.embree, &query);
  return hits;
}

bool Accelerator::occluded(const Ray& ray, Meets meets) const {
  if (state_->top == nullptr) return false;
  const std::optional<UnitRay> start = unit_ray(ray, state_->space);
  if (!start) return false;
  alignas(16) RTCRay query = embree_ray(*start);
  QueryContext context(ray.time_s, start->t_max, meets, state_->instances.data());
  rtcOccluded1(state_->top.get(), &context.embree, &query);
  return query.tfar < 0;  // Embree sets it to minus infinity
}

void Accelerator::occluded(std::span<const Ray> rays, std::span<std::uint8_t> bits,
                           Meets meets) const {
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (i % 8 == 0) bits[i / 8] = 0;
    if (occluded(rays[i], meets)) set_bit(bits.data(), i);
  }
}

const GeometrySet& Accelerator::scene() const { return state_->scene; }
const GeometrySet& Accelerator::object(std::uint32_t i) const { return state_->objects[i]; }
const GeometryInstance& Accelerator::instance(std::uint32_t i) const {
  return state_->instances[i];
}

std::uint32_t Accelerator::object_count() const {
  return static_cast<std::uint32_t>(state_->objects.size());
}

std::uint32_t Accelerator::instance_count() const {
  return static_cast<std::uint32_t>(state_->instances.size());
}

// Tests Embree's scene and not its memory, which may be 0 bytes with a scene too.
bool Accelerator::empty() const { return state_->top == nullptr; }

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
