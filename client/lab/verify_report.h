// Findings as a table with notes for people, and as JSON for programs.
#pragma once

#include <string>
#include <vector>

#include "client/lab/finding.h"
#include "client/lab/verify_truth.h"
#include "client/terminal/output.h"

namespace lucerna::verify {

/// One row for each finding.
cli::Table rows_of(const std::vector<Finding>& findings, const Truth& truth);

/// What does not agree, with the likely mistakes, and a summary in the last line.
std::string notes_of(const std::vector<Finding>& findings, const Truth& truth,
                     const Strictness& strictness);

/// One line of JSON.
std::string json_of(const std::vector<Finding>& findings, const Truth& truth,
                    const Strictness& strictness);

/// Whether something differs.
bool any_differs(const std::vector<Finding>& findings);

}  // namespace lucerna::verify
