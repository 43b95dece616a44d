#include "lucerna/client/server_list.h"

#include <netdb.h>
#include <sys/socket.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <memory>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "client/library/patience.h"
#include "client/library/target.h"
#include "proto/common/status_macros.h"

namespace lucerna::client {
namespace {

using Targets = std::vector<std::string>;

// With a dead name server, getaddrinfo() takes half a minute or more, and it cannot be stopped.
constexpr std::chrono::seconds kLookUpTime(5);

absl::Status check_target(const std::string& target) {
  const absl::Status status = servers_of(target).status();
  if (status.ok()) return status;
  return absl::InvalidArgumentError(absl::StrCat("server ", status.message()));
}

absl::StatusOr<Targets> split(const std::string& text) {
  Targets targets = absl::StrSplit(is_list(text) ? text.substr(text.find(':') + 1) : text, ',');
  for (const std::string& target : targets) LUCERNA_RETURN_IF_ERROR(check_target(target));
  return targets;
}

absl::StatusOr<Targets> lines(const std::string& path) {
  std::ifstream in(path);
  if (!in) return absl::UnavailableError(path + ": cannot be read");
  Targets targets;
  for (std::string line; std::getline(in, line);) {
    line = line.substr(0, line.find('#'));
    const std::size_t begin = line.find_first_not_of(" \t\r");
    if (begin == std::string::npos) continue;
    line = line.substr(begin, line.find_last_not_of(" \t\r") + 1 - begin);
    if (absl::Status s = check_target(line); !s.ok())
      return absl::InvalidArgumentError(path + ": " + std::string(s.message()));
    targets.push_back(line);
  }
  return targets;
}

/// The items of "a,b[1-2,5],c"; commas within brackets do not separate.
absl::StatusOr<Targets> items(const std::string& text) {
  Targets all{""};
  bool inside = false;
  for (const char c : text) {
    if (c == '[' && inside) return absl::InvalidArgumentError("");
    if (c == '[') inside = true;
    if (c == ']' && !inside) return absl::InvalidArgumentError("");
    if (c == ']') inside = false;
    if (c == ',' && !inside) {
      all.emplace_back();
    } else {
      all.back() += c;
    }
  }
  if (inside) return absl::InvalidArgumentError("");
  return all;
}

/// Appends the numbers of "1-3,07" to each of `heads`.
absl::Status append_numbers(const std::string& ranges, Targets& heads) {
  constexpr std::size_t kMostNodes = 100'000;
  Targets result;
  for (const std::string& head : heads) {
    for (std::size_t begin = 0; begin <= ranges.size();) {
      const std::size_t end = std::min(ranges.find(',', begin), ranges.size());
      const std::string range = ranges.substr(begin, end - begin);
      begin = end + 1;
      const std::size_t dash = std::min(range.find('-'), range.size());
      const std::string first = range.substr(0, dash);
      const std::string last = dash < range.size() ? range.substr(dash + 1) : first;
      const auto is_number = [](const std::string& s) {
        return !s.empty() && s.size() < 10 &&
               s.find_first_not_of("0123456789") == std::string::npos;
      };
      if (!is_number(first) || !is_number(last)) return absl::InvalidArgumentError("");
      for (unsigned long n = std::stoul(first); n <= std::stoul(last); ++n) {
        if (result.size() == kMostNodes) return absl::InvalidArgumentError("");
        const std::string digits = std::to_string(n);
        const std::size_t zeros = first.size() > digits.size() ? first.size() - digits.size() : 0;
        result.push_back(head + std::string(zeros, '0') + digits);
      }
    }
  }
  heads = std::move(result);
  return absl::OkStatus();
}

absl::StatusOr<Targets> look_up(const HostPort& server) {
  const std::string port = std::to_string(server.port);
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (const int error = getaddrinfo(server.host.c_str(), port.c_str(), &hints, &found); error != 0)
    return absl::UnavailableError(server.host + ": " + gai_strerror(error));
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> all(found, &freeaddrinfo);
  Targets targets;
  for (const addrinfo* a = found; a != nullptr; a = a->ai_next) {
    char name[NI_MAXHOST];
    if (getnameinfo(a->ai_addr, a->ai_addrlen, name, sizeof name, nullptr, 0, NI_NUMERICHOST) != 0)
      continue;
    targets.push_back(join_host_port({.host = name, .port = server.port}));
  }
  return targets;
}

}  // namespace

absl::StatusOr<Targets> numeric_addresses(const std::string& target) {
  LUCERNA_ASSIGN_OR_RETURN(const std::vector<HostPort> servers, servers_of(target));
  if (servers.size() != 1)
    return absl::InvalidArgumentError("server \"" + target + "\", allowed: one HOST:PORT");
  return look_up_within(kLookUpTime, servers[0].host,
                        [server = servers[0]] { return look_up(server); });
}

absl::StatusOr<Targets> expand_host_list(const std::string& text) {
  const absl::Status bad =
      absl::InvalidArgumentError("host list \"" + text + "\", must be of the form n[1-3,07],login");
  const absl::StatusOr<Targets> all = items(text);
  if (!all.ok()) return bad;
  Targets hosts;
  for (const std::string& item : *all) {
    Targets expanded{""};
    for (std::size_t at = 0; at < item.size();) {
      const std::size_t open = std::min(item.find('[', at), item.size());
      for (std::string& host : expanded) host += item.substr(at, open - at);
      if (open == item.size()) break;
      const std::size_t close = item.find(']', open);
      if (!append_numbers(item.substr(open + 1, close - open - 1), expanded).ok()) return bad;
      at = close + 1;
    }
    if (expanded.front().empty()) return bad;
    hosts.insert(hosts.end(), expanded.begin(), expanded.end());
  }
  return hosts;
}

absl::StatusOr<ServerList> server_list(const std::string& text) {
  if (text.starts_with('@')) {
    const std::string path = text.substr(1);
    if (absl::StatusOr<Targets> now = lines(path); absl::IsInvalidArgument(now.status()))
      return now.status();
    return ServerList([path] { return lines(path); });
  }
  if (text.starts_with("dns:///")) {
    LUCERNA_RETURN_IF_ERROR(check_target(text));
    return ServerList([text] { return numeric_addresses(text); });
  }
  if (text.starts_with("slurm:")) {
    const std::string port = text.substr(6);
    LUCERNA_RETURN_IF_ERROR(check_target(text));
    const char* nodes = std::getenv("SLURM_JOB_NODELIST");
    if (nodes == nullptr)
      return absl::InvalidArgumentError(
          "servers \"" + text + "\": SLURM_JOB_NODELIST is not set, so this is not a Slurm job");
    LUCERNA_ASSIGN_OR_RETURN(Targets hosts, expand_host_list(nodes));
    for (std::string& host : hosts) host += ":" + port;
    return ServerList([hosts = std::move(hosts)]() -> absl::StatusOr<Targets> { return hosts; });
  }
  LUCERNA_ASSIGN_OR_RETURN(Targets targets, split(text));
  return ServerList(
      [targets = std::move(targets)]() -> absl::StatusOr<Targets> { return targets; });
}

}  // namespace lucerna::client
