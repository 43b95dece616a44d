// Checks that an answer fits its request.  A server may be broken or hostile; nothing else in the
// client looks at what it sent before it is used.  This header is not installed.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "lucerna/v1/lighting.pb.h"
#include "lucerna/v1/render.pb.h"
#include "lucerna/v1/scene.pb.h"

namespace lucerna::client {

/// INTERNAL, "the server broke the protocol: FIELD: WHAT".
absl::Status broken_protocol(const std::string& what);

/// These return broken_protocol() unless arrays have the lengths that follow from the request, and
/// numbers are finite.  A request whose own arrays do not match is not checked.
absl::Status check_answer(const v1::SampleLiRequest& request, const v1::SampleLiResponse& answer);
absl::Status check_answer(const v1::PdfLiRequest& request, const v1::PdfLiResponse& answer);
absl::Status check_answer(const v1::SampleLeRequest& request, const v1::SampleLeResponse& answer);
absl::Status check_answer(const v1::PdfLeRequest& request, const v1::PdfLeResponse& answer);
absl::Status check_answer(const v1::LeRequest& request, const v1::LeResponse& answer);
absl::Status check_answer(const v1::TestVisibilityRequest& request,
                          const v1::TestVisibilityResponse& answer);
absl::Status check_answer(const v1::EstimateIrradianceRequest& request,
                          const v1::EstimateIrradianceResponse& answer);
absl::Status check_answer(const v1::FindSurfacesRequest& request,
                          const v1::FindSurfacesResponse& answer);
absl::Status check_answer(const v1::RenderTileRequest& request,
                          const v1::RenderTileResponse& answer);
absl::Status check_answer(const v1::FindMissingAssetsRequest& request,
                          const v1::FindMissingAssetsResponse& answer);
/// All other calls: numbers are finite, and a list has an end.
absl::Status check_answer(const google::protobuf::Message& request,
                          const google::protobuf::Message& answer);

/// INVALID_ARGUMENT unless the fields of a tile are consistent with each other and its numbers are
/// finite.
absl::Status check_tile(const v1::Tile& tile);

/// Checks the tiles of one picture as they arrive.
class ImageCheck {
 public:
  /// Tiles lie beside each other; a tile comes again only with more blocks.
  absl::Status add(const v1::RenderImageResponse& response);
  /// At the end, tiles cover the picture.
  absl::Status end() const;

 private:
  struct Seen {
    v1::PixelRect rect;
    std::uint64_t blocks;
  };
  std::uint32_t width_ = 0, height_ = 0;
  std::uint64_t pixels_ = 0;
  std::map<std::pair<std::uint32_t, std::uint32_t>, Seen> tiles_;  // by their corner
};

bool same_rect(const v1::PixelRect& a, const v1::PixelRect& b);
/// "tile [0, 64) x [64, 128)".
std::string describe(const v1::PixelRect& rect);
std::size_t pixel_count(const v1::PixelRect& rect);

}  // namespace lucerna::client
