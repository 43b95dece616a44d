#include "server/monitor/unblocking_sink.h"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <cstddef>
#include <utility>

namespace lucerna::monitor {

void UnblockingSink::sink_it_(const spdlog::details::log_msg& message) {
  if (!write_waiting()) {
    ++left_out_;
    return;
  }
  if (const std::uint64_t all = left_out_; all > reported_) {
    const std::string text = fmt::format("{} lines were left out, because nobody read the log",
                                         all - std::exchange(reported_, all));
    // Without the name of a logger, its text is not the members of a JSON object.
    spdlog::details::log_msg missing("", spdlog::level::warn, text);
    missing.time = message.time;
    append(missing);
  }
  append(message);
  (void)write_waiting();
}

void UnblockingSink::append(const spdlog::details::log_msg& message) {
  spdlog::memory_buf_t line;
  formatter_->format(message, line);
  waiting_.append(line.data(), line.size());
}

bool UnblockingSink::write_waiting() {
  while (!waiting_.empty()) {
    // A pipe that is ready takes this much at once.  Its flag O_NONBLOCK would also be the flag of
    // other programs that have the pipe.
    constexpr std::size_t kAtOnce = PIPE_BUF;
    pollfd ready{.fd = descriptor_, .events = POLLOUT, .revents = 0};
    if (poll(&ready, 1, 0) <= 0) return false;
    const ssize_t n = ::write(descriptor_, waiting_.data(), std::min(waiting_.size(), kAtOnce));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0 && errno == EAGAIN) return false;
    // After an error, such as a reader that is gone, nobody misses the lines.
    waiting_.erase(0, n < 0 ? waiting_.size() : static_cast<std::size_t>(n));
  }
  return true;
}

}  // namespace lucerna::monitor
