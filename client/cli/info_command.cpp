// The command info.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <string>

#include "client/cli/admin_commands.h"
#include "client/terminal/output.h"
#include "client/terminal/print.h"
#include "client/terminal/program.h"
#include "client/terminal/session.h"

namespace lucerna::cli {
namespace {

void info(Session& session) {
  const auto response =
      session.value_or_fail(session.client().get_server_info({}, session.call_options()));
  if (session.json()) {
    shell::print_text(stdout, "{}", to_json(response));
    return;
  }
  const v1::Limits& limits = response.limits();
  const v1::NumericFingerprint& fingerprint = response.fingerprint();
  Table table({{"lucernad", true, {"what"}}, {response.version(), true, {"value"}}});
  if (session.csv()) table.add({"lucernad", response.version()});
  table.add({"threads", std::to_string(response.threads())});
  table.add({"batch, at most", fmt::format("{} items", limits.max_batch_items())});
  table.add({"tile, at most", fmt::format("{} pixels", limits.max_tile_pixels())});
  table.add({"samples, at most", std::to_string(limits.max_samples())});
  table.add({"page, at most", fmt::format("{} entries", limits.max_page_size())});
  table.add({"message, at most", fmt::format("{} bytes", limits.max_message_bytes())});
  table.add({"may wait", fmt::format("{} queries, {} renders", limits.interactive_queue(),
                                     limits.bulk_queue())});
  table.add({"uploaded file, at most", fmt::format("{} bytes", limits.max_asset_bytes())});
  table.add({"uploaded files, at most", fmt::format("{} bytes", limits.asset_budget_bytes())});
  table.add({"scenes, at most", limits.memory_budget_bytes() == 0
                                    ? std::string("no limit")
                                    : fmt::format("{} bytes", limits.memory_budget_bytes())});
  table.add({"lease, at most", fmt::format("{:g} s", limits.max_lease_s())});
  // Older servers do not state these.
  if (limits.max_scene_primitives() > 0) {
    table.add({"scene, at most", fmt::format("{} primitives", limits.max_scene_primitives())});
    table.add({"files of a scene, at most", fmt::format("{} bytes", limits.max_scene_bytes())});
    table.add({".pbrt files, at most",
               fmt::format("{} tokens, {} deep", limits.max_tokens(), limits.max_include_depth())});
    table.add({"picture, at most", fmt::format("{} texels", limits.max_picture_texels())});
    table.add({"name, at most", fmt::format("{} bytes", limits.max_name_bytes())});
    table.add({"upload may pause", fmt::format("{:g} s", limits.upload_timeout_s())});
  }
  table.add({"fingerprint", fingerprint.digest()});
  table.add({"  build", fingerprint.build()});
  table.add({"  Embree", fingerprint.embree()});
  table.add({"  libm", fingerprint.libm()});
  session.show(table);
}

}  // namespace

void add_info_command(CLI::App& app, Session& session) {
  session.prints_table(*add_command(
      app, "info", "Print the version, the limits and the numeric fingerprint of the server",
      nullptr, "", "lucerna info --server 10.0.0.7:50051",
      [&session](const std::string&) { info(session); }));
}

}  // namespace lucerna::cli
