#include "lucerna/client/irradiance_job.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cstring>
#include <limits>
#include <mutex>
#include <optional>
#include <span>
#include <utility>

#include "client/library/batch_parts.h"
#include "client/library/journal.h"
#include "client/library/result_file.h"
#include "proto/common/answer_size.h"
#include "proto/common/defaults.h"
#include "proto/common/sha256.h"
#include "proto/common/status_macros.h"

namespace lucerna::client {
namespace {

// Samples of one piece: a few seconds of one core with several bounces.
constexpr std::uint64_t kSamplesPerPiece = std::uint64_t{1} << 20;
constexpr std::size_t kItemsPerRead = 8192;  // for the survey of the whole file

std::uint32_t samples_of(const v1::EstimateIrradianceRequest& request) {
  return request.accuracy().has_samples() ? request.accuracy().samples() : kIrradianceSamples;
}

/// Properties of all receivers, found before the first call.
struct Survey {
  Double3 origin;
  std::string digest;  // of all receivers
};

absl::StatusOr<Survey> survey(ReceiverSource& receivers) {
  PointOrigin origin;
  Sha256 digest;
  std::vector<Double3> points;
  std::vector<float> normals;
  const auto bytes = [](const auto& v) {
    return std::string_view(reinterpret_cast<const char*>(v.data()), v.size() * sizeof v[0]);
  };
  for (std::uint64_t first = 0; first < receivers.size();) {
    const std::size_t count = std::min<std::uint64_t>(kItemsPerRead, receivers.size() - first);
    LUCERNA_RETURN_IF_ERROR(receivers.read(first, count, points, normals));
    for (const Double3& point : points) origin.add(point);
    digest.add(bytes(points));
    digest.add(bytes(normals));
    first += count;
  }
  return Survey{origin.origin(), digest.finish()};
}

/// The smallest limits of the servers used so far.
class Limits {
 public:
  absl::Status add(const Client& client, const CallOptions& call) {
    LUCERNA_ASSIGN_OR_RETURN(const auto info, client.get_server_info({}, call));
    const std::lock_guard lock(mutex_);
    items_ = std::min<std::uint64_t>(items_, info.limits().max_batch_items());
    bytes_ = std::min(bytes_, std::uint64_t{info.limits().max_message_bytes()});
    return absl::OkStatus();
  }

  /// Receivers of a piece.
  std::uint32_t items_per_piece(const v1::EstimateIrradianceRequest& request) const {
    const std::lock_guard lock(mutex_);
    const AnswerSize answer = answer_size(request, 0);
    const std::uint64_t once = answer.fixed + request.ByteSizeLong();
    const std::uint64_t each = std::max<std::uint64_t>(answer.per_item, 6 * sizeof(float));
    const std::uint64_t by_bytes = bytes_ > once ? (bytes_ - once) / each : 1;
    const std::uint64_t by_samples = kSamplesPerPiece / std::max(1U, samples_of(request));
    const std::uint64_t most =
        std::min({std::uint64_t{kGoodBatchItems}, items_, by_bytes, by_samples});
    return static_cast<std::uint32_t>(std::bit_floor(std::max<std::uint64_t>(1, most)));
  }

 private:
  mutable std::mutex mutex_;
  std::uint64_t items_ = std::numeric_limits<std::uint64_t>::max();
  std::uint64_t bytes_ = std::numeric_limits<std::uint64_t>::max();
};

/// Receivers [first, end).
struct ReceiverRun {
  std::uint64_t first, end;
};

/// A journal record: a run of rows that are in the file of results.
struct JournalRecord {
  ReceiverRun run;
  std::array<char, 8> sum;  // first bytes of the rows' SHA-256

