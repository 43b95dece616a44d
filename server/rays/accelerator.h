// A small class around Embree.  Of the headers, only user_geometry.h includes Embree's.
#pragma once

#include <absl/status/statusor.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <numeric>
#include <optional>
#include <stop_token>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "lights/maths/motion.h"
#include "lights/maths/transform.h"
#include "lights/shapes/all_shapes.h"
#include "lights/shapes/bilinear_patch.h"
#include "server/files/load_budget.h"
#include "server/rays/curve.h"
#include "server/rays/large_triangle.h"
#include "server/rays/ray.h"

namespace lucerna {

namespace internal {
template <typename... Shapes>
std::tuple<std::vector<Shapes>...> vectors_of(ShapeTypes<Shapes...>);
}  // namespace internal

/// A vector for each kind of quadric.
using QuadricVectors = decltype(internal::vectors_of(Quadrics()));

/// Kinds of primitives.  kFirstQuadric and the numbers after it are the kinds of `Quadrics`.
enum class HitKind : std::uint8_t { kTriangle, kPatch, kCurve, kFirstQuadric };
inline constexpr std::size_t kQuadrics = std::tuple_size_v<QuadricVectors>;
inline constexpr std::size_t kFirstQuadric = static_cast<std::size_t>(HitKind::kFirstQuadric);
inline constexpr std::size_t kHitKinds = kFirstQuadric + kQuadrics;

/// The kind of a quadric, such as Sphere.
template <QuadricShape S>
inline constexpr HitKind kHitKind = [] {
  auto kind = static_cast<int>(HitKind::kFirstQuadric);
  bool found = false;
  Quadrics::for_each([&]<typename Shape>() {
    found = found || std::is_same_v<Shape, S>;
    if (!found) ++kind;
  });
  return static_cast<HitKind>(kind);
}();

struct SurfaceTable;

/// Which surfaces a ray meets.
enum class RayFilter : std::uint8_t {
  kSurfaces,       ///< all but interfaces, which only bound media
  kPanesByChance,  ///< the same, but a smooth thin pane only with the probability of a reflection
  kOpaque,         ///< the same without smooth thin panes and sheets with a constant alpha
  kPanes,          ///< only these panes and sheets
  kBoundaries,     ///< only surfaces that bound media
};

/// Everything that rays can hit in one space (the scene's or an object's).  Each kind has its
/// own numbers, in order.
struct GeometrySet {
  std::vector<Vec3f> vertices{};           ///< [m]; within an Accelerator in units of `unit_m`
  std::vector<std::uint32_t> triangles{};  ///< three vertex numbers for each triangle
  std::vector<BilinearPatch> patches{};
  std::vector<CurvePiece> curves{};
  QuadricVectors quadrics{};
  std::vector<LargeTriangle> large{};  ///< of `triangles`, in ascending order
  double other_error_m = 0;            ///< the largest ray_error_of() of any other triangle
  /// Set if rays pass some of its surfaces; null if all are opaque.
  const SurfaceTable* non_opaque = nullptr;
  /// The unit of Embree's space for this set (ray_limits.h).  The Accelerator chooses it.
  double unit_m = 1;

  /// The triangle of this number if it is large, or null.
  const LargeTriangle* large_triangle(std::uint32_t number) const {
    const auto at = std::ranges::lower_bound(large, number, {}, &LargeTriangle::triangle);
    return at != large.end() && at->triangle == number ? &*at : nullptr;
  }

  /// The quadrics of one type, such as Sphere.
  template <typename Shape>
  std::vector<Shape>& of() {
    return std::get<std::vector<Shape>>(quadrics);
  }
  template <typename Shape>
  const std::vector<Shape>& of() const {
    return std::get<std::vector<Shape>>(quadrics);
  }
  /// Calls `f(vector)` for the patches, the curves, and each kind of quadric, in the order of
  /// HitKind.
  template <typename F>
  void for_each_kind_of_surface(F&& f) const {
    f(patches), f(curves);
    std::apply([&](const auto&... of_kind) { (f(of_kind), ...); }, quadrics);
  }
  /// The result of `f(surface)` for a patch, a piece of a curve or a quadric.  `kind` is not
  /// kTriangle.
  template <typename F>
  auto visit_surface(HitKind kind, std::uint32_t primitive, F&& f) const {
    if (kind == HitKind::kPatch) return f(patches[primitive]);
    if (kind == HitKind::kCurve) return f(curves[primitive]);
    return visit_quadric<0>(static_cast<std::size_t>(kind) - kFirstQuadric, primitive, f);
  }

  /// The same for a quadric, by the number of its kind.
  template <std::size_t kNumber, typename F>
  auto visit_quadric(std::size_t number, std::uint32_t primitive, F&& f) const {
    if constexpr (kNumber + 1 < kQuadrics)
      if (number != kNumber) return visit_quadric<kNumber + 1>(number, primitive, f);
    return f(std::get<kNumber>(quadrics)[primitive]);
  }

