#include "server/rpc/listener.h"

#include <arpa/inet.h>
#include <fmt/core.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/eventfd.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <filesystem>
#include <system_error>
#include <utility>

#include "proto/common/status_macros.h"
#include "server/rpc/address.h"

namespace lucerna::rpc {
namespace {

// Descriptors that connections leave free: files of scenes and uploads, and gRPC's own.
constexpr std::uint64_t kReserved = 24;
constexpr int kBacklog = 1024;
// Pause after an error of accept, such as no memory.
constexpr int kPauseMs = 50;
// How long a connection to the own port may wait until it is accepted.
constexpr auto kOwnPatience = std::chrono::seconds(5);
constexpr auto kLogInterval = std::chrono::seconds(10);
// A connection may cancel this many calls at once, and then this many in a second.
constexpr double kCancels = 1000, kCancelsPerSecond = 200;

/// Raises the limit of open files as far as it goes.  Returns the limit.
std::uint64_t raise_file_limit() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return 1024;
  if (limit.rlim_cur < limit.rlim_max) {
    const rlimit wanted{limit.rlim_max, limit.rlim_max};
    if (setrlimit(RLIMIT_NOFILE, &wanted) == 0) limit = wanted;
  }
  return limit.rlim_cur;
}

std::uint64_t open_files() {
  std::error_code error;
  std::filesystem::directory_iterator files("/proc/self/fd", error);
  if (error) return 64;
  return static_cast<std::uint64_t>(std::distance(files, std::filesystem::directory_iterator()));
}

/// The number of the socket behind a descriptor, which no other socket has; 0 if there is none.
std::uint64_t inode_of(int descriptor) {
  struct stat status {};
  return fstat(descriptor, &status) == 0 ? status.st_ino : 0;
}

/// The address without the port.
std::string text_of(const sockaddr_storage& address) {
  char text[INET6_ADDRSTRLEN] = "";
  if (address.ss_family == AF_INET) {
    inet_ntop(AF_INET, &reinterpret_cast<const sockaddr_in&>(address).sin_addr, text, sizeof text);
  } else if (address.ss_family == AF_INET6) {
    inet_ntop(AF_INET6, &reinterpret_cast<const sockaddr_in6&>(address).sin6_addr, text,
              sizeof text);
  }
  return text;
}

/// The address of a client as ServerContext::peer() names it.
std::string name_of(const sockaddr_storage& address, int port) {
  const std::string text = text_of(address);
  constexpr std::string_view kMapped = "::ffff:";  // an IPv4 client of an IPv6 socket
  if (text.starts_with(kMapped))
    return fmt::format("ipv4:{}:{}", text.substr(kMapped.size()), port);
  return address.ss_family == AF_INET6 ? fmt::format("ipv6:%5B{}%5D:{}", text, port)
                                       : fmt::format("ipv4:{}:{}", text, port);
}

int port_of(const sockaddr_storage& address) {
  return ntohs(address.ss_family == AF_INET6
                   ? reinterpret_cast<const sockaddr_in6&>(address).sin6_port
                   : reinterpret_cast<const sockaddr_in&>(address).sin_port);
}

/// A socket that listens; -1 with errno.
int listen_on(const addrinfo& address, int port) {
  sockaddr_storage to{};
  std::copy_n(reinterpret_cast<const char*>(address.ai_addr), address.ai_addrlen,
              reinterpret_cast<char*>(&to));
  // For a free port, all addresses of a name get the same one.
  if (port != 0 && to.ss_family == AF_INET6) {
    reinterpret_cast<sockaddr_in6&>(to).sin6_port = htons(static_cast<std::uint16_t>(port));
  } else if (port != 0) {
    reinterpret_cast<sockaddr_in&>(to).sin_port = htons(static_cast<std::uint16_t>(port));
  }
  const int fd = socket(address.ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0) return -1;
  const int yes = 1, no = 0;
  setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  // Connections inherit this.
  setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
  if (address.ai_family == AF_INET6) setsockopt(fd, IPPROTO_IPV6, IPV6_V6ONLY, &no, sizeof no);
  if (bind(fd, reinterpret_cast<const sockaddr*>(&to), address.ai_addrlen) == 0 &&
      listen(fd, kBacklog) == 0) {
    return fd;
  }
  const int error = errno;
  close(fd);
  errno = error;
  return -1;
}

}  // namespace

