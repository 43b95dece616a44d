// load, scenes, lights, release, info.
#include <fmt/core.h>

#include <memory>

#include "client/cli/light_table.h"
#include "client/cli/output.h"
#include "client/cli/session.h"

namespace lucerna::cli {
namespace {

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
  fmt::print("{}", light_table(response.lights()));
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
