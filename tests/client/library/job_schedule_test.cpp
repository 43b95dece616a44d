// Decisions of the schedule, with a simulated clock and channel.
#include "client/library/job_schedule.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"
#include "lucerna/client/client.h"

namespace lucerna::client {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Time = JobSchedule::Time;
using ServerId = JobSchedule::ServerId;
using AttemptId = JobSchedule::AttemptId;

/// Records the calls of the schedule.
class Recorder final : public JobSchedule::Channel {
 public:
  struct Started {
    AttemptId attempt;
    ServerId server;
    std::size_t piece;
  };

  void prepare(ServerId server, const std::string&) override { prepares.push_back(server); }
  void renew(ServerId server) override { renewals.push_back(server); }
  void start(AttemptId attempt, ServerId server, std::size_t piece) override {
    starts.push_back({attempt, server, piece});
  }
  void cancel(AttemptId attempt) override { cancelled.push_back(attempt); }
  void report(const std::string& event) override { events.push_back(event); }

  /// Pieces that were started on a server since the last call.
  std::vector<Started> take(ServerId server) {
    std::vector<Started> result;
    std::copy_if(starts.begin(), starts.end(), std::back_inserter(result),
                 [&](const Started& s) { return s.server == server; });
    std::erase_if(starts, [&](const Started& s) { return s.server == server; });
    return result;
  }
  std::vector<std::size_t> take_pieces(ServerId server) {
    std::vector<std::size_t> result;
    for (const Started& s : take(server)) result.push_back(s.piece);
    return result;
  }

  std::vector<ServerId> prepares, renewals;
  std::vector<Started> starts;
  std::vector<AttemptId> cancelled;
  std::vector<std::string> events;
};

class JobScheduleTest : public ::testing::Test {
 protected:
  void make(std::size_t pieces, int servers, int window = 2) {
    schedule_.emplace(JobSchedule::Options{.window = window}, channel_, now_);
    schedule_->set_pieces(pieces);
    std::vector<std::string> names;
    for (int i = 0; i < servers; ++i) names.push_back(std::string(1, static_cast<char>('a' + i)));
    schedule_->list(names, now_);
  }
  void prepare(ServerId server) { schedule_->prepared(server, fits_, now_); }
  /// Advances to `until` without events from outside.
  void pass(milliseconds time, const std::function<void()>& then = {}) {
    const Time until = now_ + time;
    while (true) {
      schedule_->advance(now_);
      if (then) then();
      const Time next = schedule_->advance(now_);
      if (next > until) break;
      now_ = std::max(next, now_ + milliseconds(1));
    }
    now_ = until;
  }

