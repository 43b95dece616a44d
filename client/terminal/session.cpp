#include "client/terminal/session.h"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <cstdio>
#include <utility>

#include "client/library/pages.h"
#include "client/terminal/print.h"
#include "client/terminal/validators.h"
#include "proto/common/status_macros.h"

namespace lucerna::cli {
namespace {

constexpr std::size_t kIdDigits = 64;
constexpr std::size_t kFewestDigits = 4;

bool is_hexadecimal(const std::string& text) {
  return std::all_of(text.begin(), text.end(),
                     [](unsigned char c) { return std::isxdigit(c) != 0; });
}

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

bool is_id(const std::string& scene) { return is_hexadecimal(scene) && scene.size() == kIdDigits; }

bool is_prefix(const std::string& scene) {
  return is_hexadecimal(scene) && scene.size() >= kFewestDigits && scene.size() < kIdDigits;
}

absl::StatusOr<v1::ListScenesResponse> all_scenes(const client::Client& client,
                                                  const client::CallOptions& call) {
  return client::all_pages(v1::ListScenesRequest(),
                           [&](const auto& request) { return client.list_scenes(request, call); });
}

/// The id of the only loaded scene whose id begins with `prefix`.  NOT_FOUND if there is none,
/// INVALID_ARGUMENT if there are several.
absl::StatusOr<std::string> id_with_prefix(const client::Client& client, const std::string& prefix,
                                           const client::CallOptions& call) {
  LUCERNA_ASSIGN_OR_RETURN(const v1::ListScenesResponse scenes, all_scenes(client, call));
  std::string found;
  for (const v1::SceneSummary& scene : scenes.scenes()) {
    if (!scene.scene_id().starts_with(prefix)) continue;
    if (!found.empty()) {
      return absl::InvalidArgumentError(
          fmt::format("scene {}: several ids begin with these digits, {} and {}", prefix, found,
                      scene.scene_id()));
    }
    found = scene.scene_id();
  }
  if (!found.empty()) return found;
  return absl::NotFoundError(
      fmt::format("scene {}: no loaded scene has an id that begins with these digits (see lucerna "
                  "scenes); a file of that name is ./{}",
                  prefix, prefix));
}

/// Prints the remarks of a scene that was loaded just now.
void print_new_remarks(const v1::LoadSceneResponse& loaded) {
  if (loaded.already_loaded()) return;
  for (const v1::Remark& remark : loaded.remarks())
    shell::print_text(stderr, "{}\n", describe(remark));
}

absl::StatusOr<v1::GetSceneResponse> get_scene(const client::Client& client, const std::string& id,
                                               const client::CallOptions& call) {
  v1::GetSceneRequest request;
  request.set_scene_id(id);
  return client.get_scene(request, call);
}

/// A scene that is loaded already: an id or the beginning of one.
absl::StatusOr<v1::LoadSceneResponse> find_scene(const client::Client& client,
                                                 const std::string& scene,
                                                 const client::CallOptions& call) {
  v1::LoadSceneResponse found;
  found.set_already_loaded(true);
  found.set_scene_id(lower(scene));
  if (is_prefix(scene)) {
    LUCERNA_ASSIGN_OR_RETURN(*found.mutable_scene_id(), id_with_prefix(client, lower(scene), call));
  }
  LUCERNA_ASSIGN_OR_RETURN(v1::GetSceneResponse held, get_scene(client, found.scene_id(), call));
  *found.mutable_remarks() = std::move(*held.mutable_remarks());
  return found;
}

/// Adds the least length of a prefix to the error, if `scene` may be a prefix that is too short.
absl::Status with_prefix_length(const std::string& scene, const absl::Status& error) {
  if (!absl::IsNotFound(error) || !is_hexadecimal(scene) || scene.size() >= kFewestDigits) {
    return error;
  }
  absl::Status result(error.code(),
                      fmt::format("{}; the first digits of a scene id must be {} or "
                                  "more, these are {}",
                                  std::string(error.message()), kFewestDigits, scene.size()));
  error.ForEachPayload(
      [&](absl::string_view url, const absl::Cord& payload) { result.SetPayload(url, payload); });
  return result;
}

/// A short name by which `lucerna scene` finds the scene: the first digits of an id, or the path.
std::string short_name(const std::string& scene) {
  constexpr std::size_t kShortId = 12;
  return is_id(scene) ? lower(scene).substr(0, kShortId) : scene;
}

}  // namespace

void Session::add_options(CLI::App& app) {
  app.add_option(
         "--server", server_,
         "Address of lucernad, HOST or HOST:PORT; several, separated by commas, answer in turn")
      ->transform(server_addresses())
      ->envname("LUCERNA_SERVER")
      ->capture_default_str();
  security_.add(app);
  app.add_flag("--allow-mixed", allow_mixed_,
               "With several servers: accept servers of different numeric fingerprints");
  app.add_option("--timeout", timeout_s_, "Give up after this time [s]; default: never")
      ->check(positive());
  CLI::Option* output =
      app.add_option("--output", output_,
                     "Form of the answer: table for people; json: the messages in lucerna.v1, also "
                     "of errors; csv: the table in full precision")
          ->check(one_of({"table", "json", "csv"}))
          ->capture_default_str();
  app.add_flag("--json", json_, "The same as --output json")->excludes(output);
  // Before the command sends anything.
  app.parse_complete_callback([this, &app] {
    const auto commands = app.get_subcommands();
    const CLI::App& command = commands.empty() ? app : *commands.front();
    if (csv() && table_commands_.count(&command) == 0)
      wrong_use(fmt::format("--output csv: {} prints no table; allowed: table, json",
                            commands.empty() ? app.get_name() : "lucerna " + command.get_name()));
  });
  blender_.add(app);
  edit_.add(app);
  app.add_flag("--strict", strict_, "Fail if the scene has anything that is not modelled");
}

bool Session::several() const {
  return server_.starts_with('@') || server_.starts_with("dns:///") ||
         server_.starts_with("slurm:") || server_.find(',') != std::string::npos;
}

void Session::need_one_server(const std::string& what) const {
  if (several()) wrong_use(fmt::format("--server {}: {}; name one server", server_, what));
}

void Session::connect_to_all(const std::string& scene) {
  auto list = client::server_list(server_);
  if (!list.ok()) wrong_use("--server: " + std::string(list.status().message()));
  client::QueryServersOptions options{.servers = *std::move(list), .load = {}};
  options.allow_mixed = allow_mixed_;
  options.security = security();
  options.call = call_options();
  options.on_event = [](const std::string& event) { shell::print_text(stderr, "{}\n", event); };
  options.load = [scene, load = load_request(*this, scene, 0)](
                     const client::Client& client,
                     const client::CallOptions& call) -> absl::StatusOr<v1::LoadSceneResponse> {
    if (is_id(scene) || is_prefix(scene)) return find_scene(client, scene, call);
    auto loaded = client.load_scene(load, call);
    if (!loaded.ok()) return with_prefix_length(scene, loaded.status());
    return loaded;
  };
  auto servers = client::QueryServers::connect(options);
  if (!servers.ok()) fail(servers.status());
  servers_.emplace(*std::move(servers));
  const std::vector<std::string> fingerprints = servers_->fingerprints();
  if (fingerprints.size() > 1) {
    shell::print_text(stderr, "the servers have different numeric fingerprints: {}\n",
                      fmt::join(fingerprints, ", "));
  }
}

EditOption::Edits Session::edits() const {
  if (!edits_at_load_) return {};
  auto edits = edit_.edits();
  if (!edits.ok()) wrong_use(std::string(edits.status().message()));
  return *std::move(edits);
}

const client::Client& Session::client() {
  if (servers_) return servers_->client();
  need_one_server("this command is for one server");
  if (!client_) {
    auto client = client::Client::connect({.target = server_, .security = security()});
    if (!client.ok()) wrong_use("--server: " + std::string(client.status().message()));
    client_.emplace(*std::move(client));
  }
  return *client_;
}

const client::CallOptions& Session::call_options() {
  if (!call_options_) {
    call_options_.emplace();
    if (timeout_s_) {
      call_options_ = client::CallOptions::within(std::chrono::duration<double>(*timeout_s_));
    }
    call_options_->stop = stop_;
  }
  return *call_options_;
}

void Session::fail_if_ended(const absl::Status& status) const {
  if (stop_.stop_requested()) {
    throw CommandError(static_cast<ExitStatus>(kSignal + signal_), "interrupted");
  }
  if (absl::IsDeadlineExceeded(status) && timeout_s_) {
    throw CommandError(kServerRefused, status,
                       fmt::format("no answer within --timeout {} s", *timeout_s_));
  }
}

void Session::fail_here(const absl::Status& status, ExitStatus exit) const {
  fail_if_ended(status);
  throw CommandError(exit, status, std::string(status.message()));
}

void Session::fail(const absl::Status& status) const {
  const std::string message(status.message());
  fail_if_ended(status);
  if (absl::IsUnavailable(status) && several()) {
    throw CommandError(kServerRefused, status,
                       fmt::format("cannot reach any server of {}: {}", server_, message));
  }
  if (absl::IsUnavailable(status)) {
    // The server itself adds details to its errors.
    const bool from_server = status.GetPayload(client::kStatusPayloadUrl).has_value();
    const std::string why = from_server ? "" : client::why_unreachable(server_, security());
    std::string text =
        fmt::format("cannot reach a server at {}: {}", server_, why.empty() ? message : why);
    if (why.empty() || why == client::kNoServer) {
      text += fmt::format(
          "\nstart one with: lucernad --listen {} --scene-root DIR, or name another with --server "
          "or LUCERNA_SERVER",
          server_);
    }
    throw CommandError(kServerRefused, status, text);
  }
  const std::string code = lower(absl::StatusCodeToString(status.code()));
  throw CommandError(kServerRefused, status,
                     fmt::format("the server reported {}: {}", code, message));
}

std::string Session::scene_id(const std::string& scene) {
  if (scene.empty()) wrong_use("SCENE is empty, must be an id or a path under the scene root");
  if (blender() && (is_id(scene) || is_prefix(scene)))
    wrong_use("--blender requires the path of a file; SCENE is the id of a loaded scene");
  if (edits_at_load_ && edit_.given() && (is_id(scene) || is_prefix(scene)))
    wrong_use(
        "--set, --remove and --add require the path of a file; SCENE is the id of a loaded "
        "scene, which lucerna edit changes");
  if (several()) {
    connect_to_all(scene);
    print_new_remarks(servers_->loaded());
    return servers_->scene_id();
  }
  if (is_id(scene)) return lower(scene);
  if (is_prefix(scene)) {
    const auto id = id_with_prefix(client(), lower(scene), call_options());
    if (absl::IsInvalidArgument(id.status())) wrong_use(std::string(id.status().message()));
    if (absl::IsNotFound(id.status())) fail_here(id.status(), kServerRefused);
    return value_or_fail(id);
  }
  const v1::LoadSceneResponse response = load_scene(*this, scene);
  print_new_remarks(response);
  loaded_remarks_ = response.remarks();
  return response.scene_id();
}

std::string Session::unedited_scene_id(const std::string& scene) {
  edits_at_load_ = false;
  return scene_id(scene);
}

std::string Session::query_scene_id(const std::string& scene) {
  loaded_remarks_.reset();
  std::string id = scene_id(scene);
  if ((json() || csv()) && !strict_) return id;
  Remarks remarks;
  if (servers_) {
    remarks = servers_->loaded().remarks();
  } else if (loaded_remarks_) {
    remarks = *std::move(loaded_remarks_);
  } else {
    remarks = value_or_fail(get_scene(client(), id, call_options())).remarks();
  }
  if (absl::Status s = note_remarks(scene, remarks); !s.ok()) fail_here(s, kServerRefused);
  return id;
}

absl::Status Session::note_remarks(const std::string& scene, const Remarks& remarks) {
  const std::lock_guard lock(remarks_mutex_);
  remarks_line_.clear();
  if (remarks.empty()) return absl::OkStatus();
  remarks_line_ =
      fmt::format("{}: lucerna scene {} --remarks", count_remarks(remarks), short_name(scene));
  if (!strict_) return absl::OkStatus();
  return absl::FailedPreconditionError("not modelled (--strict): " + remarks_line_);
}

void Session::print_remarks() const {
  const std::lock_guard lock(remarks_mutex_);
  if (!remarks_line_.empty() && !csv()) shell::print_text(stdout, "{}\n", remarks_line_);
}

void Session::show(const Table& table, const std::string& notes) const {
  if (csv()) {
    shell::print_text(stdout, "{}", table.to_csv());
  } else {
    shell::print_as_is(stdout, table.to_string(shell::has_colours(STDOUT_FILENO)));
    shell::print_text(stdout, "{}", notes);
  }
}

v1::LoadSceneRequest load_request(const Session& session, const std::string& path, double lease_s) {
  v1::LoadSceneRequest request;
  request.set_path(path);
  if (lease_s > 0) request.set_lease_s(lease_s);
  if (auto levels = session.blender()) *request.mutable_blender() = *std::move(levels);
  *request.mutable_edits() = session.edits();
  return request;
}

v1::LoadSceneResponse load_scene(Session& session, const std::string& path, double lease_s) {
  auto response =
      session.client().load_scene(load_request(session, path, lease_s), session.call_options());
  if (!response.ok()) session.fail(with_prefix_length(path, response.status()));
  return *std::move(response);
}

v1::ListScenesResponse list_scenes(Session& session) {
  return session.value_or_fail(all_scenes(session.client(), session.call_options()));
}

v1::ListAvailableScenesResponse list_available_scenes(Session& session) {
  return session.value_or_fail(
      client::all_pages(v1::ListAvailableScenesRequest(), [&](const auto& request) {
        return session.client().list_available_scenes(request, session.call_options());
      }));
}

v1::ListLightsResponse list_lights(Session& session, const std::string& scene_id) {
  v1::ListLightsRequest lights;
  lights.set_scene_id(scene_id);
  return session.query_scene([&](const client::Client& client) {
    return client::all_pages(lights, [&](const auto& request) {
      return client.list_lights(request, session.call_options());
    });
  });
}

IlluminanceUnits illuminance_units(Session& session, const std::string& scene_id) {
  IlluminanceUnits units;
  if (!session.csv() && !session.has_remarks()) return units;
  const v1::ListLightsResponse lights = list_lights(session, scene_id);
  const auto unit_of = [](const v1::Light& light) {
    const std::string& flux = light.power_unit();
    return flux.empty() ? "lx" : flux == "unknown" ? flux : flux + "/m2";
  };
  bool all_lx = true;
  for (const v1::Light& light : lights.lights()) {
    const std::string unit = unit_of(light);
    all_lx = all_lx && unit == "lx";
    units.sum = units.lights.empty() || unit == units.sum ? unit : "mixed";
    units.lights.emplace(light.id(), unit);
  }
  if (all_lx) return {};
  return units;
}

}  // namespace lucerna::cli
