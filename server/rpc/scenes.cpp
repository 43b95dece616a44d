#include "server/rpc/scenes.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "server/rpc/checks.h"
#include "server/rpc/convert.h"
#include "server/rpc/errors.h"
#include "server/rpc/paging.h"

namespace lucerna::rpc {
namespace {
// Processor time of one entry [s], rounded up.
constexpr double kLightSeconds = 1e-6;
constexpr double kSceneSeconds = 2e-6;
// Of the spectra in one page of lights, which ends with the light that fills it: a page stays far
// below the least message that clients take by themselves (4 MiB).
constexpr std::size_t kPageBytes = std::size_t{1} << 20;
}  // namespace

Prepared load_scene(const Context& context, const v1::LoadSceneRequest& request,
                    v1::LoadSceneResponse* response) {
  if (request.has_lease_s() && !(request.lease_s() >= 0 && std::isfinite(request.lease_s()))) {
    return bad_field("lease_s", fmt::format("{}", request.lease_s()), "[0, inf)");
  }
  if (request.has_manifest()) {
    return unimplemented(
        "scenes of uploaded assets are not taken yet: set path, to a file under the server's "
        "scene root");
  }
  if (request.path().empty()) {
    return bad_field("path", "\"\"", "the name of a scene file under the server's scene root");
  }
  Task task;
  task.bulk = true;
  task.cost = response->mutable_cost();
  task.run = [&scenes = context.scenes, path = request.path(),
              response](const std::stop_token& stop) {
    const absl::StatusOr<LoadedScene> loaded = scenes.load(path, stop);
    if (!loaded.ok()) return loaded.status();
    response->set_scene_id(loaded->stored.scene->id());
    response->set_already_loaded(loaded->already_loaded);
    add_remarks(*loaded->stored.scene, response->mutable_remarks());
    return absl::OkStatus();
  };
  return task;
}

Prepared get_scene(const Context& context, const v1::GetSceneRequest& request,
                   v1::GetSceneResponse* response) {
  const auto scene = find_scene(context, request.scene_id());
  if (!scene.ok()) return scene.status();
  Task task;
  task.predicted_s = kSceneSeconds * static_cast<double>(1 + (*scene)->remarks().size() +
                                                         (*scene)->assets().size());
  task.run = [scene = *scene, path = context.scenes.path(request.scene_id()),
              response](const std::stop_token&) {
    set_summary({scene, path}, response->mutable_summary());
    add_remarks(*scene, response->mutable_remarks());
    set_parts(*scene, response);
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

Prepared release_scene(const Context& context, const v1::ReleaseSceneRequest& request,
                       v1::ReleaseSceneResponse*) {
  const auto scene = find_scene(context, request.scene_id());
  if (!scene.ok()) return scene.status();
  Task task;
  task.predicted_s = 1;  // freeing a large scene takes its time
  task.run = [&scenes = context.scenes, id = request.scene_id()](const std::stop_token&) {
    return scenes.release(id) ? absl::OkStatus() : unknown_scene(id);
  };
  return task;
}

}  // namespace lucerna::rpc
