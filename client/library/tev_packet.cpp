#include "client/library/tev_packet.h"

#include <bit>
#include <cstring>
#include <utility>

namespace lucerna::client {
namespace {

// The protocol is little-endian, like the memory of this machine.
static_assert(std::endian::native == std::endian::little);

/// One message of the protocol.
class Packet {
 public:
  enum Type : char { kCreateImage = 4, kUpdateImageV3 = 6 };

  explicit Packet(Type type) {
    put(std::uint32_t{0});
    put(type);
  }
  template <class T>
  void put(T value) {
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  void put(const std::string& text) { bytes_.append(text.c_str(), text.size() + 1); }
  void put(std::span<const float> values) {
    bytes_.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
  }
  void put_channels() {
    for (const char* name : {"R", "G", "B"}) put(std::string(name));
  }
  /// The packet with its length in front, which counts its own bytes.
  std::string finish() && {
    const auto length = static_cast<std::uint32_t>(bytes_.size());
    std::memcpy(bytes_.data(), &length, sizeof length);
    return std::move(bytes_);
  }

 private:
  std::string bytes_;
};

}  // namespace

std::string create_image(const std::string& name, const Canvas& picture) {
  Packet packet(Packet::kCreateImage);
  packet.put(char{1});  // select this picture
  packet.put(name);
  packet.put(static_cast<std::int32_t>(picture.width));
  packet.put(static_cast<std::int32_t>(picture.height));
  packet.put(std::int32_t{3});
  packet.put_channels();
  return std::move(packet).finish();
}

std::string update_image(const std::string& name, const Canvas& picture,
                         const v1::PixelRect& rect) {
  Packet packet(Packet::kUpdateImageV3);
  packet.put(char{0});
  packet.put(name);
  packet.put(std::int32_t{3});
  packet.put_channels();
  const std::uint32_t width = rect.x1() - rect.x0();
  for (const std::uint32_t value : {rect.x0(), rect.y0(), width, rect.y1() - rect.y0()}) {
    packet.put(static_cast<std::int32_t>(value));
  }
  for (const std::int64_t offset : {0, 1, 2}) packet.put(offset);
  for (const std::int64_t stride : {3, 3, 3}) packet.put(stride);
  for (std::size_t y = rect.y0(); y < rect.y1(); ++y) {
    packet.put(std::span<const float>(picture.row(rect, y)));
  }
  return std::move(packet).finish();
}

}  // namespace lucerna::client
