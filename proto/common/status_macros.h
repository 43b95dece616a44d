// Early returns for functions that return absl::Status or absl::StatusOr.
//
//     absl::StatusOr<Scene> load(const std::string& path) {
//       LUCERNA_ASSIGN_OR_RETURN(const std::string text, read(path));
//       LUCERNA_RETURN_IF_ERROR(check(text));
//       ...
//
// Both return the error of their expression unchanged.  Debian 12's Abseil has no such macros.
#pragma once

#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

/// Returns the status of `expression` (absl::Status) from the function if it is an error.
#define LUCERNA_RETURN_IF_ERROR(expression)                                                      \
  do {                                                                                           \
    if (absl::Status lucerna_status = (expression); !lucerna_status.ok()) return lucerna_status; \
  } while (false)

/// Declares or assigns `variable` from `expression` (absl::StatusOr), or returns its error.  A type
/// with a comma needs an alias or `auto`.
#define LUCERNA_ASSIGN_OR_RETURN(variable, expression) \
  LUCERNA_ASSIGN_OR_RETURN_(LUCERNA_JOIN_(lucerna_or_, __LINE__), variable, expression)
#define LUCERNA_ASSIGN_OR_RETURN_(result, variable, expression) \
  auto result = (expression);                                   \
  if (!result.ok()) return std::move(result).status();          \
  variable = *std::move(result)
#define LUCERNA_JOIN_(a, b) LUCERNA_JOIN_AGAIN_(a, b)
#define LUCERNA_JOIN_AGAIN_(a, b) a##b
