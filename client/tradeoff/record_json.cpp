// Writes tradeoff.json: everything that the page shows, and the runs.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "absl/strings/escaping.h"
#include "client/files/write_picture.h"
#include "client/tradeoff/flip.h"
#include "client/tradeoff/record.h"

namespace lucerna::tradeoff {
namespace {

using Json = nlohmann::ordered_json;

/// A number with six digits, which are more than measurements have.  Null for infinities and NaN,
/// which JSON does not have.
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
          {"budget_s", c.rounds > 0 ? Json(nullptr) : number(c.budget_s)},
          {"rounds", c.rounds > 0 ? Json(c.rounds) : Json(nullptr)},
          {"max_samples", c.rounds > 0 ? Json(c.max_samples) : Json(nullptr)},
          {"spent_s", number(c.spent_s)},
          {"seed", c.seed}};
}

// Pictures make the page large, so it shows only three tiles with three settings.
constexpr std::size_t kTilesShown = 3, kSettingsShown = 3;

std::vector<std::size_t> compared(const Record& record) {
  std::vector<std::size_t> settings;
  for (std::size_t i = 0; i < record.settings.size(); ++i)
    if (!record.items[i].relative.empty()) settings.push_back(i);
  return settings;
}

/// Three digits are enough to colour a point.
Json rounded(const std::vector<float>& values) {
  Json result = Json::array();
  for (const float v : values)
    result.push_back(std::stod(fmt::format("{:.3g}", std::isfinite(v) ? v : 0)));
  return result;
}

/// The errors of each point or light with each setting, at about the same time.
Json items_json(const Record& record) {
  Json result = Json::array();
  for (const std::size_t i : compared(record)) {
    const Cell& cell = record.analysis.curves[i].cells[*record.analysis.compared[i]];
    result.push_back({{"setting", i},
                      {"amount", cell.amount.text()},
                      {"seconds", cell.seconds.median},
                      {"errors", rounded(record.items[i].relative)}});
  }
  return result;
}

double root_mean_square(std::span<const float> values) {
  double sum = 0;
  for (const float v : values) sum += static_cast<double>(v) * static_cast<double>(v);
  return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(values.size(), 1)));
}

/// Linear RGB converted for a screen: 3 bytes for each pixel, in base 64.
std::string shown(std::span<const float> rgb, double exposure_ev) {
  std::string bytes;
  const auto factor = static_cast<float>(std::exp2(exposure_ev));
  for (const float v : rgb) bytes += static_cast<char>(client::srgb8(factor * v));
  return absl::Base64Escape(bytes);
}

std::string shown_difference(std::span<const float> difference) {
  std::string bytes;
  for (const float d : difference)
    bytes += static_cast<char>(std::lround(255 * std::clamp(d, 0.0F, 1.0F)));
  return absl::Base64Escape(bytes);
}

/// Automatic, the best and the worst of the settings that took about the same time.
std::vector<std::size_t> settings_shown(const Record& record) {
  std::vector<std::size_t> order = compared(record);
  if (order.empty()) return order;
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return root_mean_square(record.items[a].relative) < root_mean_square(record.items[b].relative);
  });
  std::vector<std::size_t> result = {order.front(), order.back()};
  if (!record.items[0].relative.empty()) result.insert(result.begin() + 1, 0);
  std::vector<std::size_t> distinct;
  for (const std::size_t i : result)
    if (std::find(distinct.begin(), distinct.end(), i) == distinct.end()) distinct.push_back(i);
  distinct.resize(std::min(distinct.size(), kSettingsShown));
  return distinct;
}

/// The tiles in which the best and the worst setting differ most, with their FLIP.
Json pictures_json(const Record& record) {
  const std::vector<v1::PixelRect>& tiles = record.question->layout().tiles;
  const std::vector<std::size_t> settings = settings_shown(record);
  if (settings.empty()) return Json::array();
  struct Place {
    std::size_t tile, first, count;
    double difference;
  };
  std::vector<Place> places;
  std::size_t first = 0;
  for (std::size_t t = 0; t < tiles.size(); ++t) {
    const std::size_t pixels =
        std::size_t{tiles[t].x1() - tiles[t].x0()} * (tiles[t].y1() - tiles[t].y0());
    const auto error = [&](std::size_t setting) {
      return root_mean_square(std::span(record.items[setting].relative).subspan(first / 3, pixels));
    };
    places.push_back({t, first, 3 * pixels, error(settings.back()) - error(settings.front())});
    first += 3 * pixels;
  }
  std::stable_sort(places.begin(), places.end(),
                   [](const Place& a, const Place& b) { return a.difference > b.difference; });
  places.resize(std::min(places.size(), kTilesShown));
  const double exposure = record.circumstances.exposure_ev;
  const std::vector<float> reference(record.reference.values.begin(),
                                     record.reference.values.end());
  const auto factor = static_cast<float>(std::exp2(exposure));
  Json result = Json::array();
  for (const Place& p : places) {
    const v1::PixelRect& tile = tiles[p.tile];
    const std::uint32_t w = tile.x1() - tile.x0(), h = tile.y1() - tile.y0();
    const auto exposed = [&](std::span<const float> all) {
      std::vector<float> rgb(all.begin() + static_cast<std::ptrdiff_t>(p.first),
                             all.begin() + static_cast<std::ptrdiff_t>(p.first + p.count));
      for (float& v : rgb) v *= factor;
      return rgb;
    };
    const std::vector<float> truth = exposed(reference);
    Json json = {{"x", tile.x0()}, {"y", tile.y0()}, {"width", w}, {"height", h}};
    json["reference"] = shown(truth, 0);
    Json answers = Json::array();
    for (const std::size_t i : settings) {
      const std::vector<float> answer = exposed(record.items[i].values);
      const std::vector<float> difference = flip(truth, answer, w, h);
      double sum = 0;
      for (const float d : difference) sum += static_cast<double>(d);
      answers.push_back({{"setting", i},
                         {"picture", shown(answer, 0)},
                         {"difference", shown_difference(difference)},
                         {"flip", sum / static_cast<double>(difference.size())}});
    }
    json["answers"] = answers;
    result.push_back(json);
  }
  return result;
}

}  // namespace

std::string to_json(const Record& record, bool with_runs) {
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
  json["exposure_ev"] = record.circumstances.exposure_ev;
  if (layout.tiles.empty()) {
    json["items"] = items_json(record);
  } else {
    json["pictures"] = pictures_json(record);
  }
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
  return json.dump();
}

}  // namespace lucerna::tradeoff
