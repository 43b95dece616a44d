#include "server/rpc/handlers/scenes.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "proto/common/defaults.h"
#include "proto/common/status_macros.h"
#include "server/gltf/blender_levels.h"
#include "server/rpc/handlers/light_edits.h"
#include "server/rpc/messages/checks.h"
#include "server/rpc/messages/convert.h"
#include "server/rpc/messages/errors.h"
#include "server/rpc/messages/paging.h"
#include "server/store/scene_file.h"

namespace lucerna::rpc {
namespace {
// Predicted processor time of one entry [s], rounded up.
constexpr double kLightSeconds = 1e-6;
constexpr double kSceneSeconds = 2e-6;
constexpr double kAssetSeconds = 1e-6;
// Time of listing the files under the scene root, and of freeing a large scene [s].
constexpr double kListingSeconds = 0.1;
constexpr double kReleaseSeconds = 1;
// A page of lights ends when its names and spectra have this size.  It stays far below the default
// message limit of clients (4 MiB).
constexpr std::size_t kPageBytes = std::size_t{1} << 20;

absl::Status check_digest(const std::string& field, const std::string& digest) {
  if (digest.size() == kSha256Bytes) return absl::OkStatus();
  return bad_field(field, fmt::format("{} bytes", digest.size()), "the 32 bytes of a SHA-256");
}

/// Whether scene files may use this name for a file: relative, without `.` and `..`.
bool is_plain(const std::string& name, std::size_t most_bytes) {
  if (name.empty() || name.size() > most_bytes || name.find('\0') != std::string::npos)
    return false;
  for (std::size_t begin = 0; begin <= name.size();) {
    const std::size_t end = std::min(name.find('/', begin), name.size());
    const std::string part = name.substr(begin, end - begin);
    if (part.empty() || part == "." || part == "..") return false;
    begin = end + 1;
  }
  return true;
}

absl::StatusOr<gltf::BlenderLightingMode> check_mode(v1::BlenderLightingMode mode) {
  switch (mode) {
    case v1::BLENDER_LIGHTING_MODE_STANDARD:
      return gltf::BlenderLightingMode::kStandard;
    case v1::BLENDER_LIGHTING_MODE_UNITLESS:
      return gltf::BlenderLightingMode::kUnitless;
    case v1::BLENDER_LIGHTING_MODE_RAW:
      return gltf::BlenderLightingMode::kRaw;
    default:
      break;
  }
  return bad_field("blender.mode", fmt::format("{}", static_cast<int>(mode)),
                   fmt::format("[1, {}], the numbers of BlenderLightingMode",
                               static_cast<int>(v1::BlenderLightingMode_MAX)));
}

/// The factors for the scene file `name`.
absl::StatusOr<LevelFactors> check_blender(const v1::BlenderLevels& blender,
                                           const std::string& name) {
  LUCERNA_ASSIGN_OR_RETURN(const gltf::BlenderLightingMode mode, check_mode(blender.mode()));
  const double lumens_per_watt =
      blender.has_lumens_per_watt() ? blender.lumens_per_watt() : gltf::kBlenderLumensPerWatt;
  if (!(lumens_per_watt > 0 && lumens_per_watt <= kMostLumensPerWatt)) {
    return bad_field("blender.lumens_per_watt", fmt::format("{}", lumens_per_watt),
                     fmt::format("(0, {}]", kMostLumensPerWatt));
  }
  if (!is_gltf_name(name)) {
    return bad_field(
        "blender", fmt::format("{} for \"{}\"", v1::BlenderLightingMode_Name(blender.mode()), name),
        "only for .gltf and .glb files");
  }
  return gltf::blender_level_factors(mode, lumens_per_watt);
}

void set_loaded(const LoadedScene& loaded, v1::LoadSceneResponse* response) {
  for (const MissingAsset& asset : loaded.missing) {
    v1::NamedAsset* missing = response->add_missing();
    missing->set_name(asset.name);
    missing->set_sha256(asset.digest);
  }
  if (loaded.stored.scene == nullptr) return;
  response->set_scene_id(loaded.stored.scene->id());
  response->set_already_loaded(loaded.already_loaded);
  response->set_lease_id(loaded.lease.id);
  response->set_lease_s(loaded.lease.seconds);
  add_remarks(*loaded.stored.scene, response->mutable_remarks());
}

/// The list of a scene's lights, for page tokens.
std::string light_list(const Scene& scene) { return "lights of " + scene.id(); }

}  // namespace

absl::Status check_lease(double lease_s) {
  if (lease_s >= 0 && std::isfinite(lease_s)) return absl::OkStatus();
  return bad_field("lease_s", fmt::format("{}", lease_s), "[0, inf)");
}

absl::StatusOr<Manifest> check_manifest(const Context& context, const std::string& field,
                                        const v1::SceneManifest& given) {
  const auto n = static_cast<std::size_t>(given.assets_size());
  if (n > context.limits.max_batch_items) {
    return over_limit(field + ".assets", n, context.limits.max_batch_items);
  }
  Manifest manifest{given.main(), {}};
  for (std::size_t i = 0; i < n; ++i) {
    const v1::NamedAsset& asset = given.assets(static_cast<int>(i));
    const std::string entry = fmt::format("{}.assets[{}]", field, i);
    if (!is_plain(asset.name(), context.limits.max_name_bytes)) {
      return bad_field(entry + ".name", fmt::format("\"{}\"", asset.name()),
                       fmt::format("a relative name of at most {} bytes without . and ..",
                                   context.limits.max_name_bytes));
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
                     fmt::format("a name among {}.assets", field));
  }
  return manifest;
}

Prepared find_missing_assets(const Context& context, const v1::FindMissingAssetsRequest& request,
                             v1::FindMissingAssetsResponse* response) {
  const auto n = static_cast<std::size_t>(request.sha256_size());
  if (n > context.limits.max_batch_items) {
    return over_limit("sha256", n, context.limits.max_batch_items);
  }
  for (std::size_t i = 0; i < n; ++i) {
    const std::string& digest = request.sha256(static_cast<int>(i));
    LUCERNA_RETURN_IF_ERROR(check_digest(fmt::format("sha256[{}]", i), digest));
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
  if (request.has_lease_s()) LUCERNA_RETURN_IF_ERROR(check_lease(request.lease_s()));
  Manifest manifest;
  if (request.has_manifest()) {
    LUCERNA_ASSIGN_OR_RETURN(manifest, check_manifest(context, "manifest", request.manifest()));
  } else if (request.path().empty()) {
    return bad_field("path", "\"\"", "the name of a scene file under the server's scene root");
  } else if (request.path().size() > context.limits.max_name_bytes) {
    return bad_field("path", fmt::format("{} bytes", request.path().size()),
                     fmt::format("at most {} bytes", context.limits.max_name_bytes));
  }
  std::optional<LevelFactors> factors;
  if (request.has_blender()) {
    LUCERNA_ASSIGN_OR_RETURN(
        factors,
        check_blender(request.blender(), request.has_manifest() ? manifest.main : request.path()));
  }
  LUCERNA_RETURN_IF_ERROR(check_edits(context, request.edits()));
  Task task;
  task.bulk = true;
  task.kind = JobKind::kLoad;
  task.cost = response->mutable_cost();
  task.run = [context, &request, manifest = std::move(manifest), factors,
              response](const std::stop_token& stop) -> absl::Status {
    // The lease is that of the revision, if there are edits.
    const double lease_s = request.lease_s();
    const LoadOptions options{request.edits().empty() ? lease_s : 0, stop, factors, context.caller};
    absl::StatusOr<LoadedScene> loaded = request.has_manifest()
                                             ? context.scenes.load(manifest, options)
                                             : context.scenes.load(request.path(), options);
    if (!loaded.ok()) return load_error(loaded.status());
    if (!request.edits().empty() && loaded->stored.scene != nullptr) {
      LUCERNA_ASSIGN_OR_RETURN(EditedLights edited, edited_lights(context, *loaded->stored.scene,
                                                                  request.edits(), stop));
      if (!edited.missing.empty()) {
        loaded->stored.scene = nullptr;
        loaded->missing = std::move(edited.missing);
      } else {
        loaded = context.scenes.revise(loaded->stored, std::move(edited.edits),
                                       {lease_s, stop, {}, context.caller}, edited.memory.get());
        if (!loaded.ok()) return load_error(loaded.status());
      }
    }
    set_loaded(*loaded, response);
    return absl::OkStatus();
  };
  return task;
}

Prepared get_scene(const Context& context, const v1::GetSceneRequest& request,
                   v1::GetSceneResponse* response) {
  LUCERNA_RETURN_IF_ERROR(check_scene_id(request.scene_id()));
  const std::optional<StoredScene> stored = context.scenes.stored(request.scene_id());
  if (!stored) return unknown_scene(request.scene_id());
  Task task;
  task.predicted_s = kSceneSeconds * static_cast<double>(1 + stored->scene->remarks().size() +
                                                         stored->scene->assets().size());
  task.run = [stored = *stored, response](const std::stop_token&) {
    set_summary(stored, response->mutable_summary());
    add_remarks(*stored.scene, response->mutable_remarks());
    set_parts(*stored.scene, response);
    set_contents(*stored.scene, response->mutable_contents());
    return absl::OkStatus();
  };
  return task;
}

Prepared list_scenes(const Context& context, const v1::ListScenesRequest& request,
                     v1::ListScenesResponse* response) {
  LUCERNA_ASSIGN_OR_RETURN(const std::size_t size,
                           check_page_size(request.page_size(), context.limits.max_page_size));
  LUCERNA_ASSIGN_OR_RETURN(const std::string after, page_position("scenes", request.page_token()));
  Task task;
  task.predicted_s = kSceneSeconds * static_cast<double>(std::min(size, context.scenes.size()));
  task.run = [&scenes = context.scenes, after, size, response](const std::stop_token&) {
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

Prepared list_available_scenes(const Context& context,
                               const v1::ListAvailableScenesRequest& request,
                               v1::ListAvailableScenesResponse* response) {
  LUCERNA_ASSIGN_OR_RETURN(const std::size_t size,
                           check_page_size(request.page_size(), context.limits.max_page_size));
  LUCERNA_ASSIGN_OR_RETURN(const std::string after,
                           page_position("available", request.page_token()));
  Task task;
  task.predicted_s = kListingSeconds;
  task.run = [&scenes = context.scenes, after, size, response](const std::stop_token&) {
    const FileListing files = scenes.available();
    response->set_root(scenes.root());
    response->set_incomplete(files.incomplete);
    const auto begin = std::upper_bound(files.paths.begin(), files.paths.end(), after);
    const auto left = static_cast<std::size_t>(files.paths.end() - begin);
    const auto end = begin + static_cast<std::ptrdiff_t>(std::min(size, left));
    response->mutable_paths()->Add(begin, end);
    if (left > size) response->set_next_page_token(page_token("available", *std::prev(end)));
    return absl::OkStatus();
  };
  return task;
}

Prepared list_lights(const Context& context, const v1::ListLightsRequest& request,
                     v1::ListLightsResponse* response) {
  LUCERNA_ASSIGN_OR_RETURN(const auto scene, find_scene(context, request.scene_id()));
  LUCERNA_ASSIGN_OR_RETURN(const std::size_t page_size,
                           check_page_size(request.page_size(), context.limits.max_page_size));
  const std::size_t n = scene->lights().size();
  LUCERNA_ASSIGN_OR_RETURN(const std::size_t start,
                           page_start(light_list(*scene), request.page_token(), n));
  const std::size_t end = std::min(n, start + page_size);
  Task task;
  task.predicted_s = kLightSeconds * static_cast<double>(end - start);
  task.run = [scene, start, end, n, response](const std::stop_token&) {
    std::size_t i = start, bytes = 0;
    // Names and spectra of many samples make shorter pages.
    for (; i < end && bytes < kPageBytes; ++i) {
      v1::Light* light = response->add_lights();
      set_light(*scene, static_cast<std::uint32_t>(i), light);
      bytes += light->spectrum().ByteSizeLong() + light->name().size();
    }
    if (i < n) response->set_next_page_token(page_token(light_list(*scene), i));
    return absl::OkStatus();
  };
  return task;
}

Prepared renew_lease(const Context& context, const v1::RenewLeaseRequest& request,
                     v1::RenewLeaseResponse* response) {
  LUCERNA_RETURN_IF_ERROR(find_scene(context, request.scene_id()).status());
  if (!(request.lease_s() > 0)) {
    return bad_field("lease_s", fmt::format("{}", request.lease_s()), "(0, inf)");
  }
  LUCERNA_RETURN_IF_ERROR(check_lease(request.lease_s()));
  Task task;
  task.predicted_s = kSceneSeconds;
  task.run = [&scenes = context.scenes, &request, caller = context.caller,
              response](const std::stop_token&) -> absl::Status {
    const absl::StatusOr<Lease> lease =
        scenes.lease(request.scene_id(), request.lease_id(), request.lease_s(), caller);
    if (!lease.ok()) return load_error(lease.status());
    response->set_lease_id(lease->id);
    response->set_lease_s(lease->seconds);
    return absl::OkStatus();
  };
  return task;
}

Prepared release_scene(const Context& context, const v1::ReleaseSceneRequest& request,
                       v1::ReleaseSceneResponse* response) {
  LUCERNA_RETURN_IF_ERROR(find_scene(context, request.scene_id()).status());
  Task task;
  if (request.break_leases() && !context.caller.admin) {
    return absl::PermissionDeniedError("break_leases needs the role admin");
  }
  task.predicted_s = kReleaseSeconds;
  task.run = [&scenes = context.scenes, &request, caller = context.caller,
              response](const std::stop_token&) -> absl::Status {
    if (request.break_leases()) return scenes.break_leases(request.scene_id());
    LUCERNA_ASSIGN_OR_RETURN(const bool gone,
                             scenes.release(request.scene_id(), request.lease_id(), caller));
    response->set_still_loaded(!gone);
    return absl::OkStatus();
  };
  return task;
}

Prepared list_leases(const Context& context, const v1::ListLeasesRequest& request,
                     v1::ListLeasesResponse* response) {
  LUCERNA_ASSIGN_OR_RETURN(const std::size_t size,
                           check_page_size(request.page_size(), context.limits.max_page_size));
  LUCERNA_ASSIGN_OR_RETURN(const std::string after, page_position("leases", request.page_token()));
  Task task;
  task.predicted_s = kSceneSeconds * static_cast<double>(1 + context.scenes.size());
  task.run = [&scenes = context.scenes, caller = context.caller, after, size,
              response](const std::stop_token&) {
    const std::vector<ListedLease> found = scenes.leases(caller, after, size + 1);
    for (std::size_t i = 0; i < found.size() && i < size; ++i) {
      v1::SceneLease* lease = response->add_leases();
      lease->set_lease_id(found[i].id);
      lease->set_scene_id(found[i].scene_id);
      lease->set_path(found[i].path);
      lease->set_owner(found[i].owner);
      lease->set_left_s(found[i].left_s);
    }
    if (found.size() > size) {
      response->set_next_page_token(page_token("leases", found[size - 1].id));
    }
    return absl::OkStatus();
  };
  return task;
}

}  // namespace lucerna::rpc