absl::StatusOr<std::unique_ptr<Listener>> Listener::open(const std::string& address,
                                                         const ConnectionLimits& limits) {
  std::unique_ptr<Listener> listener(new Listener);
  listener->limits_ = limits;
  LUCERNA_ASSIGN_OR_RETURN(const AddressList found, resolve(address));
  for (const addrinfo* a = found.get(); a != nullptr; a = a->ai_next) {
    const int fd = listen_on(*a, listener->port_);
    if (fd < 0) {
      // A name such as localhost may have an address of a family that this machine does not use.
      const bool other_family = errno == EAFNOSUPPORT || errno == EADDRNOTAVAIL;
      if (other_family && (a->ai_next != nullptr || !listener->listeners_.empty())) continue;
      return absl::UnavailableError(
          fmt::format("cannot listen on {}: {}", address, why_not(errno)));
    }
    listener->listeners_.push_back(fd);
    sockaddr_storage own{};
    socklen_t size = sizeof own;
    getsockname(fd, reinterpret_cast<sockaddr*>(&own), &size);
    listener->port_ = port_of(own);
  }
  listener->wake_ = eventfd(0, EFD_CLOEXEC);
  listener->spare_ = eventfd(0, EFD_CLOEXEC);
  return listener;
}

void Listener::stop() {
  if (thread_.joinable()) {
    const std::uint64_t one = 1;
    (void)!write(wake_, &one, sizeof one);
    thread_.join();
  }
  for (const int fd : listeners_) close(fd);
  listeners_.clear();
}

Listener::~Listener() {
  stop();
  if (wake_ >= 0) close(wake_);
  if (spare_ >= 0) close(spare_);
}

absl::Status Listener::start(std::function<void(int, int)> take) {
  const std::uint64_t files = raise_file_limit(), used = open_files() + kReserved;
  if (used >= files) {
    return absl::ResourceExhaustedError(fmt::format(
        "the limit of open files is {} (ulimit -n), allowed: at least {}", files, used + 1));
  }
  most_ = static_cast<std::uint32_t>(std::min<std::uint64_t>(files - used, UINT32_MAX));
  if (most_ < limits_.connections) {
    spdlog::warn(
        fmt::format("max-connections = {}, but the limit of open files, {}, leaves room "
                    "for {} (ulimit -n)",
                    limits_.connections, files, most_));
  }
  take_ = std::move(take);
  thread_ = std::thread([this] { run(); });
  return absl::OkStatus();
}

void Listener::set_limits(const ConnectionLimits& limits) {
  const std::lock_guard lock(mutex_);
  limits_ = limits;
}

ConnectionLimits Listener::limits() const {
  const std::lock_guard lock(mutex_);
  ConnectionLimits now = limits_;
  now.connections = std::min(now.connections, most_);
  return now;
}

std::size_t Listener::connections() const {
  const std::lock_guard lock(mutex_);
  sweep();
  return open_.size();
}

bool Listener::accepts() const {
  sockaddr_storage own{};
  socklen_t size = sizeof own;
  if (getsockname(listeners_.front(), reinterpret_cast<sockaddr*>(&own), &size) != 0) return false;
  const int fd = socket(own.ss_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0) return true;  // no descriptor is left, which ends by itself
  const std::uint64_t before = accepted_;
  // A wildcard address connects to this machine.
  (void)connect(fd, reinterpret_cast<const sockaddr*>(&own), size);
  const auto end = std::chrono::steady_clock::now() + kOwnPatience;
  bool accepted = false;
  while (!accepted && std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    accepted = accepted_ != before;
  }
  close(fd);
  return accepted;
}

