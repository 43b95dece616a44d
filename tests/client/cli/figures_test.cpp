#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/cli/bench_figures.h"
#include "client/cli/bench_report.h"

namespace lucerna {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(Stability, ComparesTheLastWindows) {
  EXPECT_FALSE(bench::is_stable({100, 100}, 3, 0.05));
  EXPECT_TRUE(bench::is_stable({100, 100, 100}, 3, 0.05));
  EXPECT_TRUE(bench::is_stable({1, 98, 100, 102}, 3, 0.05));
  EXPECT_FALSE(bench::is_stable({97, 100, 103}, 3, 0.05));
  EXPECT_TRUE(bench::is_stable({97, 100, 103}, 3, 0.07));
  EXPECT_FALSE(bench::is_stable({0, 0, 0}, 3, 0.05));
}

bench::Row row(double latency_s, int calls) {
  bench::Row result{.batch = 8, .in_flight = 2, .rate = {}, .figures = {}, .holds = {}};
  for (int i = 0; i < calls; ++i) {
    bench::CallEnd end;
    end.end_s = latency_s;
    end.items = 8;
    result.figures.add(end);
  }
  result.figures.seconds = 2;
  return result;
}

TEST(Report, HasRatesAndLatencies) {
  bench::Report report;
  report.server = "here";
  report.question = "visibility";
  report.scene_id = "abc";
  report.rows = {row(0.005, 10)};
  const std::string text = rows_of(report).to_string() + found_of(report);
  // 10 calls of 8 items in 2 s, each of 5 ms.
  EXPECT_THAT(text,
              ::testing::ContainsRegex("\n +8 +2 +5 +40 +5 +5 +5 +5 +0 +0 +unknown  not stable\n"));
  EXPECT_THAT(text, Not(HasSubstr("rays/s")));
  const std::string json = json_of(report);
  EXPECT_THAT(json, HasSubstr(R"("call":"visibility","sceneId":"abc")"));
  EXPECT_THAT(json, HasSubstr(R"("calls":10,"failed":0,"items":80)"));
  EXPECT_THAT(json, HasSubstr(R"("serverCpuS":null)"));
}

TEST(Report, ALoadHoldsALimitOnlyIfAllCallsSucceed) {
  const bench::LatencyLimit limit{.quantile = 0.99, .latency_s = 0.01};
  bench::Figures figures = row(0.005, 100).figures;
  EXPECT_TRUE(holds(figures, limit));
  EXPECT_FALSE(holds(figures, {.quantile = 0.99, .latency_s = 0.004}));
  EXPECT_FALSE(holds(bench::Figures(), limit));
  bench::Figures overloaded = figures;
  overloaded.overloaded = true;
  EXPECT_FALSE(holds(overloaded, limit));
  bench::CallEnd failed;
  failed.status = absl::UnavailableError("gone");
  figures.add(failed);
  EXPECT_FALSE(holds(figures, limit));
}

}  // namespace
}  // namespace lucerna
