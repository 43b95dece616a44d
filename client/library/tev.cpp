#include "lucerna/client/tev.h"

#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <condition_variable>
#include <cstring>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "client/library/tev_packet.h"
#include "proto/common/host_port.h"
#include "proto/common/status_macros.h"

// One connected socket that is only written to.  A networking library would need more code than
// these calls, and would need its own event loop.

namespace lucerna::client {
namespace {

using std::chrono::milliseconds;

constexpr std::uint64_t kMaxShownPixels = std::uint64_t{1} << 30;
// A packet of kMostEdge squared pixels fits into the first receive buffer of tev, one mebibyte.
constexpr std::uint32_t kMostEdge = 256;
constexpr milliseconds kTryAgain(2000);
constexpr milliseconds kConnectPatience(2000);
// The longest delay before a stop takes effect.
constexpr int kPollMs = 100;

class Socket {
 public:
  Socket() = default;
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  ~Socket() { close(); }

  explicit operator bool() const { return file_ >= 0; }
  void close() {
    if (file_ >= 0) ::close(file_);
    file_ = -1;
  }

  /// Returns the reason of a failure; empty on success.
  std::string connect(const addrinfo& address, const std::stop_token& stop) {
    file_ = ::socket(address.ai_family, address.ai_socktype | SOCK_NONBLOCK | SOCK_CLOEXEC,
                     address.ai_protocol);
    int error = file_ < 0 ? errno : 0;
    if (error == 0 && ::connect(file_, address.ai_addr, address.ai_addrlen) != 0) error = errno;
    if (error == EINPROGRESS) {
      error = ETIMEDOUT;
      for (milliseconds waited(0); waited < kConnectPatience && !stop.stop_requested();
           waited += milliseconds(kPollMs)) {
        if (!wait(POLLOUT)) continue;
        socklen_t size = sizeof error;
        if (::getsockopt(file_, SOL_SOCKET, SO_ERROR, &error, &size) != 0) error = errno;
        break;
      }
    }
    if (error == 0) return {};
    close();
    return std::strerror(error);
  }

  /// The number of bytes sent, which may be 0; nothing if the connection ended.
  std::optional<std::size_t> send(std::string_view bytes) {
    const short happened = wait(POLLOUT | POLLRDHUP);
    if ((happened & (POLLERR | POLLHUP | POLLRDHUP | POLLNVAL)) != 0) return std::nullopt;
    if (happened == 0) return 0;
    const ssize_t sent = ::send(file_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent >= 0) return static_cast<std::size_t>(sent);
    if (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR) return 0;
    return std::nullopt;
  }

 private:
  short wait(short events) const {
    pollfd poll{.fd = file_, .events = events, .revents = 0};
    return ::poll(&poll, 1, kPollMs) > 0 ? poll.revents : short{0};
  }

  int file_ = -1;
};

using Addresses = std::unique_ptr<addrinfo, decltype(&freeaddrinfo)>;

/// Names are resolved once, because a hanging resolver cannot be stopped.
absl::StatusOr<Addresses> resolve(const std::string& address) {
  LUCERNA_ASSIGN_OR_RETURN(const HostPort at,
                           split_host_port(with_default_port(address, kTevPort)));
  const std::string port = std::to_string(at.port);
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_NUMERICSERV;
  addrinfo* found = nullptr;
  if (const int error = getaddrinfo(at.host.c_str(), port.c_str(), &hints, &found); error != 0) {
    return absl::InvalidArgumentError(at.host + ": " + gai_strerror(error));
  }
  return Addresses(found, &freeaddrinfo);
}

}  // namespace

class TevSender::Impl {
 public:
  Impl(std::string address, Addresses resolved, std::function<void(const std::string&)> on_event)
      : address_(std::move(address)),
        resolved_(std::move(resolved)),
        on_event_(std::move(on_event)),
        thread_([this](const std::stop_token& stop) { run(stop); }) {}

  void begin(const std::string& name, std::uint32_t width, std::uint32_t height) {
    Canvas black(width, height);  // receives the previous picture, which is freed without the lock
    const std::lock_guard lock(mutex_);
    name_ = name;
    std::swap(picture_, black);
    created_ = false;
    cells_.clear();
    by_place_.clear();
    waiting_.clear();
    changed_.notify_all();
  }

  absl::Status update(const v1::PixelRect& rect, std::span<const float> rgb) {
    const std::lock_guard lock(mutex_);
    if (rect.x0() >= rect.x1() || rect.y0() >= rect.y1() || rect.x1() > picture_.width ||
        rect.y1() > picture_.height) {
      return absl::InvalidArgumentError("the rectangle is empty or not within the picture");
    }
    if (rgb.size() != std::size_t{3} * (rect.x1() - rect.x0()) * (rect.y1() - rect.y0())) {
      return absl::InvalidArgumentError("rgb has " + std::to_string(rgb.size()) +
                                        " numbers, must be three for each pixel");
    }
    for (std::size_t y = rect.y0(); y < rect.y1(); ++y) {
      const std::span<float> row = picture_.row(rect, y);
      std::copy_n(rgb.begin(), row.size(), row.begin());
      rgb = rgb.subspan(row.size());
    }
    for (std::uint32_t y = rect.y0(); y < rect.y1(); y += std::min(kMostEdge, rect.y1() - y)) {
      for (std::uint32_t x = rect.x0(); x < rect.x1(); x += std::min(kMostEdge, rect.x1() - x)) {
        v1::PixelRect part;
        part.set_x0(x);
        part.set_y0(y);
        part.set_x1(x + std::min(kMostEdge, rect.x1() - x));
        part.set_y1(y + std::min(kMostEdge, rect.y1() - y));
        queue(part);
      }
    }
    changed_.notify_all();
    return absl::OkStatus();
  }

