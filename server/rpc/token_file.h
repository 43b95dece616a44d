// The file with the tokens of callers, in TOML:
//
//   [[token]]
//   name = "render-farm"
//   sha256 = "9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08"
//   roles = ["query", "load"]
//   max-requests = 16
//   max-items-per-second = 1_000_000
//   max-asset-bytes = 1_000_000_000
//
// `token` may stand for `sha256`; the digest keeps the token itself out of the file.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "server/monitor/calls.h"

namespace lucerna::access {

using monitor::Call;
using monitor::Role;

/// What one caller may use; 0: no limit.
struct Quota {
  std::uint64_t requests = 0;  ///< in flight
  std::uint64_t leases = 0;
  std::uint64_t scenes = 0;            ///< that it loaded and that are still in memory
  std::uint64_t items_per_second = 0;  ///< that its calls compute
  std::uint64_t asset_bytes = 0;       ///< of the files on the disk that it uploaded
};

struct Token {
  std::string name;    ///< of the caller; several tokens may have one name
  std::string sha256;  ///< of the token, 32 bytes
  std::set<Role> roles;
  Quota quota;
};

/// Reads the file.  INVALID_ARGUMENT with all errors, "FILE:LINE:COLUMN: what is wrong", one a
/// line. No error contains a token.
absl::StatusOr<std::vector<Token>> read_token_file(const std::string& path);

}  // namespace lucerna::access
