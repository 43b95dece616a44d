#include "server/pbrt/projection_lights.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "lights/maths/axes.h"
#include "server/pbrt/image_lights.h"
#include "server/pbrt/pbrt_scales.h"

namespace lucerna::pbrt {
namespace {

/// Length in the world of one unit along each of the light's axes [m].
Vec3 scale_of(const Frame& axes) { return {length(axes.s), length(axes.t), length(axes.n)}; }

/// Adapts fov and aspect to the transform's scale.  The scale applies to the picture in its plane
/// and to the distance of the plane.
void apply_scale(const Vec3& scale, ProjectedPictureParams& picture) {
  const double across = scale.x / scale.z, up = scale.y / scale.z;
  // Rounding errors of rotations do not count as scale.
  constexpr double kEqual = 1e-12;
  if (std::fabs(across - 1) < kEqual && std::fabs(up - 1) < kEqual) return;
  const double shorter = std::tan(picture.fov_rad / 2);
  const double half_x = shorter * std::max(picture.aspect, 1.0) * across;
  const double half_y = shorter / std::min(picture.aspect, 1.0) * up;
  picture.fov_rad = 2 * std::atan(std::min(half_x, half_y));
  picture.aspect = half_x / half_y;
}

/// `own_space`: set for axes without right angles.
Projection perspective(const ParameterSet& params, const Frame& axes,
                       std::shared_ptr<const Frame> own_space, const Vec3& position_m,
                       NamedImage named, ImageFilter filter) {
  const double fov = params.number(
      "fov", 90, [](double f) { return f > 0 && f < 180; }, " degrees, allowed (0, 180)");
  ProjectedPictureParams picture{
      .image = named.image, .filter = filter, .fov_rad = fov * (std::numbers::pi / 180)};
  if (named.image)
    picture.aspect = static_cast<double>(named.image->width()) / named.image->height();
  if (own_space == nullptr) apply_scale(scale_of(axes), picture);
  auto projected = ProjectedPicture::create(picture);
  if (!projected.ok())
    fail(params.place_of({"fov", "filename"}),
         fmt::format("\"float fov\" = {} degrees: {}", fov,
                     std::string(projected.status().message())));
  const double lumens = luminance((*projected)->integral_sr());
  // For lights that pbrt-v4 cannot express, both counts are the same.
  const bool pbrt4 = named.image && filter == ImageFilter::kNearest;
  const double counted = pbrt4 ? luminance((*projected)->integral_by_centres_sr()) : lumens;
  return {ProjectionLightParams{.position_m = position_m,
                                .axes = axes,
                                .picture = *std::move(projected),
                                .image_name = std::move(named.name),
                                .own_space = std::move(own_space)},
          lumens, counted};
}

Projection orthographic(const ParameterSet& params, const Frame& axes, const Vec3& position_m,
                        NamedImage named, ImageFilter filter) {
  const double extent = params.number(
      "extent", 1, [](double e) { return e > 0; }, " m, allowed: positive");
  const double aspect =
      named.image ? static_cast<double>(named.image->width()) / named.image->height() : 1;
  const Vec3 scale = scale_of(axes);
  BeamLightParams beam{.position_m = position_m,
                       .axes = axes,
                       .width_m = extent * std::max(aspect, 1.0) * scale.x,
                       .height_m = extent / std::min(aspect, 1.0) * scale.y,
                       .image = named.image,
                       .filter = filter,
                       .image_name = std::move(named.name)};
  const double lumens =
      beam.width_m * beam.height_m * (named.image ? luminance(named.image->mean()) : 1);
  return {std::move(beam), lumens, lumens};
}

}  // namespace

Projection projection(LoadState& context, const ParameterSet& params,
                      const Transform& world_from_light) {
  const Frame axes = axes_of(world_from_light);
  const bool is_sheared = !check_right_angles("", axes).ok();
  NamedImage named;
  const Parameter* filename = params.find("filename", {"string"});
  if (filename != nullptr) named = read_image(context, *filename, kSrgb);
  if (filename == nullptr) check_without_picture(context, params, {"filter"});
  const ImageFilter filter = filename != nullptr ? image_filter(params) : ImageFilter::kNearest;
  const Vec3 position = world_from_light.point({0, 0, 0});
  const bool is_beam = params.choice<bool>("projection", "perspective",
                                           {{"perspective", false}, {"orthographic", true}});
  if (!is_beam)
    return perspective(params, axes,
                       is_sheared ? own_space_of(context, params, world_from_light) : nullptr,
                       position, std::move(named), filter);
  if (is_sheared)
    fail(
        params.place(),
        fmt::format("an orthographic projection under a transform that shears, {} along other "
                    "axes than the light's own, allowed: rotations, mirrors, and scale along these",
                    scales_text(world_from_light)));
  return orthographic(params, axes, position, std::move(named), filter);
}

void set_level(LoadState& context, const FilePosition& level_place, const FilePosition* power_place,
               const Rgb& level, Projection& projection) {
  if (power_place != nullptr &&
      std::fabs(projection.pbrt4_lumens - projection.lumens) > 1e-3 * projection.lumens)
    context.remark(*power_place,
                   "\"power\" of a picture, whose texels pbrt-v4 weights by their middles",
                   fmt::format("{:.6g} lm, from the same intensity as in pbrt-v4",
                               luminance(level) * projection.lumens));
  // Checks here, where the place in the file is known.  Answers contain floats, so a level out of
  // their range fails too.
  if (auto* perspective = std::get_if<ProjectionLightParams>(&projection.light)) {
    perspective->intensity_cd = level;
    if (const auto made = ProjectionLight::create(*perspective); !made.ok())
      fail(level_place, made.status());
    require_level(level_place, "projection.intensity of the brightest texel",
                  level * perspective->picture->brightest());
  } else {
    auto& beam = std::get<BeamLightParams>(projection.light);
    beam.illuminance_lx = level;
    if (const auto made = BeamLight::create(beam); !made.ok()) fail(level_place, made.status());
    // Answers hold the density of a ray's place, which is 1 over the area.
    const double per_m2 = 1 / (beam.width_m * beam.height_m);
    if (!(per_m2 >= std::numeric_limits<float>::min() &&
          per_m2 <= std::numeric_limits<float>::max()))
      fail(level_place,
           fmt::format("beam.width and height = {} and {} m, allowed: an area of 3e-39 to 8e37 m2",
                       beam.width_m, beam.height_m));
    if (beam.image)
      require_level(level_place, "beam.illuminance of the brightest texel",
                    level * beam.image->brightest());
  }
}

}  // namespace lucerna::pbrt
