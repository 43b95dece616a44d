// The common part of commands that send many items and print one answer.
#pragma once

#include <fmt/core.h>

#include <functional>
#include <string>

#include "client/library/batches.h"
#include "client/terminal/output.h"
#include "client/terminal/print.h"
#include "client/terminal/session.h"

namespace lucerna::cli {

/// Sends the request by `in_batches`, a function of client/library/batches.h, and prints the
/// answer. With --json, prints JSON with the members of `json_more` (see to_json()).  Otherwise
/// calls `print`, and then prints the scene's remarks.  The exit status is 1 if some item has no
/// answer.
template <class Request, class Response, class Print>
void send_and_print(Session& session, const Request& request,
                    absl::StatusOr<Response> (*in_batches)(const client::Client&, const Request&,
                                                           const client::BatchOptions&),
                    Print&& print,
                    const std::function<std::string(const Response&)>& json_more = {}) {
  const Response response = session.query_scene([&](const client::Client& client) {
    return in_batches(client, request, {.max_items = 0, .call = session.call_options()});
  });
  if (session.json()) {
    shell::print_text(stdout, "{}", to_json(response, json_more ? json_more(response) : ""));
  } else {
    print(response);
    session.print_remarks();
  }
  bool failed = any_failed(response.status());
  if constexpr (requires { response.estimates(); }) {
    failed |= any_failed(response.estimates().status());
  }
  if (failed) session.set_exit_status(kServerRefused);
}

}  // namespace lucerna::cli