  bool flush(milliseconds patience) {
    using Clock = std::chrono::steady_clock;
    const Clock::time_point most = Clock::now() + 10 * patience;
    std::unique_lock lock(mutex_);
    std::uint64_t sent = sent_bytes_;
    // Do not wait again for a viewer that accepted nothing since the last failure.
    if ((sending_ || has_work()) && stuck_at_ == sent) return false;
    while (sending_ || has_work()) {
      const Clock::time_point until = std::min(most, Clock::now() + patience);
      const bool more = changed_.wait_until(lock, until, [&] {
        return (reported_ && !connected_) || sent_bytes_ > sent || !(sending_ || has_work());
      });
      if (reported_ && !connected_) return false;
      if (!more || Clock::now() >= most) {
        report("did not accept the whole picture");
        stuck_at_ = sent_bytes_;
        return false;
      }
      sent = sent_bytes_;
    }
    return true;
  }

 private:
  struct Cell {
    v1::PixelRect rect;
    bool waiting = false;
  };
  using Corners = std::array<std::uint32_t, 4>;

  void queue(const v1::PixelRect& rect) {
    const auto [at, is_new] =
        by_place_.try_emplace({rect.x0(), rect.y0(), rect.x1(), rect.y1()}, cells_.size());
    if (is_new) cells_.push_back({rect});
    Cell& cell = cells_[at->second];
    if (!cell.waiting) waiting_.push_back(at->second);
    cell.waiting = true;
  }

  bool has_work() const { return picture_.width > 0 && (!created_ || !waiting_.empty()); }

  void report(const std::string& what) {
    if (!std::exchange(reported_, true) && on_event_) on_event_("tev at " + address_ + ": " + what);
  }

  std::string next_packet() {
    if (!std::exchange(created_, true)) return create_image(name_, picture_);
    Cell& cell = cells_[waiting_.front()];
    waiting_.pop_front();
    cell.waiting = false;
    return update_image(name_, picture_, cell.rect);
  }

  /// Marks the whole picture as unsent, since the next connection begins without a picture.
  /// Reports the reason once.
  void lose(const std::string& why) {
    created_ = connected_ = false;
    waiting_.clear();
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      cells_[i].waiting = true;
      waiting_.push_back(i);
    }
    report(why + "; continuing without it");
  }

  void run(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    while (changed_.wait(lock, stop, [this] { return has_work(); }) && !stop.stop_requested()) {
      if (!socket_) {
        lock.unlock();
        std::string why;
        for (const addrinfo* a = resolved_.get(); a != nullptr && !socket_; a = a->ai_next) {
          why = socket_.connect(*a, stop);
        }
        lock.lock();
        connected_ = static_cast<bool>(socket_);
        if (!connected_) {
          if (stop.stop_requested()) return;
          lose(why);
          changed_.notify_all();
          changed_.wait_for(lock, stop, kTryAgain, [] { return false; });
        }
        continue;  // begin() may have replaced the picture meanwhile
      }
      const std::string packet = next_packet();
      sending_ = true;
      std::string_view left = packet;
      while (!left.empty() && socket_) {
        lock.unlock();
        const std::optional<std::size_t> sent = socket_.send(left);
        lock.lock();
        if (stop.stop_requested()) return;
        if (sent) {
          left.remove_prefix(*sent);
          sent_bytes_ += *sent;
        } else {
          socket_.close();
        }
        if (sent != std::size_t{0}) changed_.notify_all();
      }
      sending_ = false;
      if (!socket_) {
        lose("the connection ended");
        changed_.notify_all();
        changed_.wait_for(lock, stop, kTryAgain, [] { return false; });
      }
    }
  }

  const std::string address_;
  const Addresses resolved_;
  const std::function<void(const std::string&)> on_event_;
  Socket socket_;  // only the thread uses it

  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::string name_;
  Canvas picture_;
  std::vector<Cell> cells_;                  // all rectangles of the picture
  std::map<Corners, std::size_t> by_place_;  // index into cells_
  std::deque<std::size_t> waiting_;          // indices into cells_ of unsent rectangles
  bool created_ = false;                     // the viewer has created the picture
  bool sending_ = false;
  bool connected_ = false;
  bool reported_ = false;
  std::uint64_t sent_bytes_ = 0;
  std::optional<std::uint64_t> stuck_at_;  // sent_bytes_ when a flush failed

  std::jthread thread_;  // the last member: it uses all others
};

TevSender::TevSender(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
TevSender::~TevSender() = default;

absl::StatusOr<std::unique_ptr<TevSender>> TevSender::create(
    const std::string& address, std::function<void(const std::string&)> on_event) {
  LUCERNA_ASSIGN_OR_RETURN(auto resolved, resolve(address));
  return std::unique_ptr<TevSender>(
      new TevSender(std::make_unique<Impl>(address, std::move(resolved), std::move(on_event))));
}

absl::Status TevSender::begin(const std::string& name, std::uint32_t width, std::uint32_t height) {
  if (width == 0 || height == 0 || std::uint64_t{width} * height > kMaxShownPixels) {
    return absl::InvalidArgumentError("a picture of " + std::to_string(width) + " x " +
                                      std::to_string(height) + " pixels, allowed: 1 to 2^30");
  }
  impl_->begin(name, width, height);
  return absl::OkStatus();
}

absl::Status TevSender::update(const v1::PixelRect& rect, std::span<const float> rgb) {
  return impl_->update(rect, rgb);
}

bool TevSender::flush(milliseconds patience) { return impl_->flush(patience); }

}  // namespace lucerna::client
