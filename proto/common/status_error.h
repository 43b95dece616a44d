// The exception of readers and commands, whose errors pass through many functions.
#pragma once

#include <exception>
#include <string>
#include <utility>

#include "absl/status/status.h"

namespace lucerna {

/// Thrown while a scene file is read or a command runs.  Caught where these begin: in load_pbrt,
/// load_gltf and the programs' main functions.  All other code returns absl::Status.
class StatusError : public std::exception {
 public:
  explicit StatusError(absl::Status status)
      : status_(std::move(status)), message_(status_.message()) {}

  const absl::Status& status() const { return status_; }
  const char* what() const noexcept override { return message_.c_str(); }

 private:
  absl::Status status_;
  std::string message_;
};

}  // namespace lucerna