  std::string bytes() const { return {reinterpret_cast<const char*>(this), sizeof(JournalRecord)}; }
};

std::array<char, 8> sum_of(std::span<const float> values) {
  const std::string digest =
      sha256({reinterpret_cast<const char*>(values.data()), values.size_bytes()});
  std::array<char, 8> sum{};
  std::copy_n(digest.begin(), sum.size(), sum.begin());
  return sum;
}

/// Opens the file of results.  Does not replace results of another shape if a journal refers to
/// them, since the user may have given a wrong name.
absl::StatusOr<ResultFile> open_results(const IrradianceJobOptions& options) {
  const bool has_records = !options.journal.empty() && Journal::has_records(options.journal);
  auto results =
      ResultFile::open(options.results, options.header, options.receivers->size(),
                       irradiance_columns(options.request),
                       has_records ? ResultFile::Other::kKeep : ResultFile::Other::kReplace);
  if (absl::IsFailedPrecondition(results.status()))
    return absl::FailedPreconditionError(
        options.results + ": has results for other receivers or wavelengths, which the journal " +
        options.journal + " refers to: repeat that job, or remove both files");
  return results;
}

/// The pieces of one set of receivers.
class Irradiance final : public DistributedWork {
 public:
  Irradiance(const IrradianceJobOptions& options, Survey survey, ResultFile results,
             const Limits& limits)
      : options_(options),
        receivers_(*options.receivers),
        survey_(std::move(survey)),
        results_(std::move(results)),
        limits_(limits) {}

  /// Cuts the receivers that are not done yet into pieces.
  absl::Status begin(const v1::SceneSummary& scene,
                     const v1::GetServerInfoResponse& server) override {
    const std::uint32_t items_per_piece = options_.items_per_piece > 0
                                              ? options_.items_per_piece
                                              : limits_.items_per_piece(options_.request);
    if (!options_.journal.empty()) {
      LUCERNA_ASSIGN_OR_RETURN(journal_, Journal::open(options_.journal, name(scene, server),
                                                       [this](const std::string& record) {
                                                         return from_journal(record);
                                                       }));
    }
    if (lost_ > 0 && options_.job.on_event)
      options_.job.on_event(options_.results + " lacks " + std::to_string(lost_) +
                            " of the runs in " + options_.journal + ": they are computed again");
    std::sort(done_.begin(), done_.end(),
              [](const ReceiverRun& a, const ReceiverRun& b) { return a.first < b.first; });
    std::uint64_t next = 0;
    const auto cut_until = [&](std::uint64_t end) {
      for (; next < end; next = pieces_.back().end)
        pieces_.push_back({next, std::min(next + items_per_piece, end)});
    };
    const std::uint64_t most = receivers_.size() / items_per_piece + done_.size();
    if (most >= kMostPieces)
      return absl::InvalidArgumentError("the receivers need " + std::to_string(most) +
                                        " pieces of " + std::to_string(items_per_piece) +
                                        ", allowed: " + std::to_string(kMostPieces));
    for (const ReceiverRun& run : done_) {
      cut_until(run.first);
      if (run.end > next) {
        from_journal_ += run.end - next;
        LUCERNA_RETURN_IF_ERROR(count({next, run.end}));
        next = run.end;
      }
    }
    cut_until(receivers_.size());
    std::vector<ReceiverRun>().swap(done_);
    return absl::OkStatus();
  }

  std::size_t size() const override { return pieces_.size(); }

  void start(std::size_t number, const Client& client, const std::string& scene_id,
             const CallOptions& options, Done done) override {
    const ReceiverRun& run = pieces_[number];
    const std::size_t count = run.end - run.first;
    if (absl::Status s = receivers_.read(run.first, count, points_, normals_); !s.ok()) {
      failed_ = s;
      // ABORTED: the original code could look like a failed server, and the piece would be tried
      // again.
      return done(absl::AbortedError(s.message()));
    }
    v1::EstimateIrradianceRequest request = options_.request;
    request.set_scene_id(scene_id);
    *request.mutable_receivers() = make_points(points_, survey_.origin);
    request.mutable_normals()->Assign(normals_.begin(), normals_.end());
    request.mutable_seed()->set_first_item(options_.request.seed().first_item() + run.first);
    client.estimate_irradiance(request, options,
                               answer_as<v1::EstimateIrradianceResponse>(std::move(done)));
  }

