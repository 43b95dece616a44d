#include "tests/reliability/reliability_report.h"

#include <fmt/core.h>

#include <cstdio>

namespace lucerna::reliability {

void Report::line(const std::string& what, const std::string& measured, const std::string& allowed,
                  const char* verdict) const {
  fmt::print("  {:<58} {:>14}  {:<20} {}\n", what, measured, allowed, verdict);
  (void)std::fflush(stdout);
}

void Report::time(const std::string& what, double measured, double most, const std::string& unit) {
  if (brief_) return;
  line(what, fmt::format("{:.4g} {}", measured, unit), fmt::format("at most {:.4g} {}", most, unit),
       measured <= most ? "ok" : "missed");
}

void Report::at_most(const std::string& what, double measured, double most,
                     const std::string& unit) {
  const bool good = measured <= most;
  holds_ = holds_ && good;
  line(what, fmt::format("{:.4g} {}", measured, unit), fmt::format("at most {:.4g} {}", most, unit),
       good ? "ok" : "FAILED");
}

void Report::at_least(const std::string& what, double measured, double least,
                      const std::string& unit) {
  const bool good = measured >= least;
  holds_ = holds_ && good;
  line(what, fmt::format("{:.4g} {}", measured, unit),
       fmt::format("at least {:.4g} {}", least, unit), good ? "ok" : "FAILED");
}

void Report::note(const std::string& what, double measured, const std::string& unit) {
  if (!brief_) line(what, fmt::format("{:.4g} {}", measured, unit), "", "");
}

}  // namespace lucerna::reliability