  const JobSchedule::Prepared fits_{"f", "scene"};
  Time now_{};
  Recorder channel_;
  std::optional<JobSchedule> schedule_;
};

TEST_F(JobScheduleTest, ServersPullPiecesInOrderWithAWindow) {
  make(7, 2);
  EXPECT_THAT(channel_.prepares, ElementsAre(0, 1));
  EXPECT_THAT(channel_.starts, IsEmpty());
  prepare(0);
  const auto first = channel_.take(0);
  ASSERT_EQ(first.size(), 2U);
  EXPECT_EQ(first[0].piece, 0U);
  EXPECT_EQ(first[1].piece, 1U);
  prepare(1);
  EXPECT_THAT(channel_.take_pieces(1), ElementsAre(2, 3));
  EXPECT_TRUE(schedule_->finished(first[1].attempt, absl::OkStatus(), now_));
  EXPECT_THAT(channel_.take_pieces(0), ElementsAre(4));
  EXPECT_EQ(schedule_->answering(), 2U);
  EXPECT_EQ(schedule_->pieces().done_count(), 1U);
}

TEST_F(JobScheduleTest, OnlyAnIdleServerDuplicatesAndTheFirstResultCounts) {
  make(3, 2);
  prepare(0);
  prepare(1);
  const auto at_a = channel_.take(0), at_b = channel_.take(1);
  ASSERT_EQ(at_a.size(), 2U);
  ASSERT_EQ(at_b.size(),
            1U);  // the third; the server has room for another, but only duplicates are left
  EXPECT_TRUE(schedule_->finished(at_a[0].attempt, absl::OkStatus(), now_));
  EXPECT_THAT(channel_.take(0), IsEmpty());
  EXPECT_TRUE(schedule_->finished(at_b[0].attempt, absl::OkStatus(), now_));
  const auto duplicate = channel_.take(1);
  ASSERT_EQ(duplicate.size(), 1U);
  EXPECT_EQ(duplicate[0].piece, at_a[1].piece);
  EXPECT_FALSE(schedule_->over());
  EXPECT_TRUE(schedule_->finished(duplicate[0].attempt, absl::OkStatus(), now_));
  EXPECT_THAT(channel_.cancelled, ElementsAre(at_a[1].attempt));
  EXPECT_TRUE(schedule_->over());
  EXPECT_FALSE(schedule_->finished(at_a[1].attempt, absl::OkStatus(), now_));
  EXPECT_EQ(schedule_->duplicates(), 1U);
  EXPECT_TRUE(schedule_->status().ok());
}

TEST_F(JobScheduleTest, NoPieceRunsOnMoreThanThreeServers) {
  make(1, 5);
  for (ServerId id = 0; id < 5; ++id) prepare(id);
  EXPECT_EQ(channel_.starts.size(), 3U);
  // After one gives it up, another may start it.
  const auto attempt = channel_.take(0).at(0).attempt;
  schedule_->finished(attempt, absl::UnavailableError("gone"), now_);
  EXPECT_EQ(channel_.starts.size(), 3U);  // of b, c, and d now
  EXPECT_EQ(channel_.take(3).size(), 1U);
}

TEST_F(JobScheduleTest, DuplicatesPreferFewestAttemptsThenTheOldestPiece) {
  make(2, 4, 1);
  prepare(0);
  prepare(1);
  now_ += seconds(1);
  // The first piece begins again, and so after the second.
  schedule_->finished(channel_.take(0).at(0).attempt, absl::NotFoundError("scene_id"), now_);
  pass(seconds(1));
  prepare(0);
  EXPECT_THAT(channel_.take_pieces(0), ElementsAre(0));
  EXPECT_THAT(channel_.take_pieces(1), ElementsAre(1));
  prepare(2);
  EXPECT_THAT(channel_.take_pieces(2), ElementsAre(1));
  prepare(3);
  EXPECT_THAT(channel_.take_pieces(3), ElementsAre(0));
}

TEST_F(JobScheduleTest, AResultResetsTheBackoff) {
  make(100, 1);
  for (int i = 0; i < 5; ++i) {
    channel_.prepares.clear();
    schedule_->prepared(0, absl::UnavailableError("refused"), now_);
    Time next = now_;
    do {
      now_ = next;
      next = schedule_->advance(now_);
    } while (channel_.prepares.empty());
  }
  prepare(0);
  const auto started = channel_.take(0);
  schedule_->finished(started.at(0).attempt, absl::OkStatus(), now_);
  schedule_->finished(started.at(1).attempt, absl::UnavailableError("gone"), now_);
  EXPECT_LE(schedule_->advance(now_) - now_, milliseconds(130));
}

TEST_F(JobScheduleTest, PiecesOfADeadServerAreNextAndItsDeathIsOneFailure) {
  make(10, 2);
  prepare(0);
  prepare(1);
  const auto at_a = channel_.take(0), at_b = channel_.take(1);
  for (const auto& s : at_a)
    EXPECT_FALSE(schedule_->finished(s.attempt, absl::UnavailableError("gone"), now_));
  EXPECT_THAT(channel_.events, ElementsAre(HasSubstr("a does not answer: gone")));
  EXPECT_EQ(schedule_->answering(), 1U);
  for (const auto& s : at_b) schedule_->finished(s.attempt, absl::OkStatus(), now_);
  EXPECT_THAT(channel_.take_pieces(1), ::testing::UnorderedElementsAre(0, 1));
  // The next attempt comes after the shortest wait, with jitter.
  const Time next = schedule_->advance(now_);
  EXPECT_GE(next - now_, milliseconds(70));
  EXPECT_LE(next - now_, milliseconds(130));
}

TEST_F(JobScheduleTest, FewerThanFiftyAttemptsAMinuteAtADeadServer) {
  for (const bool takes_the_scene : {false, true}) {
    SCOPED_TRACE(takes_the_scene);
    channel_ = {};
    make(10, 1);
    int attempts = 0;
    const auto fail = [&] {
      while (!channel_.prepares.empty() || !channel_.starts.empty()) {
        if (!channel_.prepares.empty()) {
          channel_.prepares.clear();
          ++attempts;
          if (takes_the_scene) {
            prepare(0);
          } else {
            schedule_->prepared(0, absl::UnavailableError("refused"), now_);
          }
        } else {
          for (const auto& s : channel_.take(0))
            schedule_->finished(s.attempt, absl::UnavailableError("draining"), now_);
        }
      }
    };
    pass(seconds(60), fail);
    EXPECT_LT(attempts, 50);
    EXPECT_GT(attempts, 15);  // and so a returning server is used within seconds
    attempts = 0;
    pass(seconds(60), fail);
    EXPECT_LT(attempts, 40);
    EXPECT_GT(attempts, 15);
  }
}

TEST_F(JobScheduleTest, ReportsEachLossAndReturnOfServersOnce) {
  make(10, 1);
  pass(seconds(2));
  EXPECT_THAT(channel_.events, IsEmpty());
  pass(seconds(1));
  EXPECT_THAT(channel_.events, ElementsAre("no server answers: waiting"));
  prepare(0);
  const auto started = channel_.take(0);
  schedule_->finished(started.at(0).attempt, absl::OkStatus(), now_);
  pass(seconds(1));
  schedule_->finished(started.at(1).attempt, absl::UnavailableError("gone"), now_);
  pass(seconds(1));
  EXPECT_THAT(channel_.events, ElementsAre("no server answers: waiting", "a does not answer: gone",
                                           "no server answers: waiting"));
}

TEST_F(JobScheduleTest, AServerThatStartsWithTheJobIsNotReported) {
  make(10, 2);
  schedule_->prepared(0, absl::UnavailableError("refused"), now_);
  schedule_->prepared(1, absl::UnavailableError("refused"), now_);
  channel_.prepares.clear();
  pass(seconds(1));
  prepare(0);
  EXPECT_THAT(channel_.events, IsEmpty());
  pass(seconds(2));
  schedule_->prepared(1, absl::UnavailableError("refused"), now_);
  EXPECT_THAT(channel_.events, ElementsAre("b does not answer: refused"));
}

TEST_F(JobScheduleTest, LeasesAreRenewedAndALostSceneIsLoadedAgain) {
  make(10, 1);
  prepare(0);
  pass(seconds(19));
  EXPECT_THAT(channel_.renewals, IsEmpty());
  pass(seconds(2));
  EXPECT_THAT(channel_.renewals, ElementsAre(0));
  // No second renewal while the first is not answered.
  schedule_->finished(channel_.take(0).at(0).attempt, absl::OkStatus(), now_);
  pass(seconds(60));
  EXPECT_THAT(channel_.renewals, ElementsAre(0));
  schedule_->renewed(0, absl::OkStatus(), now_);
  pass(seconds(21));
  EXPECT_THAT(channel_.renewals, ElementsAre(0, 0));
  EXPECT_THAT(channel_.prepares, ElementsAre(0));
  schedule_->renewed(0, absl::NotFoundError("scene_id"), now_);
  EXPECT_THAT(channel_.prepares, ElementsAre(0, 0));
}

TEST_F(JobScheduleTest, AServerThatLeavesIsStoppedAndMayComeBack) {
  make(3, 2);
  prepare(0);
  prepare(1);
  const auto at_a = channel_.take(0);
  schedule_->list(std::vector<std::string>{"b"}, now_);
  EXPECT_THAT(channel_.cancelled, ElementsAre(at_a[0].attempt, at_a[1].attempt));
  EXPECT_THAT(channel_.events, ElementsAre("a left"));
  for (const auto& s : at_a) schedule_->finished(s.attempt, absl::CancelledError(), now_);
  EXPECT_THAT(channel_.take(0), IsEmpty());
  EXPECT_EQ(channel_.take_pieces(1).size(), 2U);  // its own and one of a's
  schedule_->list(std::vector<std::string>{"a", "b"}, now_);
  EXPECT_EQ(channel_.take_pieces(0).size(), 1U);
}

TEST_F(JobScheduleTest, ABusyServerIsRetriedAfterItsDelay) {
  make(2, 1);
  prepare(0);
  google::rpc::RetryInfo info;
  info.mutable_retry_delay()->set_seconds(7);
  google::rpc::Status wire;
  wire.add_details()->PackFrom(info);
  absl::Status busy = absl::ResourceExhaustedError("busy");
  busy.SetPayload(kStatusPayloadUrl, absl::Cord(wire.SerializeAsString()));
  schedule_->finished(channel_.take(0).at(0).attempt, busy, now_);
  pass(seconds(6));
  EXPECT_THAT(channel_.starts, IsEmpty());
  EXPECT_THAT(channel_.events, IsEmpty());
  pass(seconds(2));
  EXPECT_EQ(channel_.starts.size(), 1U);
}

TEST_F(JobScheduleTest, ABrokenServerDoesNotEndTheJob) {
  make(10, 3, 1);
  for (const ServerId id : {0, 1, 2}) prepare(id);
  const auto at_b = channel_.take(1);
  // However often; the other servers are busy meanwhile.
  for (int i = 0; i < 20; ++i) {
    for (const auto& s : channel_.take(0))
      schedule_->finished(s.attempt, absl::InternalError("broken"), now_);
    channel_.prepares.clear();
    pass(milliseconds(60));
    EXPECT_THAT(channel_.prepares, IsEmpty());
    pass(seconds(5));
    prepare(0);
  }
  EXPECT_FALSE(schedule_->over());
  EXPECT_THAT(channel_.events, ElementsAre("a failed: broken"));
  schedule_->finished(at_b.at(0).attempt, absl::OkStatus(), now_);
  EXPECT_EQ(channel_.take(1).size(), 1U);
}

TEST_F(JobScheduleTest, APieceThatFailsOnAllServersEndsTheJob) {
  make(10, 2, 1);
  for (const ServerId id : {0, 1, 0}) {
    EXPECT_FALSE(schedule_->over());
    prepare(id);
    schedule_->finished(channel_.take(id).at(0).attempt, absl::InternalError("broken"), now_);
    pass(seconds(5));
  }
  EXPECT_TRUE(schedule_->over());
  EXPECT_EQ(schedule_->status().message(), "a: broken");
}

TEST_F(JobScheduleTest, AnotherBuildIsAnErrorAtTheStartAndExcludedLater) {
  make(10, 1, 1);
  prepare(0);
  schedule_->list(std::vector<std::string>{"a", "b"}, now_);
  schedule_->prepared(1, JobSchedule::Prepared{"g", "scene"}, now_);
  EXPECT_FALSE(schedule_->over());
  ASSERT_EQ(channel_.events.size(), 1U);
  EXPECT_THAT(channel_.events[0], HasSubstr("b (g) and a (f) have different numeric fingerprints"));
  EXPECT_THAT(channel_.events[0], HasSubstr("continuing without b"));
  EXPECT_THAT(channel_.take(1), IsEmpty());
  // The first returns as another build, so no server is left.
  schedule_->finished(channel_.take(0).at(0).attempt, absl::UnavailableError("gone"), now_);
  pass(seconds(1));
  schedule_->prepared(0, JobSchedule::Prepared{"g", "scene"}, now_);
  EXPECT_EQ(schedule_->status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(schedule_->status().message()), HasSubstr("no other server is left"));

  make(10, 2);
  prepare(0);
  schedule_->prepared(1, JobSchedule::Prepared{"f", "another"}, now_);
  EXPECT_THAT(std::string(schedule_->status().message()), HasSubstr("their files differ"));
}

TEST_F(JobScheduleTest, AServerWithoutRoomForTheSceneIsReportedAndRetried) {
  make(10, 1);
  google::rpc::RetryInfo info;
  info.mutable_retry_delay()->set_seconds(3600);
  google::rpc::Status wire;
  wire.add_details()->PackFrom(info);
  absl::Status full = absl::ResourceExhaustedError("all is leased");
  full.SetPayload(kStatusPayloadUrl, absl::Cord(wire.SerializeAsString()));
  for (int i = 0; i < 2; ++i) {
    channel_.prepares.clear();
    schedule_->prepared(0, full, now_);
    pass(seconds(9));
    EXPECT_THAT(channel_.prepares, IsEmpty());
    pass(seconds(2));
    EXPECT_THAT(channel_.prepares, ElementsAre(0));
  }
  EXPECT_THAT(channel_.events, ElementsAre("a cannot take the scene now: all is leased"));
}

TEST_F(JobScheduleTest, AnErrorKeepsItsDetails) {
  make(2, 1);
  prepare(0);
  absl::Status wrong = absl::InvalidArgumentError("tile");
  wrong.SetPayload(kStatusPayloadUrl, absl::Cord("details"));
  schedule_->finished(channel_.take(0).at(0).attempt, wrong, now_);
  EXPECT_TRUE(schedule_->over());
  EXPECT_EQ(schedule_->status().message(), "a: tile");
  EXPECT_EQ(schedule_->status().GetPayload(kStatusPayloadUrl), absl::Cord("details"));
}

}  // namespace
}  // namespace lucerna::client
