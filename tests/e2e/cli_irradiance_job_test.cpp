// Many receivers on several servers, which are killed, halted and interrupted during the job.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>

#include "lucerna/client/irradiance_job.h"
#include "lucerna/client/testing/local_server.h"
#include "tests/paths.h"
#include "tests/temp_directory.h"

namespace lucerna {
namespace {

namespace fs = std::filesystem;
using client::Double3;
using client::IrradianceJobOptions;
using client::IrradianceJobResult;
using ::testing::Contains;
using ::testing::HasSubstr;

/// Receivers in memory.
class Receivers final : public client::ReceiverSource {
 public:
  std::uint64_t size() const override { return points.size(); }
  absl::Status read(std::uint64_t first, std::size_t count, std::vector<Double3>& to,
                    std::vector<float>& to_normals) override {
    const auto at = static_cast<long>(first), n = static_cast<long>(count);
    to.assign(points.begin() + at, points.begin() + at + n);
    to_normals.assign(normals.begin() + 3 * at, normals.begin() + 3 * (at + n));
    return absl::OkStatus();
  }

  std::vector<Double3> points;
  std::vector<float> normals;
};

class IrradianceJob : public ::testing::Test {
 protected:
  static constexpr std::size_t kPoints = 600;

  void SetUp() override {
    add_server();
    if (HasFatalFailure()) return;
    // On the floor, on both sides of zero.  A subset of them would have its own origin.
    for (std::size_t i = 0; i < kPoints; ++i) {
      const double x = 0.011 * static_cast<double>(i) - 3.3, y = std::sin(static_cast<double>(i));
      receivers_.points.push_back({x, y, 0.0});
      receivers_.normals.insert(receivers_.normals.end(), {0, 0.1F, 1});
    }
    receivers_.points[100][1] = std::numeric_limits<double>::quiet_NaN();
    std::fill_n(receivers_.normals.begin() + std::ptrdiff_t{3} * 333, 3, 0.0F);
    request_.mutable_seed()->set_seed(5);
    request_.mutable_seed()->set_first_item(1000);
    request_.mutable_accuracy()->set_samples(48);
    request_.set_bounces(2);
    expected_ = one_request();
    options_.request = request_;
    options_.receivers = &receivers_;
    options_.results = (directory_ / "results").string();
    options_.job.servers = [this]() -> absl::StatusOr<std::vector<std::string>> {
      return targets_;
    };
    options_.job.load = [](const client::Client& client, const client::CallOptions& call) {
      v1::LoadSceneRequest request;
      request.set_path("point.pbrt");
      request.set_lease_s(60);
      return client.load_scene(request, call);
    };
    options_.job.call = client::CallOptions::within(std::chrono::minutes(10));
    options_.job.on_event = [this](const std::string& event) { events_.push_back(event); };
  }

  void add_server() {
    auto server = testing::LocalServer::start({.scene_root = test_data("reference"), .threads = 1});
    ASSERT_TRUE(server.ok()) << server.status();
    servers_.push_back(std::make_unique<testing::LocalServer>(*std::move(server)));
    targets_.push_back(servers_.back()->target());
  }

  /// The answer of one call, as rows.
  std::vector<float> one_request() {
    v1::LoadSceneRequest load;
    load.set_path("point.pbrt");
    v1::EstimateIrradianceRequest request = request_;
    request.set_scene_id(servers_[0]->client().load_scene(load).value().scene_id());
    *request.mutable_receivers() = client::make_points(receivers_.points);
    request.mutable_normals()->Assign(receivers_.normals.begin(), receivers_.normals.end());
    const auto answer = servers_[0]->client().estimate_irradiance(request).value();
    std::vector<float> rows;
    below_the_box_ =
        static_cast<std::size_t>(std::ranges::count(answer.status(), v1::ITEM_STATUS_INSIDE_SOLID));
    EXPECT_GT(below_the_box_, 0U);
    for (int i = 0; i < static_cast<int>(kPoints); ++i) {
      rows.push_back(answer.illuminance_lx(i));
      for (int c = 0; c < 3; ++c) rows.push_back(answer.irradiance_lx(3 * i + c));
      rows.push_back(answer.standard_error_lx(i));
      rows.push_back(answer.zero_bound_lx(i));
      rows.push_back(static_cast<float>(answer.status(i)));
      rows.push_back(answer.lower_lx(i));
      rows.push_back(answer.upper_lx(i));
      rows.push_back(answer.unsampled_bound_lx().empty() ? 0 : answer.unsampled_bound_lx(i));
      if (!answer.has_item_costs()) continue;
      rows.push_back(static_cast<float>(answer.item_costs().samples(i)));
    }
    return rows;
  }

