#include "client/rpc/channel.h"

#include <grpcpp/grpcpp.h>

#include <string>

namespace lucerna::client {
namespace {

// A server that starts or drains answers UNAVAILABLE; half a second bridges a restart's gap without
// making a person wait for an address where nobody is.  Uploads go on where they broke (upload.h)
// and are not sent all over again.  Where calls keep failing nothing is tried again: half of the
// tokens are what hundreds of calls at once lose by one server's death and no more.
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
  // A server that shuts down answers CANCELLED to what it has received and not begun
  // (https://github.com/grpc/grpc/issues/41785); another will answer.
  const std::string codes = many ? R"("UNAVAILABLE", "CANCELLED")" : R"("UNAVAILABLE")";
  return config.replace(config.find('@'), 1, codes);
}

constexpr char kRoundRobin[] = R"("loadBalancingConfig": [{"round_robin": {}}])";

constexpr int kRetryBytes = 64 << 20;
// The server takes a ping every five seconds.
constexpr int kKeepaliveMs = 20'000;

// One that was restarted gets its share again within so long; gRPC would let it wait for minutes.
constexpr int kLongestReconnectMs = 10'000;

bool is_list(const std::string& target) {
  return target.starts_with("ipv4:") || target.starts_with("ipv6:");
}

bool is_loopback(const std::string& target) {
  for (const char* prefix : {"127.", "localhost:", "[::1]:", "unix:"}) {
    if (target.starts_with(prefix)) return true;
  }
  return false;
}

}  // namespace

std::shared_ptr<grpc::Channel> make_channel(const ConnectOptions& options) {
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(-1);
  arguments.SetMaxSendMessageSize(-1);
  const bool many = is_list(options.target) || options.target.starts_with("dns:///");
  std::string config = many ? kRoundRobin : "";
  if (options.retry) {
    config += (config.empty() ? "" : ", ") + service_config(many);
    // Of a larger request gRPC keeps nothing to send again, and says nothing of that.
    arguments.SetInt("grpc.per_rpc_retry_buffer_size", kRetryBytes);
  } else {
    arguments.SetInt(GRPC_ARG_ENABLE_RETRIES, 0);
  }
  arguments.SetServiceConfigJSON("{" + config + "}");
  // Else the name's TXT records are asked for another configuration, at every client's start.
  arguments.SetInt(GRPC_ARG_SERVICE_CONFIG_DISABLE_RESOLUTION, 1);
  if (many) arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, kLongestReconnectMs);
  // Else a server that hangs, or a machine that is gone, keeps a call waiting for ever.
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, kKeepaliveMs);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, kKeepaliveMs);
  arguments.SetInt(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
  // Else a client inherits the waiting time of another client's failed attempts at the same
  // address.
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  // gRPC would ask a proxy from the environment to reach even this machine, or a whole list as if
  // it were one address.
  if (is_loopback(options.target) || is_list(options.target))
    arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  return grpc::CreateCustomChannel(options.target, grpc::InsecureChannelCredentials(), arguments);
}

}  // namespace lucerna::client
