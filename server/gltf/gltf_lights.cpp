#include "server/gltf/gltf_lights.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lights/maths/level_validation.h"
#include "server/files/read_luminaire.h"

namespace lucerna::gltf {
namespace {

Vec3 column(const Matrix& m, std::size_t j) { return {m[0][j], m[1][j], m[2][j]}; }

Rgb level_of(const View& light, std::string_view unit, double factor) {
  constexpr std::string_view kIntensity = "intensity";
  const std::vector<double> colour = light.numbers("color", {1, 1, 1}, kNotNegative);
  const Rgb level =
      Rgb(colour[0], colour[1], colour[2]) * light.number(kIntensity, 1, kNotNegative) * factor;
  if (const auto status = check_light_value(kIntensity, level, unit, kMostInAnswers); !status.ok())
    light.fail(status);
  return level;
}

/// Of a point light or a spot.
Rgb intensity_cd(const View& light) {
  return level_of(light, "cd", light.context().scene.level_factors.lamps);
}

/// An angle of at least 0.  Beyond `least` and `most` it ends there, with a remark unless an
/// exporter that holds floats made the difference.
double angle_of(const View& angles, std::string_view key, double otherwise, double least,
                double most) {
  constexpr double kRounded = 1e-6;
  const double angle = angles.number(key, otherwise, kNotNegative);
  if (angle < least || angle > most + kRounded)
    angles.context().remark(angles.at(key).pointer(),
                            angle < least ? fmt::format("{} rad, less than {}", angle, least)
                                          : fmt::format("{} rad, more than {}", angle, most),
                            "this limit");
  return std::clamp(angle, least, most);
}

SpotLightParams spot_light(const View& light, const Vec3& position, const Vec3& axis) {
  SpotLightParams spot;
  spot.position_m = position;
  spot.axis = axis;
  spot.intensity_cd = intensity_cd(light);
  // Earlier drafts of the extension allowed a spot without its angles.
  const auto given = light.find("spot");
  const View angles = given ? given->require_object() : light;
  constexpr double kRight = std::numbers::pi / 2;
  constexpr double kDigits = 5e-4;  // files have angles of as few as four digits
  if (const auto outer = angles.find("outerConeAngle"); outer && outer->number() > kRight + kDigits)
    outer->fail(fmt::format("found {} rad, allowed: 0 to {}", outer->number(), kRight));
  spot.cone_half_angle_rad = angle_of(angles, "outerConeAngle", std::numbers::pi / 4, 1e-6, kRight);
  spot.falloff_start_rad = angle_of(angles, "innerConeAngle", 0, 0, spot.cone_half_angle_rad);
  // The falloff that the extension suggests, and that renderers use.
  spot.profile = SpotProfile::kQuadratic;
  return spot;
}

/// Sets place, motion and name.  `definition`: the light in the extension of the root.
void set_place(const Document& document, const PlacedNode& node, const View& definition,
               LightDescription& light) {
  const std::string pointer = fmt::format("/nodes/{}", node.index);
  light.where = document.context().location(pointer);
  light.motion = node.motion;
  light.name = document.context().light_name(
      pointer, {document.model().nodes[node.index].name, definition.text("name", "")});
}

void add_punctual(const Document& document, const PlacedNode& node, const View& use) {
  const View light = document.light_of("KHR_lights_punctual", use);
  const Matrix frame = without_scale(node.world_from_node);
  const Vec3 position = column(frame, 3), back = column(frame, 2);
  const std::string& type = light.at("type").text();
  LightDescription result;
  if (type == "point") {
    result.params = PointLightParams{position, intensity_cd(light)};
  } else if (type == "spot") {
    result.params = spot_light(light, position, -back);
  } else if (type == "directional") {
    const double factor = light.context().scene.level_factors.suns;
    result.params = DistantLightParams{back, level_of(light, "lx", factor)};
  } else {
    light.at("type").fail(
        fmt::format("found \"{}\", allowed: point, spot, directional", printable(type)));
  }
  if (const auto range = light.find("range"))
    light.context().remark(range->pointer(),
                           fmt::format("a range of {} m is not applied", range->number()),
                           "light falls off with the square of the distance, without an end");
  set_place(document, node, light, result);
  document.context().scene.lights.push_back(std::move(result));
}

/// World directions of light space's axes.  The zero of both angles is -z of the node.  For types B
/// and C this is straight down of the luminaire, and V = 90, H = 0 is +x.  Horizontal angles of
/// type C are counter-clockwise seen from above, which is from +z of the node, those of type B
/// clockwise.  For type A the zero is ahead, light space's +x; V = 90 is +x of the node here too.
/// [Blut22]
Frame luminaire_axes(const Matrix& frame, PhotometricType type) {
  const Vec3 x = column(frame, 0), y = column(frame, 1), z = column(frame, 2);
  return type == PhotometricType::kA ? Frame{-z, -y, -x} : Frame{x, -y, -z};
}

void add_photometric(const Document& document, const PlacedNode& node, const View& use) {
  const View profile = document.light_of("EXT_lights_ies", use);
  const AssetContent* content = document.read(profile);
  if (content == nullptr) return;
  const auto file = read_luminaire(content->bytes, content->name);
  if (!file.ok()) profile.fail(file.status());
  const auto remark = [&](const PhotometricFile::Note& note) {
    document.context().remark(profile.pointer(),
                              fmt::format("{}:{}: {}", content->name, note.line, note.what),
                              note.instead);
  };
  for (const PhotometricFile::Note& note : file->notes) remark(note);
  if (file->opening) remark(*file->opening);
  if (file->unit) remark(*file->unit);
  const Matrix frame = without_scale(node.world_from_node);
  GoniometricLightParams light;
  light.position_m = column(frame, 3);
  light.axes = luminaire_axes(frame, file->web->type());
  const std::vector<double> colour = use.numbers("color", {1, 1, 1}, kUnit);
  light.intensity =
      Rgb(colour[0], colour[1], colour[2]) * use.number("multiplier", 1, kNotNegative);
  light.web = file->web;
  light.file = content->name;
  light.format = file->format;
  light.web_unit = light.flux_unit = file->flux_unit;
  if (const auto status = GoniometricIntensity::check(light, {}); !status.ok()) use.fail(status);
  if (const auto status =
          check_light_value("goniometric.intensity times the largest of the file",
                            light.intensity * light.web->max_cd(), "cd", kMostInAnswers);
      !status.ok())
    use.fail(status);
  LightDescription result;
  result.params = std::move(light);
  set_place(document, node, profile, result);
  document.context().scene.lights.push_back(std::move(result));
}

}  // namespace

void read_photometric_files(const Document& document) {
  const auto extension = document.root().extension("EXT_lights_ies");
  if (!extension) return;
  const View lights = extension->at("lights");
  for (std::size_t i = 0; i < lights.require_array().size(); ++i) document.read(lights[i]);
}

void add_lights(const Document& document, const PlacedNode& node) {
  const View place = document.root().at("nodes")[node.index];
  if (const auto use = place.extension("KHR_lights_punctual")) add_punctual(document, node, *use);
  if (const auto use = place.extension("EXT_lights_ies")) add_photometric(document, node, *use);
}

void set_camera(const Document& document, const std::vector<PlacedNode>& nodes) {
  LoadState& context = document.context();
  CameraDescription& camera = context.scene.camera;
  Film& film = context.scene.film;
  const PlacedNode* chosen = nullptr;
  for (const PlacedNode& node : nodes) {
    const int index = document.model().nodes[node.index].camera;
    if (index < 0) continue;
    if (chosen == nullptr)
      chosen = &node;
    else
      context.remark(fmt::format("/nodes/{}/camera", node.index), "a second camera",
                     "the first is used");
  }
  // A camera looks along -z; camera space here is left-handed with +z forward.
  const Transform turned = *Transform::scale({1, 1, -1});
  double half_height = 1, half_width = 0;
  if (chosen == nullptr) {
    context.remark("", "the scene has no camera", "one at the origin that looks along -z");
    camera.world_from_camera = turned;
  } else {
    const auto& given =
        document.model()
            .cameras[static_cast<std::size_t>(document.model().nodes[chosen->index].camera)];
    const auto place = Transform::from_matrix(without_scale(chosen->world_from_node));
    if (!place)
      context.fail(fmt::format("/nodes/{}", chosen->index), "the camera has no finite position");
    camera.world_from_camera = *place * turned;
    camera.motion = chosen->motion;
    if (given.type == "perspective") {
      half_height = std::tan(given.perspective.yfov / 2);
      half_width = half_height * given.perspective.aspectRatio;
    } else {
      camera.projection = Projection::kOrthographic;
      half_width = given.orthographic.xmag, half_height = given.orthographic.ymag;
      if (!(half_width > 0 && half_height > 0))
        context.fail(
            fmt::format("/cameras/{}/orthographic", document.model().nodes[chosen->index].camera),
            fmt::format("found xmag {} and ymag {}, allowed: above 0", half_width, half_height));
    }
  }
  // Without an aspect ratio, the film's.
  if (half_width > 0) {
    film.width = static_cast<int>(
        std::clamp(std::round(film.height * half_width / half_height), 1.0, 65536.0));
  } else {
    half_width = half_height * film.width / film.height;
  }
  camera.screen_min = {-half_width, -half_height};
  camera.screen_max = {half_width, half_height};
}

}  // namespace lucerna::gltf
