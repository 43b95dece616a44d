#include "tests/server/extremes/wire_settings.h"

#include <gtest/gtest.h>

#include <cstdlib>

namespace lucerna::testing {
namespace {

constexpr char kVariable[] = "LUCERNA_WIRE_SETTING_OF_A_TEST";

absl::StatusOr<std::uint64_t> parsed(const char* text) {
  ::setenv(kVariable, text, 1);
  auto number = whole_number_of(kVariable, 1, 7);
  ::unsetenv(kVariable);
  return number;
}

TEST(WireSettings, TakeDigitsAndPowersOfTen) {
  EXPECT_EQ(parsed("1").value(), 1u);
  EXPECT_EQ(parsed("10000000").value(), 10000000u);
  EXPECT_EQ(parsed("1e6").value(), 1000000u);
  EXPECT_EQ(parsed("2.5e3").value(), 2500u);
}

TEST(WireSettings, UseTheDefaultWhereUnsetOrEmpty) {
  EXPECT_EQ(whole_number_of(kVariable, 1, 7).value(), 7u);
  EXPECT_EQ(parsed("").value(), 7u);
}

TEST(WireSettings, RefuseInvalidCounts) {
  for (const char* text : {"abc", "-5", "0", "1.5", "1e99", "nan", "inf", "12 ", "0x10", "1,000"}) {
    const auto number = parsed(text);
    ASSERT_FALSE(number.ok()) << text;
    EXPECT_EQ(number.status().message(),
              std::string(kVariable) + " = \"" + text +
                  "\", allowed: a whole number from 1, such as 1000000 or 1e6");
  }
}

}  // namespace
}  // namespace lucerna::testing
