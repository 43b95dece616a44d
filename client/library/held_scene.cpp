#include "client/library/held_scene.h"

#include <algorithm>
#include <chrono>
#include <utility>
#include <vector>

#include "proto/common/status_macros.h"

namespace lucerna::client {
namespace {

// A server that does not answer a lease call in this time counts as absent.
constexpr std::chrono::seconds kLeaseCallTime(10);
// Longest wait for servers that still load when the scene is released.
constexpr std::chrono::seconds kWaitAtTheEnd(2);
// The shortest lease that servers allow.  Renewing with it ends a lease.  ReleaseScene would unload
// the scene.
constexpr double kNoLease_s = 1e-3;

client::CallOptions soon(client::CallOptions call) {
  call.deadline = std::min<client::CallOptions::Clock::time_point>(
      call.deadline, client::CallOptions::Clock::now() + kLeaseCallTime);
  return call;
}

}  // namespace

HeldScene::~HeldScene() {
  for (auto& [target, holding] : holdings_) holding.thread.request_stop();
  // Join before the mutex and the map are destroyed.
  for (auto& [target, holding] : holdings_) holding.thread = {};
}

HeldScene::Load HeldScene::through(Load load) {
  return [this, load = std::move(load)](const client::Client& client,
                                        const client::CallOptions& call) {
    return load_on(load, client, call);
  };
}

void HeldScene::end_lease(const Holding& held, bool forget, const client::CallOptions& call) {
  if (forget && held.brought) {
    v1::ReleaseSceneRequest request;
    request.set_scene_id(held.scene_id);
    request.set_lease_id(held.lease_id);
    if (!absl::IsNotFound(held.client->release_scene(request, call).status())) return;
    // The lease expired during a long frame.
    request.clear_lease_id();
    held.client->release_scene(request, call).status().IgnoreError();
  } else if (!held.lease_id.empty()) {
    v1::RenewLeaseRequest request;
    request.set_scene_id(held.scene_id);
    request.set_lease_id(held.lease_id);
    request.set_lease_s(kNoLease_s);
    held.client->renew_lease(request, call).status().IgnoreError();
  }
}

v1::LoadSceneResponse HeldScene::answer(const Holding& holding) {
  v1::LoadSceneResponse loaded;
  loaded.set_scene_id(holding.scene_id);
  loaded.set_already_loaded(!holding.brought);
  loaded.set_lease_id(holding.lease_id);
  return loaded;
}

absl::StatusOr<std::optional<v1::LoadSceneResponse>> HeldScene::renew(
    const client::Client& client, const client::CallOptions& call) {
  v1::RenewLeaseRequest request;
  {
    const std::lock_guard lock(mutex_);
    const Holding& holding = holdings_[client.target()];
    if (holding.loading || holding.lease_id.empty()) return std::optional<v1::LoadSceneResponse>();
    request.set_scene_id(holding.scene_id);
    request.set_lease_id(holding.lease_id);
  }
  request.set_lease_s(static_cast<double>(client::kJobLease.count()));
  const auto renewed = client.renew_lease(request, soon(call));
  // The lease expired during a long frame, or the server restarted: the scene is loaded again.
  if (absl::IsNotFound(renewed.status())) return std::optional<v1::LoadSceneResponse>();
  if (!renewed.ok()) return renewed.status();
  const std::lock_guard lock(mutex_);
  return std::optional(answer(holdings_[client.target()]));
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
  std::unique_lock lock(mutex_);
  Holding& holding = holdings_[client.target()];  // map nodes are stable
  const auto loaded = [&] {
    return changed_.wait(lock, call.stop, [&] { return !holding.loading; });
  };
  // The call of an earlier job may have loaded the scene meanwhile.  Do not create a second lease,
  // since nothing would end it.
  for (std::string lost; loaded() && holding.lease_id != lost;) {
    lost = holding.lease_id;
    lock.unlock();
    LUCERNA_ASSIGN_OR_RETURN(auto renewed, renew(client, call));
    if (renewed) return *std::move(renewed);
    lock.lock();
  }
  if (call.stop.stop_requested()) return absl::CancelledError("the job ended");
  if (!holding.loading) {
    holding.loading = true;
    holding.failure = absl::OkStatus();
    holding.thread = std::jthread(
        [this, &holding, load, client, deadline = call.deadline](const std::stop_token& stop) {
          const auto answer = load(client, {.deadline = deadline, .stop = stop});
          if (answer.ok()) hold(client, *answer);
          const std::lock_guard done(mutex_);
          if (!answer.ok()) holding.failure = answer.status();
          holding.loading = false;
          changed_.notify_all();
        });
  }
  if (!loaded()) return absl::CancelledError("the job ended");
  if (!holding.failure.ok()) return holding.failure;
  return answer(holding);
}

void HeldScene::release(bool forget, const client::CallOptions& call) {
  std::map<std::string, Holding> all;
  {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, call.stop, kWaitAtTheEnd, [this] {
      return std::none_of(holdings_.begin(), holdings_.end(),
                          [](const auto& h) { return h.second.loading; });
    });
    for (auto& [target, holding] : holdings_) holding.thread.request_stop();
  }
  for (auto& [target, holding] : holdings_) holding.thread = {};
  all.swap(holdings_);
  // Call the servers in parallel, so that all calls take as long as one.
  const client::CallOptions end = soon(call);
  std::vector<std::jthread> threads;
  for (const auto& [target, held] : all) {
    if (held.client) threads.emplace_back([&held, &end, forget] { end_lease(held, forget, end); });
  }
}

}  // namespace lucerna::client
