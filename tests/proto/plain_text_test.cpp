#include "proto/common/plain_text.h"

#include <gtest/gtest.h>

namespace lucerna {
namespace {

TEST(PlainText, KeepsLettersOfAllLanguages) {
  for (const char* text : {"", "plain", "tab\tand\nline",
                           "Stra\xc3\x9f"
                           "e",
                           "\xe6\xbc\xa2", "\xd7\x90", "\xf0\x9f\x92\xa1", "\xef\xbf\xbd"})
    EXPECT_EQ(plain_text(text), text);
}

TEST(PlainText, EscapesWhatATerminalObeys) {
  EXPECT_EQ(plain_text("\033[2J"), "\\u001b[2J");
  EXPECT_EQ(plain_text(std::string_view("\0\a\b\r\x7f", 5)), "\\u0000\\u0007\\u0008\\u000d\\u007f");
  EXPECT_EQ(plain_text("\xc2\x80\xc2\x9b\xc2\x9f\xc2\xa0"), "\\u0080\\u009b\\u009f\xc2\xa0");
  EXPECT_EQ(plain_text("\xe2\x80\xae\xe2\x81\xa6\xe2\x80\x8f\xe2\x80\xa8\xd8\x9c"),
            "\\u202e\\u2066\\u200f\\u2028\\u061c");
}

TEST(PlainText, ReplacesWhatIsNoUtf8) {
  // A C1 control as a byte, a lonely continuation, overlong forms, a surrogate, beyond the last
  // character, a character cut off.
  EXPECT_EQ(plain_text("\x9b"), "\\ufffd");
  EXPECT_EQ(plain_text("\xbf!"), "\\ufffd!");
  EXPECT_EQ(plain_text("\xc0\x9b"), "\\ufffd\\ufffd");
  EXPECT_EQ(plain_text("\xe0\x82\x9b"), "\\ufffd\\ufffd\\ufffd");
  EXPECT_EQ(plain_text("\xed\xa0\x80"), "\\ufffd\\ufffd\\ufffd");
  EXPECT_EQ(plain_text("\xf4\x90\x80\x80"), "\\ufffd\\ufffd\\ufffd\\ufffd");
  EXPECT_EQ(plain_text("\xe2\x80"), "\\ufffd\\ufffd");
}

TEST(PlainText, OfALineHasNoNewLine) { EXPECT_EQ(plain_line("a\n\tb"), "a\\u000a\\u0009b"); }

}  // namespace
}  // namespace lucerna
