// Every call that computes for long, with a request that takes as long as it may.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tests/reliability/subject.h"

namespace lucerna::reliability {

/// The items of the batches below, which the server must accept.  Four times the default limit:
/// smaller batches end by themselves too soon.
inline constexpr int kManyItems = 1 << 18;

struct LongCall {
  std::string name;
  /// Makes the request.  Requests of LoadScene and EditLights differ each time, since the server
  /// keeps what it has built.
  std::function<Message()> message;
  /// Sent again and again after the first message.
  std::optional<grpc::ByteBuffer> repeated = std::nullopt;
};

/// The other calls take microseconds.
std::vector<LongCall> long_calls(const Subject& subject, const SceneFiles& files);

}  // namespace lucerna::reliability
