#include "server/rpc/token_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "proto/common/sha256.h"

namespace lucerna::access {
namespace {

using ::testing::HasSubstr;

absl::StatusOr<std::vector<Token>> read(const std::string& text) {
  const std::string path = ::testing::TempDir() + "lucernad_tokens.toml";
  std::ofstream(path) << text;
  return read_token_file(path);
}

std::string error_of(const std::string& text) {
  const auto tokens = read(text);
  EXPECT_FALSE(tokens.ok());
  return std::string(tokens.status().message());
}

constexpr char kGood[] = R"(
[[token]]
name = "farm"
sha256 = "9F86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08"
roles = ["query", "load"]
max-requests = 3
max-leases = 4
max-scenes = 5
max-items-per-second = 6
max-asset-bytes = 7_000_000_000
[[token]]
name = "me"
token = "a secret of 22 letters"
roles = ["admin"]
)";

TEST(TokenFile, HasNamesDigestsRolesAndQuotas) {
  const auto tokens = read(kGood);
  ASSERT_TRUE(tokens.ok()) << tokens.status();
  ASSERT_EQ(tokens->size(), 2U);
  const Token& farm = tokens->front();
  EXPECT_EQ(farm.name, "farm");
  EXPECT_EQ(farm.sha256, sha256("test"));
  EXPECT_EQ(farm.roles, (std::set{Role::kQuery, Role::kLoad}));
  EXPECT_EQ(farm.quota.requests, 3U);
  EXPECT_EQ(farm.quota.leases, 4U);
  EXPECT_EQ(farm.quota.scenes, 5U);
  EXPECT_EQ(farm.quota.items_per_second, 6U);
  EXPECT_EQ(farm.quota.asset_bytes, 7'000'000'000U);
  EXPECT_EQ(tokens->back().sha256, sha256("a secret of 22 letters"));
  EXPECT_EQ(tokens->back().quota.requests, 0U);
  EXPECT_EQ(tokens->back().quota.items_per_second, 0U);
  EXPECT_EQ(tokens->back().quota.asset_bytes, 0U);
}

TEST(TokenFile, ReportsEveryErrorWithItsPlaceAndNoSecret) {
  const std::string error = error_of(R"([[token]]
name = "a b"
token = "short-secret"
roles = ["query", "reader"]
[[token]]
colour = "red"
sha256 = "12"
max-requests = -1
[other]
)");
  for (const char* part :
       {":2:1: name, allowed: 1 to 64 letters", ":3:1: token, allowed: at least 16 characters",
        ":4:1: roles, allowed: a list of query, load, admin", ":5:1: the token has no name",
        ":5:1: the token has no roles", ":6:1: colour, allowed: name, sha256",
        ":7:1: sha256, allowed: the 64 hexadecimal digits",
        ":8:1: max-requests = -1, allowed: a whole number, at least 0; 0: no limit",
        ":9:2: other, allowed: tables [[token]]"}) {
    EXPECT_THAT(error, HasSubstr(part));
  }
  EXPECT_THAT(error, ::testing::Not(HasSubstr("short-secret")));
}

TEST(TokenFile, ShowsTheValueOfAWrongQuotaUnlessItIsAText) {
  const std::string error = error_of(R"([[token]]
name = "farm"
token = "a secret of 22 letters"
roles = ["query"]
max-requests = 1.5
max-leases = true
max-scenes = "swapped-secret"
max-items-per-second = -7
max-asset-bytes = [1, 2]
)");
  for (const char* part : {":5:1: max-requests = 1.5, allowed", ":6:1: max-leases = true, allowed",
                           ":7:1: max-scenes = a text, allowed",
                           ":8:1: max-items-per-second = -7, allowed: a whole number, at least 0",
                           ":9:1: max-asset-bytes = [ 1, 2 ], allowed"}) {
    EXPECT_THAT(error, HasSubstr(part));
  }
  EXPECT_THAT(error, ::testing::Not(HasSubstr("secret")));
}

TEST(TokenFile, RefusesATokenTwice) {
  EXPECT_THAT(error_of(std::string(kGood) +
                       "[[token]]\nname = \"x\"\ntoken = \"test\"\nroles = [\"load\"]\n"),
              HasSubstr("at least 16 characters"));
  EXPECT_THAT(error_of(std::string(kGood) + "[[token]]\nname = \"x\"\ntoken = \"a secret of 22 "
                                            "letters\"\nroles = [\"load\"]\n"),
              HasSubstr("the same token twice"));
  EXPECT_THAT(error_of("[[token]]\nname = \"x\"\ntoken = \"a secret of 22 letters\"\n"
                       "sha256 = \"9f86\"\nroles = [\"load\"]\n"),
              HasSubstr("token and sha256, allowed: one of them"));
}

TEST(TokenFile, RefusesAFileWithoutTokensAndWrongSyntax) {
  EXPECT_THAT(error_of(""), HasSubstr("no [[token]]"));
  EXPECT_THAT(error_of("[[token]]\nname = \n"), HasSubstr(".toml:2:"));
  EXPECT_THAT(std::string(read_token_file("/no/such/file").status().message()),
              HasSubstr("cannot be read: No such file"));
}

}  // namespace
}  // namespace lucerna::access
