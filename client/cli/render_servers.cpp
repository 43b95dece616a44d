#include "client/cli/render_servers.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "client/library/server_list.h"
#include "client/library/upload.h"
#include "client/terminal/print.h"
#include "client/terminal/progress.h"
#include "client/terminal/server_address.h"
#include "client/terminal/validators.h"

namespace lucerna::cli {

void ServersOption::add(CLI::App& command, bool pictures) {
  command
      .add_option("--servers", servers,
                  "Share the work among servers: A:PORT,B:PORT; dns:///NAME:PORT; @FILE with one "
                  "in each line; slurm:PORT for the nodes of this Slurm job")
      ->transform(server_addresses())
      ->type_name("LIST");
  // Points of a file are always a job, even on one server.
  const std::string with = pictures ? "With --servers: " : "With -o: ";
  command.add_flag("--upload", upload, with + "send SCENE, a file of this machine, to the servers");
  command
      .add_option("--asset-root", asset_root,
                  "With --upload: send only files in this directory; default: the scene "
                  "file's")
      ->type_name("DIR");
  if (pictures) {
    command
        .add_option("--split-samples", samples_per_piece,
                    "With --servers: split the samples of a tile into runs of at most this many")
        ->check(whole64(1));
  }
  command
      .add_option("--journal", journal,
                  with +
                      "record finished pieces in this file, and resume an interrupted job "
                      "from it")
      ->type_name("FILE");
}

void ServersOption::check() const {
  if (!servers.empty()) {
    if (!asset_root.empty() && !upload) wrong_use("--asset-root requires --upload");
    return;
  }
  const auto needs = [](bool given, const char* name) {
    if (given) wrong_use(fmt::format("{} requires --servers", name));
  };
  needs(upload, "--upload");
  needs(!asset_root.empty(), "--asset-root");
  needs(samples_per_piece > 0, "--split-samples");
  needs(!journal.empty(), "--journal");
}

client::JobOptions ServersOption::job(Session& session, const std::string& scene,
                                      ProgressBar& bar) const {
  client::JobOptions job;
  std::string id;
  if (servers.empty()) {
    session.need_one_server("a job on several servers requires --servers");
    // An absent server is an error here; with many servers it may come later.
    if (upload) {
      session.value_or_fail(session.client().get_server_info({}, session.call_options()));
    } else {
      id = session.query_scene_id(scene);
    }
    job.servers = [server = session.server()] { return std::vector<std::string>{server}; };
  } else {
    auto list = client::server_list(servers);
    if (!list.ok()) wrong_use("--servers: " + std::string(list.status().message()));
    job.servers = *std::move(list);
  }
  job.allow_mixed = session.allow_mixed();
  job.security = session.security();
  job.call = session.call_options();
  job.on_event = [](const std::string& event) { shell::print_text(stderr, "{}\n", event); };
  job.on_progress = [&bar](const client::JobProgress& p) { bar.update(p.done, p.pieces); };
  const auto lease_s = static_cast<double>(client::kJobLease.count());
  job.load = [this, id, scene, lease_s, &session](
                 const client::Client& client,
                 const client::CallOptions& call) -> absl::StatusOr<v1::LoadSceneResponse> {
    const auto noted = [&](absl::StatusOr<v1::LoadSceneResponse> loaded) {
      if (!loaded.ok()) return loaded;
      const absl::Status status = session.note_remarks(scene, loaded->remarks());
      return status.ok() ? loaded : status;
    };
    if (upload) {
      return noted(client::upload_scene(client, scene,
                                        {.root = asset_root,
                                         .lease_s = lease_s,
                                         .blender = session.blender(),
                                         .edits = session.edits()},
                                        call));
    }
    if (!id.empty()) {
      v1::RenewLeaseRequest lease;
      lease.set_scene_id(id);
      lease.set_lease_s(lease_s);
      const auto leased = client.renew_lease(lease, call);
      v1::LoadSceneResponse response;
      response.set_scene_id(id);
      if (leased.ok()) response.set_lease_id(leased->lease_id());
      if (leased.ok()) return response;
      if (!absl::IsNotFound(leased.status())) return leased.status();
    }
    return noted(client.load_scene(load_request(session, scene, lease_s), call));
  };
  return job;
}

client::RenderJobResult ServersOption::render(Session& session, const std::string& scene,
                                              const v1::RenderImageRequest& request,
                                              Preview& preview) const {
  ProgressBar bar;
  client::RenderJobOptions options{
      .request = request, .samples_per_piece = samples_per_piece, .journal = journal};
  if (preview) {
    options.on_tile = [&preview](const v1::Tile& tile, const client::PictureAssembler& so_far) {
      preview.update(tile, so_far);
    };
  }
  options.job = job(session, scene, bar);
  if (held != nullptr) options.job.load = held->through(std::move(options.job.load));
  auto result = client::run_render_job(options);
  // The message names the server if it is about one.
  if (!result.ok()) session.fail_here(result.status(), kServerRefused);
  return *std::move(result);
}

std::string describe_mixed(const client::JobReport& report) {
  if (report.fingerprints.size() < 2) return {};
  return fmt::format("rendered by servers of different numeric fingerprints: {}",
                     fmt::join(report.fingerprints, ", "));
}

}  // namespace lucerna::cli
