#include "server/rpc/access.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "proto/common/sha256.h"

namespace lucerna::access {
namespace {

using ::testing::HasSubstr;

std::vector<Token> tokens() {
  return {{.name = "viewer", .sha256 = sha256("look"), .roles = {Role::kQuery}, .quota = {}},
          {.name = "farm",
           .sha256 = sha256("farm"),
           .roles = {Role::kQuery, Role::kAdmin},
           .quota = {.requests = 2}}};
}

TEST(Access, LetsEveryoneInWithoutTokens) {
  Access access;
  EXPECT_TRUE(access.open());
  const auto admission = access.admit(Call::kGetStats, "");
  ASSERT_TRUE(admission.ok());
  EXPECT_EQ(admission->caller.name, "");
  EXPECT_TRUE(admission->caller.admin);
}

TEST(Access, NeedsAKnownToken) {
  Access access;
  access.set_tokens(tokens());
  EXPECT_FALSE(access.open());
  EXPECT_TRUE(access.admit(Call::kLe, "Bearer look").ok());
  for (const char* header : {"", "look", "Bearer", "Bearer ", "Bearer loo", "Bearer look ",
                             "bearer look", "Basic look"}) {
    EXPECT_TRUE(absl::IsUnauthenticated(access.admit(Call::kLe, header).status())) << header;
  }
}

// A comparison of a part of the digest would let this token in.
TEST(Access, ComparesEveryByteOfTheDigest) {
  for (std::size_t i = 0; i < kSha256Bytes; ++i) {
    std::string almost = sha256("look");
    almost[i] = static_cast<char>(almost[i] ^ 1);
    Access access;
    access.set_tokens({{.name = "viewer", .sha256 = almost, .roles = {Role::kQuery}, .quota = {}}});
    EXPECT_FALSE(access.admit(Call::kLe, "Bearer look").ok()) << i;
  }
}

TEST(Access, NamesTheRoleThatIsMissing) {
  Access access;
  access.set_tokens(tokens());
  const absl::Status status = access.admit(Call::kLoadScene, "Bearer look").status();
  EXPECT_TRUE(absl::IsPermissionDenied(status));
  EXPECT_THAT(std::string(status.message()), HasSubstr("LoadScene needs the role load"));
  // No role includes another.
  EXPECT_TRUE(absl::IsPermissionDenied(access.admit(Call::kLoadScene, "Bearer farm").status()));
  EXPECT_FALSE(access.admit(Call::kLe, "Bearer look")->caller.admin);
  EXPECT_TRUE(access.admit(Call::kLe, "Bearer farm")->caller.admin);
}

TEST(Access, ForgetsTokensThatAreRevoked) {
  Access access;
  access.set_tokens(tokens());
  ASSERT_TRUE(access.admit(Call::kLe, "Bearer look").ok());
  access.set_tokens({tokens().back()});
  EXPECT_TRUE(absl::IsUnauthenticated(access.admit(Call::kLe, "Bearer look").status()));
}

TEST(Access, NamesTheTokenOfARefusedCall) {
  Access access;
  access.set_tokens(tokens());
  std::string name;
  EXPECT_FALSE(access.admit(Call::kLe, "Bearer wrong", &name).ok());
  EXPECT_EQ(name, "");
  EXPECT_FALSE(access.admit(Call::kLoadScene, "Bearer look", &name).ok());
  EXPECT_EQ(name, "viewer");
}

// The quota of items belongs to the name, over all calls and tokens.
TEST(Access, CountsItemsOfAllCallsOfAName) {
  Access access;
  std::vector<Token> all = tokens();
  // One item in 10^6 s: nothing comes back while the test runs.
  all[0].quota.items_per_second = 1;
  all.push_back({.name = "viewer",
                 .sha256 = sha256("see"),
                 .roles = {Role::kQuery},
                 .quota = {.items_per_second = 1}});
  access.set_tokens(all);
  EXPECT_EQ(access.admit(Call::kLe, "Bearer look")->take_items(1'000'000).count(), 0);
  for (const char* header : {"Bearer look", "Bearer see"}) {
    const auto wait = access.admit(Call::kLe, header)->take_items(1);
    EXPECT_GT(wait, std::chrono::seconds(900'000)) << header;
    EXPECT_LE(wait, std::chrono::seconds(1'000'000)) << header;
  }
  EXPECT_EQ(access.admit(Call::kLe, "Bearer farm")->take_items(1'000'000).count(), 0);
  // A new file raises the limit at once.
  all[0].quota.items_per_second = 2'000'000;
  access.set_tokens(all);
  EXPECT_EQ(access.admit(Call::kLe, "Bearer look")->take_items(1).count(), 0);
}

TEST(Access, CountsRequestsInFlight) {
  Access access;
  access.set_tokens(tokens());
  auto first = access.admit(Call::kLe, "Bearer farm");
  auto second = access.admit(Call::kLe, "Bearer farm");
  ASSERT_TRUE(first.ok() && second.ok());
  const absl::Status third = access.admit(Call::kLe, "Bearer farm").status();
  EXPECT_TRUE(absl::IsResourceExhausted(third));
  EXPECT_THAT(std::string(third.message()), HasSubstr("2 requests of \"farm\" are in flight"));
  EXPECT_TRUE(access.admit(Call::kLe, "Bearer look").ok());
  // New tokens do not change the count.
  access.set_tokens(tokens());
  EXPECT_FALSE(access.admit(Call::kLe, "Bearer farm").ok());
  second = absl::CancelledError("");
  EXPECT_TRUE(access.admit(Call::kLe, "Bearer farm").ok());
}

}  // namespace
}  // namespace lucerna::access
