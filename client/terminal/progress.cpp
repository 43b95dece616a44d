#include "client/terminal/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "client/terminal/print.h"

namespace lucerna::cli {

std::string progress_line(std::uint64_t done, std::uint64_t total,
                          std::chrono::duration<double> elapsed) {
  constexpr int kWidth = 20;
  const double part =
      total == 0 ? 0 : std::min(1.0, static_cast<double>(done) / static_cast<double>(total));
  const int filled = static_cast<int>(part * kWidth);
  std::string line = fmt::format("[{:#<{}}{:-<{}}] {:3.0f}%", "", filled, "", kWidth - filled,
                                 std::floor(100 * part));
  if (part > 0 && part < 1) {
    const auto left = static_cast<long>(std::ceil(elapsed.count() * (1 - part) / part));
    line += fmt::format("  ETA {}:{:02}", left / 60, left % 60);
  }
  return line;
}

ProgressBar::ProgressBar() : visible_(::isatty(STDERR_FILENO) != 0), start_(Clock::now()) {}

ProgressBar::~ProgressBar() {
  if (visible_) shell::print_as_is(stderr, "\r\033[K");
}

void ProgressBar::update(std::uint64_t done, std::uint64_t total) {
  if (!visible_) return;
  const Clock::time_point now = Clock::now();
  if (now - drawn_ < std::chrono::milliseconds(100)) return;
  drawn_ = now;
  shell::print_as_is(stderr, "\r\033[K" + progress_line(done, total, now - start_));
  std::fflush(stderr);
}

}  // namespace lucerna::cli
