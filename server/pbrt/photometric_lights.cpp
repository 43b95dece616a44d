#include "server/pbrt/photometric_lights.h"

#include <absl/strings/match.h>
#include <fmt/format.h>

#include <tuple>
#include <utility>

#include "server/files/read_luminaire.h"
#include "server/pbrt/image_lights.h"
#include "server/pbrt/pbrt_images.h"
#include "server/pbrt/pbrt_levels.h"
#include "server/pbrt/pbrt_scales.h"

namespace lucerna::pbrt {
namespace {

void remark_note(LoadState& context, const Parameter& filename, const std::string& name,
                 const PhotometricFile::Note& note) {
  context.remark(filename.place, fmt::format("{}:{}: {}", printable(name), note.line, note.what),
                 note.instead);
}

/// The picture that a parameter names; lights that use it in the same way share it.
std::shared_ptr<const IntensityMap> read_intensity_map(LoadState& context,
                                                       const Parameter& filename,
                                                       SphereMapping mapping, ImageFilter filter,
                                                       std::string& name) {
  const NamedImage named = read_image(context, filename, kSrgb);
  name = named.name;
  std::shared_ptr<const IntensityMap>& map =
      context.intensity_maps[std::tuple(named.name, mapping, filter)];
  if (map != nullptr) return map;
  auto made = IntensityMap::create(named.image, mapping, filter);
  if (!made.ok())
    fail(filename.place,
         fmt::format("\"string filename\": {}: {}; \"string mapping\" \"latlong\" takes any",
                     printable(named.name), std::string(made.status().message())));
  if (!is_grey(*named.image))
    context.remark(
        filename.place,
        fmt::format("{} has colours, but a goniometric light has one intensity for each direction",
                    printable(named.name)),
        "the mean of R, G and B, the same as in pbrt-v4");
  return map = *std::move(made);
}

}  // namespace

bool names_photometric_file(const std::string& name) {
  return absl::EndsWithIgnoreCase(name, ".ies") || absl::EndsWithIgnoreCase(name, ".ldt");
}

NamedPhotometricFile read_photometric_file(LoadState& context, const ParameterSet& params,
                                           const Parameter& filename) {
  if (filename.strings().size() != 1)
    fail(filename.place, fmt::format("\"string {}\" takes one name", filename.name));
  const AssetContent content = context.read(filename);
  PhotometricFile& file = context.photometric_files[content.name];
  if (file.web == nullptr) {
    context.poll();
    const std::string shown = printable(content.name);
    auto parsed = read_luminaire(content.bytes, shown);
    if (!parsed.ok())
      fail(filename.place, absl::Status(parsed.status().code(),
                                        fmt::format("\"string {}\": {}", filename.name,
                                                    std::string(parsed.status().message()))));
    for (const PhotometricFile::Note& note : parsed->notes)
      remark_note(context, filename, content.name, note);
    file = *std::move(parsed);
  }
  NamedPhotometricFile named{content.name, file, {}};
  if (file.unit && positive_parameter(params, "power") == nullptr) {
    named.flux_unit = file.flux_unit;
    remark_note(context, filename, content.name, *file.unit);
  }
  return named;
}

GoniometricLightParams goniometric(LoadState& context, const ParameterSet& params,
                                   const Transform& world_from_light) {
  GoniometricLightParams light;
  light.position_m = world_from_light.point({0, 0, 0});
  light.intensity = Rgb(1);
  const Parameter* filename = params.find("filename", {"string"});
  if (filename == nullptr) {
    // A light that is equal in all directions does not need axes.
    check_without_picture(context, params, {"mapping", "filter"});
    return light;
  }
  light.own_space = own_space_of(context, params, world_from_light);
  light.axes = axes_of(world_from_light);
  if (filename->strings().size() == 1 && names_photometric_file(filename->strings().front())) {
    NamedPhotometricFile named = read_photometric_file(context, params, *filename);
    if (named.file.opening) remark_note(context, *filename, named.name, *named.file.opening);
    light.web = std::move(named.file.web);
    light.file = std::move(named.name);
    light.format = std::move(named.file.format);
    light.web_unit = std::move(named.file.flux_unit);
    light.flux_unit = std::move(named.flux_unit);
    return light;
  }
  const SphereMapping mapping = sphere_mapping(params);
  light.map = read_intensity_map(context, *filename, mapping, image_filter(params), light.file);
  // pbrt-v4 swaps y and z when it looks up the picture.
  if (mapping == SphereMapping::kEqualArea) std::swap(light.axes.t, light.axes.n);
  return light;
}

}  // namespace lucerna::pbrt
