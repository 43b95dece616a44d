#include "server/pbrt/image_lights.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "lights/maths/level_validation.h"
#include "lights/maths/validation.h"
#include "server/pbrt/pbrt_levels.h"
#include "server/pbrt/pbrt_scales.h"

namespace lucerna::pbrt {
namespace {

/// The divisor that pbrt-v4 uses for "illuminance": the sum of luminance times cosine over the
/// texels above the light's xy plane.  pbrt-v4 weights each texel by 2 pi over the number of
/// texels, which is half of its solid angle.
double pbrt_illuminance(const Image& image) {
  const int n = image.width();
  double sum = 0;
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      const Vec2 p{(x + 0.5) / n, (y + 0.5) / n};
      const double cos = direction_from_square(SphereMapping::kEqualArea, p).z;
      sum += luminance(Rgb(image.texel(x, y))) * std::max(0.0, cos);
    }
  return sum * 2 * kPi / n / n;
}

/// Illuminance of a surface that faces +y under a latitude-longitude picture, texel by texel.
double illuminance_from_above(const Image& image) {
  double sum = 0;
  for (int y = 0; y < image.height(); ++y) {
    const auto sine = [&](double row) {
      return std::sin(kPi * std::min(row / image.height(), 0.5));
    };
    double row = 0;
    for (int x = 0; x < image.width(); ++x) row += luminance(Rgb(image.texel(x, y)));
    sum += row * (sine(y + 1) - sine(y)) * (sine(y + 1) + sine(y));
  }
  return sum * kPi / image.width();
}

/// Illuminance of the picture: as pbrt-v4 computes it, or the exact one for a latitude-longitude
/// picture.
double illuminance_of(const Image& image, SphereMapping mapping) {
  return mapping == SphereMapping::kEqualArea ? pbrt_illuminance(image)
                                              : illuminance_from_above(image);
}

/// Factor from the picture at `scale` to the illuminance in `given`.
double illuminance_factor(LoadState& context, const Parameter& given, double wanted, double scale,
                          const Image& image, SphereMapping mapping) {
  const double of_picture = illuminance_of(image, mapping);
  if (!(of_picture > 0))
    fail(given.place,
         fmt::format("\"float illuminance\" = {} lx, but the picture is black above the horizon{}",
                     wanted, kOnlyAsIfNotGiven));
  if (!(scale > 0))
    fail(given.place, fmt::format("\"float illuminance\" = {} lx, but \"scale\" is 0{}", wanted,
                                  kOnlyAsIfNotGiven));
  if (mapping == SphereMapping::kEqualArea)
    context.remark(given.place, "\"illuminance\" of a picture; pbrt-v4 counts only half of it",
                   fmt::format("a surface that faces the light's +z gets {:.6g} lx, the same as in "
                               "pbrt-v4",
                               2 * scale * wanted));
  return wanted / of_picture;
}

/// "scale" times the factor for "illuminance".
double picture_level(LoadState& context, const ParameterSet& params, const Image& image,
                     SphereMapping mapping) {
  const double scale = level_scale(params);
  const double wanted = target_of(context, params, "illuminance", "the picture's level");
  if (!(wanted > 0)) return scale;
  const Parameter& given = *params.find("illuminance", {"float"});
  return scale * illuminance_factor(context, given, wanted, scale, image, mapping);
}

/// The picture of "string filename" with its level.  `otherwise`: the filter if none is given.
ImageInfiniteLightParams picture(LoadState& context, const ParameterSet& params,
                                 const Transform& world_from_light, ImageFilter otherwise) {
  const Parameter& filename = *params.find("filename", {"string"});
  if (const Parameter* l = params.find("L", {"rgb", "spectrum", "blackbody"}))
    fail(l->place, "\"L\" and \"filename\" are both given, allowed: one of them");
  const NamedImage named = read_image(context, filename, kLuminances);
  const SphereMapping mapping = sphere_mapping(params);
  const ImageFilter filter = params.find("filter", {"string"}) ? image_filter(params) : otherwise;
  auto map = SphereMap::create(named.image, mapping, filter);
  if (!map.ok())
    fail(filename.place,
         fmt::format("\"string filename\": {}: {}; \"string mapping\" \"latlong\" takes any",
                     named.name, std::string(map.status().message())));
  ImageInfiniteLightParams infinite;
  infinite.map = *std::move(map);
  infinite.image_name = named.name;
  infinite.world_from_map = world_from_light;
  infinite.radiance_cd_m2 = Rgb(picture_level(context, params, *named.image, mapping));
  require_level(
      level_place(params, "L"),
      fmt::format("the brightest texel of {} times the light's level", printable(named.name)),
      infinite.map->brightest() * infinite.radiance_cd_m2);
  return infinite;
}

}  // namespace

