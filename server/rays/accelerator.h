// Embree behind one small class; accelerator.cpp and user_geometry.{h,cpp} alone include it.
#pragma once

#include <absl/status/statusor.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "lights/maths/motion.h"
#include "lights/maths/transform.h"
#include "lights/shapes/bilinear_patch.h"
#include "lights/shapes/cylinder.h"
#include "lights/shapes/disk.h"
#include "lights/shapes/sphere.h"
#include "server/rays/ray.h"

namespace lucerna {

/// Everything that rays can hit, in one space (the scene's, or an object's).  Each kind is numbered
/// by itself, in order.
struct GeometrySet {
  std::vector<Vec3<float>> vertices{};     ///< [m]; within an Accelerator in units of `unit_m`
  std::vector<std::uint32_t> triangles{};  ///< three vertex numbers a triangle
  std::vector<BilinearPatch<double>> patches{};
  std::vector<Sphere<double>> spheres{};
  std::vector<Disk<double>> disks{};
  std::vector<Cylinder<double>> cylinders{};
  /// Of the space in which Embree has it (ray_limits.h); the Accelerator chooses it.
  double unit_m = 1;

  bool empty() const {
    return triangles.empty() && patches.empty() && spheres.empty() && disks.empty() &&
           cylinders.empty();
  }
  std::size_t bytes() const {
    const auto of = [](const auto& v) { return v.capacity() * sizeof v[0]; };
    return of(vertices) + of(triangles) + of(patches) + of(spheres) + of(disks) + of(cylinders);
  }
};

struct GeometryInstance {
  std::uint32_t object;
  /// Where it moves: to the coordinates that `motion` starts from.
  Transform scene_from_object;
  std::shared_ptr<const Motion> motion{};  ///< to the scene's coordinates; null: it rests
};

enum class HitKind : std::uint8_t { kTriangle, kPatch, kSphere, kDisk, kCylinder };

struct RawHit {
  float t{};
  HitKind kind{};
  std::uint32_t primitive{};   ///< within its kind, within its GeometrySet
  std::int32_t instance = -1;  ///< which instance; -1: the scene's own geometry
  Vec2<float> uv;              ///< triangle: barycentrics of vertices 1 and 2; patch: (u, v)
  /// All but triangles: the point hit and its unit normal, in the space of the GeometrySet.
  Vec3<double> position, normal;
};

/// Immutable once built; all const members may be called from any thread.
class Accelerator {
 public:
  /// Takes over `scene` and `objects`.  `isa` names the kernels ("" : the best the machine has;
  /// "sse2", "sse4.2", "avx", "avx2", "avx512").  Errors: CANCELLED where `stop` was asked for,
  /// RESOURCE_EXHAUSTED where Embree had no memory, INVALID_ARGUMENT for an isa the machine lacks
  /// and for instances that are 2^40 times smaller than the scene.
  static absl::StatusOr<std::unique_ptr<Accelerator>> build(GeometrySet scene,
                                                            std::vector<GeometrySet> objects,
                                                            std::vector<GeometryInstance> instances,
                                                            const std::string& isa,
                                                            std::stop_token stop);
  ~Accelerator();

  /// Coordinates of what can be hit: at most this [m].
  static constexpr double kMaxCoordinate = 1e30;

  /// Nothing for rays whose direction is 0 or that are not finite.
  std::optional<RawHit> closest_hit(const Ray& ray) const;
  /// True where anything lies at t in (t_min, t_max).
  bool occluded(const Ray& ray) const;
  /// Bit i % 8 of bits[i / 8] is set where ray i is occluded; bits.size() >= (rays.size() + 7) / 8.
  void occluded(std::span<const Ray> rays, std::span<std::uint8_t> bits) const;

  const GeometrySet& scene() const;
  const GeometrySet& object(std::uint32_t i) const;
  const GeometryInstance& instance(std::uint32_t i) const;
  std::uint32_t object_count() const;
  std::uint32_t instance_count() const;
  bool empty() const;
  std::size_t bytes() const;  ///< Embree's own memory and the geometry it reads
  /// Kernels in use, e.g. "avx2".
  std::string isa() const;

 private:
  struct State;
  explicit Accelerator(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// Embree's version and the instruction set of its kernels, "3.13.5 avx2".  `isa` as
/// Accelerator::build takes it. INVALID_ARGUMENT where the machine lacks it.
absl::StatusOr<std::string> embree_kernels(const std::string& isa);

}  // namespace lucerna
