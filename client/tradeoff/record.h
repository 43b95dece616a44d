// The results of a study, and the files of the results.
#pragma once

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "client/tradeoff/analysis.h"
#include "client/tradeoff/question.h"

namespace lucerna::tradeoff {

/// The circumstances of the measurements: scene, server, client and budget.
struct Circumstances {
  std::string scene, scene_id;
  std::string client_version, server_version, fingerprint, build, embree;
  std::uint32_t server_threads = 0;
  std::string date;     ///< UTC, "2026-01-31T12:00:00Z"
  double budget_s = 0;  ///< 0 where rounds are set
  double spent_s = 0;
  std::uint32_t rounds = 0, max_samples = 0;  ///< 0 where a budget is set
  std::uint64_t seed = 0;
  double exposure_ev = 0;
};

/// The errors of all items with one setting, at the amount that is compared.
struct ItemErrors {
  /// For each item, the root of the mean over runs of the relative squared error.  Pictures have
  /// one value for each pixel, not for each channel.
  std::vector<float> relative;
  /// The last answer.  Only pictures have it.
  std::vector<float> values;
};

struct Record {
  const Question* question = nullptr;
  Circumstances circumstances;
  std::vector<Setting> settings;
  Reference reference;
  SweepResult sweep;
  Analysis analysis;
  std::vector<ItemErrors> items;  ///< one for each setting; empty if it is not compared
};

/// The text of tradeoff.csv, one row for each run.
std::string to_csv(const Record& record);
/// One line of JSON with everything that the page shows, and with the runs if `with_runs`.
std::string to_json(const Record& record, bool with_runs);
/// Recommendations, warnings and the reference, in words.
std::string to_text(const Record& record);

/// Makes the directory and checks that files can be written to it.  INVALID_ARGUMENT with the
/// reason.
absl::Status make_directory(const std::string& path);
/// Writes the whole file or nothing.  UNKNOWN with the reason.
absl::Status write_file(const std::string& path, const std::string& text);
/// Writes tradeoff.csv, tradeoff.json and report.html into `directory`.
absl::Status write(const Record& record, const std::string& directory);

}  // namespace lucerna::tradeoff
