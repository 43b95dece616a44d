#include "server/rpc/messages/scene_manifest.h"

#include <absl/strings/str_split.h>
#include <fmt/core.h>

#include <algorithm>
#include <vector>

#include "proto/common/sha256.h"
#include "proto/common/status_macros.h"
#include "server/rpc/messages/errors.h"

namespace lucerna::rpc {
namespace {

/// Whether scene files may use this name for a file: relative, without `.` and `..`.
bool is_plain(const std::string& name, std::size_t most_bytes) {
  if (name.empty() || name.size() > most_bytes || name.find('\0') != std::string::npos)
    return false;
  const std::vector<std::string> parts = absl::StrSplit(name, '/');
  return std::ranges::none_of(
      parts, [](const std::string& part) { return part.empty() || part == "." || part == ".."; });
}

}  // namespace

absl::Status check_digest(const std::string& field, const std::string& digest) {
  if (digest.size() == kSha256Bytes) return absl::OkStatus();
  return bad_field(field, fmt::format("{} bytes", digest.size()), "the 32 bytes of a SHA-256");
}

absl::Status check_path(const CallContext& context, const std::string& field,
                        const std::string& path) {
  if (path.empty())
    return bad_field(field, "\"\"", "the name of a scene file under the server's scene root");
  if (path.size() <= context.limits.max_name_bytes) return absl::OkStatus();
  return bad_field(field, fmt::format("{} bytes", path.size()), "at most {} bytes",
                   context.limits.max_name_bytes);
}

absl::StatusOr<Manifest> check_manifest(const CallContext& context, const std::string& field,
                                        const v1::SceneManifest& given) {
  const auto n = static_cast<std::size_t>(given.assets_size());
  LUCERNA_RETURN_IF_ERROR(check_limit(field + ".assets", n, context.limits.max_batch_items));
  Manifest manifest{given.main(), {}};
  for (std::size_t i = 0; i < n; ++i) {
    const v1::NamedAsset& asset = given.assets(static_cast<int>(i));
    const std::string entry = fmt::format("{}.assets[{}]", field, i);
    if (!is_plain(asset.name(), context.limits.max_name_bytes)) {
      return bad_field(entry + ".name", fmt::format("\"{}\"", asset.name()),
                       "a relative name of at most {} bytes without . and ..",
                       context.limits.max_name_bytes);
    }
    if (!asset.sha256().empty()) {
      LUCERNA_RETURN_IF_ERROR(check_digest(entry + ".sha256", asset.sha256()));
    }
    if (!manifest.assets.emplace(asset.name(), asset.sha256()).second) {
      return bad_field(entry + ".name", fmt::format("\"{}\"", asset.name()), "each name once");
    }
  }
  if (!manifest.assets.contains(manifest.main)) {
    return bad_field(field + ".main", fmt::format("\"{}\"", manifest.main),
                     "a name among {}.assets", field);
  }
  return manifest;
}

}  // namespace lucerna::rpc
