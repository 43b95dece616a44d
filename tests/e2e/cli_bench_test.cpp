// lucerna bench: the figures of each mode are consistent.  No test looks at the speed.
#include <nlohmann/json.hpp>

#include "tests/e2e/cli_fixture.h"

namespace lucerna {
namespace {

using ::testing::HasSubstr;
using Json = nlohmann::json;

class CliBench : public Cli {
 protected:
  /// The JSON of a short bench, which must succeed.  A bench takes both processors for its time.
  static Json bench(std::vector<std::string> arguments, const std::string& time = "400ms") {
    arguments.insert(arguments.begin(),
                     {"bench", "--json", "--warm-up", "50ms", "--time", time, "--window", "100ms"});
    const Outcome outcome = lucerna(std::move(arguments));
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return Json::parse(outcome.out, nullptr, false);
  }

  /// Rows with answers only.
  static void expect_consistent(const Json& row) {
    EXPECT_GT(row["calls"], 0) << row;
    EXPECT_EQ(row["failed"], 0) << row;
    EXPECT_EQ(row["items"], row["calls"].get<std::uint64_t>() * row["batch"].get<std::uint64_t>());
    EXPECT_GT(row["bytesReceived"], 0) << row;
    EXPECT_GT(row["seconds"], 0) << row;
    EXPECT_GT(row["serverCpuS"], 0) << row;
    const Json& latency = row["latencyS"];
    EXPECT_GT(latency["p50"], 0) << row;
    EXPECT_LE(latency["p50"], latency["p90"]) << row;
    EXPECT_LE(latency["p90"], latency["p99"]) << row;
    EXPECT_LE(latency["p99"], latency["p99.9"]) << row;
  }
};

TEST_F(CliBench, ClosedLoopsSweepBatchesAndConcurrency) {
  const Json out = bench({"visibility", "sphere.pbrt", "--batch", "1,100", "--in-flight", "1,3"});
  ASSERT_EQ(out["rows"].size(), 4U) << out;
  std::vector<std::pair<int, int>> loads;
  for (const Json& row : out["rows"]) {
    expect_consistent(row);
    // One ray decides each segment, and another one may confirm it.
    EXPECT_GE(row["rays"], row["items"]) << row;
    EXPECT_LE(row["rays"], 2 * row["items"].get<std::uint64_t>()) << row;
    loads.emplace_back(row["batch"], row["inFlight"]);
  }
  EXPECT_THAT(loads, ::testing::ElementsAre(std::pair(1, 1), std::pair(1, 3), std::pair(100, 1),
                                            std::pair(100, 3)));
}

TEST_F(CliBench, EveryCallHasAnswers) {
  const std::vector<std::vector<std::string>> calls = {
      {"visibility", "sphere.pbrt", "--batch", "50", "--coherent"},
      {"irradiance", "sphere.pbrt", "--batch", "50", "--samples", "4", "--bounces", "0"},
      {"samples", "sphere.pbrt", "--batch", "50", "--light", "1"},
      {"emission", "sphere.pbrt", "--batch", "50"},
      {"power", "named.pbrt", "--batch", "2"},
      {"tile", "small.pbrt", "--batch", "49", "--samples", "2", "--bounces", "0"},
      {"empty"}};
  for (const auto& call : calls) {
    SCOPED_TRACE(call[0]);
    const Json out = bench(call);
    EXPECT_EQ(out["call"], call[0]);
    ASSERT_EQ(out["rows"].size(), 1U) << out;
    expect_consistent(out["rows"][0]);
  }
}

TEST_F(CliBench, SamplesOfTilesAreCounted) {
  const Json out = bench({"tile", "small.pbrt", "--batch", "49", "--samples", "2"});
  ASSERT_EQ(out["rows"].size(), 1U) << out;
  EXPECT_EQ(out["rows"][0]["batch"], 49);
  EXPECT_EQ(out["rows"][0]["samples"], 2 * out["rows"][0]["items"].get<std::uint64_t>());
}

TEST_F(CliBench, OpenLoopsSendAtTheirRate) {
  const Json out = bench({"empty", "--rate", "50,100", "--seed", "4"}, "1s");
  ASSERT_EQ(out["rows"].size(), 2U) << out;
  for (const Json& row : out["rows"]) {
    expect_consistent(row);
    // Arrivals are due in one second.  Five standard deviations: below 1e-6.
    const double rate = row["rate"];
    EXPECT_NEAR(row["calls"], rate, 5 * std::sqrt(rate)) << row;
    EXPECT_FALSE(row.contains("inFlight"));
  }
  // The seed decides the arrivals.
  const Json again = bench({"empty", "--rate", "50,100", "--seed", "4"}, "1s");
  EXPECT_EQ(again["rows"][0]["calls"], out["rows"][0]["calls"]);
  EXPECT_EQ(again["rows"][1]["calls"], out["rows"][1]["calls"]);
}

TEST_F(CliBench, ASearchReportsARateThatHeld) {
  // A limit that only a broken server misses, so that the search ends by the load.
  const Json out =
      bench({"visibility", "sphere.pbrt", "--batch", "2000", "--latency-limit", "p90=100ms"});
  ASSERT_EQ(out["highest"].size(), 1U) << out;
  EXPECT_EQ(out["limit"]["quantile"], "p90");
  EXPECT_DOUBLE_EQ(out["limit"]["latencyS"], 0.1);
  double best = 0;
  for (const Json& row : out["rows"]) {
    const bool held = row["failed"] == 0 && row["overloaded"] == false && row["calls"] > 0 &&
                      row["latencyS"]["p90"] <= 0.1;
    EXPECT_EQ(row["holds"], held) << row;
    if (held) best = std::max(best, row["rate"].get<double>());
  }
  if (best > 0) {
    EXPECT_DOUBLE_EQ(out["highest"][0]["rate"], best) << out;
  } else {
    EXPECT_TRUE(out["highest"][0]["rate"].is_null()) << out;
  }
  // No answer is that fast.
  const Outcome none = lucerna({"bench", "empty", "--latency-limit", "p50=0.0001ms", "--time",
                                "10ms", "--window", "10ms", "--warm-up", "1ms"});
  EXPECT_EQ(none.status, 0) << none.err;
  EXPECT_THAT(none.out, HasSubstr("no rate holds p50 = 0.0001 ms"));
}

TEST_F(CliBench, WrongOptionsAreExplained) {
  expect_wrong_use(lucerna({"bench", "pictures"}), "CALL: pictures is not one of visibility");
  expect_wrong_use(lucerna({"bench", "visibility"}), "SCENE is missing; visibility needs a scene");
  expect_wrong_use(lucerna({"bench", "empty", "point.pbrt"}), "an empty call has no scene");
  expect_wrong_use(lucerna({"bench", "empty", "--batch", "2"}), "an empty call has no items");
  expect_wrong_use(lucerna({"bench", "tile", "point.pbrt", "--coherent"}),
                   "--coherent has no effect on tile, allowed with: visibility, irradiance");
  expect_wrong_use(lucerna({"bench", "power", "point.pbrt", "--samples", "2"}),
                   "--samples has no effect on power");
  expect_wrong_use(lucerna({"bench", "power", "named.pbrt", "--batch", "3"}),
                   "--batch: 3 lights, but the scene has 2");
  expect_wrong_use(lucerna({"bench", "empty", "--rate", "5", "--in-flight", "2"}), "excludes");
  expect_wrong_use(lucerna({"bench", "empty", "--rate", "-5"}), "--rate");
  expect_wrong_use(lucerna({"bench", "empty", "--in-flight", "0"}), "--in-flight");
  expect_wrong_use(lucerna({"bench", "visibility", "point.pbrt", "--batch", "1,0"}), "--batch");
  expect_wrong_use(lucerna({"bench", "empty", "--latency-limit", "5ms"}),
                   "5ms is not a limit such");
  expect_wrong_use(lucerna({"bench", "empty", "--server", "a:1,b:1"}), "a bench loads one server");
}

TEST_F(CliBench, AnErrorOfAllCallsEndsTheProgram) {
  // One batch over the server's limit.
  expect_no(lucerna({"bench", "samples", "sphere.pbrt", "--batch", "70000", "--time", "1s",
                     "--warm-up", "10ms", "--window", "200ms"}),
            "the server reported resource_exhausted");
  expect_no(lucerna({"bench", "visibility", "missing.pbrt"}), "missing.pbrt");
}

}  // namespace
}  // namespace lucerna
