// A client of a lucernad server.  It has one method for each call of lucerna.v1.
//
//   const auto client = Client::connect({.target = "127.0.0.1:50051"});
//   v1::LoadSceneRequest request;
//   request.set_path("scenes/demo.pbrt");
//   const auto loaded = client->load_scene(request);
//   if (!loaded.ok()) std::cerr << loaded.status().message() << '\n';
//
// All methods block; some have a second form that does not.  Requests and responses are the
// messages of the contract (lucerna/v1/*.proto), which describes every field.  The client computes
// nothing.  batches.h sends requests in batches that the server accepts, points.h fills in points,
// picture.h assembles tiles, upload.h sends scenes.
//
// Thread safety: all methods of one Client may be called from any number of threads at once.
// Copies share one connection.  After fork(), the child must not use a Client if the parent has
// used one.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "lucerna/client/security.h"
#include "lucerna/v1/admin.pb.h"
#include "lucerna/v1/lighting.pb.h"
#include "lucerna/v1/render.pb.h"
#include "lucerna/v1/scene.pb.h"

namespace lucerna::client {

/// Key for absl::Status::GetPayload().  The payload is the server's google.rpc.Status with all
/// details, serialised.
inline constexpr char kStatusPayloadUrl[] = "type.googleapis.com/google.rpc.Status";

struct ConnectOptions {
  /// "HOST:PORT", "[IPV6]:PORT", or any other name that gRPC resolves ("unix:/run/lucernad").
  ///
  /// "dns:///NAME:PORT", "ipv4:A:PORT,B:PORT" and "ipv6:[A]:PORT,..." mean all servers that they
  /// name.  Calls go in turn to the servers that can be reached (gRPC's round_robin), and a retry
  /// goes to the next one.  Each server has its own scenes; query_servers.h loads a scene on all
  /// servers.
  std::string target = "127.0.0.1:50051";
  /// Whether a call is retried after UNAVAILABLE.
  bool retry = true;
  /// TLS and the token of the caller.
  Security security = {};
};

/// Time limit and stop of a call.
struct CallOptions {
  using Clock = std::chrono::system_clock;

  /// At this time the call fails with DEADLINE_EXCEEDED.  Default: never.
  Clock::time_point deadline = Clock::time_point::max();
  /// A stop request from any thread ends the call with CANCELLED.
  std::stop_token stop = {};

  /// Options with a deadline after this time from now.
  static CallOptions within(std::chrono::duration<double> time);
  /// A copy whose deadline is at most this time from now.
  CallOptions at_most(std::chrono::duration<double> time) const;
};

/// A connection to a server.
///
/// Errors have gRPC's code, the server's message and the payload kStatusPayloadUrl.  The invalid
/// fields are added to the message ("...; receivers.offsets_m: must be three for each point").
/// After UNAVAILABLE a call is retried up to four times within half a second; after other errors it
/// is not.  Responses may have any size; the limit of the server (Limits.max_message_bytes)
/// applies.
class Client {
 public:
  /// Creates a client; nothing is sent yet.  If the server cannot be reached, the first call
  /// returns UNAVAILABLE; why_unreachable() has the reason.  INVALID_ARGUMENT for a target without
  /// a host or with a port outside of 1 to 65535, for files of TLS that cannot be read, and for a
  /// token that would leave this machine without TLS.
  static absl::StatusOr<Client> connect(const ConnectOptions& options);
  /// The target of ConnectOptions.
  const std::string& target() const;

  template <class Response>
  using Result = absl::StatusOr<Response>;
  /// The callback of a call that does not block.  It runs once, in a thread of gRPC, and must
  /// return soon.  It must not destroy a Client.
  template <class Response>
  using Done = std::function<void(Result<Response>)>;

