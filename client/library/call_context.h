// The gRPC context of one call.  This header is not installed, since it uses types of gRPC.
#pragma once

#include <grpcpp/client_context.h>

#include <stop_token>

#include "client/library/client.h"

namespace lucerna::client {

/// A gRPC context that applies the options during its lifetime.
class CallContext {
 public:
  explicit CallContext(const CallOptions& options) : cancel_(options.stop, Cancel{&context_}) {
    if (options.deadline != CallOptions::Clock::time_point::max()) {
      context_.set_deadline(options.deadline);
    }
  }

  grpc::ClientContext* get() { return &context_; }
  void cancel() { context_.TryCancel(); }

 private:
  struct Cancel {
    grpc::ClientContext* context;
    void operator()() const { context->TryCancel(); }
  };

  grpc::ClientContext context_;
  std::stop_callback<Cancel> cancel_;
};

}  // namespace lucerna::client
