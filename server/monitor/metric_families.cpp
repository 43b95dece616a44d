#include "server/monitor/metric_families.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <utility>

namespace lucerna::monitor {
namespace {

using prometheus::ClientMetric;
using prometheus::MetricFamily;
using prometheus::MetricType;
using Labels = std::vector<ClientMetric::Label>;

class Family {
 public:
  Family(std::vector<MetricFamily>& out, MetricType type, const char* name, const char* help)
      : family_(out.emplace_back()) {
    family_.name = name;
    family_.help = help;
    family_.type = type;
  }
  void add(Labels labels, double value) {
    ClientMetric& metric = family_.metric.emplace_back();
    metric.label = std::move(labels);
    if (family_.type == MetricType::Counter) {
      metric.counter.value = value;
    } else {
      metric.gauge.value = value;
    }
  }
  void add(Labels labels, std::uint64_t value) {
    add(std::move(labels), static_cast<double>(value));
  }
  void add(Labels labels, const TimeHistogram& histogram) {
    ClientMetric& metric = family_.metric.emplace_back();
    metric.label = std::move(labels);
    std::uint64_t below = 0;
    for (std::size_t i = 0; i < histogram.counts.size(); ++i) {
      below += histogram.counts[i];
      metric.histogram.bucket.push_back({below, i < kTimeBounds.size()
                                                    ? kTimeBounds[i]
                                                    : std::numeric_limits<double>::infinity()});
    }
    metric.histogram.sample_count = below;
    metric.histogram.sample_sum = histogram.sum_s;
  }

