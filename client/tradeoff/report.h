// Makes the page of a study from its JSON.
#pragma once

#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace lucerna::tradeoff {

/// An HTML page that loads no other file.  `json` is the text of a tradeoff.json.  INVALID_ARGUMENT
/// for any other text.
absl::StatusOr<std::string> report_page(std::string_view json);

/// Draws the first plot of the page at `page` into the PNG file `picture`, by a headless chromium.
/// NOT_FOUND if PATH has no chromium, UNKNOWN if chromium writes no file.
absl::Status draw_plot(const std::string& page, const std::string& picture);

}  // namespace lucerna::tradeoff
