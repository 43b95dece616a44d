// Asks a lucernad: every call of lucerna.v1 that is answered today, one method a call.  All block,
// and some have a second form that does not.
//
// Requests and responses are the messages of the contract (lucerna/v1/*.proto), where every field
// is described; nothing is computed here.  batches.h asks in batches that the server accepts,
// points.h fills in points, picture.h puts tiles together, upload.h sends scenes.
//
// Thread safety: all methods of one Client may be called from any number of threads at once, and
// copies share one connection.  Not safe in a child after fork() where the parent has used a
// Client.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "lucerna/v1/admin.pb.h"
#include "lucerna/v1/lighting.pb.h"
#include "lucerna/v1/render.pb.h"
#include "lucerna/v1/scene.pb.h"

namespace lucerna::client {

/// Where absl::Status::GetPayload() has the server's google.rpc.Status, serialised, with all
/// details.
inline constexpr char kStatusPayloadUrl[] = "type.googleapis.com/google.rpc.Status";

struct ConnectOptions {
  /// "HOST:PORT", "[IPV6]:PORT", or any other name that gRPC resolves ("unix:/run/lucernad").
  ///
  /// "dns:///NAME:PORT", "ipv4:A:PORT,B:PORT" and "ipv6:[A]:PORT,..." stand for all servers that
  /// they name: calls go to them in turn, to those that can be reached (gRPC's round_robin), and
  /// what is tried again goes to the next.  Scenes are each server's own: query_servers.h brings
  /// one to all of them.
  std::string target = "127.0.0.1:50051";
  /// Whether UNAVAILABLE is tried again before it is told.
  bool retry = true;
};

/// How long a call may take, and how to end it sooner.
struct CallOptions {
  using Clock = std::chrono::system_clock;

  /// When the call fails with DEADLINE_EXCEEDED, however far it is.  Default: never.
  Clock::time_point deadline = Clock::time_point::max();
  /// A request to stop ends the call with CANCELLED, from any thread.
  std::stop_token stop = {};

  /// A deadline this long from now.
  static CallOptions within(std::chrono::duration<double> time);
  /// These, with a deadline no later than this long from now.
  CallOptions at_most(std::chrono::duration<double> time) const;
};

/// One connection to one server.
///
/// Errors have gRPC's code and the server's message, to which the fields that it found fault with
/// are added ("...; receivers.offsets_m: must be three a point"), and kStatusPayloadUrl.
/// UNAVAILABLE is tried up to four times within half a second before it is told; no other error is
/// tried again. Messages of any size are taken from the server, whose own limit
/// (Limits.max_message_bytes) binds.
class Client {
 public:
  /// Nothing is sent yet: a server that cannot be reached is told by the first call, as
  /// UNAVAILABLE. INVALID_ARGUMENT for an empty target.
  static absl::StatusOr<Client> connect(const ConnectOptions& options);
  /// As ConnectOptions named it.
  const std::string& target() const;

  template <class Response>
  using Result = absl::StatusOr<Response>;
  /// How a call that does not block is answered: once, in a thread of gRPC's, which must not be
  /// kept for long, and in which no client may end.
  template <class Response>
  using Done = std::function<void(Result<Response>)>;

  // SceneService
  Result<v1::FindMissingAssetsResponse> find_missing_assets(
      const v1::FindMissingAssetsRequest& request, const CallOptions& options = {}) const;
  /// Sends the header, then all that `next_chunk` puts into its argument, until it returns false.
  /// The server may answer before it has read all.
  Result<v1::UploadAssetResponse> upload_asset(const v1::AssetHeader& header,
                                               const std::function<bool(std::string&)>& next_chunk,
                                               const CallOptions& options = {}) const;
  Result<v1::LoadSceneResponse> load_scene(const v1::LoadSceneRequest& request,
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
  /// Calls `on_response` in the calling thread for each message as it arrives.  Where it returns
  /// false, the server is told to stop, and the answer is CANCELLED.
  absl::Status render_image(const v1::RenderImageRequest& request,
                            const std::function<bool(const v1::RenderImageResponse&)>& on_response,
                            const CallOptions& options = {}) const;

  // AdminService
  Result<v1::GetServerInfoResponse> get_server_info(const v1::GetServerInfoRequest& request = {},
                                                    const CallOptions& options = {}) const;

  /// OK where the server says that it serves (grpc.health.v1), UNAVAILABLE where it does not now.
  absl::Status check_health(const CallOptions& options = {}) const;

 private:
  class Connection;
  explicit Client(std::shared_ptr<const Connection> connection);

  std::shared_ptr<const Connection> connection_;
};

}  // namespace lucerna::client
