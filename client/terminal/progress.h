// A progress bar.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace lucerna::cli {

/// "[#####---------------]  25%  ETA 1:05"; no ETA before the first piece is done.
std::string progress_line(std::uint64_t done, std::uint64_t total,
                          std::chrono::duration<double> elapsed);

/// Draws on stderr if stderr is a terminal, at most ten times in a second.  The destructor removes
/// the bar.
class ProgressBar {
 public:
  ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;
  ~ProgressBar();

  void update(std::uint64_t done, std::uint64_t total);

 private:
  using Clock = std::chrono::steady_clock;

  bool visible_;
  Clock::time_point start_;
  Clock::time_point drawn_{};
};

}  // namespace lucerna::cli
