#include "server/rpc/handlers/list_handlers.h"

#include <algorithm>

#include "proto/common/status_macros.h"
#include "server/rpc/messages/checks.h"
#include "server/rpc/messages/convert.h"
#include "server/rpc/messages/paging.h"

namespace lucerna::rpc {
namespace {

// Predicted processor time of one entry [s], rounded up.
constexpr double kListedLightSeconds = 1e-6;
constexpr double kListedSceneSeconds = 2e-6;
// Time of listing the files under the scene root [s].
constexpr double kListingSeconds = 0.1;
// A page of lights ends when its names and spectra have this size.  It stays far below the default
// message limit of clients (4 MiB).
constexpr std::size_t kPageBytes = std::size_t{1} << 20;

/// The list of a scene's lights, for page tokens.
std::string light_list(const Scene& scene) { return "lights of " + scene.id(); }

}  // namespace

Prepared handle_list_scenes(const Context& context, const v1::ListScenesRequest& request,
                            v1::ListScenesResponse* response) {
  LUCERNA_ASSIGN_OR_RETURN(const std::size_t size,
                           check_page_size(request.page_size(), context.limits.max_page_size));
  LUCERNA_ASSIGN_OR_RETURN(const std::string after, page_position("scenes", request.page_token()));
  Task task;
  task.predicted_s =
      kListedSceneSeconds * static_cast<double>(std::min(size, context.scenes.size()));
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

Prepared handle_list_available_scenes(const Context& context,
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

Prepared handle_list_lights(const Context& context, const v1::ListLightsRequest& request,
                            v1::ListLightsResponse* response) {
  LUCERNA_ASSIGN_OR_RETURN(const auto scene, find_scene(context, request.scene_id()));
  LUCERNA_ASSIGN_OR_RETURN(const std::size_t page_size,
                           check_page_size(request.page_size(), context.limits.max_page_size));
  const std::size_t n = scene->lights().size();
  LUCERNA_ASSIGN_OR_RETURN(const std::size_t start,
                           page_start(light_list(*scene), request.page_token(), n));
  const std::size_t end = std::min(n, start + page_size);
  Task task;
  task.predicted_s = kListedLightSeconds * static_cast<double>(end - start);
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

Prepared handle_list_leases(const Context& context, const v1::ListLeasesRequest& request,
                            v1::ListLeasesResponse* response) {
  LUCERNA_ASSIGN_OR_RETURN(const std::size_t size,
                           check_page_size(request.page_size(), context.limits.max_page_size));
  LUCERNA_ASSIGN_OR_RETURN(const std::string after, page_position("leases", request.page_token()));
  Task task;
  task.predicted_s = kListedSceneSeconds * static_cast<double>(1 + context.scenes.size());
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