  /// Number of primitives of each kind, by HitKind.
  std::array<std::size_t, kHitKinds> counts() const {
    std::array<std::size_t, kHitKinds> n{triangles.size() / 3};
    std::size_t kind = 1;
    for_each_kind_of_surface([&](const auto& surfaces) { n[kind++] = surfaces.size(); });
    return n;
  }
  std::size_t primitives() const {
    const auto n = counts();
    return std::accumulate(n.begin(), n.end(), std::size_t{0});
  }
  bool empty() const { return primitives() == 0; }
  std::size_t bytes() const {
    const auto bytes_of = [](const auto& v) { return v.capacity() * sizeof v[0]; };
    std::size_t sum = bytes_of(vertices) + bytes_of(triangles) + bytes_of(large);
    for_each_kind_of_surface([&](const auto& surfaces) { sum += bytes_of(surfaces); });
    return sum;
  }
};

struct GeometryInstance {
  std::uint32_t object;
  /// For a moving instance: to the coordinates at the start of `motion`.
  Transform scene_from_object;
  std::shared_ptr<const Motion> motion{};  ///< to the scene's coordinates; null: does not move
};

struct RawHit {
  float t{};
  HitKind kind{};
  std::uint32_t primitive{};   ///< within its kind, within its GeometrySet
  std::int32_t instance = -1;  ///< index of the instance; -1: the scene's own geometry
  Vec2f uv;                    ///< triangle: barycentrics of vertices 1 and 2; patch, curve: (u, v)
  /// Except for triangles: the point hit and its unit normal, in the space of the
  /// GeometrySet.
  Vec3 position, normal;
};

/// What a ray meets, if its ends may lie on surfaces.
enum class Obstacle : std::uint8_t {
  kNone,
  kOther,       ///< a surface that neither end lies on
  kPerhapsOwn,  ///< only surfaces that the ends may lie on: closest_hit() must decide
};

/// Primitives with consecutive numbers.
struct PrimitiveRange {
  HitKind kind;
  std::uint32_t first, count;
};

/// The order of ranges that share no primitive.
inline bool is_before(const PrimitiveRange& a, const PrimitiveRange& b) {
  return std::pair(a.kind, a.first) < std::pair(b.kind, b.first);
}

/// Immutable once built; all const members may be called from any thread.
class Accelerator {
 public:
  /// Takes ownership of `scene` and `objects`.  `isa`: the instruction set of the kernels (""
  /// : the best one of the machine; "sse2", "sse4.2", "avx", "avx2", "avx512").  Errors:
  /// CANCELLED after a request of `stop`; RESOURCE_EXHAUSTED if Embree has no memory, or if
  /// `budget` (null: no limit) refuses it;
  /// INVALID_ARGUMENT for an instruction set that the machine lacks, and for instances that are
  /// 2^40 times smaller than the scene.
  static absl::StatusOr<std::unique_ptr<Accelerator>> build(
      GeometrySet scene, std::vector<GeometrySet> objects, std::vector<GeometryInstance> instances,
      const std::string& isa, std::stop_token stop, LoadBudget* budget = nullptr);
  /// Shares the BVH of `still`, which comes from build(), but takes the scene's own primitives in
  /// `moved` from `scene`.  The unit, the numbers and all other primitives are those of
  /// still->scene().  New primitives follow them, and are in `moved` too.  Null if a new BVH would
  /// have another unit.
  /// Errors: RESOURCE_EXHAUSTED if Embree has no memory.
  static absl::StatusOr<std::shared_ptr<const Accelerator>> with_moved(
      std::shared_ptr<const Accelerator> still, GeometrySet scene,
      std::vector<PrimitiveRange> moved);
  ~Accelerator();

  /// Largest coordinate of geometry [m].
  static constexpr double kMaxCoordinate = 1e30;

  /// The first surface along the ray.  Nothing for rays that are not finite or have direction
  /// 0.
  std::optional<RawHit> closest_hit(const Ray& ray, RayFilter filter = RayFilter::kSurfaces) const;
  /// All surfaces along the ray, in no order.  A triangle may occur twice.  Their t is 0: floats
  /// cannot tell the order of surfaces that are close to each other but far from the ray's origin.
  std::vector<RawHit> all_hits(const Ray& ray, RayFilter filter) const;
  /// Whether anything is at t in (t_min, t_max).
  bool occluded(const Ray& ray, RayFilter filter = RayFilter::kSurfaces) const;
  /// What is at t in (t_min, t_max).  A surface may be an end's own if its plane passes near that
  /// end, even if the hit is far from the end.
  Obstacle obstacle(const Ray& ray, const EndTolerances& ends, RayFilter filter) const;

  /// Whether a surface may be within `radius_m` of the point.  Triangles are tested by their planes
  /// and boxes, other surfaces by their boxes.
  bool may_touch(const Vec3& point, double radius_m) const;

  const GeometrySet& scene() const;
  const GeometrySet& object(std::uint32_t i) const;
  const GeometryInstance& instance(std::uint32_t i) const;
  std::uint32_t object_count() const;
  std::uint32_t instance_count() const;
  bool empty() const;
  /// Embree's own memory and the geometry that it reads, without what it shares.
  std::size_t bytes() const;
  /// The instruction set of the kernels in use, e.g. "avx2".
  std::string isa() const;

 private:
  struct State;
  explicit Accelerator(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// Embree's version and the instruction set of its kernels: "3.13.5 avx2".  `isa`: as in
/// Accelerator::build.  INVALID_ARGUMENT if the machine lacks it.
absl::StatusOr<std::string> embree_kernels(const std::string& isa);

}  // namespace lucerna