  std::vector<float> results() const {
    std::ifstream in(options_.results, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(in), {}};
    EXPECT_TRUE(bytes.starts_with(options_.header));
    std::vector<float> rows((bytes.size() - options_.header.size()) / sizeof(float));
    std::memcpy(rows.data(), bytes.data() + options_.header.size(), rows.size() * sizeof(float));
    return rows;
  }

  void expect_the_same_bits(const absl::StatusOr<IrradianceJobResult>& result) {
    ASSERT_TRUE(result.ok()) << result.status();
    EXPECT_EQ(results(), expected_);
    EXPECT_EQ(result->statuses[v1::ITEM_STATUS_OK], kPoints - 2 - below_the_box_);
    EXPECT_EQ(result->statuses[v1::ITEM_STATUS_INSIDE_SOLID], below_the_box_);
    EXPECT_EQ(result->statuses[v1::ITEM_STATUS_INVALID_INPUT], 2U);
    if (!options_.request.accuracy().has_target_error()) {
      EXPECT_EQ(result->samples, 48U);
    }
  }

  /// Calls `f` once, when the job has finished `pieces` pieces.
  void when(std::size_t pieces, std::function<void()> f) {
    options_.job.on_progress = [pieces, f = std::move(f),
                                called = false](const client::JobProgress& p) mutable {
      if (called || p.done < pieces) return;
      called = true;
      f();
    };
  }

