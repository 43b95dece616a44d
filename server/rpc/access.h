// Who calls, and what that caller may do.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "server/rpc/item_bucket.h"
#include "server/rpc/token_file.h"

namespace lucerna::access {

/// A caller that was let in.
struct Caller {
  std::string name;  ///< empty without a token file: then all callers are one
  bool admin = true;
  Quota quota;
};

/// What the calls of one name use.  Thread-safe.
struct Usage {
  std::atomic<std::uint64_t> in_flight{0};
  ItemBucket items;
};

/// Counts one request of a caller as in flight until it is destroyed.
class InFlight {
 public:
  InFlight() = default;
  explicit InFlight(std::shared_ptr<Usage> usage) : usage_(std::move(usage)) {}
  InFlight(InFlight&&) noexcept = default;
  InFlight& operator=(InFlight&& other) noexcept {
    release();
    usage_ = std::move(other.usage_);
    return *this;
  }
  ~InFlight() { release(); }

  Usage* usage() const { return usage_.get(); }  ///< null: nothing is counted

 private:
  void release() {
    if (usage_ != nullptr) usage_->in_flight.fetch_sub(1);
    usage_ = nullptr;
  }
  std::shared_ptr<Usage> usage_;
};

struct Admission {
  Caller caller;
  InFlight in_flight;

  /// Takes `items` from the caller's items of this second.  Returns 0, or takes nothing and returns
  /// the time after which they are there.
  std::chrono::milliseconds take_items(std::uint64_t items) const {
    Usage* usage = in_flight.usage();
    if (usage == nullptr) return std::chrono::milliseconds(0);
    return usage->items.take(items, caller.quota.items_per_second);
  }
  /// Takes `items` that a call has computed.  Later calls wait until the rate has made up for them.
  void owe_items(std::uint64_t items) const {
    Usage* usage = in_flight.usage();
    if (usage != nullptr && caller.quota.items_per_second > 0) usage->items.owe(items);
  }
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
  /// in flight.  `name` gets the name of a known token, also if the call is refused.
  absl::StatusOr<Admission> admit(Call call, std::string_view authorization,
                                  std::string* name = nullptr);

 private:
  struct Known {
    std::vector<Token> tokens;
  };
  std::mutex mutex_;
  std::shared_ptr<const Known> known_;                    // null: no token file
  std::map<std::string, std::shared_ptr<Usage>> usages_;  // by name
};

}  // namespace lucerna::access
