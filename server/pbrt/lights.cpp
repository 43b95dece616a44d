#include "server/pbrt/lights.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "lights/shapes/bilinear_patch.h"
#include "lights/shapes/triangle.h"
#include "proto/common/defaults.h"
#include "server/pbrt/area_lights.h"
#include "server/pbrt/image_lights.h"
#include "server/pbrt/levels.h"
#include "server/pbrt/photometric_lights.h"
#include "server/pbrt/projection_lights.h"
#include "server/pbrt/scales.h"
#include "server/pbrt/spectra.h"

namespace lucerna::pbrt {
namespace {

constexpr double kRadPerDegree = kPi / 180;

/// A `power` or `illuminance` that a light may be given, and what it is without.
struct Target {
  const char* name;
  const char* unit;
  double of_unit_level;  ///< what a level of luminance 1 amounts to
};

/// The level (intensity, radiance or illuminance) of a light: rgb or spectrum, times scale, and
/// where the target is given, such that a light of luminance 1 would reach it.
Rgb<double> level(Context& context, const ParameterSet& params, const Place& place,
                  const char* name, const std::optional<Target>& target) {
  const Rgb<double> colour = light_level(context, params, name);
  const double scale = params.number("scale", 1);
  if (scale < 0)
    fail(params.find("scale", {"float"})->place,
         fmt::format("\"float scale\" = {}, allowed: not negative", scale));
  Rgb<double> result = colour * scale;
  const Parameter* given = target ? params.find(target->name, {"float"}) : nullptr;
  if (given != nullptr) {
    const double wanted = params.number(target->name, 0);
    // -1 is how pbrt-v4 itself writes that nothing is given.
    if (wanted < 0 && wanted != -1)
      fail(given->place,
           fmt::format("\"float {}\" = {}, allowed: not negative", target->name, wanted));
    if (wanted == 0) {
      context.remark(given->place, fmt::format("\"{}\" 0 is taken as not given", target->name),
                     fmt::format("the level that \"{}\" says", name));
    } else if (wanted > 0) {
      if (!(luminance(result) > 0))
        fail(given->place,
             fmt::format("\"float {}\" = {} {} for a light of luminance 0, which cannot have it{}",
                         target->name, wanted, target->unit, kOnlyAsIfNotGiven));
      if (!(target->of_unit_level > 0))
        fail(given->place, fmt::format("\"float {}\" = {} {} for a light that lights nothing{}",
                                       target->name, wanted, target->unit, kOnlyAsIfNotGiven));
      // Levels are written with four or five digits: closer to 1 than those can say is meant as 1.
      if (std::fabs(luminance(result) - 1) > 1e-4)
        context.remark(
            given->place,
            fmt::format("\"{}\" {} {} multiplies a level of luminance {:.6g}", target->name, wanted,
                        target->unit, luminance(result)),
            fmt::format("{:.6g} {}, as pbrt-v4 has it", wanted * luminance(result), target->unit));
      result = result * (wanted / target->of_unit_level);
    }
  }
  require_level(level_place(params, name, place),
                fmt::format("the light's level, \"{}\" times \"scale\"{}", name,
                            given ? fmt::format(" and what \"{}\" asks for", given->name) : ""),
                result);
  return result;
}

/// Fails where the light model itself refuses its parameters.
template <template <typename> typename Model, typename Params>
Params checked(const Place& place, const Params& params) {
  if (const auto made = Model<double>::create(params); !made.ok()) fail(place, made.status());
  return params;
}

/// Fails where "to" is "from", or so near that the transform leaves no direction.
void require_direction(const ParameterSet& params, const Place& place,
                       const Vec3<double>& direction) {
  if (is_finite(direction) && direction != Vec3<double>{}) return;
  const Vec3<double> from = params.point("from", {0, 0, 0}), to = params.point("to", {0, 0, 1});
  fail(
      params.place_of({"to", "from"}, place),
      fmt::format("\"point3 to\" = ({}, {}, {}) and \"from\" = ({}, {}, {}), which are ({}, {}, "
                  "{}) m apart in the world, allowed: a finite distance, not 0",
                  to.x, to.y, to.z, from.x, from.y, from.z, direction.x, direction.y, direction.z));
}

SpotLightParams spot(Context& context, const ParameterSet& params, const Place& place,
                     const Transform& world_from_light) {
  const double cone = params.number("coneangle", 30);
  const double delta = params.number("conedeltaangle", 5);
  if (!(cone > 0 && cone <= 180))
    fail(params.place_of({"coneangle"}, place),
         fmt::format("\"float coneangle\" = {} degrees, allowed (0, 180]", cone));
  // Where it is not given, it is the cone that is too narrow for it.
  if (!(delta >= 0 && delta <= cone))
    fail(params.place_of({"conedeltaangle", "coneangle"}, place),
         fmt::format("\"float conedeltaangle\" = {} degrees{}, allowed [0, coneangle], which is {}",
                     delta, params.number("conedeltaangle") ? "" : " unless it is given", cone));
  require_equal_scale(place, "a spot", world_from_light);
  SpotLightParams spot;
  const Vec3<double> from = params.point("from", {0, 0, 0});
  spot.position_m = world_from_light.point(from);
  spot.axis = world_from_light.vector(params.point("to", {0, 0, 1}) - from);
  require_direction(params, place, spot.axis);
  spot.cone_half_angle_rad = cone * kRadPerDegree;
  spot.falloff_start_rad = (cone - delta) * kRadPerDegree;
  const std::string profile = params.string("profile", "smoothstep");
  if (profile == "quartic")
    spot.profile = SpotProfile::kQuartic;
  else if (profile != "smoothstep")
    fail(params.find("profile", {"string"})->place,
         fmt::format("\"string profile\" = \"{}\", allowed: smoothstep, quartic",
                     printable(profile)));
  const double lumens = effective_solid_angle_sr(spot);
  spot.intensity_cd = level(context, params, place, "I", Target{"power", "lm", lumens});
  return checked<SpotLight>(place, spot);
}

double area_of(const Place& place, const TriangleMeshData& mesh) {
  double area = 0;
  for (std::size_t i = 0; i + 3 <= mesh.indices.size(); i += 3)
    area += Triangle<double>{mesh.positions[mesh.indices[i]], mesh.positions[mesh.indices[i + 1]],
                             mesh.positions[mesh.indices[i + 2]]}
                .area();
  if (!std::isfinite(area)) fail(place, "the area of an emitting mesh is not finite");
  return area;
}

double area_of(const Place& place, const PatchMeshData& mesh) {
  double area = 0;
  for (std::size_t i = 0; i + 4 <= mesh.indices.size(); i += 4)
    area +=
        BilinearPatch<double>{mesh.positions[mesh.indices[i]], mesh.positions[mesh.indices[i + 1]],
                              mesh.positions[mesh.indices[i + 2]],
                              mesh.positions[mesh.indices[i + 3]]}
            .area();
  if (!std::isfinite(area)) fail(place, "the area of an emitting mesh is not finite");
  return area;
}

double area_of(const Place& place, const SphereParams& params) {
  const auto sphere = Sphere<double>::create(params);
  if (!sphere.ok()) fail(place, sphere.status());
  if (const auto status = sphere->emissive_error(); !status.ok()) fail(place, status);
  return sphere->area();
}

double area_of(const Place& place, const DiskParams& params) {
  const auto disk = Disk<double>::create(params);
  if (!disk.ok()) fail(place, disk.status());
  return disk->area();
}

double area_of(const Place& place, const CylinderParams& params) {
  const auto cylinder = Cylinder<double>::create(params);
  if (!cylinder.ok()) fail(place, cylinder.status());
  if (const auto status = cylinder->emissive_error(); !status.ok()) fail(place, status);
  return cylinder->area();
}

/// Points that each sample takes on it: not pbrt-v4's but pbrt-v3's.
std::uint32_t samples_of(const ParameterSet& params) {
  const int samples = params.integer("samples", 1);
  if (samples < 1 || samples > static_cast<int>(kMostSamplesPerLight))
    fail(params.find("samples", {"integer"})->place,
         fmt::format("\"integer samples\" = {}, allowed [1, {}]", samples, kMostSamplesPerLight));
  return static_cast<std::uint32_t>(samples);
}

std::size_t primitives_of(const Geometry& geometry) {
  if (const auto* mesh = std::get_if<TriangleMeshData>(&geometry)) return mesh->indices.size() / 3;
  if (const auto* mesh = std::get_if<PatchMeshData>(&geometry)) return mesh->indices.size() / 4;
  return 1;
}

}  // namespace

std::optional<LightDescription> make_light(Context& context, const std::string& type,
                                           const ParameterSet& params, const Place& place,
                                           const Transform& world_from_light) {
  LightDescription light;
  light.where = location(place);
  light.samples = samples_of(params);
  if (type == "point") {
    PointLightParams point;
    point.position_m = world_from_light.point(params.point("from", {0, 0, 0}));
    point.intensity_cd = level(context, params, place, "I", Target{"power", "lm", 4 * kPi});
    light.params = checked<PointLight>(place, point);
  } else if (type == "spot") {
    light.params = spot(context, params, place, world_from_light);
  } else if (type == "distant") {
    DistantLightParams distant;
    const Vec3<double> towards = params.point("from", {0, 0, 0}) - params.point("to", {0, 0, 1});
    distant.to_light = world_from_light.vector(towards);
    require_direction(params, place, distant.to_light);
    distant.illuminance_lx = level(context, params, place, "L", Target{"illuminance", "lx", 1});
    // Not pbrt's: the angle under which a disk of uniform radiance is seen, such as the sun's 0.53.
    if (const Parameter* diameter = params.find("angulardiameter", {"float"})) {
      const double degrees = params.number("angulardiameter", 0);
      if (!(degrees > 0 && degrees <= 180))
        fail(diameter->place,
             fmt::format("\"float angulardiameter\" = {} degrees, allowed (0, 180]", degrees));
      // It would turn the disk into an ellipse.
      require_equal_scale(diameter->place, "\"float angulardiameter\"", world_from_light);
      light.params = checked<SunLight>(
          place, SunLightParams{distant.to_light, degrees * kRadPerDegree, distant.illuminance_lx});
    } else {
      light.params = checked<DistantLight>(place, distant);
    }
  } else if (type == "infinite") {
    const Parameter* image = params.find("filename", {"string"});
    if (params.find("portal", {"point3"}) != nullptr) {
      PortalLightParams through = portal(context, params, place, world_from_light);
      if (image == nullptr) {
        check_without_picture(context, params, {"mapping", "filter"});
        // pbrt-v4 makes it a picture of one texel, and counts that with the cosine of its middle: 2
        // pi where a uniform sky has pi.
        if (const Parameter* given = params.find("illuminance", {"float"});
            given != nullptr && given->numbers.front() > 0)
          context.remark(given->place, "\"illuminance\" beside a portal, which pbrt-v4 halves",
                         "the uniform sky without the portal gives half of it, as with pbrt-v4");
        through.radiance_cd_m2 =
            level(context, params, place, "L", Target{"illuminance", "lx", 2 * kPi});
        through = checked<PortalLight>(place, through);
      }
      light.params = std::move(through);
      if (image == nullptr) light.spectrum = light_spectrum(context, params, "L");
      params.remark_unused(context, "LightSource \"infinite\"");
      return light;
    }
    if (image != nullptr) {
      light.params = image_infinite(context, params, place, world_from_light);
      params.remark_unused(context, "LightSource \"infinite\"");
      return light;
    }
    check_without_picture(context, params, {"mapping", "filter"});
    UniformInfiniteLightParams infinite;
    // Illuminance on an upward-facing surface under a hemisphere of luminance 1: pi.
    infinite.radiance_cd_m2 = level(context, params, place, "L", Target{"illuminance", "lx", kPi});
    light.params = checked<UniformInfiniteLight>(place, infinite);
  } else if (type == "goniometric") {
    GoniometricLightParams luminaire = goniometric(context, params, place, world_from_light);
    const double lumens = flux_of_unit_intensity_lm(luminaire);
    luminaire.intensity = level(context, params, place, "I", Target{"power", "lm", lumens});
    if (luminaire.web || luminaire.map)
      require_level(level_place(params, "I", place),
                    fmt::format("the largest intensity of {} times the light's level",
                                printable(luminaire.file)),
                    luminaire.intensity *
                        (luminaire.web ? luminaire.web->max_cd() : luminaire.map->max_cd()));
    light.params = checked<GoniometricLight>(place, luminaire);
  } else if (type == "projection") {
    Projection thrown = projection(context, params, place, world_from_light);
    const Rgb<double> of_1 =
        level(context, params, place, "I", Target{"power", "lm", thrown.pbrt4_lumens});
    const Parameter* power = params.find("power", {"float"});
    const bool by_power = power != nullptr && power->numbers.front() > 0;
    set_level(context, level_place(params, "I", place), by_power ? &power->place : nullptr, of_1,
              thrown);
    std::visit([&](auto& p) { light.params = std::move(p); }, thrown.light);
  } else {
    fail(place, fmt::format("unknown light \"{}\", expected one of point spot distant infinite "
                            "goniometric projection",
                            printable(type)));
  }
  const char* level_name = type == "distant" || type == "infinite" ? "L" : "I";
  if (type == "projection" && params.find("filename", {"string"}) != nullptr)
    remark_on_spectrum_of_picture(context, params, level_name);
  else
    light.spectrum = light_spectrum(context, params, level_name);
  params.remark_unused(context, fmt::format("LightSource \"{}\"", type));
  return light;
}

bool needs_uv(const AreaLightDirective& light) {
  return light.params.find("filename", {"string"}) != nullptr ||
         light.params.find("profile", {"string"}) != nullptr;
}

std::optional<ShapeDescription::Emission> make_emission(Context& context,
                                                        const AreaLightDirective& light,
                                                        const Geometry& geometry,
                                                        const Place& shape_place, bool mirrored) {
  if (light.type != "diffuse")
    fail(light.place,
         fmt::format("unknown area light \"{}\", expected \"diffuse\"", printable(light.type)));
  ShapeDescription::Emission emission;
  emission.picture = area_picture(context, light.params);
  emission.two_sided = light.params.boolean("twosided", false);
  emission.where = location(light.place);
  emission.samples = samples_of(light.params);
  const double area =
      std::visit([&](const auto& shape) { return area_of(shape_place, shape); }, geometry);
  if (!(area > 0)) {
    if (const Parameter* power = light.params.find("power", {"float"});
        power != nullptr && power->numbers.front() > 0)
      fail(power->place,
           fmt::format("\"float power\" = {} lm for the shape at {}, which has no area{}",
                       power->numbers.front(), to_string(shape_place), kOnlyAsIfNotGiven));
    context.remark(shape_place, "a light without area", "the shape emits nothing");
    return std::nullopt;
  }
  // pbrt-v4 takes a picture's mean, as if all of its texels had the same area on the shape.
  const double mean = emission.picture ? luminance(emission.picture->image->mean()) : 1;
  double lumens = (emission.two_sided ? 2 : 1) * kPi * area * mean;
  emission.panel = area_profile(context, light.params, geometry, shape_place, mirrored);
  if (emission.panel) {
    const PhotometricWeb& web = *emission.panel->web;
    lumens = emission.two_sided ? web.flux_lm() : web.downward_flux_lm();
    // A millionth is what the sums of a file's own digits leave.
    if (const double lost = web.flux_lm() - lumens; lost > 1e-6 * web.flux_lm())
      context.remark(light.params.find("profile", {"string"})->place,
                     fmt::format("{:.6g} of the file's {:.6g} lm go to the back of a panel that "
                                 "shines to its front only",
                                 lost, web.flux_lm()),
                     "left out; \"bool twosided\" true has them");
  }
  emission.radiance_cd_m2 =
      level(context, light.params, light.place, "L", Target{"power", "lm", lumens});
  if (emission.picture)
    require_level(level_place(light.params, "L", light.place),
                  fmt::format("the brightest texel of {} times the light's level",
                              printable(emission.picture->name)),
                  emission.radiance_cd_m2 * emission.picture->brightest());
  if (emission.panel)
    require_level(level_place(light.params, "L", light.place),
                  fmt::format("the radiance of a surface with the flux of {} times the light's "
                              "level",
                              printable(emission.panel->file)),
                  emission.radiance_cd_m2 * lumens / ((emission.two_sided ? 2 : 1) * kPi * area));
  emission.spectrum = light_spectrum(context, light.params, "L");
  const std::size_t primitives = primitives_of(geometry);
  if (const Parameter* power = light.params.find("power", {"float"});
      power != nullptr && power->numbers.front() > 0 && primitives > 1)
    context.remark(power->place,
                   fmt::format("\"power\" on a mesh of {} primitives, each of which pbrt-v4 would "
                               "give that power",
                               primitives),
                   "the power of the whole mesh");
  if (const Parameter* power = light.params.find("power", {"float"});
      power != nullptr && power->numbers.front() > 0 && emission.picture &&
      !shows_texels_alike(geometry))
    context.remark(power->place,
                   "\"power\" of a picture on a shape that shows its texels on unequal areas",
                   "that of the picture's mean, as pbrt-v4 has it");
  light.params.remark_unused(context, "AreaLightSource \"diffuse\"");
  return emission;
}

}  // namespace lucerna::pbrt
