// Numbers on lucernad's command line.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <regex>
#include <set>
#include <string>
#include <vector>

#include "lucerna/client/testing/local_server.h"
#include "tests/e2e/run_program.h"
#include "tests/paths.h"

namespace lucerna {
namespace {

using ::testing::HasSubstr;

/// The numeric options in the help: those whose value is N, BYTES or SECONDS.
std::set<std::string> numeric_options() {
  const Outcome help = run_program({build_path("bin/lucernad"), "--help"});
  const std::regex option("(--[a-z-]+) (N|BYTES|SECONDS)\\b");
  std::set<std::string> names;
  for (std::sregex_iterator i(help.out.begin(), help.out.end(), option), end; i != end; ++i)
    names.insert((*i)[1]);
  return names;
}

TEST(ServerOptions, NumbersOutOfRangeAreRefusedWithTheRange) {
  const std::set<std::string> names = numeric_options();
  ASSERT_GE(names.size(), 25U);
  for (const std::string& name : names) {
    // Each start of the program takes half a second, so only two options get all values.
    std::vector<std::string> values{"-1"};
    if (name == "--memory-budget" || name == "--max-lease")
      values.insert(values.end(), {"nan", "1e30", "", "1x", "99999999999999999999"});
    for (const std::string& value : values) {
      SCOPED_TRACE(name + " '" + value + "'");
      // Without the check it would serve, and this test would wait for it.
      const Outcome outcome = run_program({"/usr/bin/timeout", "20", build_path("bin/lucernad"),
                                           "--listen", "127.0.0.1:0", name + "=" + value});
      EXPECT_EQ(outcome.status, 2);
      EXPECT_THAT(outcome.err, HasSubstr(name));
      if (!value.empty()) {
        EXPECT_THAT(outcome.err, HasSubstr("allowed: "));
      }
    }
  }
}

TEST(ServerOptions, SizesHaveUnits) {
  for (const std::string value : {"1MiB", "1 m", "1048576b"}) {
    SCOPED_TRACE(value);
    const Outcome outcome =
        run_program({build_path("bin/lucernad"), "--check-config", "--memory-budget=" + value});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_THAT(outcome.out, ::testing::ContainsRegex("memory-budget +1MiB +--memory-budget"));
  }
  const Outcome unit = run_program({build_path("bin/lucernad"), "--memory-budget=1 parsec"});
  EXPECT_EQ(unit.status, 2);
  EXPECT_THAT(unit.err, HasSubstr("1 parsec, allowed: at least 0 bytes, such as 8GiB"));
}

}  // namespace
}  // namespace lucerna
