// The command edit.
#include <fmt/core.h>
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "client/cli/commands.h"
#include "client/terminal/output.h"
#include "client/terminal/print.h"
#include "client/terminal/session.h"
#include "client/terminal/validators.h"

namespace lucerna::cli {
namespace {

/// Finds lights by their names.  Lists the lights at the first name.
class Names {
 public:
  Names(Session& session, std::string scene) : session_(session), scene_(std::move(scene)) {}

  absl::StatusOr<std::vector<std::uint64_t>> operator()(const std::string& name) {
    if (!lights_) lights_ = list_lights(session_, scene_);
    std::vector<std::uint64_t> ids;
    for (const v1::Light& light : lights_->lights())
      if (light.name() == name) ids.push_back(light.id());
    if (ids.empty())
      return absl::NotFoundError(fmt::format("the scene has no light named \"{}\"", name));
    return ids;
  }

 private:
  Session& session_;
  std::string scene_;
  std::optional<v1::ListLightsResponse> lights_;
};

void edit(Session& session, const std::string& scene, double lease_s) {
  if (!session.edit_option().given()) wrong_use("edit requires --set, --remove or --add");
  v1::EditLightsRequest request;
  request.set_scene_id(session.unedited_scene_id(scene));
  if (lease_s > 0) request.set_lease_s(lease_s);
  const auto names = std::make_shared<Names>(session, request.scene_id());
  auto edits =
      session.edit_option().edits([names](const std::string& name) { return (*names)(name); });
  if (absl::IsInvalidArgument(edits.status())) wrong_use(std::string(edits.status().message()));
  if (!edits.ok()) session.fail_here(edits.status(), kServerRefused);
  *request.mutable_edits() = *std::move(edits);
  const v1::EditLightsResponse response =
      session.value_or_fail(session.client().edit_lights(request, session.call_options()));
  if (session.json()) {
    shell::print_text(stdout, "{}", to_json(response));
    return;
  }
  shell::print_text(stdout, "{}  {}\n", response.scene_id(),
                    response.already_loaded()
                        ? std::string("was loaded already")
                        : fmt::format("made in {:.3g} s", response.cost().wall_time_s()));
  if (!response.light_ids().empty())
    shell::print_text(stdout, "new lights: {}\n", fmt::join(response.light_ids(), ", "));
  if (!response.lease_id().empty())
    shell::print_text(stdout, "lease {} for {:g} s\n", response.lease_id(), response.lease_s());
}

}  // namespace

void add_edit_command(CLI::App& app, Session& session) {
  const auto scene = std::make_shared<std::string>();
  const auto lease_s = std::make_shared<double>(0);
  CLI::App* command = app.add_subcommand(
      "edit", "Make a revision of a loaded scene with other lights; the scene stays as it is");
  command->footer(
      "Options:\n"
      "  --set LIGHT.FIELD=VALUE  Change a light: scale, tint=R,G,B, on=true|false, shift=X,Y,Z, "
      "turn=X,Y,Z,DEGREES\n"
      "  --remove LIGHT           Remove a light\n"
      "  --add PATH               Add lights and emissive shapes of another file\n"
      "LIGHT is an id or a name.  Each may be repeated.\n"
      "Example:\n  lucerna edit room.pbrt --set 3.scale=0.5 --set \"Desk lamp.on=false\" --remove "
      "7");
  command->add_option("SCENE", *scene, kSceneHelp)->required();
  command->add_option("--lease", *lease_s, "Keep the revision for at least this time [s]")
      ->type_name("SECONDS")
      ->check(positive());
  command->callback([scene, lease_s, &session] { edit(session, *scene, *lease_s); });
}

}  // namespace lucerna::cli
