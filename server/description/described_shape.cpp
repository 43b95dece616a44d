#include "server/description/described_shape.h"

#include <absl/status/status.h>

#include <cstddef>
#include <utility>
#include <variant>

#include "lights/maths/stop_poll.h"

namespace lucerna {
namespace {

using ShapePointer = std::shared_ptr<const Shape>;

template <typename S>
absl::StatusOr<ShapePointer> as_pointer(absl::StatusOr<S> shape) {
  if (!shape.ok()) return shape.status();
  return std::make_shared<const S>(*std::move(shape));
}

/// Has one overload for each kind of description.
struct ShapeMaker {
  template <typename Params>
  absl::StatusOr<ShapePointer> operator()(const Params& params) const {
    return as_pointer(QuadricOf<Params>::create(params, origin));
  }
  absl::StatusOr<ShapePointer> operator()(const TriangleMeshData& mesh) const {
    return as_pointer(TriangleMesh::create(primitives_of(mesh, origin), uv_of(mesh)));
  }
  absl::StatusOr<ShapePointer> operator()(const PatchMeshData& mesh) const {
    return as_pointer(PatchMesh::create(primitives_of(mesh, origin), uv_of(mesh)));
  }
  absl::StatusOr<ShapePointer> operator()(const CurveData&) const {
    return absl::InvalidArgumentError("a curve that emits, allowed: other shapes");
  }
  template <typename Mesh>
  std::vector<Vec2f> uv_of(const Mesh& mesh) const {
    return with_uv ? mesh.corner_uv : std::vector<Vec2f>();
  }

  const Vec3& origin;
  bool with_uv;
};

}  // namespace

std::vector<Triangle> primitives_of(const TriangleMeshData& mesh, const Vec3& origin) {
  const auto vertex = [&](std::size_t i) { return mesh.positions[mesh.indices[i]] - origin; };
  std::vector<Triangle> triangles;
  triangles.reserve(mesh.indices.size() / 3);
  StopPoll poll;
  for (std::size_t i = 0; i + 3 <= mesh.indices.size(); i += 3, poll())
    triangles.push_back({vertex(i), vertex(i + 1), vertex(i + 2)});
  return triangles;
}

std::vector<BilinearPatch> primitives_of(const PatchMeshData& mesh, const Vec3& origin) {
  const auto vertex = [&](std::size_t i) { return mesh.positions[mesh.indices[i]] - origin; };
  std::vector<BilinearPatch> patches;
  patches.reserve(mesh.indices.size() / 4);
  StopPoll poll;
  for (std::size_t i = 0; i + 4 <= mesh.indices.size(); i += 4, poll())
    patches.push_back({vertex(i), vertex(i + 1), vertex(i + 2), vertex(i + 3)});
  return patches;
}

absl::StatusOr<ShapePointer> create_shape(const Geometry& geometry, const Vec3& origin,
                                          bool with_uv) {
  return std::visit(ShapeMaker{origin, with_uv}, geometry);
}

}  // namespace lucerna
