#include "client/cli/held_scene.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace lucerna::cli {
namespace {

// Who takes longer to answer what only asks is not there.
constexpr std::chrono::seconds kPatience(10);
// For who still loads what nobody needs any more.
constexpr std::chrono::seconds kPatienceAtTheEnd(2);
// The shortest lease that can be asked for ends one: to release it would unload the scene.
constexpr double kNoLease_s = 1e-3;

client::CallOptions soon(client::CallOptions call) {
  call.deadline = std::min<client::CallOptions::Clock::time_point>(
      call.deadline, client::CallOptions::Clock::now() + kPatience);
  return call;
}

}  // namespace

HeldScene::~HeldScene() {
  for (auto& [target, holding] : holdings_) holding.thread.request_stop();
  // Joined before the mutex and the map go.
  for (auto& [target, holding] : holdings_) holding.thread = {};
}

HeldScene::Load HeldScene::through(Load load) {
  return [this, load = std::move(load)](const client::Client& client,
                                        const client::CallOptions& call) {
    return load_on(load, client, call);
  };
}

v1::LoadSceneResponse HeldScene::answer(const Holding& holding) {
  v1::LoadSceneResponse loaded;
  loaded.set_scene_id(holding.scene_id);
  loaded.set_already_loaded(!holding.brought);
  loaded.set_lease_id(holding.lease_id);
  return loaded;
}

std::optional<v1::LoadSceneResponse> HeldScene::renew(const client::Client& client,
                                                      const client::CallOptions& call) {
  v1::RenewLeaseRequest request;
  {
    const std::lock_guard lock(mutex_);
    const Holding& holding = holdings_[client.target()];
    if (holding.loading || holding.lease_id.empty()) return std::nullopt;
    request.set_scene_id(holding.scene_id);
    request.set_lease_id(holding.lease_id);
  }
  request.set_lease_s(static_cast<double>(client::kJobLease.count()));
  // The lease ran out during a long frame, or the server began anew: it is loaded again.
  if (!client.renew_lease(request, soon(call)).ok()) return std::nullopt;
  const std::lock_guard lock(mutex_);
  return answer(holdings_[client.target()]);
}

void HeldScene::hold(const client::Client& client, const v1::LoadSceneResponse& loaded) {
  const std::lock_guard lock(mutex_);
  Holding& holding = holdings_[client.target()];
  holding.client = client;
  holding.scene_id = loaded.scene_id();
  holding.lease_id = loaded.lease_id();
  holding.brought = holding.brought || !loaded.already_loaded();
  holding.failure = absl::OkStatus();
}

absl::StatusOr<v1::LoadSceneResponse> HeldScene::load_on(const Load& load,
                                                         const client::Client& client,
                                                         const client::CallOptions& call) {
  if (auto renewed = renew(client, call)) return *std::move(renewed);
  std::unique_lock lock(mutex_);
  Holding& holding = holdings_[client.target()];  // stays where it is
  if (!holding.loading) {
    holding.loading = true;
    holding.thread = std::jthread(
        [this, &holding, load, client, deadline = call.deadline](const std::stop_token& stop) {
          const auto loaded = load(client, {.deadline = deadline, .stop = stop});
          if (loaded.ok()) hold(client, *loaded);
          const std::lock_guard done(mutex_);
          if (!loaded.ok()) holding.failure = loaded.status();
          holding.loading = false;
          changed_.notify_all();
        });
  }
  if (!changed_.wait(lock, call.stop, [&] { return !holding.loading; }))
    return absl::CancelledError("the job ended");
  if (!holding.failure.ok()) return holding.failure;
  return answer(holding);
}

void HeldScene::release(bool forget, const client::CallOptions& call) {
  std::map<std::string, Holding> all;
  {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, call.stop, kPatienceAtTheEnd, [this] {
      return std::none_of(holdings_.begin(), holdings_.end(),
                          [](const auto& h) { return h.second.loading; });
    });
    for (auto& [target, holding] : holdings_) holding.thread.request_stop();
  }
  for (auto& [target, holding] : holdings_) holding.thread = {};
  all.swap(holdings_);
  for (const auto& [target, held] : all) {
    if (!held.client) continue;
    if (forget && held.brought) {
      v1::ReleaseSceneRequest request;
      request.set_scene_id(held.scene_id);
      request.set_lease_id(held.lease_id);
      if (!absl::IsNotFound(held.client->release_scene(request, soon(call)).status())) continue;
      // The lease ran out in a long frame.
      request.clear_lease_id();
      held.client->release_scene(request, soon(call)).status().IgnoreError();
    } else if (!held.lease_id.empty()) {
      v1::RenewLeaseRequest request;
      request.set_scene_id(held.scene_id);
      request.set_lease_id(held.lease_id);
      request.set_lease_s(kNoLease_s);
      held.client->renew_lease(request, soon(call)).status().IgnoreError();
    }
  }
}

}  // namespace lucerna::cli
