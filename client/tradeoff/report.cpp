#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "absl/strings/escaping.h"
#include "absl/strings/str_replace.h"
#include "client/files/write_picture.h"
#include "client/tradeoff/flip.h"
#include "client/tradeoff/record.h"
#include "client/tradeoff/report_files.h"

namespace lucerna::tradeoff {
namespace {

using Json = nlohmann::ordered_json;

// Pictures make the page large: three tiles of each.
constexpr std::size_t kTilesShown = 3, kSettingsShown = 3;

std::vector<std::size_t> compared(const Record& record) {
  std::vector<std::size_t> settings;
  for (std::size_t i = 0; i < record.settings.size(); ++i)
    if (!record.items[i].relative.empty()) settings.push_back(i);
  return settings;
}

/// Two digits are enough to colour a point.
Json rounded(const std::vector<float>& values) {
  Json result = Json::array();
  for (const float v : values)
    result.push_back(std::stod(fmt::format("{:.3g}", std::isfinite(v) ? v : 0)));
  return result;
}

/// Of points and lights: the errors of each under each setting at the same time.
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

double mean(std::span<const float> values) {
  double sum = 0;
  for (const float v : values) sum += static_cast<double>(v) * static_cast<double>(v);
  return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(values.size(), 1)));
}

/// As a screen shows it, 3 bytes a pixel, in base 64.
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

/// The settings to show: automatic, the best and the worst of those that had the same time.
std::vector<std::size_t> settings_shown(const Record& record) {
  std::vector<std::size_t> order = compared(record);
  if (order.empty()) return order;
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return mean(record.items[a].relative) < mean(record.items[b].relative);
  });
  std::vector<std::size_t> result = {order.front(), order.back()};
  if (!record.items[0].relative.empty()) result.insert(result.begin() + 1, 0);
  std::vector<std::size_t> distinct;
  for (const std::size_t i : result)
    if (std::find(distinct.begin(), distinct.end(), i) == distinct.end()) distinct.push_back(i);
  distinct.resize(std::min(distinct.size(), kSettingsShown));
  return distinct;
}

/// The tiles in which best and worst differ most, with what their FLIP is.
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
      return mean(std::span(record.items[setting].relative).subspan(first / 3, pixels));
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

std::string to_html(const Record& record) {
  Json data = to_json(record, false);
  data["exposure_ev"] = record.circumstances.exposure_ev;
  data["words"] = to_text(record);
  if (record.question->layout().tiles.empty()) {
    data["items"] = items_json(record);
  } else {
    data["pictures"] = pictures_json(record);
  }
  // Within a page, "</script>" would end the data wherever it stands.
  const std::string text = absl::StrReplaceAll(data.dump(), {{"</", "<\\/"}});
  return absl::StrReplaceAll(std::string(kPage), {{"{{style}}", std::string(kStyle)},
                                                  {"{{licence}}", std::string(kLicence)},
                                                  {"{{library}}", std::string(kLibrary)},
                                                  {"{{data}}", text},
                                                  {"{{shared}}", std::string(kSharedScript)},
                                                  {"{{plots}}", std::string(kPlotsScript)},
                                                  {"{{page}}", std::string(kPageScript)}});
}

}  // namespace lucerna::tradeoff
