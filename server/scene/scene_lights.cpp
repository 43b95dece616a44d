#include "server/scene/scene_lights.h"

#include <fmt/format.h>

#include <concepts>
#include <utility>

#include "lights/maths/stop_poll.h"
#include "lights/maths/validation.h"
#include "lights/spectra/level_validation.h"
#include "proto/common/status_macros.h"
#include "server/rays/surface_table.h"
#include "server/scene/light_edit.h"

namespace lucerna {

namespace {

/// The light model that is made from `Params`.
template <typename Params, typename Lights>
struct ModelOf;
template <typename Params, typename L, typename... Rest>
struct ModelOf<Params, std::variant<L, Rest...>> : ModelOf<Params, std::variant<Rest...>> {};
template <typename Params, typename L, typename... Rest>
requires std::same_as<typename L::Params, Params>
struct ModelOf<Params, std::variant<L, Rest...>> {
  using type = L;
};

}  // namespace

LightPlace place_of(const LightDescription& light) {
  return std::visit(
      []<typename Params>(const Params& params) {
        return ModelOf<Params, LightModels<double>>::type::place(params);
      },
      light.params);
}

namespace {

/// OK if the light's positions about the scene's origin fit floats, which answers use.
absl::Status check_place(const std::optional<Box>& box, const Vec3<double>& origin) {
  if (!box) return absl::OkStatus();
  for (const Vec3<double>& corner : {box->first, box->second})
    LUCERNA_RETURN_IF_ERROR(check_position<float>("light.position", corner, origin));
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<Light<double>> create_light(const LightDescription& light,
                                           const Vec3<double>& origin) {
  return std::visit(
      [&]<typename Params>(const Params& params) -> absl::StatusOr<Light<double>> {
        using Model = typename ModelOf<Params, LightModels<double>>::type;
        const LightPlace place = Model::place(params);
        for (const std::optional<Box>& box : {place.box_m, place.portal_m})
          if (auto s = check_place(box, origin); !s.ok()) return s;
        // Squares and products of levels must fit a double.  Answers that do not fit a float are
        // OUT_OF_RANGE.
        LightParams level = params;
        constexpr double kMostLevel = 1e100;
        if (const double most = level_of(level).max_component(); most > kMostLevel)
          return absl::InvalidArgumentError(
              fmt::format("light.level = {}, allowed: up to {}", most, kMostLevel));
        auto made = Model::create(params, origin);
        if (!made.ok()) return made.status();
        return Light<double>(*std::move(made));
      },
      light.params);
}

namespace {

template <template <typename> typename Shape, template <typename> typename Painted>
absl::StatusOr<Light<double>> as_area_light(const ShapeDescription::Emission& emission,
                                            absl::StatusOr<Shape<double>> shape,
                                            const std::vector<Vec2<float>>& corner_uv = {}) {
  LUCERNA_RETURN_IF_ERROR(shape.status());
  LUCERNA_RETURN_IF_ERROR(shape->emissive_error());
  const DiffuseEmission diffuse{emission.radiance_cd_m2, emission.two_sided};
  if (emission.picture) {
    LUCERNA_ASSIGN_OR_RETURN(
        auto painted, Painted<double>::create(*std::move(shape), *emission.picture, corner_uv));
    LUCERNA_ASSIGN_OR_RETURN(auto light,
                             (AreaLight<double, Painted>::create(diffuse, std::move(painted))));
    return Light<double>(std::move(light));
  }
  LUCERNA_ASSIGN_OR_RETURN(auto light,
                           (AreaLight<double, Shape>::create(diffuse, *std::move(shape))));
  return Light<double>(std::move(light));
}

/// For shapes that can be flat.
template <template <typename> typename Shape, template <typename> typename Painted,
          template <typename> typename Panel>
absl::StatusOr<Light<double>> as_flat_light(const ShapeDescription::Emission& emission,
                                            absl::StatusOr<Shape<double>> shape,
                                            const std::vector<Vec2<float>>& corner_uv = {}) {
  if (!emission.panel || !shape.ok())
    return as_area_light<Shape, Painted>(emission, std::move(shape), corner_uv);
  LUCERNA_ASSIGN_OR_RETURN(auto panel, Panel<double>::create(*std::move(shape), *emission.panel));
  LUCERNA_ASSIGN_OR_RETURN(
      auto light, (AreaLight<double, Panel>::create({emission.radiance_cd_m2, emission.two_sided},
                                                    std::move(panel))));
  return Light<double>(std::move(light));
}

/// Has one overload for each shape.
class AreaLightMaker {
 public:
  AreaLightMaker(const ShapeDescription::Emission& emission, const Vec3<double>& origin)
      : emission_(emission), origin_(origin) {}

  absl::StatusOr<Light<double>> operator()(const TriangleMeshData& mesh) const {
    const auto vertex = [&](std::size_t i) { return mesh.positions[mesh.indices[i]] - origin_; };
    std::vector<Triangle<double>> triangles;
    triangles.reserve(mesh.indices.size() / 3);
    StopPoll poll;
    for (std::size_t i = 0; i < mesh.indices.size() / 3; ++i, poll())
      triangles.push_back({vertex(3 * i), vertex(3 * i + 1), vertex(3 * i + 2)});
    return as_flat_light<TriangleMesh, PaintedTriangleMesh, PanelTriangleMesh>(
        emission_, TriangleMesh<double>::create(std::move(triangles)), mesh.corner_uv);
  }

  absl::StatusOr<Light<double>> operator()(const PatchMeshData& mesh) const {
    const auto vertex = [&](std::size_t i) { return mesh.positions[mesh.indices[i]] - origin_; };
    std::vector<BilinearPatch<double>> patches;
    patches.reserve(mesh.indices.size() / 4);
    StopPoll poll;
    for (std::size_t i = 0; i < mesh.indices.size() / 4; ++i, poll())
      patches.push_back({vertex(4 * i), vertex(4 * i + 1), vertex(4 * i + 2), vertex(4 * i + 3)});
    return as_flat_light<PatchMesh, PaintedPatchMesh, PanelPatchMesh>(
        emission_, PatchMesh<double>::create(std::move(patches)), mesh.corner_uv);
  }

  absl::StatusOr<Light<double>> operator()(const CurveData&) const {
    return absl::InvalidArgumentError("a curve that emits, allowed: other shapes");
  }

#define LUCERNA_CURVED(Shape)                                                            \
  absl::StatusOr<Light<double>> operator()(const Shape##Params& params) const {          \
    return as_area_light<Shape, Painted##Shape>(emission_,                               \
                                                Shape<double>::create(params, origin_)); \
  }
#define LUCERNA_FLAT(Shape)                                                     \
  absl::StatusOr<Light<double>> operator()(const Shape##Params& params) const { \
    return as_flat_light<Shape, Painted##Shape, Panel##Shape>(                  \
        emission_, Shape<double>::create(params, origin_));                     \
  }
  LUCERNA_CURVED_QUADRICS(LUCERNA_CURVED)
  LUCERNA_FLAT_QUADRICS(LUCERNA_FLAT)
#undef LUCERNA_CURVED
#undef LUCERNA_FLAT

 private:
  const ShapeDescription::Emission& emission_;
  const Vec3<double>& origin_;
};

}  // namespace

absl::StatusOr<Light<double>> create_area_light(const ShapeDescription& shape,
                                                const Vec3<double>& origin) {
  return std::visit(AreaLightMaker(*shape.emission, origin), shape.geometry);
}

std::uint64_t primitive_count(const Light<double>& light) {
  return visit(
      [](const auto& l) -> std::uint64_t {
        if constexpr (requires { l.shape(); })
          return l.shape().size();
        else
          return 1;
      },
      light);
}

}  // namespace lucerna
