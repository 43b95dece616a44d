#include "server/rpc/stats.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "server/monitor/process_figures.h"

namespace lucerna::rpc {
namespace {

/// The memory of all scenes.  Parts that revisions share count once.
std::map<std::string, std::uint64_t> bytes_by_part(const std::vector<StoredScene>& scenes) {
  std::map<std::string, std::uint64_t> bytes;
  std::set<const void*> counted;
  const auto add = [&](const Scene& scene, const std::vector<ScenePart>& without) {
    if (!counted.insert(&scene).second) return;
    for (const ScenePart& part : scene.parts()) {
      const bool shared = std::any_of(without.begin(), without.end(), [&](const ScenePart& other) {
        return part.name == other.name && part.bytes == other.bytes &&
               part.build_ms == other.build_ms;  // two parts never take the same time to the bit
      });
      if (!shared) bytes[part.name] += part.bytes;
    }
  };
  for (const StoredScene& stored : scenes) {
    const Scene* const loaded = stored.scene->loaded().get();
    // A revision keeps what it was made from, even if that is not in the store any more.
    if (loaded != nullptr) add(*loaded, {});
    std::vector<ScenePart> without;
    if (loaded != nullptr) without = loaded->parts();
    // Several revisions may have the same moved surfaces.
    if (stored.scene->has_own_geometry() && !counted.insert(&stored.scene->geometry()).second)
      for (ScenePart& part : stored.scene->geometry().parts()) without.push_back(std::move(part));
    add(*stored.scene, without);
  }
  return bytes;
}

}  // namespace

v1::GetStatsResponse stats(const Runtime& runtime) {
  using std::chrono::duration;
  v1::GetStatsResponse out;
  out.set_time_s(duration<double>(std::chrono::system_clock::now().time_since_epoch()).count());
  out.set_uptime_s(duration<double>(std::chrono::steady_clock::now() - runtime.started).count());
  runtime.statistics.read(out);
  const auto requests = [&](Lane lane) {
    const LaneLoad load = runtime.lanes.load(lane);
    v1::LaneStats& of = *out.mutable_lanes(static_cast<int>(lane));
    of.set_waiting(load.waiting);
    of.set_running(load.running);
    return static_cast<std::uint32_t>(load.waiting + load.running);
  };
  out.set_interactive_requests(requests(Lane::kInteractive));
  out.set_bulk_requests(requests(Lane::kBulk));
  const SceneStore& scenes = *runtime.scenes;
  const auto loaded = scenes.list("", std::numeric_limits<std::size_t>::max() - 1);
  out.set_scenes(static_cast<std::uint32_t>(loaded.size()));
  for (const auto& [part, bytes] : bytes_by_part(loaded)) {
    v1::PartBytes* entry = out.add_parts();
    entry->set_name(part);
    entry->set_bytes(bytes);
    out.set_scene_bytes(out.scene_bytes() + bytes);
  }
  out.set_leases(scenes.leases());
  out.set_scenes_built(scenes.builds());
  out.set_asset_bytes(runtime.assets->bytes());
  if (runtime.log_lines_left_out) out.set_log_lines_left_out(runtime.log_lines_left_out());
  *out.mutable_process() = monitor::process_figures();
  return out;
}

Prepared handle_get_stats(Runtime& runtime, const v1::GetStatsRequest&,
                          v1::GetStatsResponse* response) {
  return Task{.run = [&runtime, response](const std::stop_token&) {
    *response = stats(runtime);
    const auto is_unused = [](const v1::CallStats& call) {
      return call.codes_size() == 0 && call.running() == 0;
    };
    auto& calls = *response->mutable_calls();
    calls.erase(std::remove_if(calls.begin(), calls.end(), is_unused), calls.end());
    return absl::OkStatus();
  }};
}

Prepared handle_get_server_info(Runtime& runtime, const v1::GetServerInfoRequest&,
                                v1::GetServerInfoResponse* response) {
  return Task{.run = [&runtime, response](const std::stop_token&) {
    const std::lock_guard lock(runtime.info_mutex);
    *response = runtime.info;
    return absl::OkStatus();
  }};
}

}  // namespace lucerna::rpc
