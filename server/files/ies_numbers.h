// Reads the numbers of IES LM-63 files.
#pragma once

#include <absl/status/status.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "server/files/photometric_file.h"

namespace lucerna {

/// What a comma is.  In LM-63 it separates numbers.
enum class Comma { kSeparator, kDecimal };

/// Reads one number after the other, across line ends, separated by blanks, semicolons and commas.
/// After the first error, calls do nothing, so that callers can check `status` once for several
/// numbers.
class IesNumbers {
 public:
  /// `rest`: what follows the line `line`.
  IesNumbers(std::string_view file, std::string_view rest, int line, Comma comma)
      : file_(file), rest_(rest), line_(line), comma_(comma) {}

  /// The next number; nothing after an error, which is in `status`.
  std::optional<double> next(std::string_view what);
  /// The next number, in [least, most].
  double number(std::string_view what, double least, double most, std::string_view allowed);
  /// A whole number in [least, most].
  int whole(std::string_view what, int least, int most, std::string_view allowed);
  double positive(std::string_view what) { return number(what, 1e-300, kAny, "positive"); }
  /// A whole number from `least`, for the size of a list.
  std::size_t count(std::string_view what, int least, std::string_view allowed) {
    return static_cast<std::size_t>(whole(what, least, kMostCount, allowed));
  }

  /// `count` numbers from `least`.  The caller has called `room_for`.
  std::vector<double> list(std::string_view what, std::size_t count, double least,
                           std::string_view allowed);
  /// `count` ascending angles [degrees].  The caller has called `room_for`.
  std::vector<double> angles(std::string_view what, std::size_t count);

  /// Fails with the message of `checked` at a line, if that is an error.
  void check(int line, const absl::Status& checked);
  /// Fails if the rest is too short for `count` numbers: each takes a digit, and a blank before the
  /// next one.
  bool room_for(std::uint64_t count);

  /// Skips to the next word; false if there is none.
  bool skip();
  /// Whether the next word, after `skip`, is a number.
  bool at_number() const { return parse(word()).has_value(); }
  /// Number of the current line, from 1; the last line at the end of the file.
  int line() const { return line_; }
  void fail(std::string_view what) {
    if (status.ok()) status = photometric_error(file_, line(), what);
  }

  /// An error about commas that may separate thousands, if no other comma shows that they are
  /// decimal.
  absl::Status ambiguous() const { return comma_decides_ ? absl::OkStatus() : ambiguous_; }

  absl::Status status;

 private:
  void note_comma(std::string_view word);
  bool is_blank(char c) const;
  std::string_view word() const;
  std::optional<double> parse(std::string_view word) const;

  std::string_view file_;
  std::string_view words_;  // the rest of the current line
  std::string_view rest_;   // the lines after it
  int line_;
  Comma comma_;
  absl::Status ambiguous_;  // about the first such number
  bool comma_decides_ = false;
};

}  // namespace lucerna
