// The commands lease, leases and release.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "client/cli/admin_commands.h"
#include "client/library/pages.h"
#include "client/terminal/output.h"
#include "client/terminal/print.h"
#include "client/terminal/program.h"
#include "client/terminal/session.h"
#include "client/terminal/validators.h"

namespace lucerna::cli {
namespace {

void lease(Session& session, const std::string& scene, double seconds, const std::string& id) {
  session.need_one_server("each server has its own leases");
  v1::RenewLeaseRequest request;
  request.set_scene_id(session.scene_id(scene));
  request.set_lease_s(seconds);
  request.set_lease_id(id);
  const auto response =
      session.value_or_fail(session.client().renew_lease(request, session.call_options()));
  if (session.json()) {
    shell::print_text(stdout, "{}", to_json(response));
  } else {
    shell::print_text(stdout, "lease {} for {:g} s\n", response.lease_id(), response.lease_s());
  }
}

void leases(Session& session) {
  session.need_one_server("each server has its own leases");
  const v1::ListLeasesResponse all =
      session.value_or_fail(client::all_pages(v1::ListLeasesRequest(), [&](const auto& request) {
        return session.client().list_leases(request, session.call_options());
      }));
  if (session.json()) {
    shell::print_text(stdout, "{}", to_json(all));
    return;
  }
  Table table({{"lease", true}, {"ends in [s]"}, {"owner", true}, {"scene", true}, {"path", true}});
  for (const v1::SceneLease& lease : all.leases()) {
    table.add({lease.lease_id(),
               Cell(fmt::format("{:.0f}", lease.left_s()), {fmt::format("{}", lease.left_s())}),
               lease.owner(), lease.scene_id().substr(0, 12), lease.path()});
  }
  session.show(table);
}

void release(Session& session, const std::string& scene, const std::string& lease,
             bool break_leases) {
  session.need_one_server("each server has its own leases");
  v1::ReleaseSceneRequest request;
  request.set_scene_id(session.scene_id(scene));
  request.set_lease_id(lease);
  request.set_break_leases(break_leases);
  const auto response =
      session.value_or_fail(session.client().release_scene(request, session.call_options()));
  if (session.json()) {
    shell::print_text(stdout, "{}", to_json(response));
  } else {
    shell::print_text(stdout, "{}  {}\n", request.scene_id(),
                      response.still_loaded() ? "lease ended, others keep it" : "released");
  }
}

}  // namespace

void add_lease_commands(CLI::App& app, Session& session) {
  const auto seconds = std::make_shared<double>(0);
  const auto all = std::make_shared<bool>(false);
  const auto renewed = std::make_shared<std::string>(), ended = std::make_shared<std::string>();
  CLI::App* renew = add_command(app, "lease", "Keep a scene loaded when the server needs memory",
                                "SCENE", kSceneHelp, "lucerna lease 3f1c --for 3600",
                                [&session, seconds, renewed](const std::string& scene) {
                                  lease(session, scene, *seconds, *renewed);
                                });
  renew->add_option("--for", *seconds, "Time from now [s]")
      ->type_name("SECONDS")
      ->required()
      ->check(positive());
  renew->add_option("--id", *renewed, "Id of the lease to renew; default: a new lease");

  CLI::App* unload = add_command(
      app, "release", "Unload a scene", "SCENE", kSceneHelp, "lucerna release 3f1c",
      [&session, ended, all](const std::string& scene) { release(session, scene, *ended, *all); });
  unload
      ->add_option("--lease", *ended,
                   "End this lease; the scene is unloaded if it has no other lease")
      ->type_name("ID");
  unload->add_flag("--break-leases", *all,
                   "End all leases of the scene, those of others too; needs the role admin");

  session.prints_table(*add_command(
      app, "leases", "List your leases; with the role admin those of all callers", nullptr, "",
      "lucerna leases", [&session](const std::string&) { leases(session); }));
}

}  // namespace lucerna::cli
