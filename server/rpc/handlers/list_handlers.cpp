#include "server/rpc/handlers/list_handlers.h"

#include <algorithm>
#include <functional>
#include <span>

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

Prepared handle_list_scenes(const CallContext& context, const v1::ListScenesRequest& request,
                            v1::ListScenesResponse* response) {
  LUCERNA_ASSIGN_OR_RETURN(const Page page,
                           check_page(request, "scenes", context.limits.max_page_size));
  const std::size_t most = std::min(page.size, context.scenes.size());
  const auto run = [&scenes = context.scenes, page, response](const std::stop_token&) {
    put_page(
        page, scenes.list(page.after, page.size + 1),
        [](const StoredScene& stored) { return stored.scene->id(); },
        [&](const StoredScene& stored) { set_summary(stored, response->add_scenes()); }, response);
    return absl::OkStatus();
  };
  return Task{.predicted_s = kListedSceneSeconds * static_cast<double>(most), .run = run};
}

Prepared handle_list_available_scenes(const CallContext& context,
                                      const v1::ListAvailableScenesRequest& request,
                                      v1::ListAvailableScenesResponse* response) {
  LUCERNA_ASSIGN_OR_RETURN(const Page page,
                           check_page(request, "available", context.limits.max_page_size));
  const auto run = [&scenes = context.scenes, page, response](const std::stop_token&) {
    const FileListing files = scenes.available();
    response->set_root(scenes.root());
    response->set_incomplete(files.incomplete);
    const auto begin = std::upper_bound(files.paths.begin(), files.paths.end(), page.after);
    put_page(
        page, std::span(begin, files.paths.end()), std::identity(),
        [&](const std::string& path) { response->add_paths(path); }, response);
    return absl::OkStatus();
  };
  return Task{.predicted_s = kListingSeconds, .run = run};
}

Prepared handle_list_lights(const CallContext& context, const v1::ListLightsRequest& request,
                            v1::ListLightsResponse* response) {
  LUCERNA_ASSIGN_OR_RETURN(const auto scene, find_scene(context, request.scene_id()));
  LUCERNA_ASSIGN_OR_RETURN(const std::size_t page_size,
                           check_page_size(request.page_size(), context.limits.max_page_size));
  const std::size_t n = scene->lights().size();
  LUCERNA_ASSIGN_OR_RETURN(const std::size_t start,
                           page_start(light_list(*scene), request.page_token(), n));
  const std::size_t end = std::min(n, start + page_size);
  const auto run = [scene, start, end, n, response](const std::stop_token&) {
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
  return Task{.predicted_s = kListedLightSeconds * static_cast<double>(end - start), .run = run};
}

Prepared handle_list_leases(const CallContext& context, const v1::ListLeasesRequest& request,
                            v1::ListLeasesResponse* response) {
  LUCERNA_ASSIGN_OR_RETURN(const Page page,
                           check_page(request, "leases", context.limits.max_page_size));
  const std::size_t scenes = context.scenes.size();
  const auto add = [response](const ListedLease& listed) {
    v1::SceneLease* lease = response->add_leases();
    lease->set_lease_id(listed.id);
    lease->set_scene_id(listed.scene_id);
    lease->set_path(listed.path);
    lease->set_owner(listed.owner);
    lease->set_left_s(listed.left_s);
  };
  const auto run = [&store = context.scenes, caller = context.caller, page, add,
                    response](const std::stop_token&) {
    put_page(
        page, store.leases(caller, page.after, page.size + 1),
        [](const ListedLease& listed) { return listed.id; }, add, response);
    return absl::OkStatus();
  };
  return Task{.predicted_s = kListedSceneSeconds * static_cast<double>(1 + scenes), .run = run};
}

}  // namespace lucerna::rpc
