// What the page is made of, as it was when the program was built.
#pragma once

#include <string_view>

namespace lucerna::tradeoff {

/// HTML with the names of the others in it, where they go: {{style}}, {{licence}}, {{library}},
/// {{data}}, {{shared}}, {{plots}}, {{page}}.
extern const std::string_view kPage;
extern const std::string_view kStyle;
/// In the order in which they run.
extern const std::string_view kSharedScript, kPlotsScript, kPageScript;
/// Chart.js, and what Debian says of its licence.
extern const std::string_view kLibrary;
extern const std::string_view kLicence;

}  // namespace lucerna::tradeoff
