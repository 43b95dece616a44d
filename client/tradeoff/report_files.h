// The parts of the page, which the build embeds into the program.
#pragma once

#include <string_view>

namespace lucerna::tradeoff {

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
