// All that is known at the end, and how it is written down.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "client/tradeoff/analysis.h"
#include "client/tradeoff/question.h"

namespace lucerna::tradeoff {

/// Where and how it was measured.
struct Circumstances {
  std::string scene, scene_id;
  std::string client_version, server_version, fingerprint, build, embree;
  std::uint32_t server_threads = 0;
  std::string target;  ///< the server's name
  std::string date;    ///< UTC, "2026-01-31T12:00:00Z"
  double budget_s = 0, spent_s = 0;
  std::uint64_t seed = 0;
  double exposure_ev = 0;
};

/// What items of one setting were like at the comparison's time.
struct ItemErrors {
  /// Root of the mean over runs of the relative squared error; of pictures a pixel, not a channel.
  std::vector<float> relative;
  /// The last answer; of pictures alone.
  std::vector<float> values;
};

struct Record {
  const Question* question = nullptr;
  Circumstances circumstances;
  std::vector<Setting> settings;
  Reference reference;
  SweepResult sweep;
  Analysis analysis;
  std::vector<ItemErrors> items;  ///< one a setting; empty where it was not compared
};

/// One row a run.
std::string to_csv(const Record& record);
/// Everything; the runs where `with_runs`.
nlohmann::ordered_json to_json(const Record& record, bool with_runs);
/// A page that needs nothing but itself.
std::string to_html(const Record& record);
/// Recommendations, warnings and the reference, in words.
std::string to_text(const Record& record);

/// Makes the directory, and makes sure that it can be written to.  INVALID_ARGUMENT with the
/// reason.
absl::Status make_directory(const std::string& path);
/// Writes tradeoff.csv, tradeoff.json and report.html, each whole or not at all.
absl::Status write(const Record& record, const std::string& directory);

}  // namespace lucerna::tradeoff
