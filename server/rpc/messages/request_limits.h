// Limits of requests.
#pragma once

#include <cstdint>

namespace lucerna::rpc {

/// The server refuses requests above these; see Limits in lucerna/v1/admin.proto.
struct RequestLimits {
  std::uint32_t max_batch_items = 65536;
  std::uint32_t max_tile_pixels = 1 << 20;  // 60 bytes each, which fits the default message size
  std::uint32_t max_samples = 1 << 20;
  std::uint32_t max_page_size = 1000;
  std::uint32_t max_name_bytes = 4096;                        // of scenes and of files
  std::uint64_t max_message_bytes = std::uint64_t{64} << 20;  // below 2^31
};

}  // namespace lucerna::rpc
