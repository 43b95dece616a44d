// Types and functions for readers of photometric files: result, lines, numbers and errors.
#pragma once

#include <absl/status/status.h>

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "lights/pictures/photometric_web.h"

namespace lucerna {

/// The largest magnitude that a number of a file may have.
inline constexpr double kAny = 1e300;

/// The largest size of a list that a file may announce.
inline constexpr int kMostCount = 1'000'000'000;

struct PhotometricFile {
  std::shared_ptr<const PhotometricWeb> web;
  std::string format;  ///< "IES LM-63-2002, type C", "EULUMDAT"
  /// A part of the file that is not modelled, and what happens instead.
  struct Note {
    int line;
    std::string what, instead;
  };
  std::vector<Note> notes;
};

/// Takes the first line off `text`, without its end: CR LF, LF or CR.  The last line may have no
/// end.  Requires a text that is not empty.
std::string_view take_line(std::string_view& text);

/// `text` without spaces and tabs at its ends.
std::string_view trimmed(std::string_view text);

/// The finite number in `text`, with an optional sign; nothing if `text` is not such a number.
std::optional<double> parse_number(std::string_view text);

/// INVALID_ARGUMENT "file:line: what".
absl::Status photometric_error(std::string_view file, int line, std::string_view what);

/// The beginning of a text from a file, for a message; '?' replaces what cannot be printed.
std::string excerpt(std::string_view text);

}  // namespace lucerna
