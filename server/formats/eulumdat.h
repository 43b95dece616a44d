// Luminaires in EULUMDAT files (.ldt).  [Stockmar90]
#pragma once

#include <absl/status/statusor.h>

#include <string_view>

#include "server/formats/photometric_file.h"

namespace lucerna {

/// The luminaire that the text of a file describes, as a web of type C; `name` is the file's in
/// errors.
///
/// The file has one value a line; decimal commas are taken as points.  Intensity is what the file
/// gives per 1000 lm, times the luminous flux of the first set of lamps (of all its lamps; of the
/// luminaire where their number is negative, absolute photometry), times the conversion factor (1
/// where its line is blank, which a note tells; the description knows no blank there).
/// Further sets are alternatives: a note tells that they are left out.  The description has the
/// values of all sets field by field, programs write them set by set too: what can be a number
/// tells which it is.  Where the light output ratio contradicts the intensities by more than 2%,
/// the intensities hold and a note tells; neither it nor the downward flux fraction scales them.
///
/// Counts are checked against the lines there are before anything is allocated.  Errors
/// (INVALID_ARGUMENT): "name:line: what, allowed: ...".
absl::StatusOr<PhotometricFile> parse_eulumdat(std::string_view text, std::string_view name);

}  // namespace lucerna
