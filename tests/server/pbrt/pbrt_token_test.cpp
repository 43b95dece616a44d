#include "server/pbrt/pbrt_token.h"

#include <gtest/gtest.h>

#include <vector>

namespace lucerna::pbrt {
namespace {

const SharedText kFile = "f";

std::vector<Token> tokens(std::string_view text) {
  Tokenizer tokenizer(&kFile, text);
  std::vector<Token> result;
  do result.push_back(tokenizer.next());
  while (result.back().kind != Token::Kind::kEnd);
  return result;
}

template <typename F>
std::string failure(F&& f) {
  try {
    f();
  } catch (const StatusError& failure) {
    return std::string(failure.status().message().data(), failure.status().message().size());
  }
  return "";
}

Token word(std::string_view text) { return {Token::Kind::kWord, text, {&kFile, 1, 1}}; }

TEST(PbrtTokens, KnowTheirLineAndColumn) {
  const auto all = tokens("Shape \"sphere\" # comment \"not a string\n\t[1]\r\n Rotate");
  ASSERT_EQ(all.size(), 7U);
  EXPECT_EQ(all[0].text, "Shape");
  EXPECT_EQ(to_string(all[0].place), "f:1:1");
  EXPECT_EQ(all[1].kind, Token::Kind::kString);
  EXPECT_EQ(all[1].text, "sphere");
  EXPECT_EQ(to_string(all[1].place), "f:1:7");
  EXPECT_EQ(all[2].kind, Token::Kind::kOpen);
  EXPECT_EQ(to_string(all[2].place), "f:2:2");
  EXPECT_EQ(all[3].text, "1");
  EXPECT_EQ(all[4].kind, Token::Kind::kClose);
  EXPECT_EQ(to_string(all[5].place), "f:3:2");
  EXPECT_EQ(to_string(all[6].place), "f:3:8");
}

TEST(PbrtTokens, WordsEndAtBracketsAndQuotes) {
  const auto all = tokens("a[b\"c\"d]");
  ASSERT_EQ(all.size(), 7U);
  EXPECT_EQ(all[2].text, "b");
  EXPECT_EQ(all[3].text, "c");
  EXPECT_EQ(all[4].text, "d");
}

TEST(PbrtTokens, WordsAheadAreThoseOfAList) {
  const auto ahead = [](std::string_view text) {
    Tokenizer tokenizer(&kFile, text);
    while (tokenizer.next().kind != Token::Kind::kOpen) {
    }
    return tokenizer.words_ahead();
  };
  EXPECT_EQ(ahead("a [1 2\t3\r\n4]5"), 4U);
  EXPECT_EQ(ahead("[ 1# 2 #3 4]\n 5 # 6"), 3U) << "\"1#\" is a word, and \"#3 4]\" is a comment";
  EXPECT_EQ(ahead("[]1"), 0U);
  EXPECT_EQ(ahead("[\"1 2\" 3]"), 0U);
  EXPECT_EQ(ahead("[1 [2 3]"), 1U);
  EXPECT_EQ(ahead("[1 2"), 2U);
}

TEST(PbrtTokens, EscapesAreResolved) {
  const auto all = tokens(R"("a\"b\\c\n\t")");
  EXPECT_EQ(unescaped(all[0]), "a\"b\\c\n\t");
  EXPECT_EQ(failure([] { unescaped(tokens(R"("\q")")[0]); }),
            R"(f:1:1: unknown escape "\q" in a string, allowed: \b \f \n \r \t \\ \' \")");
}

TEST(PbrtTokens, StringsEndOnTheirLine) {
  EXPECT_EQ(failure([] { tokens(" \"abc"); }), "f:1:2: expected '\"' at the end of this string");
  EXPECT_EQ(failure([] { tokens("\"abc\n\""); }), "f:1:1: expected '\"' at the end of this string");
  EXPECT_EQ(failure([] { tokens("\"abc\\"); }), "f:1:1: expected '\"' at the end of this string");
}

TEST(PbrtTokens, NumbersAreFiniteDecimals) {
  EXPECT_EQ(number(word("-12"), "", "Scale"), -12);
  EXPECT_EQ(number(word("+.5"), "", "Scale"), 0.5);
  EXPECT_EQ(number(word("1.e-2"), "", "Scale"), 0.01);
  EXPECT_EQ(number(word("1e-999"), "", "Scale"), 0);
  for (const char* bad :
       {"inf", "nan", "-inf", "0x10", "1.2.3", "-", "+", "+-1", "--1", "1e", "e1"})
    EXPECT_EQ(failure([&] { number(word(bad), "a number", "Scale"); }),
              std::string("f:1:1: expected a number, found \"") + bad + "\"");
  EXPECT_EQ(failure([] { number(word("-1e999"), "a number", "Scale"); }),
            "f:1:1: number -1e999 of Scale does not fit a double, allowed: [-1.79769e+308, "
            "1.79769e+308]");
}

TEST(PbrtTokens, MessagesHoldNoControlCharactersAndNoBrokenUtf8) {
  EXPECT_EQ(printable("a\x01\x80\xc3(\xed\xa0\x80\xff"),
            "a???"
            "(????");
  EXPECT_EQ(printable("\xc3\xa4 \xe2\x82\xac \xf0\x9f\x92\xa1"),
            "\xc3\xa4 \xe2\x82\xac \xf0\x9f\x92\xa1");
  EXPECT_EQ(printable(std::string(100, 'x')), std::string(80, 'x') + "...");
  EXPECT_FALSE(is_printable("\xc0\x80"));
}

}  // namespace
}  // namespace lucerna::pbrt
