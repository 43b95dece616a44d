#include "lucerna/client/server_list.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/temp_directory.h"

namespace lucerna::client {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::vector<std::string> now(const std::string& text) {
  const auto list = server_list(text);
  EXPECT_TRUE(list.ok()) << list.status();
  if (!list.ok()) return {};
  const auto targets = (*list)();
  EXPECT_TRUE(targets.ok()) << targets.status();
  return targets.value_or(std::vector<std::string>());
}

TEST(ServerList, NamesSeparatedByCommas) {
  EXPECT_THAT(now("a:1"), ElementsAre("a:1"));
  EXPECT_THAT(now("a:1,[::1]:65535,unix:/run/x"), ElementsAre("a:1", "[::1]:65535", "unix:/run/x"));
}

TEST(ServerList, InvalidServersAreErrors) {
  for (const char* bad :
       {"", "a", "a:", ":1", "a:0", "a:65536", "a:1,", "a:1,,b:2", "a:1x", "dns:///a",
        "slurm:", "slurm:x", "slurm:65536", "[::1]:119537", "b:1,[::1]:0", "dns:///a:119537",
        "ipv4:127.0.0.1:1,127.0.0.1:119537", "ipv6:[::1]:119537", "a:-1"}) {
    const auto list = server_list(bad);
    EXPECT_EQ(list.status().code(), absl::StatusCode::kInvalidArgument) << bad;
    EXPECT_THAT(std::string(list.status().message()), HasSubstr(", allowed: "));
  }
}

TEST(ServerList, AListOfAddressesNamesEachServer) {
  EXPECT_THAT(now("ipv4:127.0.0.1:1,10.0.0.7:2"), ElementsAre("127.0.0.1:1", "10.0.0.7:2"));
  EXPECT_THAT(now("ipv6:[::1]:1"), ElementsAre("[::1]:1"));
}

TEST(ServerList, AFileIsReadAtEachCall) {
  const TempDirectory directory;
  const std::string name = (directory.path() / "servers").string();
  std::ofstream(name) << "# all of them\n  a:1  \n\nb:2 # the slow one\r\n";
  const auto list = server_list("@" + name);
  ASSERT_TRUE(list.ok()) << list.status();
  EXPECT_THAT((*list)().value(), ElementsAre("a:1", "b:2"));
  std::ofstream(name) << "c:3\n";
  EXPECT_THAT((*list)().value(), ElementsAre("c:3"));
  std::ofstream(name) << "127.0.0.1:119537\n";
  EXPECT_EQ((*list)().status().message(),
            name + ": server \"127.0.0.1:119537\": port \"119537\", allowed: 1 to 65535");
  std::ofstream(name) << "c\n";
  EXPECT_EQ((*list)().status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(server_list("@" + name).status().code(), absl::StatusCode::kInvalidArgument);
  std::filesystem::remove(name);
  EXPECT_EQ((*list)().status().code(), absl::StatusCode::kUnavailable);
}

TEST(ServerList, ANameStandsForEachOfItsAddresses) {
  EXPECT_THAT(now("dns:///localhost:50051"), Contains("127.0.0.1:50051"));
  EXPECT_THAT(now("dns:///127.0.0.1:7"), ElementsAre("127.0.0.1:7"));
}

TEST(ServerList, TheNodesOfASlurmJob) {
  ASSERT_EQ(unsetenv("SLURM_JOB_NODELIST"), 0);
  EXPECT_EQ(server_list("slurm:5").status().code(), absl::StatusCode::kInvalidArgument);
  ASSERT_EQ(setenv("SLURM_JOB_NODELIST", "n[1-2],login", 1), 0);
  EXPECT_THAT(now("slurm:5"), ElementsAre("n1:5", "n2:5", "login:5"));
  ASSERT_EQ(unsetenv("SLURM_JOB_NODELIST"), 0);
}

// The output of scontrol show hostnames for the same lists.
TEST(HostList, IsExpandedLikeInSlurm) {
  const auto hosts = [](const std::string& text) { return expand_host_list(text).value(); };
  EXPECT_THAT(hosts("n1"), ElementsAre("n1"));
  EXPECT_THAT(hosts("n[1-3,07],login"), ElementsAre("n1", "n2", "n3", "n07", "login"));
  EXPECT_THAT(hosts("n[008-011]"), ElementsAre("n008", "n009", "n010", "n011"));
  EXPECT_THAT(hosts("r[1-2]n[3-4]x"), ElementsAre("r1n3x", "r1n4x", "r2n3x", "r2n4x"));
  for (const char* bad :
       {"", "n[", "n]", "n[]", "n[a]", "n[1-]", "n[1,,2]", "n[[1]]", ",n", "n[0-999999999]"}) {
    EXPECT_EQ(expand_host_list(bad).status().code(), absl::StatusCode::kInvalidArgument) << bad;
  }
}

}  // namespace
}  // namespace lucerna::client
