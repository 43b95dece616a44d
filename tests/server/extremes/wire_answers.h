// What holds for every number of every answer.
#pragma once

#include <google/protobuf/message.h>

#include <string>
#include <vector>

namespace lucerna::testing {

/// What is wrong with the numbers of a message, found by reflection in all its fields: one that is
/// not finite, and one below 0 where it is not among those that may be.  Empty where all is well.
std::vector<std::string> wrong_numbers(const google::protobuf::Message& message);

/// How many numbers that looked at so far.
std::uint64_t numbers_seen();

}  // namespace lucerna::testing
