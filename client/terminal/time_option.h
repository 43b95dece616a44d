// --time: the moment of a query, for scenes where something moves.
#pragma once

#include <optional>
#include <string>

namespace CLI {
class App;
}

namespace lucerna::cli {

struct TimeOption {
  void add(CLI::App& command, const std::string& otherwise = "0");

  bool given() const { return time_s_.has_value(); }
  /// Sets the moment if it is given.
  template <typename Request>
  void put(Request& request) const {
    if (time_s_) request.set_time_s(*time_s_);
  }

 private:
  std::optional<double> time_s_;
};

}  // namespace lucerna::cli
