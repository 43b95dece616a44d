// The standard reflection service, grpc.reflection.v1 and v1alpha, which have the same messages.
#pragma once

#include <set>
#include <string>

#include "server/rpc/reactor.h"

namespace lucerna::rpc {

/// One stream: an answer for each request.
class Reflection final : public OpenStream {
 public:
  using OpenStream::OpenStream;

  void OnWriteDone(bool ok) override;

 private:
  void take(bool ok) override;

  std::set<std::string> sent_;  // names of the files that the client has
};

}  // namespace lucerna::rpc
