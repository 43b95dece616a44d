#include "client/tradeoff/record.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

namespace lucerna::tradeoff {
namespace {

using Json = nlohmann::ordered_json;

/// Six digits, which is more than is known; null for what JSON has no number for.
Json number(double value) {
  if (!std::isfinite(value)) return nullptr;
  return std::stod(fmt::format("{:.6g}", value));
}

Json array(const std::vector<double>& values) {
  Json result = Json::array();
  for (const double v : values) result.push_back(number(v));
  return result;
}

Json to_json(const Interval& i) {
  return {{"mean", number(i.mean)}, {"lower", number(i.lower)}, {"upper", number(i.upper)}};
}
Json to_json(const Quartiles& q) {
  return {{"lower", number(q.lower)}, {"median", number(q.median)}, {"upper", number(q.upper)}};
}
Json to_json(const Amount& a) {
  return {{"kind", a.target ? "error" : "samples"}, {"value", number(a.value)}};
}

const char* name(Reached::How how) {
  switch (how) {
    case Reached::How::kBetween:
      return "measured";
    case Reached::How::kWithFewest:
      return "with the fewest samples";
    case Reached::How::kExtrapolated:
      return "extrapolated";
  }
  return "";
}

const char* name(Course::Fate fate) {
  switch (fate) {
    case Course::Fate::kSwept:
      return "swept";
    case Course::Fate::kSame:
      return "same";
    case Course::Fate::kSkipped:
      return "skipped";
    case Course::Fate::kDropped:
      return "dropped";
  }
  return "";
}

Json cell_json(const Cell& cell) {
  Json json = {{"amount", to_json(cell.amount)},
               {"runs", cell.runs},
               {"seconds", to_json(cell.seconds)},
               {"relative_error", to_json(cell.error)},
               {"exact", cell.exact},
               {"rmse", to_json(cell.rmse)}};
  if (cell.flip) json["flip"] = to_json(*cell.flip);
  json["samples"] = number(cell.samples);
  json["rays"] = number(cell.rays);
  return json;
}

Json setting_json(const Record& record, std::size_t i) {
  const Course& course = record.sweep.courses[i];
  const Curve& curve = record.analysis.curves[i];
  Json json = {{"name", record.settings[i].name()},
               {"flags", record.settings[i].flags},
               {"fate", name(course.fate)}};
  const std::string about = record.question->about(record.settings[i]);
  if (!about.empty()) json["about"] = about;
  if (!course.why.empty()) json["why"] = course.why;
  if (course.fate == Course::Fate::kSame) json["same_as"] = course.same_as;
  Json cells = Json::array();
  for (const Cell& cell : curve.cells) cells.push_back(cell_json(cell));
  json["cells"] = cells;
  if (curve.exact()) json["exact_at"] = *curve.exact();
  json["rate"] = curve.rate ? number(*curve.rate) : nullptr;
  if (curve.efficiency) {
    json["efficiency_per_s"] = to_json(*curve.efficiency);
    json["efficiency_at"] = curve.efficient_at;
  }
  Json levels = Json::array();
  for (std::size_t k = 0; k < kLevels.size(); ++k) {
    const auto& reached = curve.levels[k];
    levels.push_back(reached ? Json{{"error", kLevels[k]},
                                    {"seconds", number(reached->seconds)},
                                    {"amount", number(reached->samples)},
                                    {"how", name(reached->how)}}
                             : Json{{"error", kLevels[k]}, {"seconds", nullptr}});
  }
  json["time_to_error"] = levels;
  return json;
}

Json recommendation_json(const Record& record, const Recommendation& r) {
  Json json = {{"error", r.error}, {"below_reference", r.below_reference}};
  if (!r.setting) return json;
  json["setting"] = *r.setting;
  json["name"] = record.settings[*r.setting].name();
  json["seconds"] = number(r.reached.seconds);
  json["how"] = name(r.reached.how);
  json["command"] = record.question->command(record.settings[*r.setting], r.amount);
  json["exact"] = r.exact;
  json["best"] = record.settings[r.best].name();
  json["best_seconds"] = number(r.best_reached.seconds);
  json["best_how"] = name(r.best_reached.how);
  json["automatic_over_best"] = r.automatic_ratio ? number(*r.automatic_ratio) : nullptr;
  json["automatic_extrapolated"] = r.automatic_extrapolated;
  return json;
}

Json circumstances_json(const Circumstances& c) {
  return {{"scene", c.scene},
          {"scene_id", c.scene_id},
          {"client_version", c.client_version},
          {"server_version", c.server_version},
          {"fingerprint", c.fingerprint},
          {"build", c.build},
          {"embree", c.embree},
          {"server_threads", c.server_threads},
          {"date", c.date},
          {"budget_s", number(c.budget_s)},
          {"spent_s", number(c.spent_s)},
          {"seed", c.seed}};
}

}  // namespace

std::string to_csv(const Record& record) {
  std::string csv =
      "scene,query,setting,amount_kind,amount,round,seed,seconds,samples,rays,rmse,relative_mse,"
      "flip\n";
  for (const Run& run : record.sweep.runs) {
    csv += fmt::format("{},{},\"{}\",{},{:g},{},{},{:.6g},{:.0f},{:.0f},{:.6g},{:.6g},{}\n",
                       record.circumstances.scene, name(record.question->query()),
                       record.settings[run.setting].name(), run.amount.target ? "error" : "samples",
                       run.amount.value, run.round, run.seed, run.seconds, run.samples, run.rays,
                       run.errors.rmse, run.errors.relative_mse,
                       run.errors.flip ? fmt::format("{:.6g}", *run.errors.flip) : "");
  }
  return csv;
}

Json to_json(const Record& record, bool with_runs) {
  const Reference& ref = record.reference;
  const Analysis& a = record.analysis;
  Json json = {{"lucerna_tradeoff", 1},
               {"query", name(record.question->query())},
               {"quantity", record.question->quantity()},
               {"circumstances", circumstances_json(record.circumstances)}};
  json["relative_error"] = {
      {"definition",
       "sqrt(mean of (value - reference)^2 / (reference^2 + dark^2) less the square of the "
       "reference's own)"},
      {"dark", number(ref.dark)},
      {"rounding", kRounding}};
  json["reference"] = {{"way", ref.way},
                       {"exact", ref.exact},
                       {"relative_error", number(ref.relative_error)},
                       {"rmse", number(ref.rmse)},
                       {"replicates", ref.replicates},
                       {"samples_each", ref.samples_each},
                       {"seconds", number(ref.seconds)}};
  Json levels = Json::array();
  for (const Recommendation& r : a.levels) levels.push_back(recommendation_json(record, r));
  json["levels"] = levels;
  json["warnings"] = a.warnings;
  Json settings = Json::array();
  for (std::size_t i = 0; i < record.settings.size(); ++i)
    settings.push_back(setting_json(record, i));
  json["settings"] = settings;
  Json front = Json::array();
  for (const auto& [setting, cell] : a.front) front.push_back({setting, cell});
  json["pareto_front"] = front;
  json["comparison_s"] = number(a.comparison_s);
  const Layout& layout = record.question->layout();
  if (layout.tiles.empty()) {
    json["reference"]["values"] = array(ref.values);
    json["reference"]["standard_error"] = array(ref.standard_error);
  }
  if (!layout.points.empty()) {
    Json points = Json::array();
    for (const client::Double3& p : layout.points)
      points.push_back({number(p[0]), number(p[1]), number(p[2])});
    json["points"] = points;
  }
  if (!layout.labels.empty()) json["labels"] = layout.labels;
  if (with_runs) {
    Json columns = {"setting", "amount", "round",        "seconds", "samples",
                    "rays",    "rmse",   "relative_mse", "flip"};
    Json runs = Json::array();
    for (const Run& run : record.sweep.runs) {
      runs.push_back({run.setting, number(run.amount.value), run.round, number(run.seconds),
                      number(run.samples), number(run.rays), number(run.errors.rmse),
                      number(run.errors.relative_mse),
                      run.errors.flip ? number(*run.errors.flip) : nullptr});
    }
    json["runs"] = {{"columns", columns}, {"rows", runs}};
  }
  return json;
}

std::string to_text(const Record& record) {
  const Reference& ref = record.reference;
  std::string text =
      fmt::format("Reference: {}.\n", ref.way) +
      (ref.exact && ref.relative_error == 0 ? "Its own error: 0, but for rounding.\n"
       : ref.exact ? fmt::format("Its own error: at most {:.2g}%.\n", 100 * ref.relative_error)
                   : fmt::format("Its own error: {:.2g}% ({:.3g} as RMSE), from the scatter of {} "
                                 "answers of {} samples with different seeds, {:.1f} s.\n",
                                 100 * ref.relative_error, ref.rmse, ref.replicates,
                                 ref.samples_each, ref.seconds));
  const auto& levels = record.analysis.levels;
  // What is exact does for every error where nothing that is not is faster.
  const bool any_error = std::all_of(levels.begin(), levels.end(), [&](const Recommendation& r) {
    return r.exact && r.setting == levels[0].setting;
  });
  for (const Recommendation& r : levels) {
    if (any_error && &r != &levels[0]) break;
    if (!r.setting) {
      text += fmt::format("{:g}%: {}.\n", 100 * r.error,
                          r.below_reference ? "the reference does not tell errors so small"
                                            : "no setting came near within this budget");
      continue;
    }
    const auto beyond = [](bool extrapolated) { return extrapolated ? " (extrapolated)" : ""; };
    const auto is_beyond = [](const Reached& x) { return x.how == Reached::How::kExtrapolated; };
    text += fmt::format(
        "{}: {}, {:.3g} s{}", any_error ? "any error" : fmt::format("{:g}%", 100 * r.error),
        record.settings[*r.setting].name(), r.reached.seconds,
        r.exact                                      ? ", exact"
        : r.reached.how == Reached::How::kWithFewest ? " (or less: the fewest "
                                                       "samples are that good)"
                                                     : beyond(is_beyond(r.reached)));
    if (r.best != *r.setting) {
      text += fmt::format("; not told apart from the fastest, {}, {:.3g} s{}",
                          record.settings[r.best].name(), r.best_reached.seconds,
                          beyond(is_beyond(r.best_reached)));
    } else if (r.automatic_ratio && r.best != 0) {
      text += fmt::format("; automatic takes {:.2f} times that{}", *r.automatic_ratio,
                          beyond(r.automatic_extrapolated));
    }
    text += "\n  " + record.question->command(record.settings[*r.setting], r.amount) + "\n";
  }
  for (const std::string& warning : record.analysis.warnings) text += "Note: " + warning + "\n";
  return text;
}

absl::Status make_directory(const std::string& path) {
  const auto refused = [&](const std::string& why) {
    return absl::InvalidArgumentError(fmt::format("--out {}: cannot be written to: {}", path, why));
  };
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (error) return refused(error.message());
  const std::filesystem::path probe = std::filesystem::path(path) / ".lucerna-tradeoff";
  errno = 0;
  {
    std::ofstream file(probe);
    file << '\n';
    file.close();
    if (!file) return refused(std::strerror(errno));
  }
  std::filesystem::remove(probe, error);
  return absl::OkStatus();
}

absl::Status write(const Record& record, const std::string& directory) {
  const std::array<std::pair<const char*, std::string>, 3> files = {
      {{"tradeoff.csv", to_csv(record)},
       {"tradeoff.json", to_json(record, true).dump() + "\n"},
       {"report.html", to_html(record)}}};
  for (const auto& [name, text] : files) {
    const std::filesystem::path path = std::filesystem::path(directory) / name;
    const std::filesystem::path temporary = path.string() + ".part";
    errno = 0;
    std::ofstream file(temporary, std::ios::binary);
    file << text;
    file.close();
    std::error_code error;
    if (file) std::filesystem::rename(temporary, path, error);
    if (!file || error) {
      return absl::UnknownError(fmt::format("cannot write {}: {}", path.string(),
                                            error ? error.message() : std::strerror(errno)));
    }
  }
  return absl::OkStatus();
}

}  // namespace lucerna::tradeoff
