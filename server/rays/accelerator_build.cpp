// Builds Embree's scenes.
#include <absl/status/status.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "lights/maths/stop_poll.h"
#include "proto/common/status_macros.h"
#include "server/rays/accelerator_state.h"
#include "server/runtime/denormals.h"
#include "server/runtime/isa.h"

namespace lucerna {
namespace {

/// Adds a primitive of the set [m].
void add_primitive(const GeometrySet& set, HitKind kind, std::uint32_t number, Bounds& box) {
  if (kind == HitKind::kTriangle) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t v = set.triangles[3 * std::size_t{number} + k];
      box.add(Vec3(set.vertices[v]) * set.unit_m);
    }
    return;
  }
  const std::pair<Vec3, Vec3> own =
      set.visit_surface(kind, number, [](const auto& surface) { return surface.bounds(); });
  box.add(own.first), box.add(own.second);
}

/// The box of the set [m]; empty if the set is empty.
Bounds box_of(const GeometrySet& set) {
  Bounds box;
  const auto counts = set.counts();
  for (std::size_t kind = 0; kind < kHitKinds; ++kind)
    for (std::uint32_t i = 0; i < counts[kind]; ++i)
      add_primitive(set, static_cast<HitKind>(kind), i, box);
  return box;
}

/// The box of those primitives of the set that are in the ranges [m].
Bounds box_of(const GeometrySet& set, const std::vector<PrimitiveRange>& ranges) {
  Bounds box;
  const auto counts = set.counts();
  StopPoll poll;
  for (const PrimitiveRange& range : ranges) {
    const auto end = static_cast<std::uint32_t>(std::min<std::size_t>(
        counts[static_cast<std::size_t>(range.kind)], std::size_t{range.first} + range.count));
    for (std::uint32_t i = range.first; i < end; ++i, poll())
      add_primitive(set, range.kind, i, box);
  }
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

}  // namespace

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

/// The box of the set and of all instances [m].
Bounds Accelerator::State::whole(const GeometrySet& set) const {
  Bounds all = box_of(set);
  StopPoll poll;
  for (const GeometryInstance& instance : instances) {
    poll();
    const Bounds& box = object_boxes[instance.object];
    if (box.empty()) continue;
    Bounds placed;
    for (const Vec3& corner : box.corners()) placed.add(instance.scene_from_object.point(corner));
    if (placed.empty()) continue;
    const auto [lower, upper] = instance.motion
                                    ? instance.motion->bounds(placed.lower, placed.upper)
                                    : std::pair{placed.lower, placed.upper};
    all.add(lower), all.add(upper);
  }
  return all;
}

/// Computes the spaces of scene and objects, and scales vertices to their units.
absl::Status Accelerator::State::measure() {
  const auto rescale = [](GeometrySet& set, const RaySpace& in) {
    set.unit_m = in.unit_m;
    if (in.unit_m == 1) return;
    StopPoll poll;
    for (Vec3f& v : set.vertices) poll(), v = Vec3f(Vec3(v) / in.unit_m);
  };
  for (GeometrySet& object : objects) {
    object_spaces.emplace_back(reach_of(object_boxes.emplace_back(box_of(object))));
    rescale(object, object_spaces.back());
  }
  space = RaySpace(reach_of(whole(scene)));
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

SceneHandle Accelerator::State::commit(GeometrySet& set, Primitives& primitives,
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
                               0, sizeof(Vec3f), set.vertices.size());
    if (set.large.empty()) {
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
        for (const LargeTriangle& w : set.large)
          std::fill_n(indices + 3 * std::size_t{w.triangle}, 3,
                      indices[3 * std::size_t{w.triangle}]);
      }
    }
    primitives[0] = {&set, HitKind::kTriangle};
    check_along(g, &primitives[0]);
    attach(g, static_cast<unsigned>(HitKind::kTriangle));
    primitives[kWide] = primitives[0];
    if (!set.large.empty())
      attach(large_geometry(device.get(), &primitives[kWide], set.large.size()), kWide);
  }
  const auto counts = set.counts();
  for (unsigned kind = 1; kind < kHitKinds; ++kind) {
    if (counts[kind] == 0) continue;
    primitives[kind] = {&set, static_cast<HitKind>(kind)};
    attach(analytic_geometry(device.get(), &primitives[kind], counts[kind]), kind);
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
  state->primitives.resize(1 + state->objects.size());
  for (std::size_t i = 0; i < state->objects.size(); ++i) {
    auto& scene = state->object_scenes.emplace_back();
    if (state->objects[i].empty()) continue;  // no instance uses it
    scene = state->commit(state->objects[i], state->primitives[1 + i], false);
    LUCERNA_RETURN_IF_ERROR(state->status());
  }
  state->top = state->commit(state->scene, state->primitives[0], true);
  LUCERNA_RETURN_IF_ERROR(state->status());
  state->rays = state->top.get();
  state->placed = state->instances.data();
  state->budget = nullptr;
  state->stop = {};
  return std::unique_ptr<Accelerator>(new Accelerator(std::move(state)));
}

