#include "client/terminal/error.h"

#include <fmt/core.h>
#include <google/protobuf/util/json_util.h>
#include <unistd.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "client/terminal/colour.h"
#include "client/terminal/print.h"
#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"
#include "lucerna/client/client.h"

namespace lucerna::cli {
namespace {

using nlohmann::ordered_json;

absl::StatusCode code_of(ExitStatus exit) {
  if (exit >= kSignal) return absl::StatusCode::kCancelled;
  return exit == kWrongUse ? absl::StatusCode::kInvalidArgument : absl::StatusCode::kUnknown;
}

ordered_json details_of(const absl::Status& error) {
  // Protocol buffers find the details' types by name, so the program must link them.
  google::rpc::BadRequest::descriptor();
  ordered_json details = ordered_json::array();
  const auto payload = error.GetPayload(client::kStatusPayloadUrl);
  google::rpc::Status status;
  if (!payload || !status.ParseFromString(std::string(*payload))) return details;
  for (const google::protobuf::Any& detail : status.details()) {
    std::string text;
    const auto printed = google::protobuf::util::MessageToJsonString(detail, &text);
    details.push_back(printed.ok() ? ordered_json::parse(text)
                                   : ordered_json{{"@type", detail.type_url()}});
  }
  return details;
}

/// With the details of `status`.
absl::Status with_message(const absl::Status& status, const std::string& message) {
  absl::Status changed(status.code(), message);
  status.ForEachPayload(
      [&](absl::string_view url, const absl::Cord& payload) { changed.SetPayload(url, payload); });
  return changed;
}

}  // namespace

CommandError::CommandError(ExitStatus exit, const std::string& message)
    : CommandError(exit, absl::Status(code_of(exit), message), message) {}

CommandError::CommandError(ExitStatus exit, const absl::Status& status, const std::string& message)
    : StatusError(with_message(status, message)), exit_(exit) {}

void wrong_use(const std::string& message) { throw CommandError(kWrongUse, message); }

std::string to_json(const absl::Status& error) {
  const ordered_json json = {{"error",
                              {{"code", absl::StatusCodeToString(error.code())},
                               {"message", std::string(error.message())},
                               {"details", details_of(error)}}}};
  return json.dump(-1, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

void print_error(const absl::Status& error, bool json) {
  if (json) return shell::print_text(stderr, "{}", to_json(error));
  std::string name = "lucerna:";
  if (shell::has_colours(STDERR_FILENO)) name = shell::paint(name, shell::Colour::kBad);
  shell::print_as_is(stderr, name);
  shell::print_text(stderr, " {}\n", std::string(error.message()));
}

}  // namespace lucerna::cli
