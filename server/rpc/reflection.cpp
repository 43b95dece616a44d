#include "server/rpc/reflection.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor.pb.h>
#include <grpc/health/v1/health.pb.h>
#include <grpc/reflection/v1alpha/reflection.pb.h>

#include "server/rpc/services.h"

namespace lucerna::rpc {
namespace {

using google::protobuf::DescriptorPool;
using google::protobuf::FileDescriptor;
using grpc::reflection::v1alpha::ServerReflectionRequest;
using grpc::reflection::v1alpha::ServerReflectionResponse;

/// Adds the file, and before it those that it imports, unless the client has them.
void add(const FileDescriptor& file, std::set<std::string>& sent,
         grpc::reflection::v1alpha::FileDescriptorResponse& files) {
  if (!sent.insert(file.name()).second) return;
  for (int i = 0; i < file.dependency_count(); ++i) add(*file.dependency(i), sent, files);
  google::protobuf::FileDescriptorProto proto;
  file.CopyTo(&proto);
  files.add_file_descriptor_proto(proto.SerializeAsString());
}

/// The contract has no extensions.
ServerReflectionResponse answer(const ServerReflectionRequest& request,
                                std::set<std::string>& sent) {
  const DescriptorPool& pool = *DescriptorPool::generated_pool();
  ServerReflectionResponse response;
  response.set_valid_host(request.host());
  *response.mutable_original_request() = request;
  const FileDescriptor* file = nullptr;
  switch (request.message_request_case()) {
    case ServerReflectionRequest::kListServices:
      for (const std::string& name : service_names()) {
        response.mutable_list_services_response()->add_service()->set_name(name);
      }
      return response;
    case ServerReflectionRequest::kFileByFilename:
      file = pool.FindFileByName(request.file_by_filename());
      break;
    case ServerReflectionRequest::kFileContainingSymbol:
      file = pool.FindFileContainingSymbol(request.file_containing_symbol());
      break;
    case ServerReflectionRequest::kAllExtensionNumbersOfType:
      if (pool.FindMessageTypeByName(request.all_extension_numbers_of_type()) == nullptr) break;
      response.mutable_all_extension_numbers_response()->set_base_type_name(
          request.all_extension_numbers_of_type());
      return response;
    default:
      break;
  }
  if (file != nullptr) {
    add(*file, sent, *response.mutable_file_descriptor_response());
  } else {
    response.mutable_error_response()->set_error_code(grpc::StatusCode::NOT_FOUND);
    response.mutable_error_response()->set_error_message("not found");
  }
  return response;
}

}  // namespace

void Reflection::take(bool ok) {
  if (!ok) return finish(stop_.stop_requested() ? cancelled() : absl::OkStatus());
  ServerReflectionRequest request;
  absl::Status status = parse_message(bytes_, request);
  if (status.ok()) status = encode_message(answer(request, sent_), bytes_);
  if (!status.ok()) return finish(status);
  StartWrite(&bytes_);
}

void Reflection::OnWriteDone(bool ok) {
  if (!ok) return finish(cancelled());
  read(idle_time());
}

}  // namespace lucerna::rpc