/// A scene of the moved primitives, for the device of `still`.
SceneHandle Accelerator::State::commit_moved() {
  const RTCDevice of = shared().device.get();
  SceneHandle handle(rtcNewScene(of));
  RTCScene s = handle.get();
  rtcSetSceneFlags(s, RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(s, RTC_BUILD_QUALITY_HIGH);
  unsigned number = kFirstInstance;
  const auto attach = [&](RTCGeometry geometry) {
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(s, geometry, number++);
    rtcReleaseGeometry(geometry);
  };
  for (const PrimitiveRange& range : moved)
    moved_primitives.push_back({&scene, range.kind, range.first});
  const auto large_of = [this](const PrimitiveRange& range) {
    const auto from =
        std::ranges::lower_bound(scene.large, range.first, {}, &LargeTriangle::triangle);
    const auto to = std::ranges::lower_bound(from, scene.large.end(), range.first + range.count, {},
                                             &LargeTriangle::triangle);
    return std::span(from, to);
  };
  std::vector<std::size_t> large_counts;
  for (const PrimitiveRange& range : moved) {
    if (range.kind != HitKind::kTriangle) continue;
    const auto large = large_of(range);
    moved_primitives.push_back({&scene, HitKind::kTriangle,
                                static_cast<std::uint32_t>(large.data() - scene.large.data())});
    large_counts.push_back(large.size());
  }
  // From here on the vector keeps its place, to which callbacks refer.
  PrimitivesOfSet* large_primitives = moved_primitives.data() + moved.size();
  for (std::size_t i = 0; i < moved.size(); ++i) {
    const PrimitiveRange& range = moved[i];
    if (range.kind != HitKind::kTriangle) {
      attach(analytic_geometry(of, &moved_primitives[i], range.count));
      continue;
    }
    RTCGeometry g = rtcNewGeometry(of, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                               scene.vertices.data(), 0, sizeof(Vec3f), scene.vertices.size());
    auto* indices = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
        g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), range.count));
    if (indices != nullptr) {  // else Embree has no memory, which status() reports
      std::copy_n(&scene.triangles[3 * std::size_t{range.first}], 3 * std::size_t{range.count},
                  indices);
      for (const LargeTriangle& w : large_of(range)) {
        std::uint32_t* const corners = indices + 3 * std::size_t{w.triangle - range.first};
        std::fill_n(corners, 3, corners[0]);
      }
    }
    check_along(g, &moved_primitives[i]);
    attach(g);
  }
  for (const std::size_t count : large_counts) {
    if (count > 0) attach(large_geometry(of, large_primitives, count));
    ++large_primitives;
  }
  rtcCommitScene(s);
  return handle;
}

absl::StatusOr<std::shared_ptr<const Accelerator>> Accelerator::with_moved(
    std::shared_ptr<const Accelerator> still, GeometrySet scene,
    std::vector<PrimitiveRange> moved) {
  const DenormalsAreZero denormals;
  State& shared = *still->state_;
  auto state = std::make_unique<State>();
  state->isa = shared.isa;
  state->scene = std::move(scene);
  state->scene.vertices.reserve(state->scene.vertices.size() + 1);  // Embree reads beyond the last
  state->moved = std::move(moved);
  std::ranges::sort(state->moved, is_before);
  // Others reach as far as before, unless it was these that reached farthest.
  const double others = shared.space.reach_m;
  const bool is_farthest = reach_of(box_of(shared.scene, state->moved)) >= others;
  state->space =
      RaySpace(is_farthest ? reach_of(shared.whole(state->scene))
                           : std::fmax(others, reach_of(box_of(state->scene, state->moved))));
  if (state->space.unit_m != shared.space.unit_m) return std::shared_ptr<const Accelerator>();
  state->space.direction_exponent = shared.space.direction_exponent;
  state->rays = shared.rays;
  state->placed = shared.placed;
  state->still = std::move(still);
  // One at a time, so that the error and the memory are those of this build.
  const std::lock_guard one(shared.edits);
  {
    const std::lock_guard lock(shared.mutex);
    shared.error = RTC_ERROR_NONE;
  }
  const std::ptrdiff_t before = shared.embree_bytes;
  state->moved_scene = state->commit_moved();
  LUCERNA_RETURN_IF_ERROR(shared.status());
  // Too little if another thread frees edited surfaces meanwhile.
  state->embree_bytes = std::max<std::ptrdiff_t>(shared.embree_bytes - before, 0);
  return std::shared_ptr<const Accelerator>(new Accelerator(std::move(state)));
}

}  // namespace lucerna
