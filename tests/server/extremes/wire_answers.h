// Conditions for every number of every answer.
#pragma once

#include <google/protobuf/message.h>

#include <map>
#include <string>
#include <vector>

namespace lucerna::testing {

/// The invalid numbers of a message, found by reflection in all its fields.  A number is invalid
/// where it is not finite, or below 0 in a field that `signed_fields` does not name.  Bytes that no
/// list declares as numbers or as other data are reported too.  Empty where all are valid.
std::vector<std::string> wrong_numbers(const google::protobuf::Message& message);

/// Full names of the fields whose numbers may be below 0, each with its reason: coordinates,
/// components of vectors, and times, as lucerna/v1/accuracy.proto documents.  No field may hold NaN
/// or an infinity.
const std::map<std::string, std::string>& signed_fields();

/// Whether a field of bytes holds little-endian doubles or floats.
bool holds_doubles(const google::protobuf::FieldDescriptor& field);
bool holds_floats(const google::protobuf::FieldDescriptor& field);

/// How many numbers `wrong_numbers` has checked so far.
std::uint64_t numbers_seen();

}  // namespace lucerna::testing
