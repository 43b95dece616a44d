// Reads luminaires from IES LM-63 files: the editions of 1986 (without a header line), 1991, 1995,
// 2002 and 2019.  [LM63] is the edition of 2002; [Fritz18] describes the differences of the others.
#pragma once

#include <absl/status/statusor.h>

#include <string_view>

#include "server/files/photometric_file.h"

namespace lucerna {

/// The luminaire in the text of a file.  `name` is the file's name in errors.
///
/// Intensity is candela times the candela multiplier, the ballast factor, and in the editions of
/// 1986 and 1991 the ballast-lamp photometric factor.  The edition of 1986 has the same number for
/// types A and C; negative vertical angles then mean type A.  The lumens of the lamps do not scale
/// anything: the candela values are for these lamps, or absolute if lumens are -1.  A note reports
/// a flux that exceeds that of the lamps by more than 2%.
///
/// The luminaire hangs in the position of the measurement, so the factor at angle 0 of a tilt table
/// applies.  A tilt table in a separate file is not read; its factor counts as 1.  Text after the
/// last intensity (a further luminaire in the edition of 1991) is left out.  Ballast factors of 0
/// count as 1.  One plane of types A and B is symmetric about the beam.  Planes of these types may
/// differ at a pole.  A note reports each of these, angles that leave a part of the sphere
/// open, and noise below zero.
///
/// A comma separates numbers.  If the file then has an error or more numbers than it announces, and
/// none with decimal commas, these are read, with a note.  If all of these may separate thousands
/// ("1,000"), that is an error.
///
/// Counts in the header are checked against the length of the text before anything is allocated.
/// Errors (INVALID_ARGUMENT): "name:line: what, allowed: ...".
absl::StatusOr<PhotometricFile> parse_ies(std::string_view text, std::string_view name);

}  // namespace lucerna
