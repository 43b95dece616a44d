// What holds for every number of every answer.
#pragma once

#include <google/protobuf/message.h>

#include <map>
#include <string>
#include <vector>

namespace lucerna::testing {

/// What is wrong with the numbers of a message, found by reflection in all its fields: one that is
/// not finite, one below 0 in a field that `signed_fields` does not name, and bytes of which nobody
/// said whether they hold numbers.  Empty where all is well.
std::vector<std::string> wrong_numbers(const google::protobuf::Message& message);

/// The fields whose numbers may be below 0, by their full names, and why: coordinates, components
/// of vectors, and times, as lucerna/v1/accuracy.proto says.  No field may hold NaN or an infinity.
const std::map<std::string, std::string>& signed_fields();

/// Whether a field of bytes holds little-endian doubles, or floats.
bool holds_doubles(const google::protobuf::FieldDescriptor& field);
bool holds_floats(const google::protobuf::FieldDescriptor& field);

/// How many numbers `wrong_numbers` looked at so far.
std::uint64_t numbers_seen();

}  // namespace lucerna::testing
