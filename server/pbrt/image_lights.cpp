#include "server/pbrt/image_lights.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "server/pbrt/levels.h"
#include "server/pbrt/scales.h"

namespace lucerna::pbrt {
namespace {


/// What pbrt-v4 divides "illuminance" by: the sum over the texels above the light's xy plane of
/// luminance times cosine, each of 2 pi over their number - half of their solid angle.
double pbrt_illuminance(const Image& image) {
  const int n = image.width();
  double sum = 0;
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      const Vec2<double> p{(x + 0.5) / n, (y + 0.5) / n};
      const double cos = direction_from_square(SphereMapping::kEqualArea, p).z;
      sum += luminance(Rgb<double>(image.texel(x, y))) * std::max(0.0, cos);
    }
  return sum * 2 * kPi / n / n;
}

/// On a surface that faces +y, of what a latitude-longitude picture shows texel by texel.
double illuminance_from_above(const Image& image) {
  double sum = 0;
  for (int y = 0; y < image.height(); ++y) {
    const auto sine = [&](double row) {
      return std::sin(kPi * std::min(row / image.height(), 0.5));
    };
    double row = 0;
    for (int x = 0; x < image.width(); ++x) row += luminance(Rgb<double>(image.texel(x, y)));
    sum += row * (sine(y + 1) - sine(y)) * (sine(y + 1) + sine(y));
  }
  return sum * kPi / image.width();
}

/// What the picture and its level come to.
ImageInfiniteLightParams picture(Context& context, const ParameterSet& params, const Place& place,
                                 const Transform& world_from_light, ImageFilter otherwise) {
  const Parameter& filename = *params.find("filename", {"string"});
  if (const Parameter* l = params.find("L", {"rgb", "spectrum", "blackbody"}))
    fail(l->place, "\"L\" beside \"filename\", allowed: one of them");
  require_equal_scale(place, "an infinite light", world_from_light);
  const NamedImage named = read_image(context, filename);
  const SphereMapping mapping = sphere_mapping(params);
  const ImageFilter filter = params.find("filter", {"string"}) ? image_filter(params) : otherwise;
  auto map = SphereMap::create(named.image, mapping, filter);
  if (!map.ok())
    fail(filename.place,
         fmt::format("\"string filename\": {}: {}; \"string mapping\" \"latlong\" takes any",
                     named.name, std::string(map.status().message())));
  const double scale = params.number("scale", 1);
  if (scale < 0)
    fail(params.find("scale", {"float"})->place,
         fmt::format("\"float scale\" = {}, allowed: not negative", scale));
  double level = scale;
  if (const Parameter* given = params.find("illuminance", {"float"})) {
    const double wanted = params.number("illuminance", -1);
    // -1 is how pbrt-v4 itself writes that nothing is given.
    if (wanted < 0 && wanted != -1)
      fail(given->place, fmt::format("\"float illuminance\" = {}, allowed: not negative", wanted));
    if (wanted == 0)
      context.remark(given->place, "\"illuminance\" 0 is taken as not given",
                     "the picture's level");
    if (wanted > 0) {
      const bool equal_area = mapping == SphereMapping::kEqualArea;
      const double of_picture =
          equal_area ? pbrt_illuminance(*named.image) : illuminance_from_above(*named.image);
      if (!(of_picture > 0))
        fail(given->place,
             fmt::format("\"float illuminance\" = {} lx for a picture that is black above the "
                         "horizon, which cannot have it{}",
                         wanted, kOnlyAsIfNotGiven));
      if (!(scale > 0))
        fail(
            given->place,
            fmt::format("\"float illuminance\" = {} lx for a picture times a \"scale\" of 0, which "
                        "cannot have it{}",
                        wanted, kOnlyAsIfNotGiven));
      level *= wanted / of_picture;
      if (equal_area)
        context.remark(given->place, "\"illuminance\" of a picture, of which pbrt-v4 counts half",
                       fmt::format("a surface that faces the light's +z gets {:.6g} lx, as with "
                                   "pbrt-v4",
                                   2 * scale * wanted));
    }
  }
  ImageInfiniteLightParams infinite;
  infinite.map = *std::move(map);
  infinite.image_name = named.name;
  infinite.world_from_map = world_from_light;
  infinite.radiance_cd_m2 = Rgb<double>(level);
  require_level(
      level_place(params, "L", place),
      fmt::format("the brightest texel of {} times the light's level", printable(named.name)),
      infinite.map->brightest() * infinite.radiance_cd_m2);
  return infinite;
}

}  // namespace

SphereMapping sphere_mapping(const ParameterSet& params) {
  const std::string name = params.string("mapping", "equalarea");
  if (name == "equalarea") return SphereMapping::kEqualArea;
  if (name == "latlong") return SphereMapping::kLatitudeLongitude;
  fail(params.find("mapping", {"string"})->place,
       fmt::format("\"string mapping\" = \"{}\", allowed: equalarea, latlong", printable(name)));
}

void check_without_picture(Context& context, const ParameterSet& params,
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

ImageInfiniteLightParams image_infinite(Context& context, const ParameterSet& params,
                                        const Place& place, const Transform& world_from_light) {
  ImageInfiniteLightParams infinite =
      picture(context, params, place, world_from_light, ImageFilter::kNearest);
  // All that can fail, here where its place is known, and levels that floats, which answers tell,
  // do not hold.
  if (const auto made = ImageInfiniteLight<float>::create(infinite); !made.ok())
    fail(level_place(params, "L", place), made.status());
  return infinite;
}

PortalLightParams portal(Context& context, const ParameterSet& params, const Place& place,
                         const Transform& world_from_light) {
  const Parameter& given = *params.find("portal", {"point3"});
  const std::vector<Vec3<double>> corners = params.vectors("portal", "point3");
  PortalLightParams light;
  if (corners.size() != light.corners_m.size())
    fail(given.place, fmt::format("\"point3 portal\" of {} points, allowed: 4", corners.size()));
  std::copy(corners.begin(), corners.end(), light.corners_m.begin());
  light.world_from_map = world_from_light;
  if (params.find("filename", {"string"}) != nullptr) {
    ImageInfiniteLightParams infinite =
        picture(context, params, place, world_from_light, ImageFilter::kBilinear);
    light.map = std::move(infinite.map);
    light.image_name = std::move(infinite.image_name);
    light.radiance_cd_m2 = infinite.radiance_cd_m2;
    // What pbrt-v4 makes of what it can read; a filter that is asked for is one of the picture.
    light.rectified = params.find("filter", {"string"}) == nullptr &&
                      light.map->mapping() == SphereMapping::kEqualArea;
  } else {
    // Nothing to turn or stretch.
    light.world_from_map = Transform();
  }
  if (const auto status = PortalLight<float>::check(light); !status.ok())
    fail(given.place, fmt::format("\"point3 portal\": {}", std::string(status.message())));
  return light;
}

}  // namespace lucerna::pbrt
