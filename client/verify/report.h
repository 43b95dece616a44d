// Findings as a table for people and as JSON for programs.
#pragma once

#include <string>
#include <vector>

#include "client/terminal/output.h"
#include "client/verify/finding.h"
#include "client/verify/truth.h"

namespace lucerna::verify {

/// One row for each finding.
cli::Table table_of(const std::vector<Finding>& findings, const Truth& truth);

/// The sentences about what differs, and a summary in the last line.
std::string notes_of(const std::vector<Finding>& findings, const Truth& truth,
                     const Strictness& strictness);

/// One line of JSON.
std::string json_of(const std::vector<Finding>& findings, const Truth& truth,
                    const Strictness& strictness);

/// Whether something differs.
bool any_differs(const std::vector<Finding>& findings);

}  // namespace lucerna::verify
