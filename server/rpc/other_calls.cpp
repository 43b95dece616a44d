#include "server/rpc/other_calls.h"

#include <grpcpp/server_context.h>

#include <chrono>
#include <string>
#include <string_view>
#include <unordered_set>

#include "server/monitor/request_id.h"

namespace lucerna::rpc {
namespace {

using grpc::experimental::InterceptionHookPoints;
using monitor::Call;

/// `method` is "/" and the full name.
bool is_of_contract(std::string_view method) {
  static const std::unordered_set<std::string_view> names = [] {
    std::unordered_set<std::string_view> all;
    for (std::size_t i = 0; i < monitor::kContractCalls; ++i)
      all.insert(monitor::name_of(static_cast<Call>(i)));
    return all;
  }();
  return !method.empty() && names.contains(method.substr(1));
}

Call call_of(std::string_view method) {
  if (method == "/grpc.health.v1.Health/Check") return Call::kHealthCheck;
  if (method == "/grpc.health.v1.Health/Watch") return Call::kHealthWatch;
  if (method.starts_with("/grpc.reflection.")) return Call::kReflection;
  return Call::kUnknown;
}

class Recorder final : public grpc::experimental::Interceptor {
 public:
  Recorder(Runtime& runtime, grpc::ServerContextBase* context, Call call)
      : runtime_(runtime), context_(context) {
    record_.call = call;
    record_.code = grpc::StatusCode::CANCELLED;  // unless a status is sent
    record_.request_id = monitor::make_request_id();
    runtime_.statistics.begin(call);
  }
  ~Recorder() override {
    record_.total_s =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - arrived_).count();
    runtime_.statistics.end(record_);
    if (runtime_.on_call) runtime_.on_call(record_);
  }

  void Intercept(grpc::experimental::InterceptorBatchMethods* methods) override {
    if (methods->QueryInterceptionHookPoint(InterceptionHookPoints::PRE_SEND_INITIAL_METADATA) &&
        context_ != nullptr) {
      record_.peer = context_->peer();
    }
    if (methods->QueryInterceptionHookPoint(InterceptionHookPoints::PRE_SEND_STATUS)) {
      record_.code = methods->GetSendStatus().error_code();
    }
    methods->Proceed();
  }

 private:
  Runtime& runtime_;
  grpc::ServerContextBase* context_;
  std::chrono::steady_clock::time_point arrived_ = std::chrono::steady_clock::now();
  monitor::CallRecord record_;
};

}  // namespace

grpc::experimental::Interceptor* OtherCalls::CreateServerInterceptor(
    grpc::experimental::ServerRpcInfo* info) {
  const std::string_view method = info->method();
  if (is_of_contract(method)) return nullptr;
  return new Recorder(runtime_, info->server_context(), call_of(method));  // gRPC deletes it
}

}  // namespace lucerna::rpc
