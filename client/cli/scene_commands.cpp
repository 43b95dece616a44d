// load, scenes, lights, release, info.
#include <fmt/core.h>

#include <memory>

#include "client/cli/output.h"
#include "client/cli/session.h"

namespace lucerna::cli {
namespace {

std::string rgb(const v1::Rgb& value, const char* unit) {
  return triple(value.r(), value.g(), value.b()) + " " + unit;
}

std::string point(const v1::Vector3& value) { return triple(value.x(), value.y(), value.z()); }

std::string shape_name(v1::AreaShape shape) {
  switch (shape) {
    case v1::AREA_SHAPE_TRIANGLE_MESH:
      return "triangles";
    case v1::AREA_SHAPE_BILINEAR_MESH:
      return "bilinear patches";
    case v1::AREA_SHAPE_SPHERE:
      return "sphere";
    case v1::AREA_SHAPE_DISK:
      return "disk";
    default:
      return "shape " + std::to_string(shape);
  }
}

/// What a light is, where it is and what it emits.
struct LightRow {
  std::string kind, place, emits;
};

LightRow row_of(const v1::Light& light) {
  switch (light.kind_case()) {
    case v1::Light::kPoint:
      return {"point", point(light.point().position_m()), rgb(light.point().intensity_cd(), "cd")};
    case v1::Light::kSpot:
      return {"spot", point(light.spot().position_m()), rgb(light.spot().intensity_cd(), "cd")};
    case v1::Light::kDistant:
      return {"distant", "towards " + point(light.distant().to_light()),
              rgb(light.distant().illuminance_lx(), "lx")};
    case v1::Light::kUniformInfinite:
      return {"uniform infinite", "all around",
              rgb(light.uniform_infinite().radiance_cd_m2(), "cd/m2")};
    case v1::Light::kDiffuseArea: {
      const v1::DiffuseAreaLight& area = light.diffuse_area();
      std::string kind = "area, " + shape_name(area.shape());
      if (area.primitives() > 1)
        kind = fmt::format("area, {} {}", area.primitives(), shape_name(area.shape()));
      if (area.two_sided()) kind += ", two-sided";
      const v1::Vector3& a = light.bounds().lower_m();
      const v1::Vector3& b = light.bounds().upper_m();
      return {kind, fmt::format("{} to {}", point(a), point(b)),
              rgb(area.radiance_cd_m2(), "cd/m2")};
    }
    default:
      return {"unknown kind", "", ""};
  }
}

void print_remarks(const google::protobuf::RepeatedPtrField<v1::Remark>& remarks) {
  if (remarks.empty()) return;
  fmt::print("Not modelled:\n");
  for (const v1::Remark& remark : remarks) fmt::print("  {}\n", describe(remark));
}

void load(Session& session, const std::string& path) {
  const v1::LoadSceneResponse response = load_scene(session, path);
  if (session.json()) {
    fmt::print("{}", to_json(response));
    return;
  }
  fmt::print("{}  {}\n", response.scene_id(),
             response.already_loaded()
                 ? std::string("was loaded already")
                 : fmt::format("loaded in {:.3g} s", response.cost().wall_time_s()));
  print_remarks(response.remarks());
}

void scenes(Session& session) {
  const v1::ListScenesResponse response = list_scenes(session);
  if (session.json()) {
    fmt::print("{}", to_json(response));
    return;
  }
  Table table({{"id", true},
               {"lights"},
               {"primitives"},
               {"picture [px]"},
               {"memory [kB]"},
               {"path", true}});
  for (const v1::SceneSummary& scene : response.scenes()) {
    table.add({scene.scene_id(), std::to_string(scene.lights()), std::to_string(scene.primitives()),
               fmt::format("{} x {}", scene.image_width(), scene.image_height()),
               fmt::format("{:.0f}", static_cast<double>(scene.bytes()) / 1000), scene.path()});
  }
  fmt::print("{}", table.to_string());
}

void lights(Session& session, const std::string& scene) {
  const v1::ListLightsResponse response = list_lights(session, session.scene_id(scene));
  if (session.json()) {
    fmt::print("{}", to_json(response));
    return;
  }
  Table table({{"id"},
               {"type", true},
               {"where [m]", true},
               {"emits (RGB)", true},
               {"flux [lm]"},
               {"made at", true}});
  for (const v1::Light& light : response.lights()) {
    const LightRow row = row_of(light);
    table.add({std::to_string(light.id()), row.kind, row.place, row.emits, number(light.power_lm()),
               light.source()});
  }
  fmt::print("{}", table.to_string());
}

void release(Session& session, const std::string& scene) {
  v1::ReleaseSceneRequest request;
  request.set_scene_id(session.scene_id(scene));
  const auto response =
      session.ask(session.client().release_scene(request, session.call_options()));
  if (session.json()) {
    fmt::print("{}", to_json(response));
  } else {
    fmt::print("{}  released\n", request.scene_id());
  }
}

void info(Session& session) {
  const auto response = session.ask(session.client().get_server_info({}, session.call_options()));
  if (session.json()) {
    fmt::print("{}", to_json(response));
    return;
  }
  const v1::Limits& limits = response.limits();
  const v1::NumericFingerprint& fingerprint = response.fingerprint();
  Table table({{"lucernad", true}, {response.version(), true}});
  table.add({"threads", std::to_string(response.threads())});
  table.add({"batch, at most", fmt::format("{} items", limits.max_batch_items())});
  table.add({"tile, at most", fmt::format("{} pixels", limits.max_tile_pixels())});
  table.add({"samples, at most", std::to_string(limits.max_samples())});
  table.add({"page, at most", fmt::format("{} entries", limits.max_page_size())});
  table.add({"message, at most", fmt::format("{} bytes", limits.max_message_bytes())});
  table.add({"may wait", fmt::format("{} queries, {} renders", limits.interactive_queue(),
                                     limits.bulk_queue())});
  table.add({"fingerprint", fingerprint.digest()});
  table.add({"  build", fingerprint.build()});
  table.add({"  Embree", fingerprint.embree()});
  table.add({"  libm", fingerprint.libm()});
  fmt::print("{}", table.to_string());
}

/// A subcommand whose only argument is a scene.
CLI::App* add_command(CLI::App& app, const char* name, const char* what, const char* argument,
                      const char* argument_what, const char* example,
                      std::function<void(const std::string&)> run) {
  CLI::App* command = app.add_subcommand(name, what);
  command->footer(fmt::format("Example:\n  {}", example));
  const auto value = std::make_shared<std::string>();
  if (argument != nullptr) command->add_option(argument, *value, argument_what)->required();
  command->callback([value, run = std::move(run)] { run(*value); });
  return command;
}

}  // namespace

void add_scene_commands(CLI::App& app, Session& session) {
  add_command(app, "load", "Loads a scene file; free where it is loaded already", "PATH",
              "Relative to the server's scene root", "lucerna load room.pbrt",
              [&session](const std::string& path) { load(session, path); });
  add_command(app, "scenes", "Lists the loaded scenes", nullptr, "", "lucerna scenes --json",
              [&session](const std::string&) { scenes(session); });
  add_command(app, "lights", "Lists a scene's lights", "SCENE", "Path or id",
              "lucerna lights room.pbrt",
              [&session](const std::string& scene) { lights(session, scene); });
  add_command(app, "release", "Lets a scene go", "SCENE", "Path or id", "lucerna release 3f1c",
              [&session](const std::string& scene) { release(session, scene); });
  add_command(app, "info", "Tells the server's version, limits and numeric fingerprint", nullptr,
              "", "lucerna info --server 10.0.0.7:50051",
              [&session](const std::string&) { info(session); });
}

}  // namespace lucerna::cli
