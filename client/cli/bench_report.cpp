#include "client/cli/bench_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace lucerna::bench {
namespace {

double per_second(double value, const Figures& figures) {
  return figures.seconds > 0 ? value / figures.seconds : 0;
}

double per_second(std::uint64_t value, const Figures& figures) {
  return per_second(static_cast<double>(value), figures);
}

std::string short_number(double value) { return fmt::format("{:.4g}", value); }

/// The same for people, and in full for programs.
cli::Cell number_of(double value) { return {short_number(value), {fmt::format("{}", value)}}; }

/// Two digits after the point for people.
cli::Cell fixed(double value) { return {fmt::format("{:.2f}", value), {fmt::format("{}", value)}}; }

/// What a reader must know about the figures of a row.
std::string note(const Row& row) {
  std::vector<std::string> notes;
  if (row.in_flight && !row.figures.stable) notes.emplace_back("not stable");
  if (row.figures.overloaded) notes.emplace_back("overloaded");
  if (row.holds) notes.emplace_back(*row.holds ? "holds" : "too slow");
  for (const auto& [code, calls] : row.figures.failures)
    notes.push_back(fmt::format("{} {}", calls, code));
  return fmt::format("{}", fmt::join(notes, ", "));
}

std::string name(const LatencyLimit& limit) {
  return fmt::format("{} = {:g} ms", quantile_name(limit.quantile), 1e3 * limit.latency_s);
}

}  // namespace

bool holds(const Figures& figures, const LatencyLimit& limit) {
  return figures.calls() > 0 && figures.failed() == 0 && !figures.overloaded &&
         figures.latency_s(limit.quantile) <= limit.latency_s;
}

cli::Table rows_of(const Report& report) {
  const auto any = [&](auto member) {
    return std::ranges::any_of(report.rows, [&](const Row& r) { return r.figures.*member > 0; });
  };
  const bool open = !report.rows.empty() && report.rows.front().rate.has_value();
  const bool items = any(&Figures::items), samples = any(&Figures::samples),
             rays = any(&Figures::rays);
  std::vector<cli::Table::Column> columns;
  if (items) columns.push_back({"batch"});
  columns.push_back({open ? "rate [1/s]" : "in flight"});
  columns.push_back({"calls/s"});
  if (items) columns.push_back({"items/s"});
  for (const double q : kQuantiles) columns.push_back({quantile_name(q) + " [ms]"});
  columns.insert(columns.end(), {{"sent [MB/s]"}, {"received [MB/s]"}});
  if (samples) columns.push_back({"samples/s"});
  if (rays) columns.push_back({"rays/s"});
  columns.insert(columns.end(), {{"server CPUs"}, {"", true}});
  cli::Table table(columns);
  for (const Row& row : report.rows) {
    const Figures& f = row.figures;
    std::vector<cli::Cell> cells;
    if (items) cells.push_back(std::to_string(row.batch));
    cells.push_back(open ? number_of(*row.rate) : std::to_string(*row.in_flight));
    cells.push_back(number_of(per_second(f.calls(), f)));
    if (items) cells.push_back(number_of(per_second(f.items, f)));
    for (const double q : kQuantiles) cells.push_back(number_of(1e3 * f.latency_s(q)));
    cells.push_back(number_of(1e-6 * per_second(f.bytes_sent, f)));
    cells.push_back(number_of(1e-6 * per_second(f.bytes_received, f)));
    if (samples) cells.push_back(number_of(per_second(f.samples, f)));
    if (rays) cells.push_back(number_of(per_second(f.rays, f)));
    cells.push_back(f.server_cpu_s ? fixed(per_second(*f.server_cpu_s, f)) : "unknown");
    cells.push_back(note(row));
    table.add(std::move(cells));
  }
  return table;
}

std::string found_of(const Report& report) {
  const bool items =
      std::ranges::any_of(report.rows, [](const Row& r) { return r.figures.items > 0; });
  std::string text;
  for (const HighestRate& found : report.found) {
    const std::string batch = items ? fmt::format("batch {}: ", found.batch) : "";
    text += found.rate ? fmt::format("{}{} holds up to {} calls/s\n", batch, name(*report.limit),
                                     short_number(*found.rate))
                       : fmt::format("{}no rate holds {}\n", batch, name(*report.limit));
  }
  return text;
}

std::string json_of(const Report& report) {
  using Json = nlohmann::ordered_json;
  Json out{{"server", report.server}, {"call", report.question}};
  if (!report.scene_id.empty()) out["sceneId"] = report.scene_id;
  out["rows"] = Json::array();
  for (const Row& row : report.rows) {
    const Figures& f = row.figures;
    Json latency = Json::object();
    for (const double q : kQuantiles) latency[quantile_name(q)] = f.latency_s(q);
    Json one{{"batch", row.batch}};
    if (row.in_flight) one["inFlight"] = *row.in_flight;
    if (row.rate) one["rate"] = *row.rate;
    one.update({{"seconds", f.seconds},
                {"calls", f.calls()},
                {"failed", f.failed()},
                {"items", f.items},
                {"samples", f.samples},
                {"rays", f.rays},
                {"bytesSent", f.bytes_sent},
                {"bytesReceived", f.bytes_received},
                {"latencyS", latency},
                {"serverCpuS", f.server_cpu_s ? Json(*f.server_cpu_s) : Json()},
                {"failures", f.failures}});
    if (row.in_flight) one["stable"] = f.stable;
    if (row.rate) one["overloaded"] = f.overloaded;
    if (row.holds) one["holds"] = *row.holds;
    out["rows"].push_back(std::move(one));
  }
  if (report.limit) {
    out["limit"] = {{"quantile", quantile_name(report.limit->quantile)},
                    {"latencyS", report.limit->latency_s}};
    out["highest"] = Json::array();
    for (const HighestRate& found : report.found)
      out["highest"].push_back(
          {{"batch", found.batch}, {"rate", found.rate ? Json(*found.rate) : Json()}});
  }
  return out.dump() + "\n";
}

}  // namespace lucerna::bench
