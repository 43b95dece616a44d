#include "server/rpc/handlers/scenes.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "server/rpc/messages/checks.h"
#include "server/rpc/messages/convert.h"
#include "server/rpc/messages/errors.h"
#include "server/rpc/messages/paging.h"

namespace lucerna::rpc {
namespace {
// Processor time of one entry [s], rounded up.
constexpr double kLightSeconds = 1e-6;
constexpr double kSceneSeconds = 2e-6;
// Of the spectra in one page of lights, which ends with the light that fills it: a page stays far
// below the least message that clients take by themselves (4 MiB).
constexpr std::size_t kPageBytes = std::size_t{1} << 20;
constexpr double kAssetSeconds = 1e-6;
constexpr std::size_t kMostNameBytes = 4096;

absl::Status check_lease(double lease_s) {
  if (lease_s >= 0 && std::isfinite(lease_s)) return absl::OkStatus();
  return bad_field("lease_s", fmt::format("{}", lease_s), "[0, inf)");
}

absl::Status check_digest(const std::string& field, const std::string& digest) {
  if (digest.size() == kSha256Bytes) return absl::OkStatus();
  return bad_field(field, fmt::format("{} bytes", digest.size()), "the 32 bytes of a SHA-256");
}

/// Whether it is what scene files may call a file: relative, without `.` and `..`.
bool is_plain(const std::string& name) {
  if (name.empty() || name.size() > kMostNameBytes || name.find('\0') != std::string::npos)
    return false;
  for (std::size_t begin = 0; begin <= name.size();) {
    const std::size_t end = std::min(name.find('/', begin), name.size());
    const std::string part = name.substr(begin, end - begin);
    if (part.empty() || part == "." || part == "..") return false;
    begin = end + 1;
  }
  return true;
}

absl::StatusOr<Manifest> check_manifest(const Context& context, const v1::SceneManifest& given) {
  const auto n = static_cast<std::size_t>(given.assets_size());
  if (n > context.limits.max_batch_items) {
    return over_limit("manifest.assets", n, context.limits.max_batch_items);
  }
  Manifest manifest{given.main(), {}};
  for (std::size_t i = 0; i < n; ++i) {
    const v1::NamedAsset& asset = given.assets(static_cast<int>(i));
    const std::string field = fmt::format("manifest.assets[{}]", i);
    if (!is_plain(asset.name())) {
      return bad_field(
          field + ".name", fmt::format("\"{}\"", asset.name()),
          fmt::format("a relative name of at most {} bytes without . and ..", kMostNameBytes));
    }
    if (!asset.sha256().empty()) {
      if (absl::Status s = check_digest(field + ".sha256", asset.sha256()); !s.ok()) return s;
    }
    if (!manifest.assets.emplace(asset.name(), asset.sha256()).second) {
      return bad_field(field + ".name", fmt::format("\"{}\"", asset.name()), "each name once");
    }
  }
  if (!manifest.assets.contains(manifest.main)) {
    return bad_field("manifest.main", fmt::format("\"{}\"", manifest.main),
                     "a name among manifest.assets");
  }
  return manifest;
}

}  // namespace

Prepared find_missing_assets(const Context& context, const v1::FindMissingAssetsRequest& request,
                             v1::FindMissingAssetsResponse* response) {
  const auto n = static_cast<std::size_t>(request.sha256_size());
  if (n > context.limits.max_batch_items) {
    return over_limit("sha256", n, context.limits.max_batch_items);
  }
  for (std::size_t i = 0; i < n; ++i) {
    const std::string& digest = request.sha256(static_cast<int>(i));
    if (absl::Status s = check_digest(fmt::format("sha256[{}]", i), digest); !s.ok()) return s;
  }
  Task task;
  task.predicted_s = kAssetSeconds * static_cast<double>(n);
  task.run = [&assets = context.assets, &request, response](const std::stop_token&) {
    std::set<std::string> seen;
    for (const std::string& digest : request.sha256()) {
      if (!seen.insert(digest).second) continue;
      const AssetStore::Held held = assets.held(digest);
      if (held.whole) continue;
      response->add_missing_sha256(digest);
      response->add_received_bytes(held.bytes);
    }
    return absl::OkStatus();
  };
  return task;
}

Prepared load_scene(const Context& context, const v1::LoadSceneRequest& request,
                    v1::LoadSceneResponse* response) {
  if (request.has_lease_s()) {
    if (absl::Status s = check_lease(request.lease_s()); !s.ok()) return s;
  }
  Manifest manifest;
  if (request.has_manifest()) {
    absl::StatusOr<Manifest> checked = check_manifest(context, request.manifest());
    if (!checked.ok()) return checked.status();
    manifest = *std::move(checked);
  } else if (request.path().empty()) {
    return bad_field("path", "\"\"", "the name of a scene file under the server's scene root");
  }
  Task task;
  task.bulk = true;
  task.cost = response->mutable_cost();
  task.run = [&scenes = context.scenes, &request, manifest = std::move(manifest),
              response](const std::stop_token& stop) {
    const LoadOptions options{request.lease_s(), stop};
    const absl::StatusOr<LoadedScene> loaded = request.has_manifest()
                                                   ? scenes.load(manifest, options)
                                                   : scenes.load(request.path(), options);
    if (!loaded.ok()) return load_error(loaded.status());
    for (const MissingAsset& asset : loaded->missing) {
      v1::NamedAsset* missing = response->add_missing();
      missing->set_name(asset.name);
      missing->set_sha256(asset.digest);
    }
    if (loaded->stored.scene == nullptr) return absl::OkStatus();
    response->set_scene_id(loaded->stored.scene->id());
    response->set_already_loaded(loaded->already_loaded);
    response->set_lease_id(loaded->lease.id);
    response->set_lease_s(loaded->lease.seconds);
    add_remarks(*loaded->stored.scene, response->mutable_remarks());
    return absl::OkStatus();
  };
  return task;
}

Prepared get_scene(const Context& context, const v1::GetSceneRequest& request,
                   v1::GetSceneResponse* response) {
  const std::optional<StoredScene> stored = context.scenes.stored(request.scene_id());
  if (!stored) return unknown_scene(request.scene_id());
  Task task;
  task.predicted_s = kSceneSeconds * static_cast<double>(1 + stored->scene->remarks().size() +
                                                         stored->scene->assets().size());
  task.run = [stored = *stored, response](const std::stop_token&) {
    set_summary(stored, response->mutable_summary());
    add_remarks(*stored.scene, response->mutable_remarks());
    set_parts(*stored.scene, response);
    return absl::OkStatus();
  };
  return task;
}

Prepared list_scenes(const Context& context, const v1::ListScenesRequest& request,
                     v1::ListScenesResponse* response) {
  const auto page_size = check_page_size(request.page_size(), context.limits.max_page_size);
  if (!page_size.ok()) return page_size.status();
  const auto after = page_position("scenes", request.page_token());
  if (!after.ok()) return after.status();
  Task task;
  task.predicted_s =
      kSceneSeconds * static_cast<double>(std::min(*page_size, context.scenes.size()));
  task.run = [&scenes = context.scenes, after = *after, size = *page_size,
              response](const std::stop_token&) {
    const std::vector<StoredScene> found = scenes.list(after, size + 1);
    for (std::size_t i = 0; i < found.size() && i < size; ++i) {
      set_summary(found[i], response->add_scenes());
    }
    if (found.size() > size) {
      response->set_next_page_token(page_token("scenes", found[size - 1].scene->id()));
    }
    return absl::OkStatus();
  };
  return task;
}

Prepared list_lights(const Context& context, const v1::ListLightsRequest& request,
                     v1::ListLightsResponse* response) {
  const auto scene = find_scene(context, request.scene_id());
  if (!scene.ok()) return scene.status();
  const auto page_size = check_page_size(request.page_size(), context.limits.max_page_size);
  if (!page_size.ok()) return page_size.status();
  const std::size_t n = (*scene)->lights().size();
  const auto start = page_start("lights", request.page_token(), n);
  if (!start.ok()) return start.status();
  const std::size_t end = std::min(n, *start + *page_size);
  Task task;
  task.predicted_s = kLightSeconds * static_cast<double>(end - *start);
  task.run = [scene = *scene, start = *start, end, n, response](const std::stop_token&) {
    std::size_t i = start, bytes = 0;
    // Spectra of many samples make shorter pages.
    for (; i < end && bytes < kPageBytes; ++i) {
      v1::Light* light = response->add_lights();
      set_light(*scene, static_cast<std::uint32_t>(i), light);
      bytes += light->spectrum().ByteSizeLong();
    }
    if (i < n) response->set_next_page_token(page_token("lights", i));
    return absl::OkStatus();
  };
  return task;
}

Prepared renew_lease(const Context& context, const v1::RenewLeaseRequest& request,
                     v1::RenewLeaseResponse* response) {
  const auto scene = find_scene(context, request.scene_id());
  if (!scene.ok()) return scene.status();
  if (!(request.lease_s() > 0)) {
    return bad_field("lease_s", fmt::format("{}", request.lease_s()), "(0, inf)");
  }
  if (absl::Status s = check_lease(request.lease_s()); !s.ok()) return s;
  Task task;
  task.predicted_s = kSceneSeconds;
  task.run = [&scenes = context.scenes, &request, response](const std::stop_token&) {
    const absl::StatusOr<Lease> lease =
        scenes.lease(request.scene_id(), request.lease_id(), request.lease_s());
    if (!lease.ok()) return lease.status();
    response->set_lease_id(lease->id);
    response->set_lease_s(lease->seconds);
    return absl::OkStatus();
  };
  return task;
}

Prepared release_scene(const Context& context, const v1::ReleaseSceneRequest& request,
                       v1::ReleaseSceneResponse* response) {
  if (const auto scene = find_scene(context, request.scene_id()); !scene.ok()) {
    return scene.status();
  }
  Task task;
  task.predicted_s = 1;  // freeing a large scene takes its time
  task.run = [&scenes = context.scenes, &request, response](const std::stop_token&) {
    const absl::StatusOr<bool> gone = scenes.release(request.scene_id(), request.lease_id());
    if (!gone.ok()) return gone.status();
    response->set_still_loaded(!*gone);
    return absl::OkStatus();
  };
  return task;
}

}  // namespace lucerna::rpc
