#include "client/tradeoff/record.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <utility>

#include "client/tradeoff/study_report.h"
#include "proto/common/status_macros.h"

namespace lucerna::tradeoff {

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

std::string to_text(const Record& record) {
  const Reference& ref = record.reference;
  std::string text =
      fmt::format("Reference: {}.\n", ref.way) +
      (ref.exact && ref.relative_error == 0 ? "Its own error: 0, except rounding.\n"
       : ref.exact ? fmt::format("Its own error: at most {:.2g}%.\n", 100 * ref.relative_error)
                   : fmt::format("Its own error: {:.2g}% ({:.3g} as RMSE), from the scatter of {} "
                                 "answers of {} samples with different seeds, {:.1f} s.\n",
                                 100 * ref.relative_error, ref.rmse, ref.replicates,
                                 ref.samples_each, ref.seconds));
  const auto& levels = record.analysis.levels;
  // One line is enough if the same exact setting is recommended for every error.
  const bool any_error = std::all_of(levels.begin(), levels.end(), [&](const Recommendation& r) {
    return r.exact && r.setting == levels[0].setting;
  });
  for (const Recommendation& r : levels) {
    if (any_error && &r != &levels[0]) break;
    if (!r.setting) {
      text += fmt::format(
          "{:g}%: {}.\n", 100 * r.error,
          r.below_reference ? "below the error of the reference" : "no setting reached this error");
      continue;
    }
    const auto beyond = [](bool extrapolated) { return extrapolated ? " (extrapolated)" : ""; };
    const auto is_beyond = [](const Reached& x) { return x.how == Reached::How::kExtrapolated; };
    text += fmt::format(
        "{}: {}, {:.3g} s{}", any_error ? "any error" : fmt::format("{:g}%", 100 * r.error),
        record.settings[*r.setting].name(), r.reached.seconds,
        r.exact                                      ? ", exact"
        : r.reached.how == Reached::How::kWithFewest ? " or less (the smallest amount "
                                                       "reaches this error)"
                                                     : beyond(is_beyond(r.reached)));
    if (r.best != *r.setting) {
      text += fmt::format("; not significantly slower than the fastest, {}, {:.3g} s{}",
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

absl::Status write_file(const std::string& path, const std::string& text) {
  const std::string temporary = path + ".part";
  errno = 0;
  std::ofstream file(temporary, std::ios::binary);
  file << text;
  file.close();
  std::error_code error;
  if (file) std::filesystem::rename(temporary, path, error);
  if (file && !error) return absl::OkStatus();
  return absl::UnknownError(
      fmt::format("cannot write {}: {}", path, error ? error.message() : std::strerror(errno)));
}

absl::Status write(const Record& record, const std::string& directory) {
  const std::string json = to_json(record, true) + "\n";
  LUCERNA_ASSIGN_OR_RETURN(const std::string page, report_page(json));
  const std::array<std::pair<const char*, std::string>, 3> files = {
      {{"tradeoff.csv", to_csv(record)}, {"tradeoff.json", json}, {"report.html", page}}};
  for (const auto& [name, text] : files) {
    LUCERNA_RETURN_IF_ERROR(write_file((std::filesystem::path(directory) / name).string(), text));
  }
  return absl::OkStatus();
}

}  // namespace lucerna::tradeoff
