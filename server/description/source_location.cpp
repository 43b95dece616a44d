#include "server/description/source_location.h"

#include <fmt/format.h>

namespace lucerna {

std::string text_of(const SourceLocation& where) {
  if (where.line == 0) return where.file.str();
  return fmt::format("{}:{}:{}", where.file.str(), where.line, where.column);
}

absl::Status located(const absl::Status& status, const SourceLocation& where) {
  if (status.ok()) return status;
  return {status.code(), fmt::format("{}: {}", text_of(where), std::string(status.message()))};
}

}  // namespace lucerna
