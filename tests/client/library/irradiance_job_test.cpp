// Pieces of irradiance jobs, on servers whose answers the test decides.  tests/e2e has real
// servers.
#include "lucerna/client/irradiance_job.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <set>
#include <thread>

#include "tests/client/library/fake_server.h"
#include "tests/temp_directory.h"

namespace lucerna::client {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// Receiver i is at (i, 0, 1), or not finite on request.
class Line final : public ReceiverSource {
 public:
  explicit Line(std::uint64_t size, absl::Status second = {}) : size_(size), second_(second) {}
  int reads() const { return reads_; }
  std::uint64_t size() const override { return size_; }
  absl::Status read(std::uint64_t first, std::size_t count, std::vector<Double3>& points,
                    std::vector<float>& normals) override {
    if (++reads_ == 2 && !second_.ok()) return second_;
    points.clear();
    for (std::uint64_t i = first; i < first + count; ++i)
      points.push_back({static_cast<double>(i), 0, 1});
    normals.assign(3 * count, 1);
    return absl::OkStatus();
  }

 private:
  std::uint64_t size_;
  absl::Status second_;  // result of the second read
  int reads_ = 0;
};

class IrradianceJobTest : public ::testing::Test {
 protected:
  IrradianceJobTest() {
    for (FakeServer& server : servers_) {
      server.max_batch_items = 65536;
      server.load_scene = [](auto&, auto&, v1::LoadSceneResponse* response) {
        response->set_scene_id("scene");
        return grpc::Status::OK;
      };
      server.get_scene = [](auto&, auto&, v1::GetSceneResponse* response) {
        response->mutable_summary()->set_scene_id("scene");
        return grpc::Status::OK;
      };
      server.irradiance = [this](auto&, const v1::EstimateIrradianceRequest& request,
                                 v1::EstimateIrradianceResponse* response) {
        return answer(request, response);
      };
    }
    options_.results = (directory_.path() / "results").string();
    options_.job.servers = [this]() -> absl::StatusOr<std::vector<std::string>> {
      return std::vector<std::string>{servers_[0].target()};
    };
    options_.job.load = [](const Client& client, const CallOptions& call) {
      return client.load_scene({}, call);
    };
    options_.job.call = CallOptions::within(std::chrono::minutes(10));
  }

  /// The illuminance is the receiver's number.
  grpc::Status answer(const v1::EstimateIrradianceRequest& request,
                      v1::EstimateIrradianceResponse* response) {
    const int count = request.receivers().offsets_m_size() / 3;
    for (int i = 0; i < count - short_by_; ++i) {
      const double x = request.receivers().origin_m().x() + request.receivers().offsets_m(3 * i);
      response->add_illuminance_lx(static_cast<float>(x));
      response->add_zero_bound_lx(0);
      response->mutable_irradiance_lx()->Resize(3 * (i + 1), 0.5F);
    }
    response->set_samples(request.accuracy().samples());
    const std::lock_guard lock(mutex_);
    sizes_.insert(count);
    origins_.insert(request.receivers().origin_m().z());
    firsts_.insert(request.seed().first_item());
    largest_ = std::max(largest_, request.ByteSizeLong());
    return grpc::Status::OK;
  }

  absl::StatusOr<IrradianceJobResult> run(std::uint64_t count, std::uint32_t samples = 1) {
    Line line(count);
    options_.receivers = &line;
    // Unless the test sets another accuracy.
    v1::Accuracy& accuracy = *options_.request.mutable_accuracy();
    if (!accuracy.has_target_error() && !accuracy.has_time_budget_s())
      accuracy.set_samples(samples);
    sizes_.clear();
    firsts_.clear();
    return run_irradiance_job(options_);
  }
  /// Sizes of the requested pieces.
  std::set<int> sizes(std::uint64_t count, std::uint32_t samples = 1) {
    const auto result = run(count, samples);
    EXPECT_TRUE(result.ok()) << result.status();
    return sizes_;
  }

