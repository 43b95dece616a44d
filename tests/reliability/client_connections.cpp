// Idle and half-open connections, and clients that do not read.
#include <arpa/inet.h>
#include <fmt/core.h>
#include <netinet/in.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "lucerna/v1/lighting.pb.h"
#include "proto/common/host_port.h"
#include "proto/common/quantile.h"
#include "tests/reliability/reliability_report.h"
#include "tests/reliability/subject.h"

namespace lucerna::reliability {
namespace {

// What an HTTP/2 client sends first: the preface and empty settings.
constexpr std::string_view kHello("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n\0\0\0\4\0\0\0\0\0", 33);

/// A TCP connection to the server.
class Socket {
 public:
  explicit Socket(const std::string& target) : fd_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    to.sin_port = htons(static_cast<std::uint16_t>(split_host_port(target)->port));
    if (fd_ < 0 || connect(fd_, reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0)
      throw std::runtime_error("cannot connect");
  }
  Socket(Socket&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  ~Socket() {
    if (fd_ >= 0) close(fd_);
  }
  /// Begins HTTP/2 and waits for the server's settings.
  void greet() const {
    char answer[64];
    if (send(fd_, kHello.data(), kHello.size(), MSG_NOSIGNAL) < 0 ||
        recv(fd_, answer, sizeof answer, 0) <= 0)
      throw std::runtime_error("the server refuses a connection");
  }
  /// Whether the server has closed the connection.
  bool closed() const {
    char bytes[256];
    for (;;) {
      const ssize_t n = recv(fd_, bytes, sizeof bytes, MSG_DONTWAIT);
      if (n == 0) return true;
      if (n < 0) return errno != EAGAIN;
    }
  }

 private:
  int fd_;
};

/// A client that asks four times for 1 MB, and reads nothing.
class SlowReader {
 public:
  SlowReader(const Subject& subject, const Message& message)
      : stub_(make_channel(subject.target())) {
    for (auto& [context, stream] : calls_) {
      stream = stub_.PrepareCall(&context, message.method, &queue_);
      stream->StartCall(nullptr);
      next();
      stream->WriteLast(message.bytes, grpc::WriteOptions(), nullptr);
      next();
    }
  }
  ~SlowReader() {
    for (auto& [context, stream] : calls_) {
      context.TryCancel();
      grpc::Status status;
      stream->Finish(&status, nullptr);
      next();
    }
    queue_.Shutdown();
    void* tag = nullptr;
    bool ok = false;
    while (queue_.Next(&tag, &ok)) {
    }
  }
  SlowReader(const SlowReader&) = delete;
  SlowReader& operator=(const SlowReader&) = delete;
  static constexpr int kCalls = 4;

 private:
  struct Call {
    grpc::ClientContext context;
    std::unique_ptr<grpc::GenericClientAsyncReaderWriter> stream;
  };
  void next() {
    void* tag = nullptr;
    bool ok = false;
    queue_.Next(&tag, &ok);
  }
  grpc::CompletionQueue queue_;
  grpc::GenericStub stub_;
  std::array<Call, kCalls> calls_;
};

/// The number of open files that this program may have, raised as far as it goes.
std::size_t allow_files() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return 0;
  limit.rlim_cur = limit.rlim_max;
  (void)setrlimit(RLIMIT_NOFILE, &limit);
  return static_cast<std::size_t>(limit.rlim_cur);
}

}  // namespace

void connections(const Settings& settings, Report& report) {
  const std::size_t idle = settings.brief ? 100 : 1000, half_open = settings.brief ? 20 : 200;
  constexpr int kSlowReaders = 8;
  if (allow_files() < idle + half_open + 100)
    throw std::runtime_error("too few open files are allowed (ulimit -n)");
  const SceneFiles files;
  Subject subject(files, {"--max-peer-connections", "4000", "--handshake-seconds", "600"});
  Traffic traffic(subject.target());
  const auto ask = [&] {
    const auto calls = open_loop(traffic, {subject.one_item()}, 200,
                                 Seconds(settings.brief ? 1 : 10), Seconds(60));
    report.at_least("queries of one item that succeed",
                    static_cast<double>(latencies(calls, grpc::StatusCode::OK).size()),
                    static_cast<double>(calls.size()), "calls");
    return 1e3 * quantile(latencies(calls, grpc::StatusCode::OK), 0.99);
  };
  (void)ask();
  const double alone_ms = ask();
  const double before = subject.resident_bytes();
  std::vector<Socket> sockets;
  for (std::size_t i = 0; i < idle + half_open; ++i) {
    sockets.emplace_back(subject.target());
    if (i < idle) sockets.back().greet();
  }
  // 32 numbers a ray, so the answer of 8192 rays has 1 MB.
  v1::SampleLeRequest rays;
  rays.set_scene_id(subject.scene());
  rays.set_count(8192);
  for (int i = 0; i < 18; ++i) rays.add_wavelengths_nm(400 + 10 * i);
  const Message megabyte = make_message("LightingService/SampleLe", rays);
  std::vector<std::unique_ptr<SlowReader>> readers;
  for (int i = 0; i < kSlowReaders; ++i)
    readers.push_back(std::make_unique<SlowReader>(subject, megabyte));
  // The server greets the connections and computes the answers of the slow readers in this time.
  const double arriving_ms = ask();
  const double crowded_ms = ask();
  const double more_mb = 1e-6 * (subject.resident_bytes() - before);
  std::size_t closed = 0;
  for (const Socket& socket : sockets) closed += socket.closed() ? 1 : 0;
  report.at_most("connections that the server closed", static_cast<double>(closed), 0, "");
  report.note("p99 of one item, alone", alone_ms, "ms");
  report.note("the same in the 10 s in which the others connect and ask", arriving_ms, "ms");
  report.note("the same later, with 1200 connections and 8 slow readers", crowded_ms, "ms");
  report.time("the same with 1200 connections and 8 slow readers, over alone",
              crowded_ms / alone_ms, 2, "");
  // 40 kB for each connection, and two copies of each answer that nobody reads.
  report.at_most(
      "growth of the resident memory", more_mb,
      0.04 * static_cast<double>(idle + half_open) + 2.4 * SlowReader::kCalls * kSlowReaders, "MB");
}

}  // namespace lucerna::reliability
