#include "server/monitor/call_statistics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numeric>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "lucerna/v1/admin.pb.h"
#include "lucerna/v1/lighting.pb.h"
#include "lucerna/v1/render.pb.h"
#include "lucerna/v1/scene.pb.h"
#include "server/monitor/metric_families.h"

namespace lucerna::monitor {
namespace {

using ::testing::ElementsAre;

v1::GetStatsResponse read(const CallStatistics& statistics) {
  v1::GetStatsResponse all;
  statistics.read(all);
  return all;
}

v1::CallStats stats_of(const CallStatistics& statistics, Call call) {
  return read(statistics).calls(static_cast<int>(call));
}

std::uint64_t count(const v1::TimeHistogram& histogram) {
  return std::accumulate(histogram.counts().begin(), histogram.counts().end(), std::uint64_t{0});
}

// A call that the list lacks would have no statistics.
TEST(Calls, AreThoseOfTheContract) {
  std::set<std::string> known, contract;
  for (std::size_t i = 0; i < kContractCalls; ++i) known.insert(name_of(static_cast<Call>(i)));
  for (const google::protobuf::FileDescriptor* file :
       {v1::GetStatsRequest::descriptor()->file(), v1::SampleLiRequest::descriptor()->file(),
        v1::RenderTileRequest::descriptor()->file(), v1::LoadSceneRequest::descriptor()->file()}) {
    for (int s = 0; s < file->service_count(); ++s) {
      for (int m = 0; m < file->service(s)->method_count(); ++m)
        contract.insert(file->service(s)->full_name() + "/" + file->service(s)->method(m)->name());
    }
  }
  EXPECT_EQ(known, contract);
}

TEST(CallStatistics, AddUpTheRecordsOfEachCall) {
  CallStatistics statistics;
  for (int i = 0; i < 3; ++i) statistics.begin(Call::kSampleLi);
  statistics.end({.call = Call::kSampleLi,
                  .code = 0,
                  .items = 10,
                  .samples = 20,
                  .rays = 30,
                  .request_bytes = 40,
                  .response_bytes = 50,
                  .queued = true,
                  .lane = Lane::kBulk,
                  .queue_s = 0.25,
                  .compute_s = 0.5,
                  .cpu_s = 0.75,
                  .total_s = 1});
  statistics.end({.call = Call::kSampleLi, .code = 3, .items = 1, .total_s = 0.5});
  const v1::CallStats li = stats_of(statistics, Call::kSampleLi);
  EXPECT_EQ(li.method(), "lucerna.v1.LightingService/SampleLi");
  EXPECT_EQ(li.succeeded(), 1U);
  EXPECT_EQ(li.failed(), 1U);
  ASSERT_EQ(li.codes_size(), 2);
  EXPECT_EQ(li.codes(1).code(), "INVALID_ARGUMENT");
  EXPECT_EQ(li.codes(1).calls(), 1U);
  EXPECT_EQ(li.running(), 1U);
  EXPECT_EQ(li.items(), 11U);
  EXPECT_EQ(li.samples(), 20U);
  EXPECT_EQ(li.rays(), 30U);
  EXPECT_EQ(li.request_bytes(), 40U);
  EXPECT_EQ(li.response_bytes(), 50U);
  EXPECT_DOUBLE_EQ(li.queue_s(), 0.25);
  EXPECT_DOUBLE_EQ(li.cpu_s(), 0.75);
  EXPECT_DOUBLE_EQ(li.seconds(), 1.5);
  EXPECT_EQ(count(li.compute()), 1U);  // the refused call did not compute
  EXPECT_DOUBLE_EQ(li.compute().sum_s(), 0.5);
  EXPECT_EQ(stats_of(statistics, Call::kPdfLi).codes_size(), 0);
  const v1::GetStatsResponse all = read(statistics);
  EXPECT_EQ(count(all.lanes(0).wait()), 0U);
  EXPECT_EQ(count(all.lanes(1).wait()), 1U);
  EXPECT_DOUBLE_EQ(all.lanes(1).wait().sum_s(), 0.25);
}

TEST(CallStatistics, PutTimesIntoTheirClasses) {
  CallStatistics statistics;
  // On a bound, between two bounds, and above the last.
  for (const double s : {1e-5, 2e-5, 1000.0}) statistics.end({.call = Call::kLe, .compute_s = s});
  const v1::TimeHistogram h = stats_of(statistics, Call::kLe).compute();
  EXPECT_EQ(h.counts(0), 1U);
  EXPECT_EQ(h.counts(1), 1U);
  EXPECT_EQ(h.counts(h.counts_size() - 1), 1U);
  EXPECT_EQ(count(h), 3U);
}

TEST(CallStatistics, LoseNoCallOfManyThreads) {
  CallStatistics statistics;
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&] {
      for (int i = 0; i < 10000; ++i) {
        statistics.begin(Call::kPdfLi);
        statistics.end({.call = Call::kPdfLi, .items = 1, .compute_s = 1e-4});
      }
    });
  }
  for (std::thread& t : threads) t.join();
  const v1::CallStats pdf = stats_of(statistics, Call::kPdfLi);
  EXPECT_EQ(pdf.succeeded(), 40000U);
  EXPECT_EQ(pdf.running(), 0U);
  EXPECT_EQ(pdf.items(), 40000U);
  EXPECT_EQ(count(pdf.compute()), 40000U);
}

TEST(MetricFamilies, HaveTheFiguresUnderDistinctNames) {
  CallStatistics statistics;
  for (int i = 0; i < 7; ++i)
    statistics.end({.call = Call::kSampleLi,
                    .code = 3,
                    .compute_s = i == 0  ? 1e-6
                                 : i < 3 ? 2e-5
                                         : 0});
  v1::GetStatsResponse stats = read(statistics);
  for (const auto& [part, bytes] : {std::pair{"bvh", 100U}, std::pair{"lights", 11U}}) {
    stats.add_parts()->set_name(part);
    stats.mutable_parts(stats.parts_size() - 1)->set_bytes(bytes);
  }
  std::set<std::string> names;
  for (const prometheus::MetricFamily& family : metric_families(stats, {})) {
    EXPECT_TRUE(names.insert(family.name).second) << family.name;
    EXPECT_FALSE(family.help.empty()) << family.name;
    if (family.name == "lucerna_calls_total") {
      int found = 0;
      for (const prometheus::ClientMetric& m : family.metric) {
        if (m.label[0].value != "SampleLi" || m.label[1].value != "INVALID_ARGUMENT") continue;
        EXPECT_EQ(m.counter.value, 7);
        ++found;
      }
      EXPECT_EQ(found, 1);
    } else if (family.name == "lucerna_call_compute_seconds") {
      ASSERT_EQ(family.metric.size(), 1U);
      const auto& histogram = family.metric[0].histogram;
      EXPECT_EQ(histogram.bucket[0].cumulative_count, 1U);
      EXPECT_EQ(histogram.bucket[1].cumulative_count, 3U);
      EXPECT_EQ(histogram.bucket.back().cumulative_count, 3U);
      EXPECT_TRUE(std::isinf(histogram.bucket.back().upper_bound));
      EXPECT_EQ(histogram.sample_count, 3U);
    } else if (family.name == "lucerna_scene_bytes") {
      std::vector<double> bytes;
      for (const prometheus::ClientMetric& m : family.metric) bytes.push_back(m.gauge.value);
      EXPECT_THAT(bytes, ElementsAre(100, 11));
    }
  }
  EXPECT_TRUE(names.contains("process_open_fds"));
}

}  // namespace
}  // namespace lucerna::monitor
