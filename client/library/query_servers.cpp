#include "lucerna/client/query_servers.h"

#include <algorithm>
#include <atomic>
#include <optional>
#include <set>
#include <thread>
#include <vector>

#include "client/library/server_error.h"
#include "proto/common/host_port.h"
#include "proto/common/status_macros.h"

namespace lucerna::client {
namespace {

// A server that does not answer in this time counts as absent.
constexpr std::chrono::seconds kAnswerTime(10);
constexpr std::size_t kMostAtOnce = 32;

/// The answer of a server, from the first of its addresses that answers.
struct Answer {
  std::string target;
  std::string address;
  absl::Status status = absl::UnavailableError("its name has no address");
  std::optional<Client> client;
  std::string fingerprint;
  v1::LoadSceneResponse loaded;
};

void make_ready(const QueryServersOptions& options, Answer* answer) {
  std::vector<std::string> addresses{answer->target};
  if (!answer->target.starts_with("unix:")) {
    auto found = numeric_addresses(answer->target);
    if (!found.ok()) {
      answer->status = found.status();
      return;
    }
    addresses = *std::move(found);
  }
  for (const std::string& address : addresses) {
    const auto client = Client::connect({.target = address, .security = options.security});
    if (!client.ok()) {
      answer->status = client.status();
      continue;
    }
    CallOptions soon = options.call;
    soon.deadline = std::min<CallOptions::Clock::time_point>(
        soon.deadline, CallOptions::Clock::now() + kAnswerTime);
    const auto info = client->get_server_info({}, soon);
    answer->status = info.status();
    if (!info.ok()) continue;
    auto loaded = options.load(*client, options.call);
    answer->status = loaded.status();
    if (!loaded.ok()) return;
    answer->address = address;
    answer->client = *client;
    answer->fingerprint = info->fingerprint().digest();
    answer->loaded = *std::move(loaded);
    return;
  }
}

std::vector<Answer> make_all_ready(const QueryServersOptions& options,
                                   const std::vector<std::string>& targets) {
  std::vector<Answer> answers(targets.size());
  std::atomic<std::size_t> next = 0;
  std::vector<std::jthread> threads;
  for (std::size_t i = 0; i < std::min(targets.size(), kMostAtOnce); ++i) {
    threads.emplace_back([&] {
      for (std::size_t n = next++; n < targets.size(); n = next++) {
        answers[n].target = targets[n];
        make_ready(options, &answers[n]);
      }
    });
  }
  threads.clear();
  return answers;
}

/// A target in gRPC's syntax for lists, for all these addresses.
std::string target_of(const std::set<std::string>& addresses) {
  const bool v6 = std::any_of(addresses.begin(), addresses.end(),
                              [](const std::string& a) { return a.starts_with('['); });
  std::string target = v6 ? "ipv6:" : "ipv4:";
  for (const std::string& address : addresses) {
    if (target.size() > 5) target += ',';
    HostPort at = *split_host_port(address);
    // A list has one kind of addresses.  IPv6 includes all of IPv4 [RFC4291, 2.5.5.2].
    if (v6 && !address.starts_with('[')) at.host.insert(0, "::ffff:");
    target += join_host_port(at);
  }
  return target;
}

}  // namespace

struct QueryServers::State {
  QueryServersOptions options;
  std::optional<Client> client;
  v1::LoadSceneResponse loaded;
  std::set<std::string> fingerprints;
  std::set<std::string> reported;  // servers that were reported as left out
};

QueryServers::QueryServers(std::unique_ptr<State> state) : state_(std::move(state)) {}
QueryServers::QueryServers(QueryServers&&) noexcept = default;
QueryServers& QueryServers::operator=(QueryServers&&) noexcept = default;
QueryServers::~QueryServers() = default;

absl::StatusOr<QueryServers> QueryServers::connect(const QueryServersOptions& options) {
  QueryServers servers(std::make_unique<State>());
  servers.state_->options = options;
  LUCERNA_RETURN_IF_ERROR(servers.load_everywhere());
  return servers;
}

const Client& QueryServers::client() const { return *state_->client; }
const std::string& QueryServers::scene_id() const { return state_->loaded.scene_id(); }
const v1::LoadSceneResponse& QueryServers::loaded() const { return state_->loaded; }
std::vector<std::string> QueryServers::fingerprints() const {
  return {state_->fingerprints.begin(), state_->fingerprints.end()};
}

bool QueryServers::scene_may_be_lost(const absl::Status& status) {
  return absl::IsNotFound(status) || absl::IsUnavailable(status) || absl::IsUnknown(status) ||
         absl::IsCancelled(status);
}

absl::Status QueryServers::load_everywhere() {
  State& state = *state_;
  if (state.options.call.stop.stop_requested()) return absl::CancelledError("the caller stopped");
  const bool first_time = !state.client.has_value();
  LUCERNA_ASSIGN_OR_RETURN(const auto targets, state.options.servers());
  const std::vector<Answer> answers = make_all_ready(state.options, targets);

  const auto leave_out = [&](const Answer& answer, const std::string& why) {
    if (state.options.on_event && state.reported.insert(answer.target).second) {
      state.options.on_event(answer.target + ": " + why + "; continuing without it");
    }
  };
  std::optional<v1::LoadSceneResponse> loaded;
  if (!first_time) loaded = state.loaded;
  const Answer* first = nullptr;
  std::set<std::string> addresses;
  std::set<std::string> fingerprints;
  if (!first_time && !state.options.allow_mixed) fingerprints = state.fingerprints;
  for (const Answer& answer : answers) {
    if (!answer.status.ok()) continue;
    if (!loaded) loaded = answer.loaded;
    if (answer.loaded.scene_id() != loaded->scene_id()) {
      return absl::FailedPreconditionError(
          "the scene of " + answer.target + " is " + answer.loaded.scene_id() + ", but " +
          (first_time ? "that of the other servers is " : "it was ") + loaded->scene_id() +
          ": the files differ");
    }
    if (!state.options.allow_mixed && !fingerprints.empty() &&
        !fingerprints.contains(answer.fingerprint)) {
      const std::string why = "its numeric fingerprint is " + answer.fingerprint + ", that of " +
                              (first == nullptr ? "the servers before" : first->target) + " " +
                              *fingerprints.begin() +
                              ": their results would differ in the last digits";
      if (first_time) return absl::FailedPreconditionError(answer.target + ": " + why);
      leave_out(answer, why);
      continue;
    }
    fingerprints.insert(answer.fingerprint);
    addresses.insert(answer.address);
    if (first == nullptr) first = &answer;
  }
  if (first == nullptr) {
    if (answers.empty()) return absl::UnavailableError("the list of servers is empty");
    // Prefers the error of a server that answers over that of one that does not.
    const auto worst = std::find_if(answers.begin(), answers.end(), [](const Answer& answer) {
      return !answer.status.ok() && !absl::IsUnavailable(answer.status);
    });
    const Answer& failed = worst == answers.end() ? answers.front() : *worst;
    if (failed.status.ok()) {
      return absl::FailedPreconditionError(
          "no server with the numeric fingerprint of the earlier ones is left");
    }
    return from_server(failed.target, failed.status);
  }
  for (const Answer& answer : answers) {
    if (!answer.status.ok()) leave_out(answer, std::string(answer.status.message()));
  }
  if (addresses.size() == 1) {
    state.client = first->client;
  } else {
    const bool is_path = std::any_of(addresses.begin(), addresses.end(),
                                     [](const std::string& a) { return a.starts_with("unix:"); });
    if (is_path) return absl::InvalidArgumentError("unix: names one server, not one of several");
    LUCERNA_ASSIGN_OR_RETURN(auto client, Client::connect({.target = target_of(addresses),
                                                           .security = state.options.security}));
    state.client = std::move(client);
  }
  state.loaded = *std::move(loaded);
  state.fingerprints = std::move(fingerprints);
  return absl::OkStatus();
}

}  // namespace lucerna::client
