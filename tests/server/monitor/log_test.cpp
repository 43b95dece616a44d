// The lines of the log, and the limit of their number.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/logger.h>
#include <spdlog/sinks/ostream_sink.h>

#include <iostream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "server/monitor/call_log.h"

namespace lucerna::monitor {
namespace {

using ::testing::HasSubstr;
using ::testing::MatchesRegex;
using ::testing::Not;

/// A log into a string, with a clock that the test moves.
struct Log {
  explicit Log(LogFormat format, std::uint64_t lines = 0, const std::string& level = "info")
      : sink(std::make_shared<spdlog::sinks::ostream_sink_mt>(text)),
        limit(std::make_shared<LogLimit>(sink, lines, [this] { return now; })),
        calls(format, spdlog::level::from_str(level), limit) {
    sink->set_formatter(make_formatter(format));
  }

  LogLimit::Clock::time_point now{};
  std::ostringstream text;
  std::shared_ptr<spdlog::sinks::sink> sink;
  std::shared_ptr<LogLimit> limit;
  CallLog calls;
};

CallRecord record() {
  return {.call = Call::kSampleLi,
          .request_id = "my-id",
          .traceparent = "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01",
          .peer = "ipv4:127.0.0.1:40000",
          .caller = "farm",
          .scene_id = std::string(64, 'a'),
          .code = 3,
          .items = 12,
          .queued = true,
          .lane = Lane::kBulk,
          .queue_s = 0.0015,
          .compute_s = 2,
          .total_s = 2.25};
}

TEST(CallLog, WritesOneLineOfTextForEachCall) {
  Log log(LogFormat::kText);
  log.calls.write(record());
  EXPECT_THAT(
      log.text.str(),
      MatchesRegex("[0-9-]+T[0-9:.]+[+-][0-9:]+ \\[info\\] call SampleLi code=INVALID_ARGUMENT "
                   "id=my-id peer=ipv4:127.0.0.1:40000 caller=farm scene=a+ items=12 lane=bulk "
                   "queue_ms=1.500 "
                   "compute_ms=2000.000 total_ms=2250.000 traceparent=00-[0-9a-f-]+\n"));
}

TEST(CallLog, WritesOneJsonObjectForEachCall) {
  Log log(LogFormat::kJson);
  log.calls.write(record());
  const auto line = nlohmann::json::parse(log.text.str());
  EXPECT_EQ(line["message"], "call");
  EXPECT_EQ(line["level"], "info");
  EXPECT_EQ(line["call"], "SampleLi");
  EXPECT_EQ(line["code"], "INVALID_ARGUMENT");
  EXPECT_EQ(line["id"], "my-id");
  EXPECT_EQ(line["caller"], "farm");
  EXPECT_EQ(line["scene"], std::string(64, 'a'));
  EXPECT_EQ(line["items"], 12);
  EXPECT_EQ(line["compute_ms"], 2000);
  EXPECT_THAT(line["time"], MatchesRegex("[0-9-]+T[0-9:.]+[+-][0-9:]+"));
}

TEST(CallLog, KeepsToTheLevel) {
  Log log(LogFormat::kText, 0, "warning");
  log.calls.write(record());
  EXPECT_EQ(log.text.str(), "");
}

TEST(CallLog, WritesAtMostSoManyLinesInASecond) {
  Log log(LogFormat::kText, 10);
  for (int i = 0; i < 1000; ++i) log.calls.write(record());
  const auto lines = [&] {
    const std::string text = log.text.str();
    return std::count(text.begin(), text.end(), '\n');
  };
  EXPECT_EQ(lines(), 10);
  EXPECT_EQ(log.calls.left_out(), 990U);
  log.now += std::chrono::milliseconds(500);
  for (int i = 0; i < 1000; ++i) log.calls.write(record());
  EXPECT_EQ(lines(), 10 + 5 + 1);  // and the number of missing lines
  EXPECT_THAT(log.text.str(), HasSubstr("[warning] 990 lines were left out"));
}

TEST(LogFormat, QuotesAnyTextInJson) {
  std::ostringstream text;
  const auto sink = std::make_shared<spdlog::sinks::ostream_sink_mt>(text);
  sink->set_formatter(make_formatter(LogFormat::kJson));
  spdlog::logger logger("lucernad", sink);
  const std::string hard = "a \"quoted\" line\nand \xff bytes";
  logger.error(hard);
  const auto line = nlohmann::json::parse(text.str());
  EXPECT_EQ(line["level"], "error");
  EXPECT_EQ(line["message"], "a \"quoted\" line\nand \xef\xbf\xbd bytes");
}

TEST(LogFormat, LetsNoTextForgeALineOrMoveTheTerminal) {
  for (const LogFormat format : {LogFormat::kText, LogFormat::kJson}) {
    Log log(format);
    spdlog::logger logger("lucernad", log.sink);
    logger.error(std::string_view("a\n[info] forged\r\x1b[2J\x7f\xc2\x9b\x9b\xe2\x80\xae\0b", 29));
    CallRecord call = record();
    call.caller = "a\nb\x1b\xc2\x9b";
    log.calls.write(call);
    const std::string text = log.text.str();
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 2) << text;
    for (const char* obeyed : {"\r", "\x1b", "\x7f", "\xc2\x9b", "\xe2\x80\xae"})
      EXPECT_THAT(text, Not(HasSubstr(obeyed)));
    EXPECT_THAT(text, HasSubstr("forged"));
  }
}

TEST(LogLimit, OfTheOtherLinesReportsWhatItLeftOut) {
  std::ostringstream text;
  LogLimit::Clock::time_point now{};
  const auto out = std::make_shared<spdlog::sinks::ostream_sink_mt>(text);
  out->set_formatter(make_formatter(LogFormat::kText));
  spdlog::logger logger("lucernad", std::make_shared<LogLimit>(out, 2, [&] { return now; }));
  for (int i = 0; i < 5; ++i) logger.info("flood");
  EXPECT_THAT(text.str(), Not(HasSubstr("left out")));
  now += std::chrono::seconds(1);
  logger.info("after");
  EXPECT_THAT(text.str(), HasSubstr("3 lines were left out"));
  EXPECT_THAT(text.str(), HasSubstr("after"));
}

TEST(LogLimit, OfZeroIsNone) {
  LogLimit limit(std::make_shared<spdlog::sinks::ostream_sink_mt>(std::cout), 0);
  for (int i = 0; i < 10000; ++i) EXPECT_TRUE(limit.take());
}

}  // namespace
}  // namespace lucerna::monitor
