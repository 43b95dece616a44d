#include "client/terminal/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <utility>

#include "client/terminal/validators.h"

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
  v1::ListScenesResponse all;
  v1::ListScenesRequest request;
  do {
    auto page = client.list_scenes(request, call);
    if (!page.ok()) return page.status();
    request.set_page_token(page->next_page_token());
    all.MergeFrom(*page);
  } while (!request.page_token().empty());
  all.clear_next_page_token();
  return all;
}

/// NOT_FOUND for none, INVALID_ARGUMENT for more than one.
absl::StatusOr<std::string> id_with_prefix(const client::Client& client, const std::string& prefix,
                                           const client::CallOptions& call) {
  const auto scenes = all_scenes(client, call);
  if (!scenes.ok()) return scenes.status();
  std::string found;
  for (const v1::SceneSummary& scene : scenes->scenes()) {
    if (!scene.scene_id().starts_with(prefix)) continue;
    if (!found.empty()) {
      return absl::InvalidArgumentError(fmt::format(
          "scene {}: more than one id begins so, {} and {}", prefix, found, scene.scene_id()));
    }
    found = scene.scene_id();
  }
  if (!found.empty()) return found;
  return absl::NotFoundError(fmt::format(
      "scene {}: no id of a loaded scene begins so (see lucerna scenes); a file of that name is "
      "./{}",
      prefix, prefix));
}

void tell_remarks(const v1::LoadSceneResponse& loaded) {
  if (loaded.already_loaded()) return;
  for (const v1::Remark& remark : loaded.remarks()) fmt::print(stderr, "{}\n", describe(remark));
}

/// A scene that the server has already.
absl::StatusOr<v1::LoadSceneResponse> find_scene(const client::Client& client,
                                                 const std::string& scene,
                                                 const client::CallOptions& call) {
  v1::LoadSceneResponse found;
  found.set_already_loaded(true);
  if (is_prefix(scene)) {
    auto id = id_with_prefix(client, lower(scene), call);
    if (!id.ok()) return id.status();
    found.set_scene_id(*std::move(id));
    return found;
  }
  v1::GetSceneRequest request;
  request.set_scene_id(lower(scene));
  const auto response = client.get_scene(request, call);
  if (!response.ok()) return response.status();
  found.set_scene_id(lower(scene));
  return found;
}

}  // namespace

void wrong_use(const std::string& message) { throw CommandError(kWrongUse, message); }

void Session::add_options(CLI::App& app) {
  app.add_option(
         "--server", server_,
         "Where lucernad listens, HOST:PORT; or several, as --servers of render takes them, "
         "which are asked in turn")
      ->envname("LUCERNA_SERVER")
      ->capture_default_str();
  app.add_flag("--allow-mixed", allow_mixed_,
               "With several servers: let in those of different numeric fingerprints");
  app.add_option("--timeout", timeout_s_, "Give up after this long [s]; default: never")
      ->check(positive());
  app.add_flag("--json", json_,
               "For machines: the answer as protocol-buffers JSON of its message in lucerna.v1");
}

bool Session::several() const {
  return server_.starts_with('@') || server_.starts_with("dns:///") ||
         server_.starts_with("slurm:") || server_.find(',') != std::string::npos;
}

void Session::need_one_server(const std::string& what) const {
  if (several()) wrong_use(fmt::format("--server {}: {}; name one", server_, what));
}

void Session::connect_to_all(const std::string& scene) {
  auto list = client::server_list(server_);
  if (!list.ok()) wrong_use("--server: " + std::string(list.status().message()));
  client::QueryServersOptions options{.servers = *std::move(list), .load = {}};
  options.allow_mixed = allow_mixed_;
  options.call = call_options();
  options.on_event = [](const std::string& event) { fmt::print(stderr, "{}\n", event); };
  options.load = [scene](const client::Client& client, const client::CallOptions& call) {
    if (is_id(scene) || is_prefix(scene)) return find_scene(client, scene, call);
    v1::LoadSceneRequest load;
    load.set_path(scene);
    return client.load_scene(load, call);
  };
  auto servers = client::QueryServers::connect(options);
  if (!servers.ok()) fail(servers.status());
  servers_.emplace(*std::move(servers));
  const std::vector<std::string> fingerprints = servers_->fingerprints();
  if (fingerprints.size() > 1) {
    fmt::print(stderr, "asks servers of different numeric fingerprints: {}\n",
               fmt::join(fingerprints, ", "));
  }
}

const client::Client& Session::client() {
  if (servers_) return servers_->client();
  need_one_server("what is not about a scene is for one server");
  if (!client_) {
    auto client = client::Client::connect({.target = server_});
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
    throw CommandError(kServerSaidNo, fmt::format("no answer within --timeout {} s", *timeout_s_));
  }
}

void Session::fail_here(const absl::Status& status, ExitStatus exit) const {
  fail_if_ended(status);
  throw CommandError(exit, std::string(status.message()));
}

void Session::fail(const absl::Status& status) const {
  const std::string message(status.message());
  fail_if_ended(status);
  if (absl::IsUnavailable(status) && several()) {
    throw CommandError(kServerSaidNo,
                       fmt::format("cannot reach any server of {}: {}", server_, message));
  }
  if (absl::IsUnavailable(status)) {
    throw CommandError(
        kServerSaidNo,
        fmt::format("cannot reach a server at {}: {}\nstart one with: lucernad --listen {} "
                    "--scene-root DIR, or name another with --server or LUCERNA_SERVER",
                    server_, message, server_));
  }
  const std::string code = lower(absl::StatusCodeToString(status.code()));
  throw CommandError(kServerSaidNo, fmt::format("the server said {}: {}", code, message));
}

std::string Session::scene_id(const std::string& scene) {
  if (scene.empty()) wrong_use("SCENE is empty, must be an id or a path under the scene root");
  if (several()) {
    connect_to_all(scene);
    tell_remarks(servers_->loaded());
    return servers_->scene_id();
  }
  if (is_id(scene)) return lower(scene);
  if (is_prefix(scene)) {
    const auto id = id_with_prefix(client(), lower(scene), call_options());
    if (absl::IsInvalidArgument(id.status())) wrong_use(std::string(id.status().message()));
    if (absl::IsNotFound(id.status())) fail_here(id.status(), kServerSaidNo);
    return ask(id);
  }
  const v1::LoadSceneResponse response = load_scene(*this, scene);
  tell_remarks(response);
  return response.scene_id();
}

v1::LoadSceneResponse load_scene(Session& session, const std::string& path, double lease_s) {
  v1::LoadSceneRequest request;
  request.set_path(path);
  if (lease_s > 0) request.set_lease_s(lease_s);
  return session.ask(session.client().load_scene(request, session.call_options()));
}

v1::ListScenesResponse list_scenes(Session& session) {
  return session.ask(all_scenes(session.client(), session.call_options()));
}

v1::ListLightsResponse list_lights(Session& session, const std::string& scene_id) {
  v1::ListLightsResponse all;
  v1::ListLightsRequest request;
  request.set_scene_id(scene_id);
  do {
    auto page = session.ask_about_scene([&](const client::Client& client) {
      return client.list_lights(request, session.call_options());
    });
    request.set_page_token(page.next_page_token());
    all.MergeFrom(page);
  } while (!request.page_token().empty());
  all.clear_next_page_token();
  return all;
}

std::string describe(const v1::Remark& remark) {
  std::string place = remark.file();
  if (remark.line() > 0) place += fmt::format(":{}:{}", remark.line(), remark.column());
  return fmt::format("{}: {}; {}", place, remark.what(), remark.instead());
}

}  // namespace lucerna::cli
