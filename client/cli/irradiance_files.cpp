#include "client/cli/irradiance_files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include "client/cli/irradiance_output.h"
#include "client/files/npy_file.h"
#include "client/files/open_vectors.h"
#include "client/library/irradiance_job.h"
#include "client/terminal/certainty.h"
#include "client/terminal/output.h"
#include "client/terminal/print.h"
#include "client/terminal/progress.h"

namespace lucerna::cli {
namespace {

namespace fs = std::filesystem;
using client::VectorFile;
using client::VectorFormat;
using client::VectorKind;

std::unique_ptr<VectorFile> open(const std::string& path, VectorKind kind) {
  auto file = client::open_vectors(path, kind);
  if (!file.ok()) wrong_use(std::string(file.status().message()));
  return *std::move(file);
}

/// Points of one file.  The normals are in the same file or in another file, or all points share
/// one normal.
class Receivers final : public client::ReceiverSource {
 public:
  Receivers(const std::string& points, const std::string& normals,
            const std::optional<Double3>& normal)
      : points_(open(points, VectorKind::kPoints)), normal_(normal) {
    if (points_->rows() == 0) wrong_use(points + ": has no points");
    const bool own = points_->columns() == 6;
    if (int{own} + int{!normals.empty()} + int{normal.has_value()} > 1) {
      wrong_use(
          own ? fmt::format("{}: has its own normals; do not give --normals or --normal", points)
              : "--normals and --normal: only one of them");
    }
    if (own || normal) return;
    if (normals.empty()) {
      wrong_use(
          fmt::format("no normals: give --normals FILE or --normal, or normals in {}", points));
    }
    normals_ = open(normals, VectorKind::kNormals);
    if (normals_->columns() != 3) {
      wrong_use(fmt::format("{}: {} columns, must be 3: normals", normals, normals_->columns()));
    }
    const client::MapWindow *a = points_->window(), *b = normals_->window();
    if (a != nullptr && b != nullptr && (a->width != b->width || a->height != b->height)) {
      wrong_use(fmt::format("{} has {} x {} texels, {} has {} x {}", normals, b->width, b->height,
                            points, a->width, a->height));
    }
    if (normals_->rows() != points_->rows()) {
      wrong_use(fmt::format("{} has {} normals, {} has {} points", normals, normals_->rows(),
                            points, points_->rows()));
    }
  }

  std::uint64_t size() const override { return points_->rows(); }
  const client::MapWindow* window() const { return points_->window(); }
  /// The error of the last read().
  const absl::Status& failed() const { return failed_; }

  absl::Status read(std::uint64_t first, std::size_t count, std::vector<Double3>& points,
                    std::vector<float>& normals) override {
    const std::size_t columns = points_->columns();
    points.resize(count);
    normals.resize(3 * count);
    numbers_.resize(count * columns);
    failed_ = points_->read(first, numbers_);
    for (std::size_t i = 0; i < count; ++i) {
      const double* row = numbers_.data() + i * columns;
      points[i] = {row[0], row[1], row[2]};
      const double* normal = columns == 6 ? row + 3 : normal_ ? normal_->data() : nullptr;
      if (normal != nullptr) std::copy_n(normal, 3, normals.data() + 3 * i);
    }
    if (normals_ != nullptr && failed_.ok()) {
      numbers_.resize(3 * count);
      failed_ = normals_->read(first, numbers_);
      std::copy(numbers_.begin(), numbers_.end(), normals.begin());
    }
    return failed_;
  }

 private:
  std::unique_ptr<VectorFile> points_, normals_;
  std::optional<Double3> normal_;
  std::vector<double> numbers_;
  absl::Status failed_;
};

/// The file that holds the results until they are complete.  The destructor deletes it unless a
/// journal refers to it.
class PartFile {
 public:
  PartFile(const std::string& output, std::string journal)
      : path_(output + ".part"), journal_(std::move(journal)) {
    std::error_code error;
    if (fs::is_directory(output, error))
      wrong_use("cannot write " + output + ": it is a directory");
    const int file = ::open(path_.c_str(), O_CREAT | O_WRONLY | O_CLOEXEC, 0666);
    if (file < 0) wrong_use(fmt::format("cannot write {}: {}", output, std::strerror(errno)));
    ::close(file);
  }
  PartFile(const PartFile&) = delete;
  PartFile& operator=(const PartFile&) = delete;
  ~PartFile() {
    std::error_code error;
    if (!journal_.empty() && fs::exists(journal_, error)) return;
    const int file = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC);
    if (file < 0) return;
    // Another process may hold the lock and write to the file; this one then leaves it.
    if (::flock(file, LOCK_EX | LOCK_NB) == 0) ::unlink(path_.c_str());
    ::close(file);
  }

  const std::string& path() const { return path_; }
  /// Deletes the journal.  Call it when the results have their final name.
  void done() {
    std::error_code error;
    if (!journal_.empty()) fs::remove(journal_, error);
  }

 private:
  std::string path_, journal_;
};

void must_differ(const std::string& output, const std::string& other, const char* option) {
  std::error_code error;
  const bool same = !other.empty() && (fs::equivalent(output, other, error) ||
                                       fs::absolute(output).lexically_normal() ==
                                           fs::absolute(other).lexically_normal());
  if (same) wrong_use(fmt::format("-o and {}: {} is given twice", option, other));
}

std::string describe_statuses(const client::IrradianceJobResult& result) {
  std::string text;
  for (std::size_t i = 0; i < result.statuses.size(); ++i) {
    if (i == v1::ITEM_STATUS_OK || result.statuses[i] == 0) continue;
    text += fmt::format(", {} {}", result.statuses[i], status_name(static_cast<float>(i)));
  }
  return text;
}

}  // namespace

