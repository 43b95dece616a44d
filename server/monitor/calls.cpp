#include "server/monitor/calls.h"

namespace lucerna::monitor {
namespace {

// In the order of their numbers.
constexpr std::array<const char*, kCodes> kCodeNames{
    "OK",
    "CANCELLED",
    "UNKNOWN",
    "INVALID_ARGUMENT",
    "DEADLINE_EXCEEDED",
    "NOT_FOUND",
    "ALREADY_EXISTS",
    "PERMISSION_DENIED",
    "RESOURCE_EXHAUSTED",
    "FAILED_PRECONDITION",
    "ABORTED",
    "OUT_OF_RANGE",
    "UNIMPLEMENTED",
    "INTERNAL",
    "UNAVAILABLE",
    "DATA_LOSS",
    "UNAUTHENTICATED",
};

}  // namespace

const char* code_name(int code) {
  return code >= 0 && static_cast<std::size_t>(code) < kCodes ? kCodeNames[code] : "UNKNOWN";
}

}  // namespace lucerna::monitor