  absl::Status accept(std::size_t number, Result result) override {
    const auto& response = static_cast<v1::EstimateIrradianceResponse&>(*result);
    const ReceiverRun& run = pieces_[number];
    LUCERNA_RETURN_IF_ERROR(to_rows(response, run.end - run.first));
    LUCERNA_RETURN_IF_ERROR(results_.write(run.first, rows_));
    count_statuses();
    client::append_cost(response.cost(), &cost_);
    samples_ = std::max(samples_, response.samples());
    missed_surfaces_.insert(response.missed_surfaces().begin(), response.missed_surfaces().end());
    return journal_ ? journal_->add(JournalRecord{run, sum_of(rows_)}.bytes()) : absl::OkStatus();
  }

  /// The error of reading receivers, if any.
  const absl::Status& failed() const { return failed_; }

  void put(IrradianceJobResult& result) const {
    result.pieces = pieces_.size();
    result.from_journal = from_journal_;
    result.samples = samples_ > 0 ? samples_ : samples_of(options_.request);
    result.statuses = statuses_;
    result.missed_surfaces = missed_surfaces_;
    result.cost = cost_;
  }

 private:
  /// Identifies the job in the journal.
  std::string name(const v1::SceneSummary& scene, const v1::GetServerInfoResponse& server) const {
    v1::EstimateIrradianceRequest named = options_.request;
    named.set_scene_id(scene.scene_id());
    if (!named.accuracy().has_target_error())
      named.mutable_accuracy()->set_samples(samples_of(options_.request));
    std::string job = named.SerializeAsString() + survey_.digest;
    if (!options_.job.allow_mixed) job += server.fingerprint().digest();
    return hexadecimal(sha256(job));
  }

  /// Takes a record.  Ignores it if its rows are not in the file, for example after a power
  /// failure.
  absl::Status from_journal(const std::string& bytes) {
    JournalRecord record{};
    const bool fits = bytes.size() == sizeof record;
    if (fits) std::memcpy(&record, bytes.data(), sizeof record);
    const ReceiverRun& run = record.run;
    if (!fits || run.first >= run.end || run.end > results_.rows())
      return absl::FailedPreconditionError(options_.journal +
                                           ": has a record that is not a piece of this job");
    rows_.resize((run.end - run.first) * results_.columns());
    LUCERNA_RETURN_IF_ERROR(results_.read(run.first, rows_));
    if (sum_of(rows_) == record.sum) {
      done_.push_back(run);
    } else {
      ++lost_;
    }
    return absl::OkStatus();
  }

  /// Counts the statuses of a run that the file holds.
  absl::Status count(const ReceiverRun& run) {
    rows_.resize((run.end - run.first) * results_.columns());
    LUCERNA_RETURN_IF_ERROR(results_.read(run.first, rows_));
    count_statuses();
    return absl::OkStatus();
  }

  void count_statuses() {
    for (std::size_t i = kStatusColumn; i < rows_.size(); i += results_.columns()) {
      const auto status = static_cast<std::size_t>(std::max(0.0F, rows_[i]));
      ++statuses_[status < statuses_.size() ? status : std::size_t{v1::ITEM_STATUS_UNSPECIFIED}];
    }
  }

