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
#include <condition_variable>
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

/// The address without the port, and without the interface of a link-local one.
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
  if (address.ss_family == AF_INET) return fmt::format("ipv4:{}:{}", text, port);
  const std::uint32_t link = reinterpret_cast<const sockaddr_in6&>(address).sin6_scope_id;
  return fmt::format("ipv6:%5B{}{}%5D:{}", text, link == 0 ? "" : fmt::format("%25{}", link), port);
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
  std::unique_ptr<Listener> listener(new Listener(limits));
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
  const std::uint64_t one = 1;
  (void)!write(wake_, &one, sizeof one);
  for (std::thread& thread : threads_) thread.join();
  threads_.clear();
  // It closes the connections that keep a thread, so it ends last.
  watch_ = {};
  for (const int fd : listeners_) close(fd);
  listeners_.clear();
}

Listener::~Listener() {
  stop();
  if (wake_ >= 0) close(wake_);
  if (spare_ >= 0) close(spare_);
}

absl::Status Listener::start(std::function<void(std::size_t, int, int)> take,
                             const std::function<std::chrono::milliseconds()>& watch) {
  const std::uint64_t files = raise_file_limit(), used = open_files() + kReserved;
  if (used >= files) {
    return absl::ResourceExhaustedError(fmt::format(
        "the limit of open files is {} (ulimit -n), allowed: at least {}", files, used + 1));
  }
  const auto most = static_cast<std::uint32_t>(std::min<std::uint64_t>(files - used, UINT32_MAX));
  connections_.set_most(most);
  if (most < limits_.connections) {
    spdlog::warn(
        fmt::format("max-connections = {}, but the limit of open files, {}, leaves room "
                    "for {} (ulimit -n)",
                    limits_.connections, files, most));
  }
  take_ = std::move(take);
  for (std::size_t i = 0; i < kThreads; ++i) threads_.emplace_back([this, i] { run(i); });
  watch_ = std::jthread([watch](const std::stop_token& stop) {
    std::mutex mutex;
    std::condition_variable_any ended;
    std::unique_lock lock(mutex);
    while (!stop.stop_requested()) ended.wait_for(lock, stop, watch(), [] { return false; });
  });
  return absl::OkStatus();
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

void Listener::run(std::size_t thread) {
  std::vector<pollfd> ready;
  for (const int fd : listeners_) ready.push_back({fd, POLLIN, 0});
  ready.push_back({wake_, POLLIN, 0});
  for (;;) {
    if (poll(ready.data(), ready.size(), -1) < 0) continue;
    if (ready.back().revents != 0) return;
    for (const pollfd& r : ready) {
      if (r.revents != 0) accept_one(thread, r.fd);
    }
  }
}

void Listener::accept_one(std::size_t thread, int listener) {
  const int fd = accept_from(listener);
  if (fd >= 0) take_(thread, listener, fd);
}

int Listener::accept_from(int listener) {
  const std::lock_guard lock(mutex_);
  sockaddr_storage peer{};
  socklen_t size = sizeof peer;
  const int fd =
      accept4(listener, reinterpret_cast<sockaddr*>(&peer), &size, SOCK_NONBLOCK | SOCK_CLOEXEC);
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
    return -1;
  }
  ++accepted_;
  const std::string address = text_of(peer);
  const std::string reason = connections_.add(fd, address, name_of(peer, port_of(peer)));
  if (reason.empty()) return fd;
  close(fd);
  ++refused_;
  const auto now = std::chrono::steady_clock::now();
  if (now < next_line_) return -1;
  spdlog::warn(fmt::format("refused {} connections; the last from {}: {}",
                           std::exchange(refused_, 0), address, reason));
  next_line_ = now + kLogInterval;
  return -1;
}

}  // namespace lucerna::rpc
