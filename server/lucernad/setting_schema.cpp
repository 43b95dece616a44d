#include "server/lucernad/setting_schema.h"

namespace lucerna::config {

namespace {

Setting reloads(Setting setting) {
  setting.reloads = true;
  return setting;
}

std::vector<Setting> connection_settings(rpc::ServerOptions& server) {
  return {
      {"listen", "HOST:PORT", "Address to listen on; port 0 chooses a free port",
       Text{&server.listen}},
      {"insecure", "",
       "Allow an address that other machines can reach, without TLS.  Anyone there can read and "
       "send",
       Switch{&server.connections.insecure}},
      reloads({"tls-cert", "FILE", "The server's certificate chain in PEM",
               Text{&server.connections.tls.certificate}}),
      reloads({"tls-key", "FILE", "The private key of --tls-cert in PEM",
               Text{&server.connections.tls.key}}),
      reloads({"tls-client-ca", "FILE",
               "Clients need a certificate of this authority; default: they need none",
               Text{&server.connections.tls.client_ca}}),
      reloads(
          {"token-file", "FILE",
           "Tokens of callers with their roles, in TOML; default: every caller may do everything",
           Text{&server.connections.token_file}}),
      reloads({"max-connections", "N", "Most open connections",
               Whole{&server.connections.limits.connections, 1, 1U << 20}}),
      reloads({"max-peer-connections", "N", "Most open connections from one address",
               Whole{&server.connections.limits.peer_connections, 1, 1U << 20}}),
      {"max-streams", "N", "Most calls at once on one connection",
       Whole{&server.connections.streams, 1, 1U << 20}},
      {"idle-seconds", "SECONDS", "Close a connection without calls after this time; 0: never",
       Whole{&server.connections.idle_s, 0, 2000000}},
      {"handshake-seconds", "SECONDS", "Close a connection without TLS and HTTP/2 within this time",
       Whole{&server.connections.handshake_s, 1, 3600}},
      {"ping-seconds", "SECONDS", "Time of silence after which the server pings a client",
       Whole{&server.connections.ping_s, 1, 2000000}},
      {"min-ping-seconds", "SECONDS", "Disconnect a client that pings more often than this",
       Whole{&server.connections.least_ping_gap_s, 0, 3600}},
  };
}

std::vector<Setting> scene_settings(rpc::ServerOptions& server) {
  return {
      {"scene-root", "DIR", "Directory of the scenes", Text{&server.scenes.root}},
      {"load", "PATH", "Load this scene before serving; may be repeated", Texts{&server.load}},
      {"threads", "N", "Compute threads; 0: one for each processor",
       Whole{&server.lanes.threads, 0, 1024}},
      {"isa", "NAME", "Instruction set of the kernels: sse2, sse4.2, avx, avx2 or avx512",
       Text{&server.scenes.isa}},
      reloads({"max-batch-items", "N", "Most items of one batch",
               Whole{&server.limits.max_batch_items, 1024, 1U << 24}}),
      reloads({"max-tile-pixels", "N", "Most pixels of one tile",
               Whole{&server.limits.max_tile_pixels, 1, 1U << 26}}),
      reloads({"max-samples", "N", "Most samples for each pixel or item of one request",
               Whole{&server.limits.max_samples, 1, 1U << 30}}),
      {"max-message-bytes", "BYTES", "Most bytes of one message",
       Bytes{&server.limits.max_message_bytes, 1U << 20, 2147483647}},
      {"memory-budget", "BYTES",
       "Memory of all scenes and loads, such as 8GiB; 0: no limit.  Least recently used scenes "
       "without a lease are unloaded first",
       Bytes{&server.scenes.memory_budget_bytes}},
      {"texture-memory", "BYTES",
       "Memory of the pictures on the surfaces of a scene; 0: no limit.  Larger pictures are "
       "halved until they fit",
       Bytes{&server.scenes.texture_bytes}},
      {"max-lease", "SECONDS", "The longest lease of a scene [s]",
       Real{&server.scenes.max_lease_s, 1, 1e9}},
      {"max-scene-primitives", "N", "Most triangles, patches, curves and other shapes of a scene",
       Whole{&server.scenes.load.max_primitives, 1, std::uint64_t{1} << 32}},
      {"max-scene-bytes", "BYTES",
       "Most bytes of the files of a scene.  Compressed files also count unpacked",
       Bytes{&server.scenes.load.max_scene_bytes, 1}},
      {"max-picture-texels", "N", "Most texels of one picture",
       Whole{&server.scenes.load.max_texels, 1, std::uint64_t{1} << 30}},
      {"max-include-depth", "N", "How deep .pbrt files may include each other",
       Whole{&server.scenes.load.max_include_depth, 1, 1000}},
      {"max-tokens", "N", "Most words, strings and brackets of the .pbrt files of a scene",
       Whole{&server.scenes.load.max_tokens, 1, std::uint64_t{1} << 40}},
  };
}

std::vector<Setting> other_settings(Options& options) {
  rpc::ServerOptions& server = options.server;
  return {
      {"asset-dir", "DIR",
       "Directory of uploaded files, kept for the next start; default: a temporary directory",
       Text{&server.assets.directory}},
      {"asset-budget", "BYTES",
       "Disk space of uploaded files.  Least recently used files are deleted first",
       Bytes{&server.assets.budget_bytes, 1}},
      {"max-asset-bytes", "BYTES", "Largest size of one uploaded file",
       Bytes{&server.assets.max_asset_bytes, 1}},
      {"upload-timeout", "SECONDS", "How long an upload may send nothing before it is ended [s]",
       Whole{&options.upload_timeout_s, 1, 86400}},
      {"keep-partial-uploads", "SECONDS", "How long the part of an interrupted upload is kept [s]",
       Whole{&options.keep_partial_uploads_s, 0, 1'000'000'000}},
      {"interactive-queue", "N", "Most queries of less than 0.1 s that may wait",
       Whole{&server.lanes.interactive_queue, 1, 1U << 20}},
      {"bulk-queue", "N", "Most renders, loads and longer queries that may wait",
       Whole{&server.lanes.bulk_queue, 1, 1U << 20}},
      {"max-call-seconds", "SECONDS",
       "Longest computation of a call without a deadline [s]; 0: no limit",
       Real{&server.max_call_s, 0, 1e9}},
      {"metrics", "HOST:PORT",
       "Address of the metrics for Prometheus, without encryption; default: no metrics",
       Text{&server.metrics}},
      {"log-format", "FORMAT", "Form of the log: text, or json (JSON lines)",
       Text{&options.log.format, {"text", "json"}}},
      {"log-level", "LEVEL", "Least level of the lines in the log",
       Text{&options.log.level, {"debug", "info", "warning", "error", "off"}}},
      {"log-lines", "N",
       "Most lines of the log in a second, of calls and of other lines each; 0: no limit",
       Whole{&options.log.lines_per_second, 0, 1U << 20}},
      {"drain-seconds", "SECONDS", "How long calls may continue after SIGTERM [s]",
       Whole{&options.drain_seconds, 0, 86400}},
  };
}

}  // namespace

std::vector<Setting> settings(Options& options) {
  std::vector<Setting> all = connection_settings(options.server);
  for (const auto& more : {scene_settings(options.server), other_settings(options)})
    all.insert(all.end(), more.begin(), more.end());
  return all;
}

}  // namespace lucerna::config