SphereMapping sphere_mapping(const ParameterSet& params) {
  return params.choice<SphereMapping>(
      "mapping", "equalarea",
      {{"equalarea", SphereMapping::kEqualArea}, {"latlong", SphereMapping::kLatitudeLongitude}});
}

void check_without_picture(LoadState& context, const ParameterSet& params,
                           std::initializer_list<std::string_view> names) {
  for (const std::string_view name : names) {
    const Parameter* given = params.find(name, {"string"});
    if (given == nullptr) continue;
    if (name == "mapping")
      sphere_mapping(params);
    else
      image_filter(params);
    if (params.is_own(*given))
      context.remark(given->place,
                     fmt::format("\"string {}\" without a picture (\"string filename\")", name),
                     "it changes nothing");
  }
}

ImageInfiniteLightParams image_infinite(LoadState& context, const ParameterSet& params,
                                        const Transform& world_from_light) {
  ImageInfiniteLightParams infinite =
      picture(context, params, world_from_light, ImageFilter::kNearest);
  // Checks here, where the place in the file is known.
  if (const auto made = ImageInfiniteLight::create(infinite); !made.ok())
    fail(level_place(params, "L"), made.status());
  return infinite;
}

PortalLightParams portal(LoadState& context, const ParameterSet& params,
                         const Transform& world_from_light) {
  const Parameter& given = *params.find("portal", {"point3"});
  const bool has_picture = params.find("filename", {"string"}) != nullptr;
  // pbrt-v4 resamples the pictures that it can read.  If a filter is given, it applies to the
  // picture itself.
  const bool is_resampled = has_picture && params.find("filter", {"string"}) == nullptr &&
                            sphere_mapping(params) == SphereMapping::kEqualArea;
  if (has_picture && !is_resampled)
    require_equal_scale(params.place(), "a filtered or latitude-longitude picture behind a portal",
                        world_from_light);
  const std::vector<Vec3> corners = params.vectors("portal", "point3");
  PortalLightParams light;
  if (corners.size() != light.corners_m.size())
    fail(given.place, fmt::format("\"point3 portal\" of {} points, allowed: 4", corners.size()));
  std::copy(corners.begin(), corners.end(), light.corners_m.begin());
  light.world_from_map = world_from_light;
  if (has_picture) {
    ImageInfiniteLightParams infinite =
        picture(context, params, world_from_light, ImageFilter::kBilinear);
    light.map = std::move(infinite.map);
    light.image_name = std::move(infinite.image_name);
    light.radiance_cd_m2 = infinite.radiance_cd_m2;
    light.rectified = is_resampled;
  } else {
    // The transform has no effect on a uniform sky.
    light.world_from_map = Transform();
  }
  absl::Status status = PortalLight::check(light);
  for (const Vec3& corner : light.corners_m)
    if (status.ok()) status = check_position("infinite.portal", corner, {}, kMostInAnswers);
  if (!status.ok())
    fail(given.place, fmt::format("\"point3 portal\": {}", std::string(status.message())));
  return light;
}

}  // namespace lucerna::pbrt
