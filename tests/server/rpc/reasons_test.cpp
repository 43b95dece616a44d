#include <gmock/gmock.h>
#include <google/rpc/error_details.pb.h>
#include <google/rpc/status.pb.h>
#include <gtest/gtest.h>

#include <set>

#include "server/rpc/messages/errors.h"

namespace lucerna::rpc {
namespace {

using ::testing::MatchesRegex;

std::set<std::string> names() {
  std::set<std::string> all;
  for (const ErrorReason& reason : kErrorReasons) all.insert(reason.name);
  return all;
}

std::string reason_of(const absl::Status& status) {
  google::rpc::Status wire;
  EXPECT_TRUE(wire.ParseFromString(to_wire(status).details));
  google::rpc::ErrorInfo info;
  for (const auto& any : wire.details()) any.UnpackTo(&info);
  return info.reason();
}

TEST(Reasons, HaveDistinctNamesAndAMeaning) {
  EXPECT_EQ(names().size(), kErrorReasons.size());
  for (const ErrorReason& reason : kErrorReasons) {
    EXPECT_THAT(reason.name, MatchesRegex("[A-Z_]+"));
    EXPECT_THAT(reason.meaning, MatchesRegex("[A-Z].*\\.")) << reason.name;
  }
}

// The functions below set reasons, and so do calls of error().
TEST(Reasons, OfEveryErrorAreInTheTable) {
  std::set<std::string> seen;
  for (int code = 1; code <= 16; ++code)
    seen.insert(reason_of(absl::Status(static_cast<absl::StatusCode>(code), "text")));
  absl::Status leased = absl::ResourceExhaustedError("full");
  leased.SetPayload("lucerna.retry_after_ms", absl::Cord("20"));
  absl::Status quota = absl::ResourceExhaustedError("full");
  quota.SetPayload("lucerna.over_quota", absl::Cord());
  for (const absl::Status& status :
       {bad_field("f", "1", "2"), bad_length("f", 1, 2, "two"), no_message(), unknown_light(3),
        error(Reason::kSceneNotLoaded, "x"), over_limit("f", 2, 1),
        error(Reason::kDraining, "ends"), load_error(leased), load_error(quota),
        retry_after(absl::ResourceExhaustedError("full"), Reason::kQueueFull,
                    std::chrono::milliseconds(1)),
        retry_after(absl::FailedPreconditionError("busy"), Reason::kAssetBeingUploaded,
                    std::chrono::milliseconds(1))})
    seen.insert(reason_of(status));
  EXPECT_EQ(seen, names());
}

}  // namespace
}  // namespace lucerna::rpc
