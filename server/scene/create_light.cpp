#include "server/scene/create_light.h"

#include <fmt/format.h>

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "lights/maths/stop_poll.h"
#include "lights/maths/validation.h"
#include "lights/spectra/level_validation.h"
#include "proto/common/status_macros.h"
#include "server/rays/surface_table.h"
#include "server/scene/light_edit.h"

namespace lucerna {

LightPlace place_of(const LightDescription& light) {
  return std::visit(
      []<typename Params>(const Params& params) { return LightOf<Params>::place(params); },
      light.params);
}

namespace {

template <typename L>
absl::StatusOr<LightPointer> as_pointer(absl::StatusOr<L> light) {
  if (!light.ok()) return light.status();
  return std::make_shared<const L>(*std::move(light));
}

/// OK if the light's positions about the scene's origin fit floats, which answers use.
absl::Status check_place(const std::optional<Bounds>& box, const Vec3& origin) {
  if (!box) return absl::OkStatus();
  for (const Vec3& corner : {box->lower, box->upper})
    LUCERNA_RETURN_IF_ERROR(check_position("light.position", corner, origin, kMostInAnswers));
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<LightPointer> create_light(const LightDescription& light, const Vec3& origin) {
  return std::visit(
      [&]<typename Params>(const Params& params) -> absl::StatusOr<LightPointer> {
        const LightPlace place = LightOf<Params>::place(params);
        for (const std::optional<Bounds>& box : {place.box_m, place.portal_m})
          if (auto s = check_place(box, origin); !s.ok()) return s;
        // Squares and products of levels must fit a double.  Answers that do not fit a float are
        // OUT_OF_RANGE.
        LightParams level = params;
        constexpr double kMostLevel = 1e100;
        if (const double most = level_of(level).max_component(); most > kMostLevel)
          return absl::InvalidArgumentError(
              fmt::format("light.level = {}, allowed: up to {}", most, kMostLevel));
        return as_pointer(LightOf<Params>::create(params, origin));
      },
      light.params);
}

namespace {

template <typename Shape, typename Painted>
absl::StatusOr<LightPointer> as_area_light(const ShapeDescription::Emission& emission,
                                           absl::StatusOr<Shape> shape,
                                           const std::vector<Vec2f>& corner_uv = {}) {
  LUCERNA_RETURN_IF_ERROR(shape.status());
  LUCERNA_RETURN_IF_ERROR(shape->emissive_error());
  const DiffuseEmission diffuse{emission.radiance_cd_m2, emission.two_sided};
  if (emission.picture) {
    LUCERNA_ASSIGN_OR_RETURN(auto painted,
                             Painted::create(*std::move(shape), *emission.picture, corner_uv));
    return as_pointer(AreaLight<Painted>::create(diffuse, std::move(painted)));
  }
  return as_pointer(AreaLight<Shape>::create(diffuse, *std::move(shape)));
}

/// For shapes that can be flat.
template <typename Shape, typename Painted, typename Panel>
absl::StatusOr<LightPointer> as_flat_light(const ShapeDescription::Emission& emission,
                                           absl::StatusOr<Shape> shape,
                                           const std::vector<Vec2f>& corner_uv = {}) {
  if (!emission.panel || !shape.ok())
    return as_area_light<Shape, Painted>(emission, std::move(shape), corner_uv);
  LUCERNA_ASSIGN_OR_RETURN(auto panel, Panel::create(*std::move(shape), *emission.panel));
  return as_pointer(
      AreaLight<Panel>::create({emission.radiance_cd_m2, emission.two_sided}, std::move(panel)));
}

/// Has one overload for each shape.
class AreaLightMaker {
 public:
  AreaLightMaker(const ShapeDescription::Emission& emission, const Vec3& origin)
      : emission_(emission), origin_(origin) {}

  absl::StatusOr<LightPointer> operator()(const TriangleMeshData& mesh) const {
    const auto vertex = [&](std::size_t i) { return mesh.positions[mesh.indices[i]] - origin_; };
    std::vector<Triangle> triangles;
    triangles.reserve(mesh.indices.size() / 3);
    StopPoll poll;
    for (std::size_t i = 0; i < mesh.indices.size() / 3; ++i, poll())
      triangles.push_back({vertex(3 * i), vertex(3 * i + 1), vertex(3 * i + 2)});
    return as_flat_light<TriangleMesh, PaintedTriangleMesh, PanelTriangleMesh>(
        emission_, TriangleMesh::create(std::move(triangles)), mesh.corner_uv);
  }

  absl::StatusOr<LightPointer> operator()(const PatchMeshData& mesh) const {
    const auto vertex = [&](std::size_t i) { return mesh.positions[mesh.indices[i]] - origin_; };
    std::vector<BilinearPatch> patches;
    patches.reserve(mesh.indices.size() / 4);
    StopPoll poll;
    for (std::size_t i = 0; i < mesh.indices.size() / 4; ++i, poll())
      patches.push_back({vertex(4 * i), vertex(4 * i + 1), vertex(4 * i + 2), vertex(4 * i + 3)});
    return as_flat_light<PatchMesh, PaintedPatchMesh, PanelPatchMesh>(
        emission_, PatchMesh::create(std::move(patches)), mesh.corner_uv);
  }

  absl::StatusOr<LightPointer> operator()(const CurveData&) const {
    return absl::InvalidArgumentError("a curve that emits, allowed: other shapes");
  }

#define LUCERNA_CURVED(Shape)                                                               \
  absl::StatusOr<LightPointer> operator()(const Shape##Params& params) const {              \
    return as_area_light<Shape, Painted##Shape>(emission_, Shape::create(params, origin_)); \
  }
#define LUCERNA_FLAT(Shape)                                                                    \
  absl::StatusOr<LightPointer> operator()(const Shape##Params& params) const {                 \
    return as_flat_light<Shape, Painted##Shape, Panel##Shape>(emission_,                       \
                                                              Shape::create(params, origin_)); \
  }
  LUCERNA_CURVED_QUADRICS(LUCERNA_CURVED)
  LUCERNA_FLAT_QUADRICS(LUCERNA_FLAT)
#undef LUCERNA_CURVED
#undef LUCERNA_FLAT

 private:
  const ShapeDescription::Emission& emission_;
  const Vec3& origin_;
};

}  // namespace

absl::StatusOr<LightPointer> create_area_light(const ShapeDescription& shape, const Vec3& origin) {
  return std::visit(AreaLightMaker(*shape.emission, origin), shape.geometry);
}

std::uint64_t primitive_count(const Light& light) {
  const auto* const surface = dynamic_cast<const SurfaceLight*>(&light);
  if (surface == nullptr) return 1;
  return std::visit([](const auto* shape) -> std::uint64_t { return shape->size(); },
                    surface->surface());
}

}  // namespace lucerna
