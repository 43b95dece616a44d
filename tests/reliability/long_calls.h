// Every call that computes for long, with a request that takes at least a tenth of a second.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tests/reliability/subject.h"

namespace lucerna::reliability {

/// The items of the batches below, which the server must accept.
inline constexpr int kManyItems = 1 << 20;

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
