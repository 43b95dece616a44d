// The rows of the table of reliability.
#pragma once

#include <string>
#include <vector>

namespace lucerna::reliability {

/// How a row runs.
struct Settings {
  /// The short form: few repeats, and times are not printed, since other programs may run.
  bool brief = false;
  double soak_minutes = 20;
};

/// Collects figures.  Times depend on the machine, so a time over its limit is only reported. Every
/// other figure over its limit makes the program fail.  Not thread-safe.
class Report {
 public:
  explicit Report(bool brief) : brief_(brief) {}

  /// A figure that depends on the speed of the machine.
  void time(const std::string& what, double measured, double most, const std::string& unit);
  /// A figure that does not.
  void at_most(const std::string& what, double measured, double most, const std::string& unit);
  void at_least(const std::string& what, double measured, double least, const std::string& unit);
  /// A figure without a limit.
  void note(const std::string& what, double measured, const std::string& unit);

  /// Whether all figures that do not depend on the machine are within their limits.
  bool holds() const { return holds_; }

 private:
  void line(const std::string& what, const std::string& measured, const std::string& allowed,
            const char* verdict) const;
  bool brief_, holds_ = true;
};

// One function for each row.
void attacks(const Settings& settings, Report& report);
void overload(const Settings& settings, Report& report);
void priority(const Settings& settings, Report& report);
void stopping(const Settings& settings, Report& report);
void connections(const Settings& settings, Report& report);
void churn(const Settings& settings, Report& report);
void drain(const Settings& settings, Report& report);
void monitoring(const Settings& settings, Report& report);
void soak(const Settings& settings, Report& report);

}  // namespace lucerna::reliability
