// A stand-in for the viewer tev: reads its protocol from a loopback socket and checks every byte.
//
// The protocol is described in tev's README and src/Ipc.cpp: uint32 length of the whole packet,
// byte kind.  Kind 4 (CreateImage) continues with byte focus, name\0, int32 width, height, number
// of channels, their names\0.  Kind 6 (UpdateImage, third version) continues with byte focus,
// name\0, int32 number of channels, their names\0, int32 x, y, width, height, int64 offset of each
// channel, int64 stride of each, floats.  All numbers are little-endian.
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <functional>
#include <map>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace lucerna {

class TevReceiver {
 public:
  struct Image {
    std::int32_t width = 0, height = 0;
    std::vector<float> rgb;  ///< the layout of client::Picture
    std::size_t updates = 0;
  };
  struct Options {
    int port = 0;  ///< 0: any
    /// Closes its first connection after reading this many bytes; 0: never.
    std::size_t close_after = 0;
    /// Waits for read_on() before it reads.
    bool asleep = false;
  };

  TevReceiver() : TevReceiver(Options{}) {}
  explicit TevReceiver(const Options& options)
      : close_after_(options.close_after), asleep_(options.asleep) {
    listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const int on = 1, little = 4096;
    ::setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    if (asleep_) ::setsockopt(listener_, SOL_SOCKET, SO_RCVBUF, &little, sizeof little);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(options.port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    if (::bind(listener_, reinterpret_cast<sockaddr*>(&address), size) != 0 ||
        ::listen(listener_, 5) != 0 ||
        ::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size) != 0) {
      ::close(listener_);
      throw std::runtime_error("no port to listen on");
    }
    port_ = ntohs(address.sin_port);
    thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
  }
  ~TevReceiver() {
    thread_.request_stop();
    thread_.join();
    ::close(listener_);
  }
  TevReceiver(const TevReceiver&) = delete;
  TevReceiver& operator=(const TevReceiver&) = delete;

  int port() const { return port_; }
  std::string address() const { return "127.0.0.1:" + std::to_string(port_); }
  void read_on() { asleep_ = false; }

  std::size_t connections() const { return connections_; }
  /// All bytes from connections that this side did not close.
  std::string bytes() const {
    const std::lock_guard lock(mutex_);
    return bytes_;
  }
  std::map<std::string, Image> images() const {
    const std::lock_guard lock(mutex_);
    return images_;
  }
  /// Errors in packets.
  std::vector<std::string> faults() const {
    const std::lock_guard lock(mutex_);
    return faults_;
  }
  /// Returns false if the condition is still false after half a minute.
  static bool wait_for(const std::function<bool()>& condition) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(10);
    while (!condition()) {
      if (std::chrono::steady_clock::now() > end) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return true;
  }

 private:
  /// The unread rest of a packet.
  struct Reader {
    const std::string& bytes;
    std::size_t at = 0;

    template <class T>
    T number() {
      T value;
      if (bytes.size() - at < sizeof value) throw std::runtime_error("too short");
      std::memcpy(&value, bytes.data() + at, sizeof value);
      at += sizeof value;
      return value;
    }
    std::string text() {
      const std::size_t end = bytes.find('\0', at);
      if (end == std::string::npos) throw std::runtime_error("a name without end");
      const std::string result = bytes.substr(at, end - at);
      at = end + 1;
      return result;
    }
    void channels() {
      if (number<std::int32_t>() != 3 || text() != "R" || text() != "G" || text() != "B") {
        throw std::runtime_error("not three channels R, G, B");
      }
    }
    void end() const {
      if (at != bytes.size()) throw std::runtime_error("too long");
    }
  };

