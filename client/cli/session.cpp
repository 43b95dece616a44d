#include "client/cli/session.h"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <utility>

#include "client/cli/validators.h"

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

}  // namespace

void wrong_use(const std::string& message) { throw CommandError(kWrongUse, message); }

void Session::add_options(CLI::App& app) {
  app.add_option("--server", server_, "Where lucernad listens, HOST:PORT")
      ->envname("LUCERNA_SERVER")
      ->capture_default_str();
  app.add_option("--timeout", timeout_s_, "Give up after this long [s]; default: never")
      ->check(positive());
  app.add_flag("--json", json_,
               "For machines: the answer as protocol-buffers JSON of its message in lucerna.v1");
}

const client::Client& Session::client() {
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
  if (stop_.stop_requested()) throw CommandError(kServerSaidNo, "interrupted");
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
  if (is_hexadecimal(scene) && scene.size() == kIdDigits) return lower(scene);
  if (is_hexadecimal(scene) && scene.size() >= kFewestDigits && scene.size() < kIdDigits) {
    return id_with_prefix(lower(scene));
  }
  const v1::LoadSceneResponse response = load_scene(*this, scene);
  if (!response.already_loaded()) {
    for (const v1::Remark& remark : response.remarks()) {
      fmt::print(stderr, "{}\n", describe(remark));
    }
  }
  return response.scene_id();
}

std::string Session::id_with_prefix(const std::string& prefix) {
  std::string found;
  const v1::ListScenesResponse scenes = list_scenes(*this);
  for (const v1::SceneSummary& scene : scenes.scenes()) {
    if (!scene.scene_id().starts_with(prefix)) continue;
    if (!found.empty()) {
      wrong_use(fmt::format("scene {}: more than one id begins so, {} and {}", prefix, found,
                            scene.scene_id()));
    }
    found = scene.scene_id();
  }
  if (found.empty()) {
    throw CommandError(kServerSaidNo,
                       fmt::format("scene {}: no id of a loaded scene begins so (see lucerna "
                                   "scenes); a file of that name is ./{}",
                                   prefix, prefix));
  }
  return found;
}

v1::LoadSceneResponse load_scene(Session& session, const std::string& path, double lease_s) {
  v1::LoadSceneRequest request;
  request.set_path(path);
  if (lease_s > 0) request.set_lease_s(lease_s);
  return session.ask(session.client().load_scene(request, session.call_options()));
}

v1::ListScenesResponse list_scenes(Session& session) {
  v1::ListScenesResponse all;
  v1::ListScenesRequest request;
  do {
    auto page = session.ask(session.client().list_scenes(request, session.call_options()));
    request.set_page_token(page.next_page_token());
    all.MergeFrom(page);
  } while (!request.page_token().empty());
  all.clear_next_page_token();
  return all;
}

v1::ListLightsResponse list_lights(Session& session, const std::string& scene_id) {
  v1::ListLightsResponse all;
  v1::ListLightsRequest request;
  request.set_scene_id(scene_id);
  do {
    auto page = session.ask(session.client().list_lights(request, session.call_options()));
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
