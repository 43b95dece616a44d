#include "server/pbrt/photometric_lights.h"

#include <fmt/format.h>

#include <utility>

#include "server/eulumdat.h"
#include "server/ies.h"

namespace lucerna::pbrt {
namespace {

bool ends_in(const std::string& name, std::string_view lower_case) {
  if (name.size() < lower_case.size()) return false;
  const std::string_view end = std::string_view(name).substr(name.size() - lower_case.size());
  for (std::size_t i = 0; i < end.size(); ++i) {
    const char c = end[i] >= 'A' && end[i] <= 'Z' ? static_cast<char>(end[i] + 32) : end[i];
    if (c != lower_case[i]) return false;
  }
  return true;
}

}  // namespace

bool names_photometric_file(const std::string& name) {
  return ends_in(name, ".ies") || ends_in(name, ".ldt");
}

NamedPhotometricFile read_photometric_file(Context& context, const Parameter& filename) {
  if (filename.strings.size() != 1)
    fail(filename.place, fmt::format("\"string {}\" takes one name", filename.name));
  const AssetContent content = context.read(filename.place, filename.strings.front());
  PhotometricFile& file = context.photometric_files[content.name];
  if (file.web == nullptr) {
    context.poll();
    const std::string shown = printable(content.name);
    auto parsed = ends_in(content.name, ".ldt") ? parse_eulumdat(content.bytes, shown)
                                                : parse_ies(content.bytes, shown);
    if (!parsed.ok())
      fail(filename.place, absl::Status(parsed.status().code(),
                                        fmt::format("\"string {}\": {}", filename.name,
                                                    std::string(parsed.status().message()))));
    for (const PhotometricFile::Note& note : parsed->notes)
      context.remark(filename.place, fmt::format("{}:{}: {}", shown, note.line, note.what),
                     note.instead);
    file = *std::move(parsed);
  }
  return {content.name, file};
}

std::optional<GoniometricLightParams> goniometric(Context& context, const ParameterSet& params,
                                                  const Place& place,
                                                  const Transform& world_from_light) {
  if (!world_from_light.uniform_scale())
    fail(
        place,
        "a goniometric light under a transform of unequal scale, allowed: equal scale on all axes");
  GoniometricLightParams light;
  light.position_m = world_from_light.point({0, 0, 0});
  light.axes = {world_from_light.vector({1, 0, 0}), world_from_light.vector({0, 1, 0}),
                world_from_light.vector({0, 0, 1})};
  light.intensity = Rgb<double>(1);
  const Parameter* filename = params.find("filename", {"string"});
  if (filename == nullptr) return light;
  if (filename->strings.size() == 1 && !names_photometric_file(filename->strings.front())) {
    context.remark(filename->place, "a goniometric light with an image is not modelled yet",
                   "left out");
    return std::nullopt;
  }
  NamedPhotometricFile named = read_photometric_file(context, *filename);
  light.web = std::move(named.file.web);
  light.file = std::move(named.name);
  light.format = std::move(named.file.format);
  return light;
}

}  // namespace lucerna::pbrt
