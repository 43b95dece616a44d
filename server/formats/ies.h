// Luminaires in IES LM-63 files: the editions of 1986 (which has no header line), 1991, 1995, 2002
// and 2019.  [LM63] has that of 2002; how the others differ, [Fritz18] says.
#pragma once

#include <absl/status/statusor.h>

#include <string_view>

#include "server/formats/photometric_file.h"

namespace lucerna {

/// The luminaire that the text of a file describes; `name` is the file's in errors.
///
/// Intensity is candela times the candela multiplier, the ballast factor, and in the editions of
/// 1986 and 1991 the ballast-lamp photometric factor.  Where the edition of 1986 says type C and
/// vertical angles are negative, it is type A, which has the same number there.  Lumens of the
/// lamps scale nothing: the candela are for those lamps, or absolute where lumens are -1.  The
/// luminaire hangs as it was measured: of a tilt table the factor at angle 0 holds; a tilt table in
/// a file of its own is not read, its factor being 1 there.  What follows the last intensity (a
/// further luminaire of the edition of 1991) is left out.  Notes tell of each.
///
/// What the numbers claim to follow is checked against the length of the text before anything is
/// allocated.  Errors (INVALID_ARGUMENT): "name:line: what, allowed: ...".
absl::StatusOr<PhotometricFile> parse_ies(std::string_view text, std::string_view name);

}  // namespace lucerna