 private:
  MetricFamily& family_;  // valid until the next family is made
};

Labels call_label(std::size_t call) {
  return {{"call", std::strrchr(name_of(static_cast<Call>(call)), '/') + 1}};
}

void add_counts(const Figures& figures, std::vector<MetricFamily>& out) {
  {
    Family family(out, MetricType::Counter, "lucerna_calls_total", "Calls that ended, by code.");
    constexpr std::size_t kOk = 0, kInternal = 13;
    for (std::size_t i = 0; i < kCalls; ++i) {
      for (std::size_t code = 0; code < kCodes; ++code) {
        // Rates and alerts need the 0 before the first call.  All codes would be 17 rows a call.
        if (code != kOk && code != kInternal && figures.calls[i].ended[code] == 0) continue;
        Labels labels = call_label(i);
        labels.push_back({"code", code_name(static_cast<int>(code))});
        family.add(std::move(labels), figures.calls[i].ended[code]);
      }
    }
  }
  Family running(out, MetricType::Gauge, "lucerna_calls_running", "Calls that wait or run now.");
  for (std::size_t i = 0; i < kCalls; ++i) running.add(call_label(i), figures.calls[i].running);
}

/// One counter for each call that was made.
template <typename Value>
void add_total(const Figures& figures, const char* name, const char* help, const Value& value,
               std::vector<MetricFamily>& out) {
  Family family(out, MetricType::Counter, name, help);
  for (std::size_t i = 0; i < kCalls; ++i) {
    if (figures.calls[i].calls() > 0) family.add(call_label(i), value(figures.calls[i]));
  }
}

void add_totals(const Figures& figures, std::vector<MetricFamily>& out) {
  using C = CallFigures;
  add_total(
      figures, "lucerna_call_seconds_total", "Time from arrival to answer, in seconds.",
      [](const C& c) { return c.total_s; }, out);
  add_total(
      figures, "lucerna_call_queue_seconds_total", "Time in queues, in seconds.",
      [](const C& c) { return c.queue_s; }, out);
  add_total(
      figures, "lucerna_call_cpu_seconds_total",
      "Processor time of the work on all threads, in seconds.", [](const C& c) { return c.cpu_s; },
      out);
  add_total(
      figures, "lucerna_items_total",
      "Receivers, rays, points, lights or pixels of successful calls.",
      [](const C& c) { return c.items; }, out);
  add_total(
      figures, "lucerna_samples_total", "Samples of successful calls.",
      [](const C& c) { return c.samples; }, out);
  add_total(
      figures, "lucerna_rays_total", "Rays of successful calls.", [](const C& c) { return c.rays; },
      out);
  add_total(
      figures, "lucerna_request_bytes_total", "Size of all requests, in bytes.",
      [](const C& c) { return c.request_bytes; }, out);
  add_total(
      figures, "lucerna_response_bytes_total", "Size of all responses, in bytes.",
      [](const C& c) { return c.response_bytes; }, out);
  Family compute(out, MetricType::Histogram, "lucerna_call_compute_seconds",
                 "Wall time of the work of a call, in seconds.");
  for (std::size_t i = 0; i < kCalls; ++i) {
    if (figures.calls[i].compute.count() > 0) compute.add(call_label(i), figures.calls[i].compute);
  }
}

void add_lanes(const Figures& figures, std::vector<MetricFamily>& out) {
  const auto label = [](std::size_t lane) { return Labels{{"lane", lane_name(lane)}}; };
  {
    Family waiting(out, MetricType::Gauge, "lucerna_lane_waiting",
                   "Jobs that wait in the lane now.");
    for (std::size_t i = 0; i < 2; ++i) waiting.add(label(i), figures.lanes[i].waiting);
  }
  {
    Family running(out, MetricType::Gauge, "lucerna_lane_running",
                   "Jobs of the lane that run now.");
    for (std::size_t i = 0; i < 2; ++i) running.add(label(i), figures.lanes[i].running);
  }
  Family wait(out, MetricType::Histogram, "lucerna_lane_wait_seconds",
              "Time that a call waited in the lane, in seconds.");
  for (std::size_t i = 0; i < 2; ++i) wait.add(label(i), figures.lanes[i].wait);
}

template <typename Value>
void add_one(std::vector<MetricFamily>& out, MetricType type, const char* name, const char* help,
             Value value) {
  Family(out, type, name, help).add({}, value);
}

void add_scenes(const Figures& figures, std::vector<MetricFamily>& out) {
  add_one(out, MetricType::Gauge, "lucerna_scenes", "Scenes in memory.", figures.scenes);
  add_one(out, MetricType::Gauge, "lucerna_scene_leases", "Leases that hold scenes in memory.",
          figures.leases);
  {
    Family bytes(out, MetricType::Gauge, "lucerna_scene_bytes",
                 "Memory of all scenes by part, in bytes.");
    for (const auto& [part, n] : figures.scene_bytes) bytes.add({{"part", part}}, n);
  }
  add_one(out, MetricType::Gauge, "lucerna_memory_budget_bytes",
          "Memory that all scenes may use, in bytes; 0: no limit.", figures.memory_budget_bytes);
  add_one(out, MetricType::Counter, "lucerna_scene_builds_total", "Scenes that were built.",
          figures.scenes_built);
  add_one(out, MetricType::Counter, "lucerna_scene_hits_total",
          "Calls of LoadScene and EditLights that found their scene in memory.",
          figures.already_loaded);
  add_one(out, MetricType::Gauge, "lucerna_asset_bytes", "Uploaded files on the disk, in bytes.",
          figures.asset_bytes);
  add_one(out, MetricType::Gauge, "lucerna_asset_budget_bytes",
          "Disk space that uploaded files may use, in bytes.", figures.asset_budget_bytes);
}

void add_process(const Figures& figures, std::vector<MetricFamily>& out) {
  Family(out, MetricType::Gauge, "lucerna_build_info", "1, with the version as labels.")
      .add({{"version", figures.version}, {"fingerprint", figures.fingerprint}}, 1.0);
  add_one(out, MetricType::Counter, "lucerna_log_lines_left_out_total",
          "Lines of calls that the limit of the log left out.", figures.log_lines_left_out);
  const ProcessFigures& p = figures.process;
  // These names are the convention of Prometheus.
  add_one(out, MetricType::Gauge, "process_start_time_seconds",
          "When the server started, in seconds since 1970-01-01 UTC.",
          figures.time_s - figures.uptime_s);
  add_one(out, MetricType::Counter, "process_cpu_seconds_total", "Processor time, in seconds.",
          p.cpu_s);
  add_one(out, MetricType::Gauge, "process_resident_memory_bytes", "Resident memory, in bytes.",
          p.resident_bytes);
  add_one(out, MetricType::Gauge, "process_open_fds", "Open file descriptors.", p.open_descriptors);
  add_one(out, MetricType::Gauge, "process_max_fds", "Limit of open file descriptors.",
          p.most_descriptors);
  add_one(out, MetricType::Gauge, "process_threads", "Threads.", p.threads);
}

}  // namespace

std::vector<MetricFamily> metric_families(const Figures& figures) {
  std::vector<MetricFamily> out;
  add_counts(figures, out);
  add_totals(figures, out);
  add_lanes(figures, out);
  add_scenes(figures, out);
  add_process(figures, out);
  return out;
}

}  // namespace lucerna::monitor