  // SceneService
  Result<v1::FindMissingAssetsResponse> find_missing_assets(
      const v1::FindMissingAssetsRequest& request, const CallOptions& options = {}) const;
  /// Uploads a file in chunks.  `next_chunk` puts each chunk into its argument, and returns false
  /// after the last.  The server may answer before it has read everything.
  Result<v1::UploadAssetResponse> upload_asset(const v1::AssetHeader& header,
                                               const std::function<bool(std::string&)>& next_chunk,
                                               const CallOptions& options = {}) const;
  Result<v1::LoadSceneResponse> load_scene(const v1::LoadSceneRequest& request,
                                           const CallOptions& options = {}) const;
  Result<v1::EditLightsResponse> edit_lights(const v1::EditLightsRequest& request,
                                             const CallOptions& options = {}) const;
  Result<v1::GetSceneResponse> get_scene(const v1::GetSceneRequest& request,
                                         const CallOptions& options = {}) const;
  void get_scene(const v1::GetSceneRequest& request, const CallOptions& options,
                 Done<v1::GetSceneResponse> done) const;
  Result<v1::ListScenesResponse> list_scenes(const v1::ListScenesRequest& request,
                                             const CallOptions& options = {}) const;
  Result<v1::ListAvailableScenesResponse> list_available_scenes(
      const v1::ListAvailableScenesRequest& request, const CallOptions& options = {}) const;
  Result<v1::ListLightsResponse> list_lights(const v1::ListLightsRequest& request,
                                             const CallOptions& options = {}) const;
  Result<v1::RenewLeaseResponse> renew_lease(const v1::RenewLeaseRequest& request,
                                             const CallOptions& options = {}) const;
  void renew_lease(const v1::RenewLeaseRequest& request, const CallOptions& options,
                   Done<v1::RenewLeaseResponse> done) const;
  Result<v1::ReleaseSceneResponse> release_scene(const v1::ReleaseSceneRequest& request,
                                                 const CallOptions& options = {}) const;

  // LightingService
  Result<v1::SampleLiResponse> sample_li(const v1::SampleLiRequest& request,
                                         const CallOptions& options = {}) const;
  Result<v1::PdfLiResponse> pdf_li(const v1::PdfLiRequest& request,
                                   const CallOptions& options = {}) const;
  Result<v1::SampleLeResponse> sample_le(const v1::SampleLeRequest& request,
                                         const CallOptions& options = {}) const;
  Result<v1::PdfLeResponse> pdf_le(const v1::PdfLeRequest& request,
                                   const CallOptions& options = {}) const;
  Result<v1::LeResponse> le(const v1::LeRequest& request, const CallOptions& options = {}) const;
  Result<v1::EstimatePowerResponse> estimate_power(const v1::EstimatePowerRequest& request,
                                                   const CallOptions& options = {}) const;
  Result<v1::TestVisibilityResponse> test_visibility(const v1::TestVisibilityRequest& request,
                                                     const CallOptions& options = {}) const;
  Result<v1::EstimateIrradianceResponse> estimate_irradiance(
      const v1::EstimateIrradianceRequest& request, const CallOptions& options = {}) const;
  void estimate_irradiance(const v1::EstimateIrradianceRequest& request, const CallOptions& options,
                           Done<v1::EstimateIrradianceResponse> done) const;

  // RenderService
  Result<v1::RenderTileResponse> render_tile(const v1::RenderTileRequest& request,
                                             const CallOptions& options = {}) const;
  void render_tile(const v1::RenderTileRequest& request, const CallOptions& options,
                   Done<v1::RenderTileResponse> done) const;
  /// Calls `on_response` in the calling thread for each message as it arrives.  If it returns
  /// false, the call is cancelled and the result is CANCELLED.
  absl::Status render_image(const v1::RenderImageRequest& request,
                            const std::function<bool(const v1::RenderImageResponse&)>& on_response,
                            const CallOptions& options = {}) const;
  Result<v1::FindSurfacesResponse> find_surfaces(const v1::FindSurfacesRequest& request,
                                                 const CallOptions& options = {}) const;

  // AdminService
  Result<v1::ListLeasesResponse> list_leases(const v1::ListLeasesRequest& request,
                                             const CallOptions& options = {}) const;
  Result<v1::GetServerInfoResponse> get_server_info(const v1::GetServerInfoRequest& request = {},
                                                    const CallOptions& options = {}) const;
  Result<v1::GetStatsResponse> get_stats(const v1::GetStatsRequest& request = {},
                                         const CallOptions& options = {}) const;

  /// Calls grpc.health.v1.  OK if the server is serving, UNAVAILABLE if it is not.
  absl::Status check_health(const CallOptions& options = {}) const;

 private:
  class Connection;
  explicit Client(std::shared_ptr<const Connection> connection);

  std::shared_ptr<const Connection> connection_;
};

}  // namespace lucerna::client