void Listener::count_cancelled(const std::string& peer) {
  const std::lock_guard lock(mutex_);
  const auto found = descriptors_.find(peer);
  if (found == descriptors_.end()) return;
  const auto open = open_.find(found->second);
  if (open == open_.end() || open->second.name != peer) {
    descriptors_.erase(found);
    return;
  }
  Connection& c = open->second;
  const auto now = std::chrono::steady_clock::now();
  const double gained = kCancelsPerSecond * std::chrono::duration<double>(now - c.counted).count();
  c.cancels = std::min(kCancels, c.cancels + gained) - 1;
  c.counted = now;
  if (c.cancels >= 0 || inode_of(open->first) != c.inode) return;
  shutdown(open->first, SHUT_RDWR);
  descriptors_.erase(found);
  spdlog::warn(
      fmt::format("closed a connection of {}: more than {:g} calls were cancelled, and "
                  "then more than {:g} in a second",
                  c.peer, kCancels, kCancelsPerSecond));
}

void Listener::sweep() const {
  // gRPC does not report closed connections.  A descriptor that is closed, or used again, has
  // another inode.
  std::erase_if(open_, [](const auto& c) { return inode_of(c.first) != c.second.inode; });
}

std::string Listener::refusal(const std::string& peer) const {
  const std::uint32_t most = std::min(limits_.connections, most_);
  const auto of_peer = [&] {
    return std::count_if(open_.begin(), open_.end(),
                         [&](const auto& c) { return c.second.peer == peer; });
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

void Listener::run() {
  std::vector<pollfd> ready;
  for (const int fd : listeners_) ready.push_back({fd, POLLIN, 0});
  ready.push_back({wake_, POLLIN, 0});
  for (;;) {
    if (poll(ready.data(), ready.size(), -1) < 0) continue;
    if (ready.back().revents != 0) return;
    for (const pollfd& r : ready) {
      if (r.revents != 0) accept_one(r.fd);
    }
  }
}

void Listener::accept_one(int listener) {
  sockaddr_storage peer{};
  socklen_t size = sizeof peer;
  const int fd =
      accept4(listener, reinterpret_cast<sockaddr*>(&peer), &size, SOCK_NONBLOCK | SOCK_CLOEXEC);
  ++accepted_;
  if (fd < 0) {
    const int error = errno;
    if ((error == EMFILE || error == ENFILE) && spare_ >= 0) {
      // The client learns at once that the server is full.  Otherwise it would wait.
      close(spare_);
      const int refused = accept4(listener, nullptr, nullptr, SOCK_CLOEXEC);
      if (refused >= 0) close(refused);
      spare_ = eventfd(0, EFD_CLOEXEC);
      spdlog::warn("refused a connection: no file descriptor is left");
    } else if (error != EAGAIN && error != EINTR && error != ECONNABORTED) {
      spdlog::warn(fmt::format("cannot accept a connection: {}", why_not(error)));
    }
    if (error != EINTR && error != ECONNABORTED && error != EAGAIN) {
      pollfd wait{wake_, POLLIN, 0};
      poll(&wait, 1, kPauseMs);  // does not read it, so run() ends too
    }
    return;
  }
  const std::string address = text_of(peer);
  std::string reason;
  {
    const std::lock_guard lock(mutex_);
    reason = refusal(address);
    if (reason.empty()) {
      // Descriptors are used again, so this forgets closed connections.
      if (const auto before = open_.find(fd); before != open_.end())
        descriptors_.erase(before->second.name);
      const std::string name = name_of(peer, port_of(peer));
      open_[fd] = {inode_of(fd), address, name, kCancels, std::chrono::steady_clock::now()};
      descriptors_[name] = fd;
    }
  }
  if (reason.empty()) return take_(listener, fd);
  close(fd);
  ++refused_;
  const auto now = std::chrono::steady_clock::now();
  if (now < next_line_) return;
  spdlog::warn(fmt::format("refused {} connections; the last from {}: {}",
                           std::exchange(refused_, 0), address, reason));
  next_line_ = now + kLogInterval;
}

}  // namespace lucerna::rpc
