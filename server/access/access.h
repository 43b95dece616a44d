// Who calls, and what that caller may do.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "server/access/token_file.h"

namespace lucerna::access {

/// A caller that was let in.
struct Caller {
  std::string name;  ///< empty without a token file: then all callers are one
  bool admin = true;
  Quota quota;
};

/// Counts one request of a caller as in flight until it is destroyed.
class InFlight {
 public:
  InFlight() = default;
  explicit InFlight(std::shared_ptr<std::atomic<std::uint64_t>> count) : count_(std::move(count)) {}
  InFlight(InFlight&&) noexcept = default;
  InFlight& operator=(InFlight&& other) noexcept {
    release();
    count_ = std::move(other.count_);
    return *this;
  }
  ~InFlight() { release(); }

 private:
  void release() {
    if (count_ != nullptr) count_->fetch_sub(1);
    count_ = nullptr;
  }
  std::shared_ptr<std::atomic<std::uint64_t>> count_;
};

struct Admission {
  Caller caller;
  InFlight in_flight;
};

/// Thread-safe.
class Access {
 public:
  /// Without tokens every caller may do everything.
  Access() = default;

  /// From now on only these tokens are known.  Calls that run continue.
  void set_tokens(std::vector<Token> tokens);

  /// Whether every caller may do everything.
  bool open();

  /// Lets a call in.  `authorization` is the header of that name, or empty.
  ///
  /// UNAUTHENTICATED without a known token.  PERMISSION_DENIED if the token lacks the role of the
  /// call; the message names that role.  RESOURCE_EXHAUSTED if too many requests of the caller are
  /// in flight.
  absl::StatusOr<Admission> admit(Call call, std::string_view authorization);

 private:
  struct Known {
    std::vector<Token> tokens;
  };
  std::mutex mutex_;
  std::shared_ptr<const Known> known_;  // null: no token file
  std::map<std::string, std::shared_ptr<std::atomic<std::uint64_t>>> in_flight_;  // by name
};

}  // namespace lucerna::access
