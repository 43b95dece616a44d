#include "server/rpc/connections.h"

#include <fmt/core.h>
#include <linux/tcp.h>
#include <netinet/in.h>
#include <spdlog/spdlog.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/stat.h>

#include <algorithm>

#include "server/runtime/memory.h"

namespace lucerna::rpc {
namespace {

// A connection may cancel this many calls at once, and then this many in a second.
constexpr double kCancels = 1000, kCancelsPerSecond = 200;
constexpr const char* kResets = "its client cancels too many calls";
// Bytes that need not belong to a call, such as those of calls that gRPC has not begun yet, and in
// each second those of pings and settings.
constexpr double kSpareBytes = 32 << 20, kSpareBytesPerSecond = 1 << 10;
// How long the rest of a stream may arrive after its call has ended.
constexpr auto kLateTime = std::chrono::seconds(10);
// Of requests that are left again and again.
constexpr double kLeftBytesPerSecond = 1 << 20;
// A client that takes answers opens windows for them, with a part of their bytes.
constexpr double kWindowShare = 1.0 / 16;
// How long a client may take nothing while others have no room for their answers.
constexpr std::uint32_t kCrowdedSeconds = 10;
// There is always room for smaller answers.
constexpr std::uint64_t kSmallAnswerBytes = 64 << 10;
// gRPC 1.51 reads a header of n bytes in a time of n^2.  If bytes wait to be read at so many looks
// in a row, for so long, it must read this much.
constexpr int kSlowLooks = 200;
constexpr auto kSlowTime = std::chrono::seconds(10);
constexpr std::uint64_t kSlowBytes = 10 << 20;
constexpr int kWaitingBytes = 64 << 10;
// When to look again: a client on this machine may send 50 MB in 50 ms.  Connections on which this
// much is on its way, and more arrives, are looked at sooner.
constexpr std::chrono::milliseconds kLater(50), kSoon(10);
constexpr double kSuspectBytes = 256 << 10;
// gRPC releases the memory of a closed connection later.  That of one is not blamed on others.
constexpr double kMostClosing = 200e6;
// Scenes, parsed messages and messages on their way may take more memory than is counted.
constexpr double kPerCounted = 1.5, kPerMessageByte = 16, kPerByteOnItsWay = 1.25;
// A byte of a header may take 160 bytes of gRPC's memory.  So if the process has much memory that
// nothing else explains, the client with the longest headers probably fills it.
constexpr double kPerHeaderByte = 160;
// What gRPC and we keep of calls and connections.
constexpr double kPerCall = 64 << 10, kPerConnection = 100 << 10;
// Answers to pings are less.
constexpr std::uint64_t kLeastReadBytes = 4 << 10;

/// The number of the socket behind a descriptor, which no other socket has; 0 if there is none.
std::uint64_t inode_of(int descriptor) {
  struct stat status {};
  return fstat(descriptor, &status) == 0 ? status.st_ino : 0;
}

double seconds(std::chrono::steady_clock::duration d) {
  return std::chrono::duration<double>(d).count();
}

}  // namespace

void Connections::set_limits(const ConnectionLimits& limits) {
  const std::lock_guard lock(mutex_);
  limits_ = limits;
}

void Connections::set_most(std::uint32_t connections) {
  const std::lock_guard lock(mutex_);
  most_ = connections;
}

void Connections::set_patience(const ConnectionPatience& patience) {
  const std::lock_guard lock(mutex_);
  patience_ = patience;
  most_unsent_ = patience.unsent_bytes;
  most_calls_ = patience.calls;
}

bool Connections::has_room(std::uint64_t bytes) const {
  return bytes <= kSmallAnswerBytes || unsent_ + bytes <= most_unsent_;
}

std::string Connections::add(int descriptor, const std::string& peer, const std::string& name) {
  const std::lock_guard lock(mutex_);
  if (std::string reason = refusal(peer); !reason.empty()) return reason;
  // Descriptors are used again.
  if (const auto before = open_.find(descriptor); before != open_.end()) {
    forget(*before->second);
    open_.erase(before);
  }
  auto c = std::make_shared<Connection>();
  c->descriptor_ = descriptor;
  c->inode_ = inode_of(descriptor);
  c->peer_ = peer;
  c->name_ = name;
  c->cancels_ = kCancels;
  c->counted_ = c->seen_ = c->read_ = Connection::Clock::now();
  c->may_leave_ = static_cast<double>(patience_.unfinished_bytes);
  names_.erase(name);
  names_[c->name_] = c;
  open_[descriptor] = std::move(c);
  return {};
}

std::shared_ptr<Connection> Connections::find(std::string_view name) const {
  const std::lock_guard lock(mutex_);
  const auto found = names_.find(name);
  return found == names_.end() ? nullptr : found->second;
}

std::size_t Connections::size() const {
  const std::lock_guard lock(mutex_);
  sweep();
  return open_.size();
}

void Connections::forget(const Connection& connection) const {
  const auto found = names_.find(connection.name_);
  if (found != names_.end() && found->second.get() == &connection) names_.erase(found);
}

void Connections::sweep() const {
  // gRPC does not report closed connections.  A descriptor that is closed, or used again, has
  // another inode.
  std::erase_if(open_, [&](const auto& c) {
    const bool closed = inode_of(c.first) != c.second->inode_;
    if (closed) forget(*c.second);
    return closed;
  });
}

std::string Connections::refusal(const std::string& peer) const {
  const std::uint32_t most = std::min(limits_.connections, most_);
  const auto of_peer = [&] {
    return std::count_if(open_.begin(), open_.end(),
                         [&](const auto& c) { return c.second->peer_ == peer; });
  };
  const auto full = [&] {
    return open_.size() >= most ||
           of_peer() >= static_cast<std::ptrdiff_t>(limits_.peer_connections);
  };
  if (!full()) return {};
  sweep();
  if (!full()) return {};
  if (open_.size() >= most)
    return fmt::format("{} connections are open, allowed: {}", open_.size(), most);
  return fmt::format("{} connections of this peer are open, allowed: {}", of_peer(),
                     limits_.peer_connections);
}

void Connections::close(Connection& connection, const std::string& why) const {
  if (connection.closed_ || inode_of(connection.descriptor_) != connection.inode_) return;
  connection.closed_ = true;
  shutdown(connection.descriptor_, SHUT_RDWR);  // gRPC closes it, when its calls have ended
  // gRPC would read what has arrived.  TCP drops it.  gRPC may close the descriptor meanwhile.
  constexpr std::size_t kAll = 1 << 30;
  constexpr int kMostPieces = 64;
  for (int i = 0; i < kMostPieces && inode_of(connection.descriptor_) == connection.inode_; ++i)
    if (recv(connection.descriptor_, nullptr, kAll, MSG_TRUNC | MSG_DONTWAIT) <= 0) break;
  spdlog::warn(fmt::format("closed a connection of {}: {}", connection.peer_, why));
}

void Connections::call_begun(Connection& c) {
  c.explained_ += Connection::kHeaderBytes;
  if (++c.calls_ != most_calls_) return;
  const std::lock_guard lock(mutex_);
  close(c, kResets);
}

void Connections::count_cancelled(Connection& c) {
  const std::lock_guard lock(mutex_);
  const auto now = Connection::Clock::now();
  c.cancels_ = std::min(kCancels, c.cancels_ + kCancelsPerSecond * seconds(now - c.counted_)) - 1;
  c.counted_ = now;
  if (c.cancels_ < 0) close(c, kResets);
}

void Connections::count_bytes(Connection& c, std::uint64_t received, std::uint64_t acknowledged,
                              Connection::Clock::time_point now) const {
  const std::uint64_t explained = c.explained_;
  const double time = seconds(now - c.seen_);
  const double more = static_cast<double>(received - c.received_) -
                      static_cast<double>(explained - c.explained_before_) -
                      kWindowShare * static_cast<double>(acknowledged - c.acknowledged_) -
                      kSpareBytesPerSecond * time;
  c.unexplained_ = std::max(0.0, c.unexplained_ + more);
  c.grows_ = more > 0;
  c.seen_ = now;
  c.received_ = received;
  c.acknowledged_ = acknowledged;
  c.explained_before_ = explained;
  // A request that was left explains what has arrived of it, and what arrives soon.
  c.may_leave_ = std::min(static_cast<double>(patience_.unfinished_bytes),
                          c.may_leave_ + kLeftBytesPerSecond * time);
  const double left = std::min(c.may_leave_, static_cast<double>(c.left_.exchange(0)));
  c.may_leave_ -= left;
  if (left > 0) c.left_at_ = now;
  const bool recent = now - c.left_at_ < kLateTime;
  c.late_ = recent ? c.late_ + left : 0;
  const double late = std::min(c.late_, c.unexplained_);
  c.late_ -= late;
  c.unexplained_ -= late;
  c.excused_ = recent ? c.excused_ + late : 0;
}

std::string Connections::complaint(Connection& c, Connection::Clock::time_point now) const {
  tcp_info info{};
  socklen_t size = sizeof info;
  if (getsockopt(c.descriptor_, IPPROTO_TCP, TCP_INFO, &info, &size) != 0) return {};
  const std::uint64_t acknowledged = info.tcpi_bytes_acked;
  int waiting = 0;
  ioctl(c.descriptor_, FIONREAD, &waiting);
  const std::uint64_t read = info.tcpi_bytes_received - c.received_;
  // Bytes arrive in bursts, so only many looks show the rate.
  if (waiting <= kWaitingBytes) c.looks_ = 0;
  if (c.looks_ == 0) c.looks_since_ = now, c.looks_bytes_ = 0;
  c.looks_bytes_ += read;
  // Looks count too, since the whole machine may have stood still.
  const bool looked = ++c.looks_ > kSlowLooks && now - c.looks_since_ > kSlowTime;
  if (looked) c.looks_ = 0;
  count_bytes(c, info.tcpi_bytes_received, acknowledged, now);
  const double unfinished = static_cast<double>(
      std::min(c.requests_ * patience_.message_bytes, patience_.unfinished_bytes));
  if (c.unexplained_ > kSpareBytes + unfinished)
    return fmt::format("{:.0f} MB of its messages and headers are not complete",
                       1e-6 * c.unexplained_);
  if (looked && c.looks_bytes_ < kSlowBytes) return "its headers take too much time to read";
  if (c.unsent_ == 0 || acknowledged >= c.read_bytes_ + kLeastReadBytes) {
    c.read_ = now;
    c.read_bytes_ = acknowledged;
  }
  const bool crowded = !has_room(patience_.message_bytes);
  const std::uint32_t idle_s = crowded ? kCrowdedSeconds : patience_.idle_s;
  if (idle_s > 0 && now - c.read_ > std::chrono::seconds(idle_s))
    return fmt::format("its client took no answer for {} s", idle_s);
  return {};
}

void Connections::close_all() const {
  const std::lock_guard lock(mutex_);
  sweep();
  for (const auto& [descriptor, connection] : open_) shutdown(descriptor, SHUT_RDWR);
}

std::shared_ptr<Connection> Connections::filler() const {
  std::shared_ptr<Connection> longest;
  double explained = 0, headers = 0, closing = 0;
  std::function<std::uint64_t()> counted_bytes;
  {
    const std::lock_guard lock(mutex_);
    counted_bytes = patience_.counted_bytes;
    explained = static_cast<double>(patience_.uncounted_bytes);
    for (const auto& [descriptor, c] : open_) {
      explained += kPerConnection + kPerCall * c->calls_;
      (c->closed_ ? closing : headers) += kPerHeaderByte * c->on_their_way();
      if (c->closed_) continue;
      explained += kPerByteOnItsWay * c->on_their_way();
      if (longest == nullptr || c->on_their_way() > longest->on_their_way()) longest = c;
    }
    if (longest == nullptr || longest->on_their_way() <= Connection::kHeaderBytes) return nullptr;
  }
  explained += std::min(closing, kMostClosing);
  explained += kPerCounted * static_cast<double>(counted_bytes()) +
               kPerMessageByte * static_cast<double>(held_) + static_cast<double>(unsent_);
  const auto unexplained = [&](std::uint64_t used) {
    const double more = static_cast<double>(used) - explained;
    return more > 0 && more < headers;
  };
  // The second takes longer.
  return unexplained(resident_bytes()) && unexplained(allocated_bytes()) ? longest : nullptr;
}

std::chrono::milliseconds Connections::watch() {
  bool suspect = false;
  {
    const std::lock_guard lock(mutex_);
    const auto now = Connection::Clock::now();
    const bool all = now >= next_look_;
    if (all) {
      sweep();
      next_look_ = now + kLater;
    }
    for (auto& [descriptor, c] : open_) {
      if (c->closed_ || (!all && c->on_their_way() <= kSuspectBytes)) continue;
      if (!all && inode_of(descriptor) != c->inode_) continue;
      const std::string why = complaint(*c, now);
      if (!why.empty()) close(*c, why);
      suspect |= c->grows_ && c->on_their_way() > kSuspectBytes;
    }
  }
  // Not under the lock, which every call takes.
  if (const std::shared_ptr<Connection> c = filler()) {
    const std::lock_guard lock(mutex_);
    close(*c, "its headers probably fill the memory");
  }
  return suspect ? kSoon : kLater;
}

}  // namespace lucerna::rpc
