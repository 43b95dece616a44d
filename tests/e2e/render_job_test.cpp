// One picture on several servers, which are killed and halted during the job.
#include "lucerna/client/render_job.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <filesystem>
#include <fstream>

#include "lucerna/client/testing/local_server.h"
#include "lucerna/client/upload.h"
#include "tests/e2e/run_program.h"
#include "tests/paths.h"
#include "tests/temp_directory.h"

namespace lucerna {
namespace {

namespace fs = std::filesystem;
using client::RenderJobOptions;
using client::RenderJobResult;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::Not;

class RenderJob : public ::testing::Test {
 protected:
  void SetUp() override {
    add_server();
    if (HasFatalFailure()) return;
    v1::LoadSceneRequest load;
    load.set_path("point.pbrt");
    request_.set_scene_id(servers_[0]->client().load_scene(load).value().scene_id());
    request_.set_seed(5);
    request_.mutable_accuracy()->set_samples(48);
    request_.set_final_only(true);
    request_.set_intervals(true);
    client::PictureAssembler whole;
    ASSERT_TRUE(servers_[0]
                    ->client()
                    .render_image(request_,
                                  [&](const v1::RenderImageResponse& response) {
                                    EXPECT_TRUE(whole.add(response.tile()).ok());
                                    return true;
                                  })
                    .ok());
    expected_ = whole.picture().value();
    options_.request = request_;
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
  void expect_the_same_bits(const absl::StatusOr<RenderJobResult>& result) {
    ASSERT_TRUE(result.ok()) << result.status();
    EXPECT_GT(result->cost.wall_time_s(), 0);
    EXPECT_EQ(result->picture.width, expected_.width);
    EXPECT_EQ(result->picture.pixels, expected_.pixels);
    EXPECT_EQ(result->picture.standard_error, expected_.standard_error);
    EXPECT_FALSE(result->picture.upper.empty());
    EXPECT_EQ(result->picture.lower, expected_.lower);
    EXPECT_EQ(result->picture.upper, expected_.upper);
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

  const TempDirectory temporary_;  // outlives the servers
  const fs::path directory_ = temporary_.path();
  std::vector<std::unique_ptr<testing::LocalServer>> servers_;
  std::vector<std::string> targets_;
  v1::RenderImageRequest request_;
  client::Picture expected_;
  RenderJobOptions options_;
  std::vector<std::string> events_;
};

TEST_F(RenderJob, TheSameBitsFromAnyNumberOfServersAndAnySplit) {
  for (const int n : {1, 3}) {
    while (static_cast<int>(servers_.size()) < n) add_server();
    for (const std::uint32_t tile : {13U, 1000U}) {
      for (const std::uint64_t samples : {0U, 1U, 8U}) {
        if (tile == 13 && samples == 1) continue;  // 5760 pieces
        SCOPED_TRACE(::testing::Message() << n << " servers, " << tile << ", " << samples);
        options_.request.set_tile_size(tile);
        options_.samples_per_piece = samples;
        expect_the_same_bits(client::run_render_job(options_));
      }
    }
  }
  EXPECT_THAT(events_, Each(Not(HasSubstr("does not answer"))));
}

TEST_F(RenderJob, FinishesWithoutServersThatAreKilledOrHalt) {
  add_server();
  add_server();
  options_.request.set_tile_size(16);
  when(20, [this] {
    ::kill(servers_[1]->process_id(), SIGKILL);
    ::kill(servers_[2]->process_id(), SIGSTOP);
  });
  expect_the_same_bits(client::run_render_job(options_));
  ::kill(servers_[2]->process_id(), SIGCONT);
}

TEST_F(RenderJob, AnInterruptedJobResumesFromItsJournal) {
  options_.request.set_tile_size(16);
  options_.samples_per_piece = 16;
  options_.journal = (directory_ / "journal").string();
  std::stop_source stop;
  options_.job.call.stop = stop.get_token();
  when(30, [&] { stop.request_stop(); });
  EXPECT_EQ(client::run_render_job(options_).status().code(), absl::StatusCode::kCancelled);
  // Cut off within a record, as a power failure may leave it.
  fs::resize_file(options_.journal, fs::file_size(options_.journal) - 5);
  options_.job.call.stop = {};
  options_.job.on_progress = {};
  const auto result = client::run_render_job(options_);
  expect_the_same_bits(result);
  EXPECT_GE(result->from_journal, 29U);
  EXPECT_LT(result->from_journal, result->pieces);
  // All pieces come from the journal, even where it holds each record twice.  Two jobs may write
  // such a journal on a file system without locks.
  for (int i = 0; i < 2; ++i) {
    const auto again = client::run_render_job(options_);
    expect_the_same_bits(again);
    EXPECT_EQ(again->from_journal, again->pieces);
    std::ifstream in(options_.journal, std::ios::binary);
    std::string line;
    std::getline(in, line);
    const std::string records{std::istreambuf_iterator<char>(in), {}};
    std::ofstream(options_.journal, std::ios::binary | std::ios::app) << records;
  }
  options_.request.set_seed(6);
  EXPECT_EQ(client::run_render_job(options_).status().code(),
            absl::StatusCode::kFailedPrecondition);
}

TEST_F(RenderJob, PixelsOfATargetErrorAreTheSameFromAnyServersAndTiles) {
  v1::TargetError* target = request_.mutable_accuracy()->mutable_target_error();
  target->set_relative(0.3);
  target->set_max_samples(128);
  request_.set_bounces(0);
  client::PictureAssembler whole;
  ASSERT_TRUE(servers_[0]
                  ->client()
                  .render_image(request_,
                                [&](const v1::RenderImageResponse& response) {
                                  return whole.add(response.tile()).ok();
                                })
                  .ok());
  expected_ = whole.picture().value();
  ASSERT_EQ(expected_.upper.size(), expected_.pixels.size() / 3);
  options_.request = request_;
  add_server();
  for (const std::uint32_t tile : {13U, 1000U}) {
    options_.request.set_tile_size(tile);
    options_.journal = (directory_ / ("journal" + std::to_string(tile))).string();
    for (const bool again : {false, true}) {
      const auto result = client::run_render_job(options_);
      expect_the_same_bits(result);
      EXPECT_EQ(result->picture.samples, expected_.samples);
      EXPECT_EQ(result->picture.lower, expected_.lower);
      EXPECT_EQ(result->picture.upper, expected_.upper);
      EXPECT_EQ(result->from_journal, again ? result->pieces : 0);
    }
  }
  // Another target error is another job.
  options_.request.mutable_accuracy()->mutable_target_error()->set_relative(0.2);
  EXPECT_EQ(client::run_render_job(options_).status().code(),
            absl::StatusCode::kFailedPrecondition);
}

TEST_F(RenderJob, SplitSamplesWithATargetErrorAndTimeBudgetsAreRefused) {
  options_.samples_per_piece = 8;
  options_.request.mutable_accuracy()->mutable_target_error()->set_relative(0.3);
  auto result = client::run_render_job(options_);
  EXPECT_EQ(result.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(result.status().message()), HasSubstr("samples_per_piece = 8"));
  options_.samples_per_piece = 0;
  options_.request.mutable_accuracy()->set_time_budget_s(1);
  result = client::run_render_job(options_);
  EXPECT_EQ(result.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(result.status().message()), HasSubstr("accuracy.time_budget_s"));
}

TEST_F(RenderJob, TooManyPiecesAreRefused) {
  options_.request.set_tile_size(1);
  options_.request.mutable_accuracy()->set_samples(1U << 31);
  options_.request.set_samples_per_block(1);
  options_.samples_per_piece = 1;
  const auto result = client::run_render_job(options_);
  EXPECT_EQ(result.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(result.status().message()), HasSubstr("16777216 pieces"));
}

TEST_F(RenderJob, TheCommandLineUploadsAndRendersEverywhere) {
  add_server();
  fs::copy(test_data("reference/point.pbrt"), directory_ / "my.pbrt");
  fs::copy(test_data("reference/ball.ply"), directory_ / "ball.ply");
  const auto lucerna = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {build_path("bin/lucerna"), "render"});
    return run_program(std::move(arguments), {}, {{"LUCERNA_SERVER", targets_[0]}});
  };
  const std::string here = (directory_ / "here.pfm").string(),
                    there = (directory_ / "there.pfm").string();
  const Outcome one = lucerna({"point.pbrt", "-o", here, "--samples", "8"});
  ASSERT_EQ(one.status, 0) << one.err;
  const Outcome many = lucerna({"--servers", targets_[0] + "," + targets_[1], "--upload",
                                (directory_ / "my.pbrt").string(), "-o", there, "--samples", "8",
                                "--tile-size", "20", "--split-samples", "2"});
  ASSERT_EQ(many.status, 0) << many.err;
  const auto bytes = [](const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return std::string((std::istreambuf_iterator<char>(in)), {});
  };
  EXPECT_EQ(bytes(here), bytes(there));
  EXPECT_EQ(lucerna({"point.pbrt", "-o", here, "--journal", "x"}).status, 2);
  std::ofstream(directory_ / "letter") << "to my aunt\n";
  const Outcome letter = lucerna({"--servers", targets_[0], "point.pbrt", "-o", here, "--journal",
                                  (directory_ / "letter").string()});
  EXPECT_EQ(letter.status, 1);
  EXPECT_THAT(letter.err, HasSubstr("is the journal of another job, or not a journal"));
  EXPECT_THAT(letter.err, Not(HasSubstr("the server reported")));
  EXPECT_EQ(lucerna({"point.pbrt", "-o", here, "--servers", "nowhere:0"}).status, 2);
}

}  // namespace
}  // namespace lucerna
