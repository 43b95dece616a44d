#include "server/monitor/metric_families.h"

#include <algorithm>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <string>
#include <utility>

namespace lucerna::monitor {
namespace {

using prometheus::ClientMetric;
using prometheus::MetricFamily;
using Labels = std::vector<ClientMetric::Label>;
constexpr auto kCounter = prometheus::MetricType::Counter;
constexpr auto kGauge = prometheus::MetricType::Gauge;
constexpr auto kHistogram = prometheus::MetricType::Histogram;

/// Adds a number to a family of counters or gauges.
template <typename Number>
void add(MetricFamily& family, Labels labels, Number value) {
  ClientMetric& metric = family.metric.emplace_back();
  metric.label = std::move(labels);
  (family.type == kCounter ? metric.counter.value : metric.gauge.value) =
      static_cast<double>(value);
}

void add(MetricFamily& family, Labels labels, const v1::TimeHistogram& histogram) {
  ClientMetric& metric = family.metric.emplace_back();
  metric.label = std::move(labels);
  std::uint64_t below = 0;
  for (int i = 0; i < histogram.counts_size(); ++i) {
    below += histogram.counts(i);
    metric.histogram.bucket.push_back({below, i < histogram.bounds_s_size()
                                                  ? histogram.bounds_s(i)
                                                  : std::numeric_limits<double>::infinity()});
  }
  metric.histogram.sample_count = below;
  metric.histogram.sample_sum = histogram.sum_s();
}

ClientMetric::Label label_of(const v1::CallStats& call) {
  return {"call", call.method().substr(call.method().rfind('/') + 1)};
}

/// The families so far.
class Families {
 public:
  explicit Families(const v1::GetStatsResponse& stats) : stats_(stats) {}

  /// A family without metrics.  Valid until the next is made.
  MetricFamily& family(prometheus::MetricType type, const char* name, const char* help) {
    return out_.emplace_back(MetricFamily{name, help, type, {}});
  }
  template <typename Number>
  void one(prometheus::MetricType type, const char* name, const char* help, Number value) {
    add(family(type, name, help), {}, value);
  }
  /// A counter for each call that was made.
  template <typename Value>
  void total(const char* name, const char* help, Value value) {
    MetricFamily& of = family(kCounter, name, help);
    for (const v1::CallStats& call : stats_.calls())
      if (call.codes_size() > 0) add(of, {label_of(call)}, std::invoke(value, call));
  }
  /// A metric for each lane.
  template <typename Value>
  void lanes(prometheus::MetricType type, const char* name, const char* help, Value value) {
    MetricFamily& of = family(type, name, help);
    for (const v1::LaneStats& lane : stats_.lanes())
      add(of, {{"lane", lane.name()}}, std::invoke(value, lane));
  }
  std::vector<MetricFamily> take() { return std::move(out_); }

