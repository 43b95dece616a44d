// The commands load, inspect, scenes, scene and lights.
#include <fmt/core.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "client/cli/commands.h"
#include "client/cli/light_table.h"
#include "client/terminal/output.h"
#include "client/terminal/print.h"
#include "client/terminal/program.h"
#include "client/terminal/session.h"
#include "client/terminal/validators.h"
#include "lucerna/client/upload.h"

namespace lucerna::cli {
namespace {

void print_remarks(const google::protobuf::RepeatedPtrField<v1::Remark>& remarks) {
  if (remarks.empty()) return;
  shell::print_text(stdout, "Not modelled:\n");
  for (const v1::Remark& remark : remarks) shell::print_text(stdout, "  {}\n", describe(remark));
}

struct LoadFlags {
  std::string path;
  bool upload = false;
  std::string asset_root;
  double lease_s = 0;
};

/// Ends the program for an option that requires another.
void check(const LoadFlags& flags) {
  if (!flags.asset_root.empty() && !flags.upload) wrong_use("--asset-root requires --upload");
}

/// Draws on one line of the terminal; the next text replaces it.
void show(const client::UploadProgress& progress) {
  shell::print_as_is(stderr, "\r\033[K");
  shell::print_text(stderr, "{}: {:.0f} of {:.0f} kB", progress.name,
                    static_cast<double>(progress.sent_bytes) / 1000,
                    static_cast<double>(progress.size_bytes) / 1000);
}

v1::LoadSceneResponse upload(Session& session, const LoadFlags& flags) {
  client::UploadOptions options{.root = flags.asset_root,
                                .lease_s = flags.lease_s,
                                .blender = session.blender(),
                                .edits = session.edits()};
  const bool terminal = isatty(STDERR_FILENO) != 0;
  if (terminal) options.progress = show;
  auto response =
      client::upload_scene(session.client(), flags.path, options, session.call_options());
  if (terminal) shell::print_as_is(stderr, "\r\033[K");
  // An error without details of the server is about the files here.
  if ((absl::IsNotFound(response.status()) || absl::IsInvalidArgument(response.status())) &&
      !response.status().GetPayload(client::kStatusPayloadUrl)) {
    session.fail_here(response.status(), kWrongUse);
  }
  return session.value_or_fail(std::move(response));
}

v1::LoadSceneResponse load_file(Session& session, const LoadFlags& flags) {
  return flags.upload ? upload(session, flags) : load_scene(session, flags.path, flags.lease_s);
}

/// Ends the program under --strict for a scene with remarks.
void check_strict(Session& session, const v1::LoadSceneResponse& loaded) {
  const absl::Status status = session.note_remarks(loaded.scene_id(), loaded.remarks());
  if (!status.ok()) session.fail_here(status, kServerRefused);
}

void load(Session& session, const LoadFlags& flags) {
  check(flags);
  const v1::LoadSceneResponse response = load_file(session, flags);
  if (session.json()) {
    shell::print_text(stdout, "{}", to_json(response));
    return check_strict(session, response);
  }
  shell::print_text(stdout, "{}  {}\n", response.scene_id(),
                    response.already_loaded()
                        ? std::string("was loaded already")
                        : fmt::format("loaded in {:.3g} s", response.cost().wall_time_s()));
  if (!response.lease_id().empty()) {
    shell::print_text(stdout, "lease {} for {:g} s\n", response.lease_id(), response.lease_s());
  }
  print_remarks(response.remarks());
  check_strict(session, response);
}

/// The files that may be loaded.
void available_scenes(Session& session) {
  const v1::ListAvailableScenesResponse response = list_available_scenes(session);
  if (session.json()) {
    shell::print_text(stdout, "{}", to_json(response));
    return;
  }
  if (session.csv()) {
    Table table({{"path", true}});
    for (const std::string& path : response.paths()) table.add({path});
    return session.show(table);
  }
  for (const std::string& path : response.paths()) shell::print_text(stdout, "{}\n", path);
  shell::print_text(stdout, "{} files under {}{}\n", response.paths_size(), response.root(),
                    response.incomplete() ? "; the list is incomplete" : "");
}

std::string counted_lights(const v1::SceneSummary& scene) {
  return fmt::format("{} {}", scene.edited_lights(),
                     scene.edited_lights() == 1 ? "light" : "lights");
}

/// In kB with `digits` after the point.
Cell kilobytes_cell(std::uint64_t bytes, int digits) {
  const double kilobytes = static_cast<double>(bytes) / 1000;
  return {fmt::format("{:.{}f}", kilobytes, digits), {fmt::format("{}", kilobytes)}};
}

void scenes(Session& session, bool available) {
  if (available) return available_scenes(session);
  const v1::ListScenesResponse response = list_scenes(session);
  if (session.json()) {
    shell::print_text(stdout, "{}", to_json(response));
    return;
  }
  Table table({{"id", true},
               {"lights"},
               {"primitives"},
               {"picture [px]", false, {"width [px]", "height [px]"}},
               {"memory [kB]"},
               {"leased [s]"},
               {"path", true}});
  for (const v1::SceneSummary& scene : response.scenes()) {
    table.add({scene.scene_id(), std::to_string(scene.lights()), std::to_string(scene.primitives()),
               Cell(fmt::format("{} x {}", scene.image_width(), scene.image_height()),
                    {std::to_string(scene.image_width()), std::to_string(scene.image_height())}),
               kilobytes_cell(scene.bytes(), 0),
               scene.leased_s() > 0 ? fmt::format("{:.0f}", std::ceil(scene.leased_s())) : "",
               scene.edited_lights() > 0
                   ? fmt::format("{}, {} edited", scene.path(), counted_lights(scene))
                   : scene.path()});
  }
  session.show(table);
}

/// Empty if the levels of the scene file are unchanged.
std::string describe_levels(const v1::SceneSummary& scene) {
  if (!scene.has_level_factors()) return {};
  const v1::LevelFactors& factors = scene.level_factors();
  return fmt::format("lamps times {:.6g}, suns times {:.6g}, emission times {:.6g}",
                     factors.lamps(), factors.suns(), factors.emission());
}

/// The size of the picture, and the unit of its values.
std::string describe_picture(const v1::SceneSummary& scene) {
  std::string text = fmt::format("picture {} x {} px", scene.image_width(), scene.image_height());
  if (scene.has_film_crop()) {
    const v1::FilmCrop& crop = scene.film_crop();
    text += fmt::format(" from ({}, {}) of a film of {} x {}", crop.x(), crop.y(),
                        crop.film_width(), crop.film_height());
  }
  return text + fmt::format(", values in cd/m2 times {:.6g}", scene.film_scale());
}

Table parts_table(const v1::GetSceneResponse& scene) {
  Table table({{"part", true}, {"memory [kB]"}, {"built in [ms]"}, {"why", true}});
  for (const v1::ScenePart& part : scene.parts()) {
    table.add({part.name(), kilobytes_cell(part.bytes(), 1),
               Cell(fmt::format("{:.3g}", part.build_ms()), {fmt::format("{}", part.build_ms())}),
               part.why()});
  }
  return table;
}

void scene(Session& session, const std::string& name, bool remarks_only) {
  session.need_one_server("each server builds its own parts of a scene");
  v1::GetSceneRequest request;
  request.set_scene_id(session.scene_id(name));
  const auto response =
      session.value_or_fail(session.client().get_scene(request, session.call_options()));
  if (session.json()) {
    shell::print_text(stdout, "{}", to_json(response));
    return;
  }
  if (session.csv()) {
    if (!remarks_only) return session.show(parts_table(response));
    Table remarks(
        {{"file", true}, {"line"}, {"column"}, {"what", true}, {"instead", true}, {"count"}});
    for (const v1::Remark& remark : response.remarks())
      remarks.add({remark.file(), std::to_string(remark.line()), std::to_string(remark.column()),
                   remark.what(), remark.instead(), std::to_string(remark.count())});
    return session.show(remarks);
  }
  if (remarks_only) {
    for (const v1::Remark& remark : response.remarks())
      shell::print_text(stdout, "{}\n", describe(remark));
    return;
  }
  const v1::SceneSummary& summary = response.summary();
  shell::print_text(stdout, "{}  {}: {} lights, {} primitives, {:.0f} kB\n", summary.scene_id(),
                    summary.path(), summary.lights(), summary.primitives(),
                    static_cast<double>(summary.bytes()) / 1000);
  shell::print_text(stdout, "{}\n", describe_picture(summary));
  if (summary.edited_lights() > 0)
    shell::print_text(stdout, "revision of {}: {} edited, {:.0f} kB of its own\n",
                      summary.loaded_scene_id(), counted_lights(summary),
                      static_cast<double>(summary.own_bytes()) / 1000);
  if (summary.has_level_factors())
    shell::print_text(stdout, "light levels: {}\n", describe_levels(summary));
  session.show(parts_table(response));
  print_remarks(response.remarks());
}

/// A row for each thing of a kind that a scene holds.
void add_kinds(const char* what, const google::protobuf::RepeatedPtrField<v1::KindCount>& kinds,
               Table& table) {
  for (const v1::KindCount& kind : kinds) {
    std::string primitives;
    if (kind.primitives() > 0) primitives = fmt::format("{} primitives", kind.primitives());
    if (kind.without_area() > 0)
      primitives += fmt::format(", {} of them without area", kind.without_area());
    table.add({what, kind.kind(), std::to_string(kind.count()), primitives});
  }
}

std::string kilobytes(std::uint64_t bytes) {
  return fmt::format("{:.1f} kB", static_cast<double>(bytes) / 1000);
}

Table contents_table(const v1::GetSceneResponse& scene,
                     const std::map<std::string, std::size_t>& lights) {
  const v1::SceneContents& contents = scene.contents();
  Table table({{"what", true}, {"kind", true}, {"count"}, {"details", true}});
  add_kinds("shape", contents.shapes(), table);
  if (contents.objects() > 0)
    table.add({"object", "", std::to_string(contents.objects()),
               fmt::format("{} instances", contents.instances())});
  add_kinds("material", contents.materials(), table);
  add_kinds("texture", contents.textures(), table);
  for (const v1::TexturePicture& picture : contents.pictures())
    table.add({"picture", picture.name(), "",
               fmt::format("{} x {} px, {} in memory", picture.width(), picture.height(),
                           kilobytes(picture.bytes()))});
  for (const auto& [kind, count] : lights) table.add({"light", kind, std::to_string(count), ""});
  if (scene.summary().has_level_factors())
    table.add({"light levels", "", "", describe_levels(scene.summary())});
  table.add({"camera", contents.camera(), "", describe_picture(scene.summary())});
  for (const v1::NamedAsset& file : scene.assets())
    table.add({"file", file.name(), "", kilobytes(file.size_bytes())});
  for (const v1::ScenePart& part : scene.parts())
    table.add({"memory", part.name(), "", kilobytes(part.bytes())});
  table.add({"memory", "all", "", kilobytes(scene.summary().bytes())});
  return table;
}

void inspect(Session& session, const LoadFlags& flags) {
  check(flags);
  session.need_one_server("each server builds its own parts of a scene");
  const v1::LoadSceneResponse loaded = load_file(session, flags);
  v1::GetSceneRequest request;
  request.set_scene_id(loaded.scene_id());
  const auto scene =
      session.value_or_fail(session.client().get_scene(request, session.call_options()));
  if (session.json()) {
    shell::print_text(stdout, "{}", to_json(scene));
    return check_strict(session, loaded);
  }
  std::map<std::string, std::size_t> lights;
  const v1::ListLightsResponse listed = list_lights(session, loaded.scene_id());
  for (const v1::Light& light : listed.lights()) ++lights[type_of(light)];
  if (!session.csv())
    shell::print_text(stdout, "{}  {}\n", loaded.scene_id(), scene.summary().path());
  session.show(contents_table(scene, lights));
  if (!session.csv()) print_remarks(scene.remarks());
  check_strict(session, loaded);
}

void lights(Session& session, const std::string& scene) {
  const v1::ListLightsResponse response = list_lights(session, session.query_scene_id(scene));
  if (session.json()) {
    shell::print_text(stdout, "{}", to_json(response));
    return;
  }
  session.show(light_table(response.lights()), light_notes(response.lights()));
  session.print_remarks();
}

/// The file and its options.
std::shared_ptr<LoadFlags> add_file_options(CLI::App& command) {
  const auto flags = std::make_shared<LoadFlags>();
  command
      .add_option("PATH", flags->path,
                  "A path under the scene root; with --upload, a file of this machine")
      ->required();
  command.add_flag(
      "--upload", flags->upload,
      "Send the scene file and the files that it names, unless the server already has them");
  command
      .add_option("--asset-root", flags->asset_root,
                  "With --upload: send only files in this directory; default: the scene file's")
      ->type_name("DIR");
  return flags;
}

void add_load_command(CLI::App& app, Session& session) {
  CLI::App* command =
      app.add_subcommand("load", "Load a scene file; a loaded scene is not loaded again");
  command->footer(
      "Example:\n  lucerna load room.pbrt\n  lucerna load --upload ~/scenes/room.pbrt\n"
      "  lucerna load --blender standard room.glb");
  const auto flags = add_file_options(*command);
  command->add_option("--lease", flags->lease_s, "Keep the scene for at least this time [s]")
      ->type_name("SECONDS")
      ->check(positive());
  command->callback([flags, &session] { load(session, *flags); });

  command = app.add_subcommand(
      "inspect", "Load a scene file and print what it holds, its memory, and what is not modelled");
  command->footer("Example:\n  lucerna inspect room.pbrt\n  lucerna inspect --upload ~/room.pbrt");
  const auto inspected = add_file_options(*command);
  session.prints_table(*command);
  command->callback([inspected, &session] { inspect(session, *inspected); });
}

}  // namespace

void add_scene_commands(CLI::App& app, Session& session) {
  add_load_command(app, session);
  const auto available = std::make_shared<bool>(false);
  CLI::App* scenes_command =
      add_command(app, "scenes", "List the loaded scenes", nullptr, "",
                  "lucerna scenes --json\n  lucerna scenes --available",
                  [&session, available](const std::string&) { scenes(session, *available); });
  session.prints_table(*scenes_command);
  scenes_command->add_flag("--available", *available, "List the scene files that may be loaded");
  const auto remarks_only = std::make_shared<bool>(false);
  CLI::App* scene_command = add_command(
      app, "scene", "Print the parts that were built for a scene, with memory, time and reason",
      "SCENE", kSceneHelp, "lucerna scene room.pbrt",
      [&session, remarks_only](const std::string& name) { scene(session, name, *remarks_only); });
  session.prints_table(*scene_command);
  scene_command->add_flag("--remarks", *remarks_only, "List only the content that is not modelled");
  session.prints_table(*add_command(
      app, "lights", "List the lights of a scene", "SCENE", kSceneHelp, "lucerna lights room.pbrt",
      [&session](const std::string& scene) { lights(session, scene); }));
}

}  // namespace lucerna::cli
