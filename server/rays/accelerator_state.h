// What an Accelerator holds.  Only the sources of this room that name Embree include it.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <vector>

#include "server/rays/accelerator.h"
#include "server/rays/ray_limits.h"
#include "server/rays/surface_table.h"
#include "server/rays/user_geometry.h"

namespace lucerna {

struct SceneDeleter {
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};
struct DeviceDeleter {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
};
using SceneHandle = std::unique_ptr<std::remove_pointer_t<RTCScene>, SceneDeleter>;
using DeviceHandle = std::unique_ptr<std::remove_pointer_t<RTCDevice>, DeviceDeleter>;

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
  std::mutex edits;  // held while with_moved() builds for this device

  // The data that callbacks point to: of the scene, then of each object.  Wide triangles are last.
  using Primitives = std::array<PrimitivesOfSet, kHitKinds + 1>;
  std::vector<Primitives> primitives;
  std::vector<MovingInstance> moving;
  DeviceHandle device;
  std::vector<SceneHandle> object_scenes;
  SceneHandle top;
  RaySpace space;                            // of the scene
  RTCScene rays = nullptr;                   // what rays meet: `top`, or that of `still`
  const GeometryInstance* placed = nullptr;  // the same for `instances`
  std::vector<RaySpace> object_spaces;
  std::vector<Bounds> object_boxes;  // [m]

  absl::Status open(const std::string& wanted_isa);
  bool count(ssize_t bytes);
  absl::Status measure();
  Bounds whole(const GeometrySet& set) const;
  SceneHandle commit(GeometrySet& set, Primitives& primitives, bool with_instances);
  SceneHandle commit_moved();
  RTCGeometry resting(const GeometryInstance& instance) const;
  absl::Status status() const;
  void intersect_all(QueryContext& context, RTCRayHit& query) const;

  // Of an accelerator with moved primitives.  It has no device and no scenes for what it shares.
  std::shared_ptr<const Accelerator> still;
  const State& shared() const { return still != nullptr ? *still->state_ : *this; }
  std::vector<PrimitiveRange> moved;              // in order
  std::vector<PrimitivesOfSet> moved_primitives;  // as `moved`, then the large triangles among them
  SceneHandle moved_scene;                        // geometry kFirstInstance + i: range i
};

}  // namespace lucerna
