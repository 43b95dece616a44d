// Findings as a table for people and as JSON for programs.
#pragma once

#include <string>
#include <vector>

#include "client/verify/finding.h"
#include "client/verify/truth.h"

namespace lucerna::verify {

/// The table, the sentences about what differs, and a summary in the last line.
std::string table_of(const std::vector<Finding>& findings, const Truth& truth,
                     const Strictness& strictness);

/// One line of JSON.
std::string json_of(const std::vector<Finding>& findings, const Truth& truth,
                    const Strictness& strictness);

/// Whether something differs.
bool any_differs(const std::vector<Finding>& findings);

}  // namespace lucerna::verify
