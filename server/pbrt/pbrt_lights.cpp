#include "server/pbrt/pbrt_lights.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "proto/common/defaults.h"
#include "server/files/printable.h"
#include "server/pbrt/image_lights.h"
#include "server/pbrt/pbrt_levels.h"
#include "server/pbrt/pbrt_scales.h"
#include "server/pbrt/pbrt_spectra.h"
#include "server/pbrt/photometric_lights.h"
#include "server/pbrt/projection_lights.h"

namespace lucerna::pbrt {
namespace {

using LightParams = decltype(LightDescription::params);

/// A LightSource directive and the current transform.
struct LightSource {
  LoadState& context;
  const ParameterSet& params;
  const Transform& world_from_light;

  Rgb level(const char* name, const LevelTarget& target) const {
    return light_level_with_target(context, params, name, target);
  }
};

/// Fails if the light model refuses its parameters.
template <typename Model, typename Params>
Params checked(const LightSource& source, const Params& params) {
  if (const auto made = Model::create(params); !made.ok())
    fail(source.params.place(), made.status());
  return params;
}

/// Fails if "to" equals "from", or if the transformed direction is 0 or not finite.
void require_direction(const LightSource& source, const Vec3& direction) {
  if (is_finite(direction) && direction != Vec3{}) return;
  const ParameterSet& params = source.params;
  const Vec3 from = params.point("from", {0, 0, 0}), to = params.point("to", {0, 0, 1});
  fail(
      params.place_of({"to", "from"}),
      fmt::format("\"point3 to\" = ({}, {}, {}) and \"from\" = ({}, {}, {}), which are ({}, {}, "
                  "{}) m apart in the world, allowed: a finite distance, not 0",
                  to.x, to.y, to.z, from.x, from.y, from.z, direction.x, direction.y, direction.z));
}

LightParams point_light(const LightSource& source) {
  PointLightParams point;
  point.position_m = source.world_from_light.point(source.params.point("from", {0, 0, 0}));
  point.intensity_cd = source.level("I", {"power", "lm", 4 * kPi});
  return checked<PointLight>(source, point);
}

LightParams spot_light(const LightSource& source) {
  const ParameterSet& params = source.params;
  const double cone = params.number(
      "coneangle", 30, [](double c) { return c > 0 && c <= 180; }, " degrees, allowed (0, 180]");
  const double delta = params.number("conedeltaangle", 5);
  // If "conedeltaangle" is not given, its default is too wide for the cone.
  if (!(delta >= 0 && delta <= cone))
    fail(params.place_of({"conedeltaangle", "coneangle"}),
         fmt::format("\"float conedeltaangle\" = {} degrees{}, allowed [0, coneangle], which is {}",
                     delta, params.number("conedeltaangle") ? "" : " unless it is given", cone));
  SpotLightParams spot;
  const Vec3 from = params.point("from", {0, 0, 0});
  spot.position_m = source.world_from_light.point(from);
  spot.axis = source.world_from_light.vector(params.point("to", {0, 0, 1}) - from);
  require_direction(source, spot.axis);
  spot.cone_half_angle_rad = cone * kRadPerDegree;
  spot.falloff_start_rad = (cone - delta) * kRadPerDegree;
  spot.profile = params.choice<SpotProfile>("profile", "smoothstep",
                                            {{"smoothstep", SpotProfile::kSmoothstep},
                                             {"quadratic", SpotProfile::kQuadratic},
                                             {"quartic", SpotProfile::kQuartic}});
  spot.own_space = own_space_of(source.context, params, source.world_from_light);
  spot.intensity_cd = source.level("I", {"power", "lm", effective_solid_angle_sr(spot)});
  return checked<SpotLight>(source, spot);
}

/// "float angulardiameter" is not in pbrt-v4.  It is the angular diameter of a disk of uniform
/// radiance, 0.53 degrees for the sun.
LightParams sun_light(const LightSource& source, const Parameter& diameter,
                      const DistantLightParams& distant) {
  const double degrees = source.params.number(
      "angulardiameter", 0, [](double d) { return d > 0 && d <= 180; },
      " degrees, allowed (0, 180]");
  // Unequal scale would turn the disk into an ellipse.
  require_equal_scale(diameter.place, "\"float angulardiameter\"", source.world_from_light);
  return checked<SunLight>(
      source, SunLightParams{distant.to_light, degrees * kRadPerDegree, distant.illuminance_lx});
}

LightParams distant_light(const LightSource& source) {
  const ParameterSet& params = source.params;
  DistantLightParams distant;
  const Vec3 towards = params.point("from", {0, 0, 0}) - params.point("to", {0, 0, 1});
  distant.to_light = source.world_from_light.vector(towards);
  require_direction(source, distant.to_light);
  distant.illuminance_lx = source.level("L", {"illuminance", "lx", 1});
  if (const Parameter* diameter = params.find("angulardiameter", {"float"}))
    return sun_light(source, *diameter, distant);
  return checked<DistantLight>(source, distant);
}

/// A uniform sky behind a portal; `through` has the corners.
LightParams uniform_portal_light(const LightSource& source, PortalLightParams through) {
  check_without_picture(source.context, source.params, {"mapping", "filter"});
  // pbrt-v4 represents it by a picture of one texel, weighted by the cosine of its middle. The
  // illuminance of luminance 1 is then 2 pi, while a uniform sky has pi.
  if (const Parameter* given = positive_parameter(source.params, "illuminance"))
    source.context.remark(
        given->place, "\"illuminance\" of a portal; pbrt-v4 halves it",
        "the uniform sky without the portal gives half of it, the same as in pbrt-v4");
  through.radiance_cd_m2 = source.level("L", {"illuminance", "lx", 2 * kPi});
  return checked<PortalLight>(source, through);
}

LightParams uniform_infinite_light(const LightSource& source) {
  check_without_picture(source.context, source.params, {"mapping", "filter"});
  UniformInfiniteLightParams infinite;
  // A hemisphere of luminance 1 gives illuminance pi on a surface that faces up.
  infinite.radiance_cd_m2 = source.level("L", {"illuminance", "lx", kPi});
  return checked<UniformInfiniteLight>(source, infinite);
}

LightParams infinite_light(const LightSource& source) {
  const auto& [context, params, world_from_light] = source;
  const bool has_picture = params.find("filename", {"string"}) != nullptr;
  if (params.find("portal", {"point3"}) != nullptr) {
    PortalLightParams through = portal(context, params, world_from_light);
    return has_picture ? LightParams(std::move(through))
                       : uniform_portal_light(source, std::move(through));
  }
  if (has_picture) return image_infinite(context, params, world_from_light);
  return uniform_infinite_light(source);
}

LightParams goniometric_light(const LightSource& source) {
  const auto& [context, params, world_from_light] = source;
  GoniometricLightParams luminaire = goniometric(context, params, world_from_light);
  luminaire.intensity = source.level("I", {"power", "lm", flux_of_unit_intensity_lm(luminaire)});
  if (luminaire.web || luminaire.map)
    require_level(
        level_place(params, "I"),
        fmt::format("the largest intensity of {} times the light's level",
                    printable(luminaire.file)),
        luminaire.intensity * (luminaire.web ? luminaire.web->max_cd() : luminaire.map->max_cd()));
  return checked<GoniometricLight>(source, luminaire);
}

LightParams projection_light(const LightSource& source) {
  const auto& [context, params, world_from_light] = source;
  Projection projected = projection(context, params, world_from_light);
  const Rgb level = source.level("I", {"power", "lm", projected.pbrt4_lumens});
  const Parameter* power = positive_parameter(params, "power");
  set_level(context, level_place(params, "I"), power != nullptr ? &power->place : nullptr, level,
            projected);
  return std::visit([](auto& light) { return LightParams(std::move(light)); }, projected.light);
}

struct LightType {
  std::string_view name;
  const char* level;        ///< the parameter that holds its colour
  bool has_colour_picture;  ///< "filename" is a picture in RGB
  LightParams (*make)(const LightSource&);
};

constexpr auto kLightTypes = std::to_array<LightType>({
    {"point", "I", false, point_light},
    {"spot", "I", false, spot_light},
    {"distant", "L", false, distant_light},
    {"infinite", "L", true, infinite_light},
    {"goniometric", "I", false, goniometric_light},
    {"projection", "I", true, projection_light},
});

const LightType& light_type(const ParameterSet& params) {
  const auto* known =
      std::ranges::find(kLightTypes, std::string_view(params.type()), &LightType::name);
  if (known != kLightTypes.end()) return *known;
  std::string names;
  for (const LightType& type : kLightTypes) names += fmt::format(" {}", type.name);
  fail(params.place(),
       fmt::format("unknown light \"{}\", expected one of{}", printable(params.type()), names));
}

}  // namespace

LightDescription make_light(LoadState& context, const ParameterSet& params,
                            const Transform& world_from_light) {
  LightDescription light;
  light.where = location(params.place());
  light.samples = samples_of(params);
  light.name = name_of(params);
  const LightType& known = light_type(params);
  light.params = known.make({context, params, world_from_light});
  if (known.has_colour_picture && params.find("filename", {"string"}) != nullptr)
    remark_on_spectrum_of_picture(context, params, known.level);
  else
    light.spectrum = light_spectrum(context, params, known.level);
  params.remark_unused(context, fmt::format("LightSource \"{}\"", params.type()));
  return light;
}

std::uint32_t samples_of(const ParameterSet& params) {
  const int samples = params.integer("samples", 1);
  if (samples < 1 || samples > static_cast<int>(kMostSamplesPerLight))
    fail(params.find("samples", {"integer"})->place,
         fmt::format("\"integer samples\" = {}, allowed [1, {}]", samples, kMostSamplesPerLight));
  return static_cast<std::uint32_t>(samples);
}

std::string name_of(const ParameterSet& params) {
  if (params.find("name", {"string"}) == nullptr) return {};
  std::string name = params.string("name", "");
  if (!is_light_name(name))
    fail(params.find("name", {"string"})->place,
         fmt::format("\"string name\" = \"{}\", {} bytes, allowed: 1 to {} bytes of UTF-8 without "
                     "control characters",
                     printable(name), name.size(), kMostLightNameBytes));
  return name;
}

}  // namespace lucerna::pbrt
