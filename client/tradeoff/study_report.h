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

// The parts of the page, which the build embeds into the program.

/// HTML with placeholders for the other parts: {{style}}, {{licence}}, {{library}}, {{data}},
/// {{shared}}, {{plots}}, {{page}}.
extern const std::string_view kPage;
extern const std::string_view kStyle;
/// The scripts, in the order in which they run.
extern const std::string_view kSharedScript, kPlotsScript, kPageScript;
/// Chart.js, and its licence from the Debian package.
extern const std::string_view kLibrary;
extern const std::string_view kLicence;

}  // namespace lucerna::tradeoff
