#include "proto/common/host_port.h"

#include <gtest/gtest.h>

namespace lucerna {
namespace {

TEST(HostPort, IsSplitAndJoined) {
  struct Case {
    const char *text, *host;
    int port;
  };
  for (const Case& c :
       {Case{"localhost:1", "localhost", 1}, Case{"10.0.0.7:65535", "10.0.0.7", 65535},
        Case{"[::1]:50051", "::1", 50051}, Case{"[::]:0", "::", 0},
        Case{"[fe80::1%eth0]:80", "fe80::1%eth0", 80}}) {
    const auto split = split_host_port(c.text, 0);
    ASSERT_TRUE(split.ok()) << split.status();
    EXPECT_EQ(split->host, c.host);
    EXPECT_EQ(split->port, c.port);
    EXPECT_EQ(join_host_port(*split), c.text);
  }
}

TEST(HostPort, ErrorsNameTheTextAndWhatIsAllowed) {
  const auto error = [](const char* text, int lowest_port = 1) {
    return std::string(split_host_port(text, lowest_port).status().message());
  };
  const std::string hosts = ", allowed: a name, an IPv4 address, or an IPv6 address in brackets";
  EXPECT_EQ(error(""), "\"\": no host, allowed: HOST:PORT");
  EXPECT_EQ(error(":1"), "\":1\": no host, allowed: HOST:PORT");
  EXPECT_EQ(error("a"), "\"a\": no port, allowed: HOST:PORT");
  EXPECT_EQ(error("[::1]"), "\"[::1]\": no port, allowed: HOST:PORT");
  EXPECT_EQ(error("::1:1"), "\"::1:1\": host \"::1\"" + hosts);
  EXPECT_EQ(error("[::1:119537]:1"), "\"[::1:119537]:1\": host \"[::1:119537]\"" + hosts);
  EXPECT_EQ(error("[a]:1"), "\"[a]:1\": host \"[a]\"" + hosts);
  EXPECT_EQ(error("http://a:1"), "\"http://a:1\": host \"http://a\"" + hosts);
  for (const std::string port :
       {"65536", "119537", "-1", "+1", "1x", " 1", "", "0x1", "1e3", "4294967297"}) {
    for (const std::string host : {"a:", "[::1]:"}) {
      EXPECT_EQ(error((host + port).c_str(), 0),
                "\"" + host + port + "\": port \"" + port + "\", allowed: 0 to 65535");
    }
  }
  EXPECT_EQ(error("a:0"), "\"a:0\": port \"0\", allowed: 1 to 65535");
}

TEST(HostPort, OnlyAddressesOfThisMachineAreLoopback) {
  for (const char* here : {"127.0.0.1", "127.8.9.10", "localhost", "::1"})
    EXPECT_TRUE(is_loopback({.host = here, .port = 1})) << here;
  for (const char* other : {"10.0.0.7", "127.example.org", "localhost.example.org", "::2", "::"})
    EXPECT_FALSE(is_loopback({.host = other, .port = 1})) << other;
}

}  // namespace
}  // namespace lucerna
