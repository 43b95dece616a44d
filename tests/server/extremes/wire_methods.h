// The methods of all services, from their descriptors.
#pragma once

#include <google/protobuf/descriptor.h>

#include <vector>

namespace lucerna::testing {

/// All methods of every service of the server.
std::vector<const google::protobuf::MethodDescriptor*> all_methods();

/// Whether a field holds floats or doubles, or bytes that contain them.
bool holds_numbers(const google::protobuf::FieldDescriptor& field);

/// Whether a message of this type can hold any of them, at any depth.
bool holds_numbers(const google::protobuf::Descriptor& type);

}  // namespace lucerna::testing
