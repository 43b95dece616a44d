#include "server/rpc/stats.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace lucerna::rpc {
namespace {

void set_histogram(const monitor::TimeHistogram& histogram, v1::TimeHistogram* out) {
  for (const double bound : monitor::kTimeBounds) out->add_bounds_s(bound);
  for (const std::uint64_t count : histogram.counts) out->add_counts(count);
  out->set_sum_s(histogram.sum_s);
}

void set_call(monitor::Call call, const monitor::CallFigures& figures, v1::CallStats* out) {
  constexpr std::size_t kOk = 0;
  out->set_method(monitor::name_of(call));
  out->set_succeeded(figures.ended[kOk]);
  out->set_failed(figures.calls() - figures.ended[kOk]);
  out->set_seconds(figures.total_s);
  for (std::size_t code = 0; code < monitor::kCodes; ++code) {
    if (figures.ended[code] == 0) continue;
    v1::CodeCount* count = out->add_codes();
    count->set_code(monitor::code_name(static_cast<int>(code)));
    count->set_calls(figures.ended[code]);
  }
  out->set_running(figures.running);
  set_histogram(figures.compute, out->mutable_compute());
  out->set_queue_s(figures.queue_s);
  out->set_cpu_s(figures.cpu_s);
  out->set_items(figures.items);
  out->set_samples(figures.samples);
  out->set_rays(figures.rays);
  out->set_request_bytes(figures.request_bytes);
  out->set_response_bytes(figures.response_bytes);
}

void set_process(const monitor::ProcessFigures& figures, v1::ProcessStats* out) {
  out->set_cpu_s(figures.cpu_s);
  out->set_resident_bytes(figures.resident_bytes);
  out->set_open_descriptors(figures.open_descriptors);
  out->set_most_descriptors(figures.most_descriptors);
  out->set_threads(figures.threads);
}

/// Adds the memory of all scenes, by part.  Parts that revisions share count once.
void add_parts(const std::vector<StoredScene>& scenes,
               std::map<std::string, std::uint64_t>& bytes) {
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
}

void set_stats(const monitor::Figures& figures, v1::GetStatsResponse* out) {
  out->set_uptime_s(figures.uptime_s);
  out->set_time_s(figures.time_s);
  for (std::size_t i = 0; i < monitor::kCalls; ++i) {
    const monitor::CallFigures& call = figures.calls[i];
    if (call.calls() + call.running == 0) continue;
    set_call(static_cast<monitor::Call>(i), call, out->add_calls());
  }
  const auto requests = [&](std::size_t lane) {
    return static_cast<std::uint32_t>(figures.lanes[lane].waiting + figures.lanes[lane].running);
  };
  out->set_interactive_requests(requests(0));
  out->set_bulk_requests(requests(1));
  for (std::size_t i = 0; i < figures.lanes.size(); ++i) {
    v1::LaneStats* lane = out->add_lanes();
    lane->set_name(monitor::lane_name(i));
    lane->set_waiting(figures.lanes[i].waiting);
    lane->set_running(figures.lanes[i].running);
    set_histogram(figures.lanes[i].wait, lane->mutable_wait());
  }
  out->set_scenes(static_cast<std::uint32_t>(figures.scenes));
  out->set_scene_bytes(figures.all_scene_bytes());
  for (const auto& [part, bytes] : figures.scene_bytes) {
    v1::PartBytes* entry = out->add_parts();
    entry->set_name(part);
    entry->set_bytes(bytes);
  }
  out->set_leases(figures.leases);
  out->set_scenes_built(figures.scenes_built);
  out->set_already_loaded(figures.already_loaded);
  out->set_asset_bytes(figures.asset_bytes);
  out->set_log_lines_left_out(figures.log_lines_left_out);
  set_process(figures.process, out->mutable_process());
}

}  // namespace

monitor::Figures figures(const Runtime& runtime) {
  using std::chrono::duration;
  monitor::Figures out;
  out.version = runtime.info.version();
  out.fingerprint = runtime.info.fingerprint().digest();
  out.time_s = duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
  out.uptime_s = duration<double>(std::chrono::steady_clock::now() - runtime.started).count();
  runtime.statistics.read(out);
  for (const Lane lane : {Lane::kInteractive, Lane::kBulk}) {
    const LaneLoad load = runtime.lanes.load(lane);
    out.lanes[static_cast<std::size_t>(lane)].waiting = load.waiting;
    out.lanes[static_cast<std::size_t>(lane)].running = load.running;
  }
  const SceneStore& scenes = *runtime.scenes;
  const auto loaded = scenes.list("", std::numeric_limits<std::size_t>::max() - 1);
  out.scenes = loaded.size();
  add_parts(loaded, out.scene_bytes);
  out.leases = scenes.leases();
  out.scenes_built = scenes.builds();
  out.memory_budget_bytes = runtime.info.limits().memory_budget_bytes();
  out.asset_bytes = runtime.assets->bytes();
  out.asset_budget_bytes = runtime.info.limits().asset_budget_bytes();
  if (runtime.log_lines_left_out) out.log_lines_left_out = runtime.log_lines_left_out();
  out.process = monitor::process_figures();
  return out;
}

Prepared handle_get_stats(Runtime& runtime, const v1::GetStatsRequest&,
                          v1::GetStatsResponse* response) {
  return Task{.run = [&runtime, response](const std::stop_token&) {
    set_stats(figures(runtime), response);
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
