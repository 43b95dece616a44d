// Types and functions for readers of photometric files: result, lines, numbers and errors.
#pragma once

#include <absl/status/status.h>

#include <functional>
#include <initializer_list>
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
  /// For a light that is a point; nothing if the file's luminous opening has no size.
  std::optional<Note> opening;
  /// Unit of the web's flux if its intensities are not candela, such as "mW"; otherwise empty.
  std::string flux_unit;
  /// For a light whose level is the file's; nothing without `flux_unit`.
  std::optional<Note> unit;
};

/// The note about a luminous opening of these sizes [m], of any sign; nothing if all are 0.
std::optional<PhotometricFile::Note> opening_note(int line, std::initializer_list<double> sizes_m);

/// Adds the note about angles that leave a part of the sphere open, if they do.
void note_gap(int line, std::optional<AngleGap> gap, PhotometricFile& file);

/// The negative intensities of a file.  Small ones are noise about 0 of the measurement.
class NoiseBelowZero {
 public:
  /// The `number`-th value of the list, from 1, and its line.
  void add(double value, std::size_t number, int line);
  /// Sets them to 0, with a note.  Error (INVALID_ARGUMENT): one is below -3% of the largest.
  /// `what` describes the list's value of a number.
  absl::Status clear(std::vector<double>& values, std::string_view name,
                     const std::function<std::string(std::size_t)>& what,
                     PhotometricFile& file) const;

 private:
  double least_ = 0;
  std::size_t number_ = 0, count_ = 0;
  int line_ = 0;
};

/// Takes the first line off `text`, without its end: CR LF, LF or CR.  The last line may have no
/// end.  Requires a text that is not empty.
std::string_view take_line(std::string_view& text);

/// `text` without spaces and tabs at its ends.
std::string_view trimmed(std::string_view text);

/// ASCII letters in upper case.
std::string upper_case(std::string_view text);

/// The finite number in `text`, with an optional sign; nothing if `text` is not such a number.
std::optional<double> parse_number(std::string_view text);

/// "1000 or 1, ..." for "1,000", whose comma may separate thousands or decimals.  Nothing for
/// numbers such as "0,500" and "1,5".
std::optional<std::string> ambiguous_commas(std::string_view number);

/// INVALID_ARGUMENT "file:line: what".
absl::Status photometric_error(std::string_view file, int line, std::string_view what);

/// The beginning of a text from a file, for a message; '?' replaces what cannot be printed.
std::string excerpt(std::string_view text);

}  // namespace lucerna
