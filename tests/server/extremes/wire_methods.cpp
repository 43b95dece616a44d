#include "tests/server/extremes/wire_methods.h"

#include <stdexcept>

#include "server/rpc/services.h"
#include "tests/server/extremes/wire_answers.h"

namespace lucerna::testing {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;

std::vector<const google::protobuf::MethodDescriptor*> all_methods() {
  std::vector<const google::protobuf::MethodDescriptor*> methods;
  for (const std::string& name : rpc::service_names()) {
    if (!name.starts_with("lucerna.")) continue;
    const auto* service =
        google::protobuf::DescriptorPool::generated_pool()->FindServiceByName(name);
    if (service == nullptr) throw std::runtime_error("no description of " + name);
    for (int i = 0; i < service->method_count(); ++i) methods.push_back(service->method(i));
  }
  return methods;
}

bool holds_numbers(const FieldDescriptor& field) {
  return field.cpp_type() == FieldDescriptor::CPPTYPE_FLOAT ||
         field.cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE || holds_doubles(field) ||
         holds_floats(field);
}

bool holds_numbers(const Descriptor& type) {
  for (int i = 0; i < type.field_count(); ++i) {
    const FieldDescriptor& f = *type.field(i);
    if (f.message_type() != nullptr ? holds_numbers(*f.message_type()) : holds_numbers(f))
      return true;
  }
  return false;
}

}  // namespace lucerna::testing