  const TempDirectory temporary_;
  const fs::path directory_ = temporary_.path();
  std::vector<std::unique_ptr<testing::LocalServer>> servers_;
  std::vector<std::string> targets_;
  Receivers receivers_;
  v1::EstimateIrradianceRequest request_;
  std::vector<float> expected_;
  std::size_t below_the_box_ = 0;  ///< receivers on the floor below the box of the scene
  IrradianceJobOptions options_;
  std::vector<std::string> events_;
};

TEST_F(IrradianceJob, TheSameBitsAsOneRequestFromAnyNumberOfServersAndAnyPieces) {
  for (const int n : {1, 2, 3}) {
    while (static_cast<int>(servers_.size()) < n) add_server();
    for (const std::uint32_t items : {1U, 7U, 64U, 0U}) {
      SCOPED_TRACE(::testing::Message() << n << " servers, " << items);
      options_.items_per_piece = items;
      options_.header = std::string(items, 'h');
      const auto result = client::run_irradiance_job(options_);
      expect_the_same_bits(result);
      EXPECT_EQ(result->pieces, items == 0 ? 1 : (kPoints + items - 1) / items);
    }
  }
}

TEST_F(IrradianceJob, FinishesWithoutServersThatAreKilledOrHalt) {
  add_server();
  add_server();
  options_.items_per_piece = 4;
  when(20, [this] {
    ::kill(servers_[1]->process_id(), SIGKILL);
    ::kill(servers_[2]->process_id(), SIGSTOP);
  });
  expect_the_same_bits(client::run_irradiance_job(options_));
  ::kill(servers_[2]->process_id(), SIGCONT);
}

TEST_F(IrradianceJob, AnInterruptedJobResumesFromItsJournal) {
  add_server();
  options_.journal = (directory_ / "journal").string();
  options_.items_per_piece = 4;
  std::stop_source stop;
  options_.job.call.stop = stop.get_token();
  when(50, [&] { stop.request_stop(); });
  EXPECT_EQ(client::run_irradiance_job(options_).status().code(), absl::StatusCode::kCancelled);
  // Cuts the journal within a record, and spoils the results of another piece.
  fs::resize_file(options_.journal, fs::file_size(options_.journal) - 5);
  {
    std::fstream file(options_.results, std::ios::binary | std::ios::in | std::ios::out);
    file.seekp(3);
    file.put(1);
  }
  // The journal records where results are, and does not repeat them.
  EXPECT_LT(fs::file_size(options_.journal), 100 + 50 * 40);
  options_.job.call.stop = {};
  options_.job.on_progress = {};
  options_.items_per_piece = 9;
  const auto result = client::run_irradiance_job(options_);
  expect_the_same_bits(result);
  EXPECT_GE(result->from_journal, 4 * 48U);
  EXPECT_LT(result->from_journal, kPoints);
  const auto again = client::run_irradiance_job(options_);
  expect_the_same_bits(again);
  EXPECT_EQ(again->from_journal, kPoints);
  EXPECT_EQ(again->pieces, 0U);

  receivers_.normals[7] = 0.5F;
  EXPECT_EQ(client::run_irradiance_job(options_).status().code(),
            absl::StatusCode::kFailedPrecondition);
}

TEST_F(IrradianceJob, AJournalWithoutItsResultsIsNotUsed) {
  options_.journal = (directory_ / "journal").string();
  options_.items_per_piece = 64;
  expect_the_same_bits(client::run_irradiance_job(options_));
  fs::remove(options_.results);
  const auto result = client::run_irradiance_job(options_);
  expect_the_same_bits(result);
  EXPECT_EQ(result->from_journal, 0U);
  EXPECT_THAT(events_, Contains(HasSubstr("lacks 10 of the runs in ")));
}

TEST_F(IrradianceJob, ASingleSampleHasNoErrorAndWavelengthsAreTheLastColumns) {
  options_.request.mutable_accuracy()->set_samples(1);
  options_.request.set_bounces(0);
  options_.request.add_wavelengths_nm(450);
  options_.request.add_wavelengths_nm(555);
  ASSERT_TRUE(client::run_irradiance_job(options_).ok());
  const std::vector<float> rows = results();
  ASSERT_EQ(rows.size(), 12 * kPoints);
  for (const std::size_t c :
       {client::kStandardErrorColumn, client::kLowerColumn, client::kUpperColumn})
    EXPECT_TRUE(std::isnan(rows[c])) << c;
  EXPECT_GT(rows[0], 0);
  EXPECT_EQ(rows[client::kStatusColumn], 1);
  // In W/m2/nm.  The white light has most of its watts in the middle.
  EXPECT_GT(rows[client::kIrradianceColumns], 0);
  EXPECT_GT(rows[client::kIrradianceColumns + 1], 0);
  EXPECT_LT(rows[client::kIrradianceColumns + 1], rows[0] / 100);
}

TEST_F(IrradianceJob, ATargetErrorGivesIntervalsAndSamplesOfEachReceiver) {
  add_server();
  request_.mutable_accuracy()->mutable_target_error()->set_relative(0.2);
  request_.mutable_accuracy()->mutable_target_error()->set_max_samples(512);
  expected_ = one_request();
  options_.request = request_;
  options_.journal = (directory_ / "journal").string();
  options_.items_per_piece = 64;
  expect_the_same_bits(client::run_irradiance_job(options_));
  const auto again = client::run_irradiance_job(options_);
  expect_the_same_bits(again);
  EXPECT_EQ(again->from_journal, kPoints);
  const std::vector<float> rows = results();
  ASSERT_EQ(rows.size(), 11 * kPoints);
  EXPECT_LT(rows[7], rows[0]);
  EXPECT_GT(rows[8], rows[0]);
  EXPECT_GE(rows[client::kSamplesColumn], 64);
  // Without the target the rows have other columns, so they must not replace these.
  options_.request.mutable_accuracy()->set_samples(48);
  EXPECT_EQ(client::run_irradiance_job(options_).status().code(),
            absl::StatusCode::kFailedPrecondition);
}

}  // namespace
}  // namespace lucerna
