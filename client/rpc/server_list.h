// Which servers there are.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace lucerna::client {

/// Says who is there now, as HOST:PORT each.  Errors pass: the list may be there the next time.
using ServerList = std::function<absl::StatusOr<std::vector<std::string>>()>;

/// The list that `text` stands for:
///   a:50051,b:50051    these
///   dns:///name:50051  every address that the name has now, asked anew each time
///   @file              the lines of a file, each HOST:PORT, read anew each time; # is a comment
///   slurm:50051        the nodes of this Slurm job (SLURM_JOB_NODELIST), each at this port
/// INVALID_ARGUMENT for anything else.
absl::StatusOr<ServerList> server_list(const std::string& text);

/// The addresses of "HOST:PORT", as A.B.C.D:PORT or [IPV6]:PORT.  UNAVAILABLE where the name has
/// none now, or is not found within 5 s; it is then still looked up in a thread that is left
/// behind.
absl::StatusOr<std::vector<std::string>> numeric_addresses(const std::string& target);

/// The nodes of a Slurm host list, as "n[1-3,07],login".  INVALID_ARGUMENT for what is none.
absl::StatusOr<std::vector<std::string>> expand_host_list(const std::string& text);

}  // namespace lucerna::client
