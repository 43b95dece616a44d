#include "client/library/patience.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <future>
#include <memory>

namespace lucerna::client {
namespace {

using std::chrono::seconds;
using ::testing::ElementsAre;
using Answer = absl::StatusOr<std::vector<std::string>>;

TEST(Patience, AnAnswerInTimeIsReturned) {
  EXPECT_THAT(*look_up_within(seconds(60), "a", [] { return Answer{{"1.2.3.4:5"}}; }),
              ElementsAre("1.2.3.4:5"));
  EXPECT_EQ(look_up_within(seconds(60), "a",
                           []() -> Answer { return absl::UnavailableError("a: no such name"); })
                .status()
                .message(),
            "a: no such name");
}

TEST(Patience, WaitsNoLongerThanTheLimit) {
  std::promise<void> go, gone;
  auto over = gone.get_future();
  const auto answer =
      look_up_within(seconds(0), "slow",
                     [go = go.get_future().share(),
                      gone = std::make_shared<decltype(gone)>(std::move(gone))]() -> Answer {
                       go.wait_for(seconds(600));
                       gone->set_value();
                       return Answer{{"1.2.3.4:5"}};
                     });
  EXPECT_EQ(answer.status(),
            absl::UnavailableError("the name slow is still being looked up after 0 s"));
  // The thread that was left behind ends without an error.
  go.set_value();
  EXPECT_EQ(over.wait_for(seconds(600)), std::future_status::ready);
}

}  // namespace
}  // namespace lucerna::client