  void run(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      if (!readable(listener_)) continue;
      const int connection = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
      const std::size_t limit = connections_++ == 0 ? close_after_ : 0;
      read(connection, limit, stop);
      ::close(connection);
    }
  }

  static bool readable(int file) {
    pollfd poll{.fd = file, .events = POLLIN, .revents = 0};
    return ::poll(&poll, 1, 20) > 0;
  }

  void read(int connection, std::size_t limit, const std::stop_token& stop) {
    std::string pending;
    std::size_t total = 0;
    std::vector<char> buffer(1 << 16);
    while (!stop.stop_requested()) {
      if (asleep_) {
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
        continue;
      }
      if (!readable(connection)) continue;
      const std::size_t most = limit > 0 ? std::min(buffer.size(), limit - total) : buffer.size();
      const ssize_t got = ::recv(connection, buffer.data(), most, 0);
      if (got <= 0) {
        if (!pending.empty()) fault("the connection ended within a packet");
        return;
      }
      total += static_cast<std::size_t>(got);
      pending.append(buffer.data(), static_cast<std::size_t>(got));
      const std::lock_guard lock(mutex_);
      if (limit == 0) bytes_.append(buffer.data(), static_cast<std::size_t>(got));
      while (take_packet(pending)) {
      }
      if (limit > 0 && total == limit) return;
    }
  }

  void fault(const std::string& what) {
    const std::lock_guard lock(mutex_);
    faults_.push_back(what);
  }

  bool take_packet(std::string& pending) {
    std::uint32_t length = 0;
    if (pending.size() < sizeof length) return false;
    std::memcpy(&length, pending.data(), sizeof length);
    if (length < 5) {
      faults_.push_back("a packet of " + std::to_string(length) + " bytes");
      pending.clear();
    }
    if (pending.size() < length) return false;
    const std::string packet = pending.substr(0, length);
    pending.erase(0, length);
    try {
      Reader reader{packet, 4};
      switch (const int kind = reader.number<std::uint8_t>()) {
        case 4:
          create(reader);
          break;
        case 6:
          update(reader);
          break;
        default:
          throw std::runtime_error("kind " + std::to_string(kind));
      }
    } catch (const std::runtime_error& error) {
      faults_.emplace_back(error.what());
    }
    return true;
  }

  void create(Reader& reader) {
    if (reader.number<std::uint8_t>() != 1) throw std::runtime_error("created without focus");
    Image image;
    const std::string name = reader.text();
    image.width = reader.number<std::int32_t>();
    image.height = reader.number<std::int32_t>();
    reader.channels();
    reader.end();
    if (image.width < 1 || image.height < 1) throw std::runtime_error("an empty image");
    image.rgb.resize(std::size_t{3} * image.width * image.height);
    images_[name] = image;
  }

  void update(Reader& reader) {
    if (reader.number<std::uint8_t>() != 0) throw std::runtime_error("an update takes the focus");
    const auto found = images_.find(reader.text());
    if (found == images_.end())
      throw std::runtime_error("an update of an image that was not created");
    Image& image = found->second;
    reader.channels();
    std::int32_t rect[4];
    for (std::int32_t& value : rect) value = reader.number<std::int32_t>();
    const auto [x0, y0, width, height] = rect;
    if (x0 < 0 || y0 < 0 || width < 1 || height < 1 || x0 + width > image.width ||
        y0 + height > image.height) {
      throw std::runtime_error("an update beyond the image");
    }
    std::int64_t offsets[3], strides[3];
    for (std::int64_t& value : offsets) value = reader.number<std::int64_t>();
    for (std::int64_t& value : strides) value = reader.number<std::int64_t>();
    std::vector<float> data((reader.bytes.size() - reader.at) / sizeof(float));
    for (float& value : data) value = reader.number<float>();
    reader.end();
    // The number of floats that the last channel needs.
    const std::int64_t pixels = std::int64_t{width} * height;
    std::int64_t needed = 0;
    for (int c = 0; c < 3; ++c)
      needed = std::max(needed, offsets[c] + (pixels - 1) * strides[c] + 1);
    if (static_cast<std::int64_t>(data.size()) != needed) {
      throw std::runtime_error("floats: " + std::to_string(data.size()) + ", needed " +
                               std::to_string(needed));
    }
    for (std::int64_t p = 0; p < pixels; ++p) {
      const std::int64_t x = x0 + p % width, y = y0 + p / width;
      for (int c = 0; c < 3; ++c) {
        image.rgb[static_cast<std::size_t>(3 * (y * image.width + x) + c)] =
            data[static_cast<std::size_t>(offsets[c] + p * strides[c])];
      }
    }
    ++image.updates;
  }

  const std::size_t close_after_;
  std::atomic<bool> asleep_;
  int listener_ = -1;
  int port_ = 0;
  std::atomic<std::size_t> connections_ = 0;
  mutable std::mutex mutex_;
  std::string bytes_;
  std::map<std::string, Image> images_;
  std::vector<std::string> faults_;
  std::jthread thread_;
};

}  // namespace lucerna
