#include "client/library/channel.h"

#include <grpcpp/grpcpp.h>
#include <grpcpp/support/client_interceptor.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client/library/target.h"
#include "proto/common/status_macros.h"

namespace lucerna::client {
namespace {

// A server that starts or drains answers UNAVAILABLE.  Retries for half a second bridge a restart,
// and a wrong address still fails soon.  Uploads continue where they stopped (upload.h), so they
// are not retried as a whole.  Retries stop if more than half of the tokens are used.  Half of them
// are enough for the hundreds of concurrent calls that one lost server breaks.
std::string service_config(bool many) {
  std::string config = R"(
  "retryThrottling": {"maxTokens": 1000, "tokenRatio": 1},
  "methodConfig": [{
    "name": [{}],
    "retryPolicy": {
      "maxAttempts": 4,
      "initialBackoff": "0.05s",
      "maxBackoff": "0.3s",
      "backoffMultiplier": 2,
      "retryableStatusCodes": [@]
    }
  }, {
    "name": [{"service": "lucerna.v1.SceneService", "method": "UploadAsset"}]
  }])";
  // A server that shuts down answers CANCELLED to requests that it received but did not begin
  // (https://github.com/grpc/grpc/issues/41785).  Another server can answer them.
  const std::string codes = many ? R"("UNAVAILABLE", "CANCELLED")" : R"("UNAVAILABLE")";
  return config.replace(config.find('@'), 1, codes);
}

constexpr char kRoundRobin[] = R"("loadBalancingConfig": [{"round_robin": {}}])";

constexpr int kRetryBytes = 64 << 20;
// The server allows a ping every five seconds.
constexpr int kKeepaliveMs = 20'000;

// A restarted server gets its share again after at most this time; the default of gRPC is minutes.
constexpr int kLongestReconnectMs = 10'000;

/// Whether all servers of the target are on this machine.  `servers`: what it names.
bool all_loopback(const std::string& target, const std::vector<HostPort>& servers) {
  if (servers.empty()) return target.starts_with("unix:");
  return std::all_of(servers.begin(), servers.end(), is_loopback);
}

/// Adds the token to each call.  Credentials of gRPC's calls need TLS, also on loopback.
class TokenInterceptor final : public grpc::experimental::Interceptor {
 public:
  explicit TokenInterceptor(const std::string& header) : header_(header) {}
  void Intercept(grpc::experimental::InterceptorBatchMethods* methods) override {
    if (methods->QueryInterceptionHookPoint(
            grpc::experimental::InterceptionHookPoints::PRE_SEND_INITIAL_METADATA)) {
      methods->GetSendInitialMetadata()->emplace("authorization", header_);
    }
    methods->Proceed();
  }

 private:
  const std::string& header_;
};

class TokenInterceptors final : public grpc::experimental::ClientInterceptorFactoryInterface {
 public:
  explicit TokenInterceptors(const std::string& token) : header_("Bearer " + token) {}
  grpc::experimental::Interceptor* CreateClientInterceptor(
      grpc::experimental::ClientRpcInfo*) override {
    return new TokenInterceptor(header_);  // gRPC deletes it
  }

 private:
  const std::string header_;
};

absl::Status read_file(const char* field, const std::string& path, std::string& text) {
  if (path.empty()) return absl::OkStatus();
  std::ifstream stream(path, std::ios::binary);
  std::stringstream content;
  if (stream) content << stream.rdbuf();
  if (!stream || content.bad()) {
    return absl::InvalidArgumentError(
        absl::StrCat(field, ": ", path, " cannot be read: ", std::strerror(errno)));
  }
  text = content.str();
  return absl::OkStatus();
}

absl::StatusOr<std::shared_ptr<grpc::ChannelCredentials>> make_credentials(
    const Security& security) {
  if (!security.tls) return grpc::InsecureChannelCredentials();
  if (security.certificate_file.empty() != security.key_file.empty()) {
    return absl::InvalidArgumentError("certificate_file and key_file, allowed: both or neither");
  }
  grpc::SslCredentialsOptions options;
  LUCERNA_RETURN_IF_ERROR(read_file("ca_file", security.ca_file, options.pem_root_certs));
  LUCERNA_RETURN_IF_ERROR(
      read_file("certificate_file", security.certificate_file, options.pem_cert_chain));
  LUCERNA_RETURN_IF_ERROR(read_file("key_file", security.key_file, options.pem_private_key));
  return grpc::SslCredentials(options);
}

}  // namespace

absl::StatusOr<std::shared_ptr<grpc::Channel>> make_channel(const ConnectOptions& options) {
  const Security& security = options.security;
  const auto servers = servers_of(options.target);
  if (!servers.ok())
    return absl::InvalidArgumentError(absl::StrCat("target ", servers.status().message()));
  const bool here = all_loopback(options.target, *servers);
  if (!security.token.empty() && !security.tls && !here) {
    return absl::InvalidArgumentError(absl::StrCat(
        "the token would leave this machine without encryption; use TLS for ", options.target));
  }
  LUCERNA_ASSIGN_OR_RETURN(const auto credentials, make_credentials(security));
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(-1);
  arguments.SetMaxSendMessageSize(-1);
  const bool many = is_list(options.target) || options.target.starts_with("dns:///");
  std::string config = many ? kRoundRobin : "";
  if (options.retry) {
    config += (config.empty() ? "" : ", ") + service_config(many);
    // gRPC keeps no copy of a larger request for retries, and does not report that.
    arguments.SetInt("grpc.per_rpc_retry_buffer_size", kRetryBytes);
  } else {
    arguments.SetInt(GRPC_ARG_ENABLE_RETRIES, 0);
  }
  arguments.SetServiceConfigJSON("{" + config + "}");
  // Otherwise each client looks up TXT records of the name for another configuration.
  arguments.SetInt(GRPC_ARG_SERVICE_CONFIG_DISABLE_RESOLUTION, 1);
  if (many) arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, kLongestReconnectMs);
  // Otherwise a call to a server that hangs, or to a machine that is gone, waits forever.
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, kKeepaliveMs);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, kKeepaliveMs);
  arguments.SetInt(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
  // Otherwise a client inherits the backoff of another client's failed attempts at the same
  // address.
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  // gRPC would use a proxy from the environment even for this machine, or for a whole list at once.
  if (here || is_list(options.target)) arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  if (security.tls && !security.name.empty()) {
    arguments.SetSslTargetNameOverride(security.name);
  }
  if (security.token.empty()) {
    return grpc::CreateCustomChannel(options.target, credentials, arguments);
  }
  std::vector<std::unique_ptr<grpc::experimental::ClientInterceptorFactoryInterface>> factories;
  factories.push_back(std::make_unique<TokenInterceptors>(security.token));
  return grpc::experimental::CreateCustomChannelWithInterceptors(options.target, credentials,
                                                                 arguments, std::move(factories));
}

}  // namespace lucerna::client
