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

/// Counts one request of a caller as in flight until it is destroyed.  Null: nothing is counted.
struct EndRequest {
  void operator()(Usage* usage) const { --usage->in_flight; }
};
using InFlight = std::unique_ptr<Usage, EndRequest>;

struct Admission {
  Caller caller;
  InFlight in_flight;

  /// Takes `items` from the caller's items of this second.  Returns 0, or takes nothing and returns
  /// the time after which they are there.
  std::chrono::milliseconds take_items(std::uint64_t items) const {
    if (in_flight == nullptr) return std::chrono::milliseconds(0);
    return in_flight->items.take(items, caller.quota.items_per_second);
  }
  /// Takes `items` that a call has computed.  Later calls wait until the rate has made up for them.
  void owe_items(std::uint64_t items) const {
    if (in_flight != nullptr && caller.quota.items_per_second > 0) in_flight->items.owe(items);
  }
};

/// Thread-safe.  Must outlive its admissions.
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
  std::mutex mutex_;
  std::shared_ptr<const std::vector<Token>> tokens_;  // null: no token file
  std::map<std::string, Usage> usages_;               // by name; never erased
};

}  // namespace lucerna::access
