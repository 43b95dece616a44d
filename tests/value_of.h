// The value of a result that a test needs.
#pragma once

#include <absl/status/statusor.h>

#include <stdexcept>
#include <utility>

namespace lucerna::testing {

/// Throws the error, which ends the test and fails it.
template <typename T>
T value_of(absl::StatusOr<T> result) {
  if (!result.ok()) throw std::runtime_error(result.status().ToString());
  return *std::move(result);
}

}  // namespace lucerna::testing
