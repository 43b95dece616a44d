#include "server/pbrt/pbrt_area_lights.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <type_traits>

#include "lights/maths/stop_poll.h"
#include "server/description/described_shape.h"
#include "server/pbrt/image_lights.h"
#include "server/pbrt/pbrt_levels.h"
#include "server/pbrt/pbrt_lights.h"
#include "server/pbrt/pbrt_spectra.h"
#include "server/pbrt/photometric_lights.h"

namespace lucerna::pbrt {
namespace {

/// dp/du of the first primitive that has an area; its first edge if its (u, v) are degenerate.
/// `normal(corners)` is the normal of a primitive.
template <std::size_t kCorners, typename Mesh, typename F>
Vec3 tangent_of(const Mesh& mesh, F&& normal) {
  static constexpr std::array<Vec2f, 4> kPatch{{{0, 0}, {1, 0}, {0, 1}, {1, 1}}};
  StopPoll poll;
  for (std::size_t i = 0; i + kCorners <= mesh.indices.size(); i += kCorners, poll()) {
    std::array<Vec3, kCorners> p;
    std::array<Vec2f, kCorners> uv;
    for (std::size_t k = 0; k < kCorners; ++k) {
      p[k] = mesh.positions[mesh.indices[i + k]];
      uv[k] = mesh.corner_uv.empty() ? kPatch[k] : mesh.corner_uv[i + k];
    }
    if (normal(p) == Vec3{}) continue;
    const Vec3 e = p[1] - p[0], f = p[2] - p[0];
    const double du1 = uv[1].x - uv[0].x, dv1 = uv[1].y - uv[0].y;
    const double du2 = uv[2].x - uv[0].x, dv2 = uv[2].y - uv[0].y;
    const double determinant = du1 * dv2 - dv1 * du2;
    // Limits the sine between the edges of the chart, which does not depend on their length.
    constexpr double kParallel = 1e-9;
    if (!(std::fabs(determinant) > kParallel * std::hypot(du1, dv1) * std::hypot(du2, dv2)))
      return e;
    return (e * dv2 - f * dv1) / determinant;
  }
  return {};
}

[[noreturn]] void refuse_profile(const FilePosition& shape_place, std::string_view name) {
  std::string flat_names = "bilinearmesh, trianglemesh, plymesh";
  Quadrics::for_each([&]<typename Shape>() {
    if (FlatShape<Shape>) flat_names += fmt::format(", {}", Shape::kName);
  });
  fail(shape_place, fmt::format("a light with \"profile\" on a {}, allowed: flat shapes ({})", name,
                                flat_names));
}

Vec3 tangent_of(const Geometry& geometry, const FilePosition& shape_place) {
  if (const auto* mesh = std::get_if<TriangleMeshData>(&geometry))
    return tangent_of<3>(*mesh, [](const auto& p) { return Triangle{p[0], p[1], p[2]}.normal(); });
  if (const auto* mesh = std::get_if<PatchMeshData>(&geometry))
    return tangent_of<4>(*mesh, [](const auto& p) {
      return BilinearPatch{p[0], p[1], p[2], p[3]}.normal({0.5, 0.5});
    });
  return std::visit(
      [&]<typename Params>(const Params& params) -> Vec3 {
        if constexpr (requires { typename QuadricOf<Params>; }) {
          if constexpr (FlatShape<QuadricOf<Params>>)
            return params.world_from_object.vector({1, 0, 0});
          else
            refuse_profile(shape_place, QuadricOf<Params>::kName);
        }
        refuse_profile(shape_place, "mesh");
      },
      geometry);
}

/// The emission image of "string filename"; nothing if there is none.  Fails if "L" is given too.
std::optional<Picture> area_picture(LoadState& context, const ParameterSet& params) {
  const Parameter* filename = params.find("filename", {"string"});
  if (filename == nullptr) {
    check_without_picture(context, params, {"filter"});
    return std::nullopt;
  }
  if (const Parameter* l = params.find("L", {"rgb", "spectrum", "blackbody"}))
    fail(l->place, "\"L\" and \"filename\" are both given, allowed: one of them, and \"scale\"");
  NamedImage named = read_image(context, *filename, kLuminances);
  return Picture{std::move(named.image), image_filter(params, "bilinear"), std::move(named.name)};
}

/// The photometry of "string profile"; nothing if there is none.  Fails on files of other kinds,
/// and on shapes that are not flat.
std::optional<PanelProfile> area_profile(LoadState& context, const ParameterSet& params,
                                         const Geometry& geometry, const FilePosition& shape_place,
                                         bool mirrored) {
  const Parameter* file = params.find("profile", {"string"});
  if (file == nullptr) return std::nullopt;
  if (file->strings().size() != 1 || !names_photometric_file(file->strings().front()))
    fail(file->place,
         fmt::format("\"string profile\" = \"{}\", allowed: the name of an .ies or .ldt file",
                     file->strings().empty() ? "" : printable(file->strings().front())));
  NamedPhotometricFile named = read_photometric_file(context, params, *file);
  PanelProfile profile{.web = std::move(named.file.web),
                       .tangent = tangent_of(geometry, shape_place),
                       .mirrored = mirrored,
                       .file = std::move(named.name),
                       .format = std::move(named.file.format),
                       .web_unit = std::move(named.file.flux_unit),
                       .flux_unit = std::move(named.flux_unit)};
  const auto shape = create_shape(geometry, {}, false);
  if (!shape.ok()) fail(shape_place, shape.status());
  if (const auto axes = photometric_axes(**shape, profile); !axes.ok())
    fail(shape_place, axes.status());
  return profile;
}

/// Whether every texel of an emission image has the same area on the shape.
bool has_equal_texels(const Geometry& geometry) {
  if (std::holds_alternative<CylinderParams>(geometry)) return true;
  const auto* mesh = std::get_if<PatchMeshData>(&geometry);
  if (mesh == nullptr || !mesh->corner_uv.empty()) return false;
  StopPoll poll;
  for (std::size_t i = 0; i + 4 <= mesh->indices.size(); i += 4, poll()) {
    const auto corner = [&](std::size_t k) { return mesh->positions[mesh->indices[i + k]]; };
    const Vec3 along = corner(1) - corner(0), across = corner(2) - corner(0);
    const Vec3 opposite = corner(3) - corner(2);
    if (length(opposite - along) > 1e-6 * (length(along) + length(across))) return false;
  }
  return true;
}

/// The area of the shape [m2].  0 for a curve: make_emission refuses it before.
double area_of(const FilePosition& place, const Geometry& geometry) {
  return std::visit(
      [&]<typename Params>(const Params& params) -> double {
        double area = 0;
        if constexpr (requires { typename QuadricOf<Params>; }) {
          const auto shape = QuadricOf<Params>::create(params);
          if (!shape.ok()) fail(place, shape.status());
          if (const auto status = shape->emissive_error(); !status.ok()) fail(place, status);
          area = shape->area();
        } else if constexpr (!std::is_same_v<Params, CurveData>) {
          StopPoll poll;
          for (const auto& primitive : lucerna::primitives_of(params, {}))
            poll(), area += primitive.area();
          if (!std::isfinite(area)) fail(place, "the area of an emitting mesh is not finite");
        }
        return area;
      },
      geometry);
}

std::size_t primitives_of(const Geometry& geometry) {
  if (const auto* mesh = std::get_if<TriangleMeshData>(&geometry)) return mesh->indices.size() / 3;
  if (const auto* mesh = std::get_if<PatchMeshData>(&geometry)) return mesh->indices.size() / 4;
  return 1;
}

/// Sides that emit.
double sides(const ShapeDescription::Emission& emission) { return emission.two_sided ? 2 : 1; }

/// A shape without area emits nothing, so a "power" for it is an error.
void refuse_power_without_area(const ParameterSet& params, const FilePosition& shape_place) {
  if (const Parameter* power = positive_parameter(params, "power"))
    fail(power->place,
         fmt::format("\"float power\" = {} lm for the shape at {}, which has no area{}",
                     power->numbers().front(), to_string(shape_place), kOnlyAsIfNotGiven));
}

/// Luminous flux of a panel at level 1 [lm].  Adds a remark if its back, which does not emit, loses
/// a part.
double panel_lumens(LoadState& context, const ParameterSet& params,
                    const ShapeDescription::Emission& emission) {
  const PhotometricWeb& web = *emission.panel->web;
  const double lumens = emission.two_sided ? web.flux_lm() : web.downward_flux_lm();
  // A relative 1e-6 allows for the digits of the file.
  if (const double lost = web.flux_lm() - lumens; lost > 1e-6 * web.flux_lm())
    context.remark(params.find("profile", {"string"})->place,
                   fmt::format("{:.6g} of the file's {:.6g} {} go to the back of a panel that "
                               "emits from its front only",
                               lost, web.flux_lm(),
                               emission.panel->web_unit.empty() ? "lm" : emission.panel->web_unit),
                   "left out; \"bool twosided\" true includes them");
  return lumens;
}

/// Luminous flux of the shape at level 1 [lm].
double lumens_of_unit_level(LoadState& context, const ParameterSet& params,
                            const ShapeDescription::Emission& emission, double area) {
  // pbrt-v4 uses a picture's mean, as if all of its texels had the same area on the shape.
  const double mean = emission.picture ? luminance(emission.picture->image->mean()) : 1;
  if (emission.panel) return panel_lumens(context, params, emission) * mean;
  return sides(emission) * kPi * area * mean;
}

/// Fails if the brightest radiance of a picture or a panel does not fit a float.
void require_emission(const ParameterSet& params, const ShapeDescription::Emission& emission,
                      double lumens, double area) {
  const FilePosition place = level_place(params, "L");
  if (emission.picture)
    require_level(place,
                  fmt::format("the brightest texel of {} times the light's level",
                              printable(emission.picture->name)),
                  emission.radiance_cd_m2 * emission.picture->image->brightest());
  if (emission.panel)
    require_level(place,
                  fmt::format("the radiance of a surface with the flux of {} times the light's "
                              "level",
                              printable(emission.panel->file)),
                  emission.radiance_cd_m2 * lumens / (sides(emission) * kPi * area));
}

/// Adds remarks if "power" differs from pbrt-v4, or only approximates a picture.
void remark_power(LoadState& context, const ParameterSet& params, const Geometry& geometry,
                  bool has_picture) {
  const Parameter* power = positive_parameter(params, "power");
  if (power == nullptr) return;
  if (const std::size_t primitives = primitives_of(geometry); primitives > 1)
    context.remark(
        power->place,
        fmt::format(
            "\"power\" on a mesh of {} primitives; pbrt-v4 gives this power to each of them",
            primitives),
        "the power of the whole mesh");
  if (has_picture && !has_equal_texels(geometry))
    context.remark(power->place,
                   "\"power\" of a picture on a shape that shows its texels on unequal areas",
                   "that of the picture's mean, the same as in pbrt-v4");
}

}  // namespace

bool needs_uv(const ParameterSet& params) {
  return params.find("filename", {"string"}) != nullptr ||
         params.find("profile", {"string"}) != nullptr;
}

std::optional<ShapeDescription::Emission> make_emission(LoadState& context,
                                                        const ParameterSet& params,
                                                        const Geometry& geometry,
                                                        const FilePosition& shape_place,
                                                        bool mirrored) {
  if (std::holds_alternative<CurveData>(geometry)) {
    context.remark(shape_place, "a curve that emits is not modelled", "the curve emits nothing");
    return std::nullopt;
  }
  if (params.type() != "diffuse")
    fail(params.place(),
         fmt::format("unknown area light \"{}\", expected \"diffuse\"", printable(params.type())));
  ShapeDescription::Emission emission;
  try {
    emission.picture = area_picture(context, params);
  } catch (const LightLeftOut&) {
    return std::nullopt;
  }
  emission.two_sided = params.boolean("twosided", false);
  emission.where = location(params.place());
  emission.samples = samples_of(params);
  emission.name = name_of(params);
  const double area = area_of(shape_place, geometry);
  if (!(area > 0)) {
    refuse_power_without_area(params, shape_place);
    return std::nullopt;
  }
  emission.panel = area_profile(context, params, geometry, shape_place, mirrored);
  const double lumens = lumens_of_unit_level(context, params, emission, area);
  emission.radiance_cd_m2 = light_level_with_target(context, params, "L", {"power", "lm", lumens});
  require_emission(params, emission, lumens, area);
  emission.spectrum = light_spectrum(context, params, "L");
  remark_power(context, params, geometry, emission.picture.has_value());
  params.remark_unused(context, "AreaLightSource \"diffuse\"");
  return emission;
}

}  // namespace lucerna::pbrt
