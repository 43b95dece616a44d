// Lists of servers.
//
//   const auto list = server_list("@hosts.txt");
//   if (!list.ok()) return list.status();
//   const auto targets = (*list)();  // {"a:50051", "b:50051"}
//
// Jobs and QueryServers call the list repeatedly, so servers may join and leave.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace lucerna::client {

/// Returns the servers that are present now, each as HOST:PORT.  After an error the caller tries
/// again later.
using ServerList = std::function<absl::StatusOr<std::vector<std::string>>()>;

/// The list that `text` describes:
///   a:50051,b:50051    these servers; also ipv4:A:50051,B:50051 and ipv6:[A]:50051,[B]:50051
///   dns:///name:50051  every address that the name has, looked up at each call
///   @file              the lines of a file, each HOST:PORT, read at each call; # starts a comment
///   slurm:50051        the nodes of this Slurm job (SLURM_JOB_NODELIST), each at this port
/// INVALID_ARGUMENT for anything else.
absl::StatusOr<ServerList> server_list(const std::string& text);

/// The addresses of "HOST:PORT", each as A.B.C.D:PORT or [IPV6]:PORT.  UNAVAILABLE if the name has
/// no address, or if the look-up takes more than 5 s.  The look-up thread then continues until it
/// has an answer.
absl::StatusOr<std::vector<std::string>> numeric_addresses(const std::string& target);

/// The nodes of a Slurm host list such as "n[1-3,07],login".  INVALID_ARGUMENT for other text.
absl::StatusOr<std::vector<std::string>> expand_host_list(const std::string& text);

}  // namespace lucerna::client