  absl::Status to_rows(const v1::EstimateIrradianceResponse& response, std::size_t count) {
    const auto wavelengths = static_cast<std::size_t>(options_.request.wavelengths_nm_size());
    const bool target = options_.request.accuracy().has_target_error();
    const auto has = [count](int size, std::size_t per_item) {
      return static_cast<std::size_t>(size) == count * per_item;
    };
    if (!has(response.irradiance_lx_size(), 3) || !has(response.illuminance_lx_size(), 1) ||
        !has(response.zero_bound_lx_size(), 1) ||
        !(response.standard_error_lx().empty() || has(response.standard_error_lx_size(), 1)) ||
        !(response.status().empty() || has(response.status_size(), 1)) ||
        !(response.lower_lx().empty() || has(response.lower_lx_size(), 1)) ||
        response.upper_lx_size() != response.lower_lx_size() ||
        !(response.unsampled_bound_lx().empty() || has(response.unsampled_bound_lx_size(), 1)) ||
        (target &&
         (response.lower_lx().empty() || !has(response.item_costs().samples_size(), 1))) ||
        !has(response.spectral_irradiance_size(), wavelengths))
      return absl::InternalError("a server returned another number of receivers than requested");
    constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
    rows_.resize(count * results_.columns());
    float* row = rows_.data();
    for (int i = 0; i < static_cast<int>(count); ++i) {
      *row++ = response.illuminance_lx(i);
      for (int c = 0; c < 3; ++c) *row++ = response.irradiance_lx(3 * i + c);
      *row++ = response.standard_error_lx().empty() ? kUnknown : response.standard_error_lx(i);
      *row++ = response.zero_bound_lx(i);
      *row++ = static_cast<float>(response.status().empty() ? int{v1::ITEM_STATUS_OK}
                                                            : int{response.status(i)});
      *row++ = response.lower_lx().empty() ? kUnknown : response.lower_lx(i);
      *row++ = response.upper_lx().empty() ? kUnknown : response.upper_lx(i);
      *row++ = response.unsampled_bound_lx().empty() ? 0 : response.unsampled_bound_lx(i);
      if (target) *row++ = static_cast<float>(response.item_costs().samples(i));
      for (std::size_t w = 0; w < wavelengths; ++w)
        *row++ = response.spectral_irradiance(static_cast<int>(i * wavelengths + w));
    }
    return absl::OkStatus();
  }

  const IrradianceJobOptions& options_;
  ReceiverSource& receivers_;
  const Survey survey_;
  ResultFile results_;
  const Limits& limits_;
  std::optional<Journal> journal_;
  std::vector<ReceiverRun> done_;  // filled while the journal is read
  std::size_t lost_ = 0;           // records whose rows are not in the file
  std::vector<ReceiverRun> pieces_;
  // Buffers of the current piece.
  std::vector<Double3> points_;
  std::vector<float> normals_, rows_;

  absl::Status failed_;
  std::uint64_t from_journal_ = 0;
  std::uint32_t samples_ = 0;
  std::array<std::uint64_t, v1::ItemStatus_ARRAYSIZE> statuses_{};
  std::set<std::string> missed_surfaces_;
  v1::Cost cost_;
};

}  // namespace

std::size_t irradiance_columns(const v1::EstimateIrradianceRequest& request) {
  return kIrradianceColumns + (request.accuracy().has_target_error() ? 1 : 0) +
         static_cast<std::size_t>(request.wavelengths_nm_size());
}

absl::StatusOr<IrradianceJobResult> run_irradiance_job(const IrradianceJobOptions& options) {
  const auto begun = std::chrono::steady_clock::now();
  const std::uint64_t count = options.receivers->size();
  if (count == 0) return absl::InvalidArgumentError("there are no receivers");
  if (options.request.per_light())
    return absl::InvalidArgumentError(
        "per_light = true: the file of results has no columns for shares");
  if (options.request.accuracy().has_time_budget_s())
    return absl::InvalidArgumentError(
        "accuracy.time_budget_s: not allowed in a job, whose pieces wait for servers; set samples "
        "or a target error");
  LUCERNA_ASSIGN_OR_RETURN(auto results, open_results(options));
  LUCERNA_ASSIGN_OR_RETURN(auto surveyed, survey(*options.receivers));

  Limits limits;
  JobOptions job = options.job;
  job.load = [&](const Client& client,
                 const CallOptions& call) -> absl::StatusOr<v1::LoadSceneResponse> {
    LUCERNA_RETURN_IF_ERROR(limits.add(client, call));
    return options.job.load(client, call);
  };
  Irradiance irradiance(options, std::move(surveyed), std::move(results), limits);
  auto report = run_job(irradiance, job);
  if (!irradiance.failed().ok()) return irradiance.failed();
  if (!report.ok()) return report.status();
  IrradianceJobResult result;
  result.report = *std::move(report);
  irradiance.put(result);
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begun;
  result.cost.set_wall_time_s(wall.count());
  return result;
}

}  // namespace lucerna::client