  const TempDirectory directory_;
  std::mutex mutex_;
  std::set<int> sizes_;
  std::set<double> origins_;
  std::set<std::uint64_t> firsts_;
  std::size_t largest_ = 0;
  int short_by_ = 0;
  FakeServer servers_[2];
  IrradianceJobOptions options_;
};

TEST_F(IrradianceJobTest, PiecesAreNeitherTinyNorMinutesLong) {
  EXPECT_THAT(sizes(40'000), ElementsAre(40'000 - 4 * 8192, 8192));
  EXPECT_THAT(sizes(10'000, 256), ElementsAre(10'000 - 2 * 4096, 4096));
  EXPECT_THAT(sizes(20, 100'000), ElementsAre(4, 8));
  EXPECT_THAT(sizes(3, 1 << 30), ElementsAre(1));
  EXPECT_THAT(firsts_, ElementsAre(0, 1, 2));
  EXPECT_THAT(origins_, ElementsAre(1));
}

TEST_F(IrradianceJobTest, PiecesStayWithinTheServersLimits) {
  servers_[0].max_batch_items = 3000;
  EXPECT_THAT(sizes(10'000), ElementsAre(10'000 - 4 * 2048, 2048));
  servers_[0].max_batch_items = 1 << 24;
  servers_[0].max_message_bytes = 100'000;
  sizes(10'000);
  EXPECT_LE(largest_, 100'000U);
  EXPECT_GT(largest_, 40'000U);
  // The caller's size has priority.
  options_.items_per_piece = 7000;
  EXPECT_THAT(sizes(10'000), ElementsAre(3000, 7000));
}

TEST_F(IrradianceJobTest, ResultsHaveTheOrderOfTheirReceivers) {
  options_.header = "head";
  options_.items_per_piece = 100;
  const auto result = run(1050);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->pieces, 11U);
  EXPECT_EQ(result->statuses[v1::ITEM_STATUS_OK], 1050U);
  std::ifstream in(options_.results, std::ios::binary);
  in.seekg(4);
  for (int i = 0; i < 1050; ++i) {
    float row[kIrradianceColumns];
    in.read(reinterpret_cast<char*>(row), sizeof row);
    ASSERT_TRUE(in) << i;
    EXPECT_EQ(row[0], static_cast<float>(i));
    EXPECT_EQ(row[3], 0.5F);
    EXPECT_EQ(row[kStatusColumn], 1);
  }
  EXPECT_EQ(in.peek(), std::ifstream::traits_type::eof());
}

TEST_F(IrradianceJobTest, EachStatusIsCounted) {
  // One receiver of each status that the contract has, and one of a later contract.
  const int statuses = v1::ItemStatus_ARRAYSIZE;
  servers_[0].irradiance = [&](auto&, const v1::EstimateIrradianceRequest& request,
                               v1::EstimateIrradianceResponse* response) {
    const int count = request.receivers().offsets_m_size() / 3;
    for (int i = 0; i < count; ++i) {
      const double x = request.receivers().origin_m().x() + request.receivers().offsets_m(3 * i);
      response->add_status(static_cast<v1::ItemStatus>(std::lround(x)));
    }
    return answer(request, response);
  };
  const auto result = run(static_cast<std::uint64_t>(statuses) + 1);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->statuses[v1::ITEM_STATUS_UNSPECIFIED], 2U);  // its own, and the unknown one
  for (int i = 1; i < statuses; ++i) EXPECT_EQ(result->statuses[i], 1U) << i;
}

TEST_F(IrradianceJobTest, ImpossibleJobsAreErrors) {
  EXPECT_THAT(run(0).status().message(), HasSubstr("there are no receivers"));
  options_.items_per_piece = 1;
  EXPECT_THAT(run((1 << 24) + 1).status().message(), HasSubstr("allowed: 16777216"));
  options_.request.set_per_light(true);
  EXPECT_THAT(run(1).status().message(), HasSubstr("per_light"));
  options_.request.set_per_light(false);
  options_.request.mutable_accuracy()->set_time_budget_s(1);
  EXPECT_THAT(run(1).status().message(), HasSubstr("time_budget_s"));
  options_.request.clear_accuracy();
  short_by_ = 1;
  options_.items_per_piece = 0;
  const auto result = run(10);
  EXPECT_EQ(result.status().code(), absl::StatusCode::kInternal);
  EXPECT_THAT(result.status().message(), HasSubstr("the server broke the protocol"));
}

TEST_F(IrradianceJobTest, UnreadableReceiversEndTheJob) {
  for (const absl::StatusCode code :
       {absl::StatusCode::kUnavailable, absl::StatusCode::kUnknown,
        absl::StatusCode::kDeadlineExceeded, absl::StatusCode::kCancelled,
        absl::StatusCode::kInternal, absl::StatusCode::kNotFound}) {
    const absl::Status stale(code, "desks.npy: Stale file handle");
    Line line(10, stale);
    options_.receivers = &line;
    EXPECT_EQ(run_irradiance_job(options_).status(), stale);
    EXPECT_EQ(line.reads(), 2) << stale;  // once in the survey, once for the piece
  }
}

TEST_F(IrradianceJobTest, AnotherRequestKeepsTheResults) {
  options_.header = "head";
  options_.journal = (directory_.path() / "journal").string();
  ASSERT_TRUE(run(100).ok());
  const auto refused = [&](std::uint64_t count) {
    const absl::Status status = run(count).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
    EXPECT_THAT(std::string(status.message()), HasSubstr(options_.journal));
    EXPECT_THAT(sizes_, ElementsAre());
    return std::string(status.message());
  };
  EXPECT_THAT(refused(101), HasSubstr(options_.results + ": has results for other receivers"));
  options_.header = "tail";
  EXPECT_THAT(refused(100), HasSubstr(options_.results + ": has results for other receivers"));
  options_.header = "head";
  options_.request.add_wavelengths_nm(555);
  EXPECT_THAT(refused(100), HasSubstr(options_.results + ": has results for other receivers"));
  options_.request.clear_wavelengths_nm();
  options_.request.mutable_seed()->set_seed(1);
  EXPECT_THAT(refused(100), HasSubstr("is the journal of another job"));
  options_.request.clear_seed();
  const auto result = run(100);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->from_journal, 100U);
  // Without a journal that refers to them, results are not kept.
  std::filesystem::remove(options_.journal);
  EXPECT_TRUE(run(101).ok());
}

TEST_F(IrradianceJobTest, TheSmallestLimitOfTheServersCounts) {
  // Neither server answers about the scene before both have reported their limits.
  servers_[1].max_batch_items = 1100;
  std::atomic<int> loaded = 0;
  for (FakeServer& server : servers_) {
    server.load_scene = [&](auto&, auto&, v1::LoadSceneResponse* response) {
      ++loaded;
      for (int i = 0; i < 600'000 && loaded < 2; ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      response->set_scene_id("scene");
      return grpc::Status::OK;
    };
  }
  options_.job.servers = [this]() -> absl::StatusOr<std::vector<std::string>> {
    return std::vector<std::string>{servers_[0].target(), servers_[1].target()};
  };
  EXPECT_THAT(sizes(10'240), ElementsAre(1024));
}

}  // namespace
}  // namespace lucerna::client
