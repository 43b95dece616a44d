// Reads luminaires from files of both kinds.
#pragma once

#include <absl/status/statusor.h>

#include <string_view>

#include "server/files/photometric_file.h"

namespace lucerna {

/// The luminaire in the bytes of an IES LM-63 or EULUMDAT file.  The content decides which: "TILT="
/// or numbers in the places of EULUMDAT; without both, the name does.  A note reports a name that
/// says otherwise.  UTF-16 with a byte-order mark is read, and an end-of-file mark (Ctrl-Z) left
/// out.  Errors: those of parse_ies and parse_eulumdat.
absl::StatusOr<PhotometricFile> read_luminaire(std::string_view bytes, std::string_view name);

}  // namespace lucerna
