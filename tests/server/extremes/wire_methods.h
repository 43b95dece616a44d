// The calls of all services, as their descriptions have them.
#pragma once

#include <google/protobuf/descriptor.h>

#include <vector>

namespace lucerna::testing {

/// Of every service that the server has.
std::vector<const google::protobuf::MethodDescriptor*> all_methods();

/// Whether a field is of floats or doubles, or of bytes that hold them.
bool holds_numbers(const google::protobuf::FieldDescriptor& field);

/// Whether a message of this type can hold any of them, in whatever depth.
bool holds_numbers(const google::protobuf::Descriptor& type);

}  // namespace lucerna::testing