void IrradianceFilesOption::add(CLI::App& command) {
  command
      .add_option(
          "-o,--output", output_,
          "Write the answers of --points to this file: .npy, .csv, or .exr if the points are a map")
      ->type_name("FILE");
  command
      .add_option("--normals", normals_,
                  "With -o: file of the normals if --points has none: .npy, .csv or .exr")
      ->type_name("FILE");
  servers_.add(command, false);
}

void IrradianceFilesOption::check() const {
  const auto needs = [](bool given, const char* name) {
    if (given) wrong_use(fmt::format("{} requires -o", name));
  };
  needs(!normals_.empty(), "--normals");
  needs(!servers_.servers.empty(), "--servers");
  needs(servers_.upload, "--upload");
  needs(!servers_.asset_root.empty(), "--asset-root");
  needs(!servers_.journal.empty(), "--journal");
}

void IrradianceFilesOption::run(Session& session, const std::string& scene,
                                const PointOptions& points, const TripleOption& normal,
                                const v1::EstimateIrradianceRequest& request) const {
  const std::string& journal = servers_.journal;
  if (points.file().empty() || points.file() == "-") {
    wrong_use("-o requires --points FILE: .npy, .csv or .exr");
  }
  if (session.csv()) wrong_use("--output csv: not with -o, whose file has the answers");
  if (request.per_light()) wrong_use("--per-light: not with -o, which has no columns for it");
  if (!servers_.asset_root.empty() && !servers_.upload) {
    wrong_use("--asset-root requires --upload");
  }
  const auto format = client::vector_format(output_);
  if (!format.ok()) wrong_use("cannot write " + std::string(format.status().message()));
  must_differ(output_, points.file(), "--points");
  must_differ(output_, normals_, "--normals");
  must_differ(output_, journal, "--journal");
  std::optional<Double3> one;
  if (normal.given()) one = normal.read(1)[0];
  Receivers receivers(points.file(), normals_, one);
  if (*format == VectorFormat::kExr && receivers.window() == nullptr) {
    wrong_use(fmt::format("cannot write {}: {} is not a map, so it has no width and height",
                          output_, points.file()));
  }
  PartFile part(output_, journal);

  client::IrradianceJobOptions options;
  options.request = request;
  options.receivers = &receivers;
  options.results = part.path();
  options.journal = journal;
  const std::size_t columns = client::irradiance_columns(request);
  if (*format == VectorFormat::kNpy) {
    options.header = client::npy_header(receivers.size(), columns);
  }
  const auto result = [&] {
    ProgressBar bar;
    options.job = servers_.job(session, scene, bar);
    return client::run_irradiance_job(options);
  }();
  if (!receivers.failed().ok()) wrong_use(std::string(receivers.failed().message()));
  if (!result.ok()) session.fail_here(result.status(), kServerRefused);
  const std::string mixed = describe_mixed(result->report);
  if (!mixed.empty()) shell::print_text(stderr, "{}\n", mixed);

  const IrradianceOutput output{.output = output_,
                                .results = part.path(),
                                .format = *format,
                                .request = request,
                                .samples = result->samples,
                                .description = mixed};
  const v1::Accuracy& accuracy = request.accuracy();
  absl::StatusOr<TargetCheck> target(accuracy.target_error());
  if (accuracy.has_target_error()) target = check_results(output, options.header, receivers.size());
  if (!target.ok()) session.fail_here(target.status(), kServerRefused);
  const absl::Status written = write_irradiance(output, receivers, receivers.window());
  if (!written.ok()) {
    throw CommandError(kServerRefused, "cannot write " + std::string(written.message()));
  }
  part.done();

  v1::EstimateIrradianceResponse summary;
  summary.set_samples(result->samples);
  *summary.mutable_cost() = result->cost;
  if (session.json()) {
    std::string more = json_of_approximate(accuracy);
    if (accuracy.has_target_error())
      more += fmt::format(",\"pointsNotReached\":{}", target->missed());
    shell::print_text(stdout, "{}", to_json(summary, more));
  } else {
    const std::string before =
        result->from_journal > 0
            ? fmt::format(", {} of them from the journal", result->from_journal)
            : "";
    shell::print_text(stdout, "{}: {} points{}{}; {}{}{}{}\n", output_, receivers.size(), before,
                      describe_statuses(*result),
                      describe_missed(result->statuses[v1::ITEM_STATUS_MAY_MISS_LIGHT],
                                      receivers.size(), result->missed_surfaces),
                      target->describe("points"), describe(summary.cost()),
                      describe_approximations(accuracy, summary.cost()));
    session.print_remarks();
  }
  // A map has texels without a surface, whose status is INVALID_INPUT.
  const auto failed = [&](std::size_t status) {
    google::protobuf::RepeatedField<int> statuses;
    statuses.Add(static_cast<int>(status));
    return result->statuses[status] > 0 && any_failed(statuses) &&
           !(receivers.window() != nullptr && status == v1::ITEM_STATUS_INVALID_INPUT);
  };
  for (std::size_t status = 0; status < result->statuses.size(); ++status) {
    if (failed(status)) session.set_exit_status(kServerRefused);
  }
}

}  // namespace lucerna::cli