 private:
  const v1::GetStatsResponse& stats_;
  std::vector<MetricFamily> out_;
};

void add_calls(const v1::GetStatsResponse& stats, Families& out) {
  MetricFamily& ended = out.family(kCounter, "lucerna_calls_total", "Calls that ended, by code.");
  for (const v1::CallStats& call : stats.calls()) {
    // Rates and alerts need the 0 before the first call.  All codes would be 17 rows a call.
    std::map<std::string, std::uint64_t> codes{{"OK", 0}, {"INTERNAL", 0}};
    for (const v1::CodeCount& count : call.codes()) codes[count.code()] = count.calls();
    for (const auto& [code, calls] : codes) add(ended, {label_of(call), {"code", code}}, calls);
  }
  MetricFamily& running =
      out.family(kGauge, "lucerna_calls_running", "Calls that wait or run now.");
  for (const v1::CallStats& call : stats.calls()) add(running, {label_of(call)}, call.running());

  using C = v1::CallStats;
  out.total("lucerna_call_seconds_total", "Time from arrival to answer, in seconds.", &C::seconds);
  out.total("lucerna_call_queue_seconds_total", "Time in queues, in seconds.", &C::queue_s);
  out.total("lucerna_call_cpu_seconds_total",
            "Processor time of the work on all threads, in seconds.", &C::cpu_s);
  out.total("lucerna_items_total", "Receivers, rays, points, lights or pixels of successful calls.",
            &C::items);
  out.total("lucerna_samples_total", "Samples of successful calls.", &C::samples);
  out.total("lucerna_rays_total", "Rays of successful calls.", &C::rays);
  out.total("lucerna_request_bytes_total", "Size of all requests, in bytes.", &C::request_bytes);
  out.total("lucerna_response_bytes_total", "Size of all responses, in bytes.", &C::response_bytes);
  MetricFamily& compute = out.family(kHistogram, "lucerna_call_compute_seconds",
                                     "Wall time of the work of a call, in seconds.");
  for (const v1::CallStats& call : stats.calls()) {
    const auto& counts = call.compute().counts();
    if (std::any_of(counts.begin(), counts.end(), [](std::uint64_t n) { return n > 0; }))
      add(compute, {label_of(call)}, call.compute());
  }
}

void add_lanes(Families& out) {
  out.lanes(kGauge, "lucerna_lane_waiting", "Jobs that wait in the lane now.",
            &v1::LaneStats::waiting);
  out.lanes(kGauge, "lucerna_lane_running", "Jobs of the lane that run now.",
            &v1::LaneStats::running);
  out.lanes(kHistogram, "lucerna_lane_wait_seconds",
            "Time that a call waited in the lane, in seconds.", &v1::LaneStats::wait);
}

void add_scenes(const v1::GetStatsResponse& stats, const v1::Limits& limits, Families& out) {
  out.one(kGauge, "lucerna_scenes", "Scenes in memory.", stats.scenes());
  out.one(kGauge, "lucerna_scene_leases", "Leases that hold scenes in memory.", stats.leases());
  MetricFamily& bytes =
      out.family(kGauge, "lucerna_scene_bytes", "Memory of all scenes by part, in bytes.");
  for (const v1::PartBytes& part : stats.parts()) add(bytes, {{"part", part.name()}}, part.bytes());
  out.one(kGauge, "lucerna_memory_budget_bytes",
          "Memory that all scenes may use, in bytes; 0: no limit.", limits.memory_budget_bytes());
  out.one(kCounter, "lucerna_scene_builds_total", "Scenes that were built.", stats.scenes_built());
  out.one(kCounter, "lucerna_scene_hits_total",
          "Calls of LoadScene and EditLights that found their scene in memory.",
          stats.already_loaded());
  out.one(kGauge, "lucerna_asset_bytes", "Uploaded files on the disk, in bytes.",
          stats.asset_bytes());
  out.one(kGauge, "lucerna_asset_budget_bytes", "Disk space that uploaded files may use, in bytes.",
          limits.asset_budget_bytes());
}

void add_process(const v1::GetStatsResponse& stats, const v1::GetServerInfoResponse& info,
                 Families& out) {
  add(out.family(kGauge, "lucerna_build_info", "1, with the version as labels."),
      {{"version", info.version()}, {"fingerprint", info.fingerprint().digest()}}, 1);
  out.one(kCounter, "lucerna_log_lines_left_out_total",
          "Lines of calls that the limit of the log left out.", stats.log_lines_left_out());
  const v1::ProcessStats& p = stats.process();
  // These names are the convention of Prometheus.
  out.one(kGauge, "process_start_time_seconds",
          "When the server started, in seconds since 1970-01-01 UTC.",
          stats.time_s() - stats.uptime_s());
  out.one(kCounter, "process_cpu_seconds_total", "Processor time, in seconds.", p.cpu_s());
  out.one(kGauge, "process_resident_memory_bytes", "Resident memory, in bytes.",
          p.resident_bytes());
  out.one(kGauge, "process_open_fds", "Open file descriptors.", p.open_descriptors());
  out.one(kGauge, "process_max_fds", "Limit of open file descriptors.", p.most_descriptors());
  out.one(kGauge, "process_threads", "Threads.", p.threads());
}

}  // namespace

std::vector<MetricFamily> metric_families(const v1::GetStatsResponse& stats,
                                          const v1::GetServerInfoResponse& info) {
  Families out(stats);
  add_calls(stats, out);
  add_lanes(out);
  add_scenes(stats, info.limits(), out);
  add_process(stats, info, out);
  return out.take();
}

}  // namespace lucerna::monitor
