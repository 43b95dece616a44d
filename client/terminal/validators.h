// Checks of the words on the command line, with messages for people.  CLI11's own ranges accept
// NaN, and read -1 as a large unsigned number.  Messages of its own sets of names also show the
// numbers of the names.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace CLI {
class Validator;
}

namespace lucerna::cli {

/// The number in `text`.  Nothing if `text` is not a finite number.
std::optional<double> read_number(std::string_view text);

/// A finite number for which `allowed` is true.  `what` describes these numbers in the error
/// message.
CLI::Validator checked_number(const std::string& what, std::function<bool(double)> allowed);

/// Any finite number.
CLI::Validator finite_number();

/// One of `names`.
CLI::Validator one_of(const std::vector<std::string>& names);

CLI::Validator positive();

CLI::Validator not_negative();

/// A whole number from `least` to `most`.  If `limit` is not empty, the message shows it instead of
/// `most`.  CLI11's own check silently replaces a number that is too large by the largest allowed
/// one.
CLI::Validator whole(std::uint64_t least,
                     std::uint64_t most = std::numeric_limits<std::uint32_t>::max(),
                     const std::string& limit = {});

/// Seeds, ids and other 64-bit numbers.
CLI::Validator whole64(std::uint64_t least = 0);

/// Numbers of samples.  The server has its own limit.
CLI::Validator sample_count(std::uint64_t least = 1);

/// A fraction above 0, such as 0.01 or 1%.  The text becomes the fraction.  A number of 1 or more
/// must have the percent sign, because users often forget it.
CLI::Validator share();

/// Seconds of a time such as 60, 60s, 2m, 500ms, 1h or 1h30m.  The text is a number of seconds, or
/// numbers with the units h, m, s and ms in this order, each at most once.  Nothing for any other
/// text.
std::optional<double> read_duration(std::string_view text);

/// A time above 0 in the form of read_duration().  The text becomes the number of seconds.
CLI::Validator duration();

}  // namespace lucerna::cli
