#include "server/scene/create_light.h"

#include <fmt/format.h>

#include <memory>
#include <utility>

#include "lights/maths/level_validation.h"
#include "lights/maths/validation.h"
#include "proto/common/status_macros.h"
#include "server/description/described_shape.h"
#include "server/rays/surface_table.h"
#include "server/scene/light_edit.h"

namespace lucerna {

LightPlace place_of(const LightDescription& light) {
  return std::visit(
      []<typename Params>(const Params& params) { return LightOf<Params>::place(params); },
      light.params);
}

namespace {

/// A shared pointer to what was made.
template <typename T>
absl::StatusOr<std::shared_ptr<const T>> as_pointer(absl::StatusOr<T> made) {
  if (!made.ok()) return made.status();
  return std::make_shared<const T>(*std::move(made));
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

absl::StatusOr<LightPointer> create_area_light(const ShapeDescription& shape, const Vec3& origin) {
  const ShapeDescription::Emission& emission = *shape.emission;
  LUCERNA_ASSIGN_OR_RETURN(auto made,
                           create_shape(shape.geometry, origin, emission.picture.has_value()));
  return as_pointer(AreaLight::create({emission.radiance_cd_m2, emission.two_sided},
                                      std::move(made), {emission.picture, emission.panel}));
}

std::uint64_t primitive_count(const Light& light) {
  const auto* const area = dynamic_cast<const AreaLight*>(&light);
  return area != nullptr ? area->shape().size() : 1;
}

}  // namespace lucerna
