// Reads luminaires from EULUMDAT files (.ldt).  [Stockmar90]
#pragma once

#include <absl/status/statusor.h>

#include <string_view>

#include "server/files/photometric_file.h"

namespace lucerna {

/// The luminaire in the text of a file, as a web of type C.  `name` is the file's name in errors.
///
/// The file has one value per line; decimal commas are accepted, unless those of a flux or of an
/// intensity may separate thousands ("1,000") and no other comma shows what they are.  Intensity is
/// the file's value per 1000 lm, times the luminous flux of the first set of lamps, times the
/// conversion factor.  The flux is that of all lamps of the set.  If the number of lamps is
/// negative, it is that of the luminaire (absolute photometry).  A conversion factor that is
/// blank or 0 counts as 1, with a note, although the format does not allow it.
///
/// Further sets of lamps are alternatives; they are ignored with a note.  The format lists the
/// values of all sets field by field, but some programs write set by set.  The reader distinguishes
/// the two orders by the fields that are numbers.  If the light output ratio differs from the
/// intensities by more than 2%, the intensities are used, with a note.  This ratio and the downward
/// flux fraction do not scale them.
///
/// Planes are those of the symmetry Isym, from one plane of symmetry to the other, or between them.
/// Without symmetry they may begin anywhere.  If the file has the intensities of all planes that Mc
/// announces, all are used, with a note: of the circle, or of the part that Isym needs.  If only
/// those of the last plane are missing, the others are used, with a note.  Notes also report planes
/// and gamma-angles that leave a part of the sphere open, the tilt during the measurement, what
/// follows the last intensity, and noise below zero.
///
/// Counts are checked against the number of lines before anything is allocated.  Errors
/// (INVALID_ARGUMENT): "name:line: what, allowed: ...".
absl::StatusOr<PhotometricFile> parse_eulumdat(std::string_view text, std::string_view name);

}  // namespace lucerna
