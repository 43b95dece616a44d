// Tiles and pictures with a target error or a time budget.
#include <gmock/gmock.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <thread>

#include "service_fixture.h"

namespace lucerna::testing {
namespace {

using ::testing::HasSubstr;

template <typename Number>
std::vector<Number> plane(const std::string& bytes) {
  std::vector<Number> numbers(bytes.size() / sizeof(Number));
  std::memcpy(numbers.data(), bytes.data(), bytes.size());
  return numbers;
}

class RenderAccuracyTest : public ::testing::Test {
 protected:
  using Place = std::pair<std::uint32_t, std::uint32_t>;

  v1::RenderTileRequest tile_request() const {
    auto q = about<v1::RenderTileRequest>(scene_);
    set_rect(&q, 60, 40, 100, 60);
    q.set_seed(5);
    return q;
  }
  v1::RenderImageRequest image_request() const {
    auto q = about<v1::RenderImageRequest>(scene_);
    q.set_seed(5);
    return q;
  }
  static Place place(const v1::Tile& tile) { return {tile.rect().x0(), tile.rect().y0()}; }

  Service service_;
  const std::string scene_ = service_.load("rectangle.pbrt");
};

TEST_F(RenderAccuracyTest, ATargetErrorReportsSamplesAndIntervalsOfEachPixel) {
  v1::RenderTileRequest q = tile_request();
  q.mutable_accuracy()->mutable_target_error()->set_relative(0.1);
  q.mutable_accuracy()->mutable_target_error()->set_max_samples(512);
  q.set_bounces(0);
  const auto r = service_.answer(q);
  const v1::Tile& t = r.tile();
  EXPECT_EQ(t.block_count(), 32U);
  EXPECT_EQ(t.samples_per_block(), 0U);
  const auto samples = plane<std::uint32_t>(t.samples());
  const auto lower = plane<float>(t.lower()), upper = plane<float>(t.upper());
  const auto sum = plane<double>(t.sum());
  ASSERT_EQ(samples.size(), 800U);
  ASSERT_EQ(lower.size(), 800U);
  ASSERT_EQ(upper.size(), 800U);
  std::uint64_t all = 0;
  std::map<std::uint32_t, std::vector<std::size_t>> by_count;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    all += samples[i];
    by_count[samples[i]].push_back(i);
    const double value =
        (0.2126 * sum[3 * i] + 0.7152 * sum[3 * i + 1] + 0.0722 * sum[3 * i + 2]) / 32;
    EXPECT_LE(lower[i], value * (1 + 1e-3));
    EXPECT_GE(upper[i], value * (1 - 1e-3));
  }
  EXPECT_GT(r.cost().samples(), all + 64 * 800 - 1);  // includes pilots
  EXPECT_GE(by_count.size(), 2U);
  // The same count gives the same bits.
  for (const auto& [count, pixels] : by_count) {
    v1::RenderTileRequest again = q;
    again.mutable_accuracy()->set_samples(count);
    again.set_samples_per_block(count / 32);
    const auto same = service_.answer(again);
    EXPECT_EQ(same.tile().block_count(), 32U);
    EXPECT_TRUE(same.tile().samples().empty());
    EXPECT_TRUE(same.tile().lower().empty());
    EXPECT_TRUE(same.tile().upper().empty());
    for (const std::size_t i : pixels) {
      ASSERT_EQ(same.tile().sum().substr(24 * i, 24), t.sum().substr(24 * i, 24)) << count;
      ASSERT_EQ(same.tile().deviation().substr(24 * i, 24), t.deviation().substr(24 * i, 24));
    }
  }
}

TEST_F(RenderAccuracyTest, ImagesWithATargetErrorHaveTheBitsOfTiles) {
  v1::RenderImageRequest q = image_request();
  q.mutable_accuracy()->mutable_target_error()->set_relative(0.5);
  q.mutable_accuracy()->mutable_target_error()->set_max_samples(64);
  q.set_tile_size(50);
  q.set_bounces(0);
  const auto sent = service_.answer(q);
  ASSERT_EQ(sent.size(), 12U);  // each tile once
  std::uint64_t done = 0;
  for (const v1::RenderImageResponse& r : sent) {
    for (const std::uint32_t n : plane<std::uint32_t>(r.tile().samples())) done += n;
    EXPECT_EQ(r.samples_done(), done);
    EXPECT_EQ(r.samples_total(), 0U);
    // A third of the tiles is rendered again.
    if ((&r - sent.data()) % 3 != 0) continue;
    auto one = about<v1::RenderTileRequest>(scene_);
    one.set_seed(5);
    *one.mutable_rect() = r.tile().rect();
    *one.mutable_accuracy() = q.accuracy();
    one.set_bounces(0);
    const auto same = service_.answer(one);
    EXPECT_EQ(same.tile().SerializeAsString(), r.tile().SerializeAsString());
  }
}

TEST_F(RenderAccuracyTest, ACountReportsIntervalsIfTheyAreRequested) {
  v1::RenderTileRequest q = tile_request();
  q.mutable_accuracy()->set_samples(64);
  q.set_bounces(1);
  auto plain = service_.answer(q);
  for (const std::string* bytes :
       {&plain.tile().lower(), &plain.tile().upper(), &plain.tile().moments()})
    EXPECT_TRUE(bytes->empty());
  q.set_intervals(true);
  const auto r = service_.answer(q);
  EXPECT_EQ(r.tile().sum(), plain.tile().sum());
  EXPECT_EQ(r.tile().deviation(), plain.tile().deviation());
  EXPECT_TRUE(r.tile().samples().empty());
  const auto lower = plane<float>(r.tile().lower()), upper = plane<float>(r.tile().upper());
  const auto moments = plane<double>(r.tile().moments());
  ASSERT_EQ(lower.size(), 800U);
  ASSERT_EQ(upper.size(), 800U);
  ASSERT_EQ(moments.size(), 800U * 7);
  for (std::size_t i = 0; i < 800; ++i) {
    const double value = moments[7 * i] / 8;  // 8 blocks of 8 samples
    EXPECT_LE(lower[i], value);
    EXPECT_GE(upper[i], value);
    if (value > 0) {
      EXPECT_LT(lower[i], upper[i]);
    }
  }
}

TEST_F(RenderAccuracyTest, OneSequenceHasNoIntervals) {
  v1::RenderTileRequest q = tile_request();
  q.mutable_accuracy()->set_samples(64);
  const auto blocks = service_.answer(q);
  q.set_one_sequence(true);
  auto one = service_.answer(q);
  EXPECT_NE(one.tile().sum(), blocks.tile().sum());
  q.set_intervals(true);
  EXPECT_THAT(service_.call(q, &one).error_message(),
              HasSubstr("one_sequence = true, allowed: false with intervals"));
  q.set_intervals(false);
  q.mutable_accuracy()->mutable_target_error()->set_relative(0.1);
  EXPECT_THAT(service_.call(q, &one).error_message(),
              HasSubstr("one_sequence = true, allowed: false"));
}

TEST_F(RenderAccuracyTest, OneSequenceEndsWhereItsNumbersEnd) {
  v1::RenderTileRequest q = tile_request();
  q.mutable_accuracy()->set_samples(64);
  q.set_bounces(0);
  q.set_one_sequence(true);
  constexpr std::uint64_t kEnd = std::uint64_t{1} << 28;
  q.set_first_sample(kEnd - 64);
  auto r = service_.answer(q);
  q.set_first_sample(kEnd);
  EXPECT_THAT(service_.call(q, &r).error_message(),
              HasSubstr("first_sample = 268435456, allowed: [0, 268435392]"));
}

TEST_F(RenderAccuracyTest, ImagesHaveTheIntervalsOfTiles) {
  v1::RenderImageRequest q = image_request();
  q.mutable_accuracy()->set_samples(24);  // 8 blocks of 3 is no power of two
  q.set_samples_per_block(2);
  q.set_intervals(true);
  q.set_tile_size(50);
  q.set_bounces(0);
  const auto sent = service_.answer(q);
  ASSERT_FALSE(sent.empty());
  for (const v1::RenderImageResponse& message : sent) {
    const v1::Tile& t = message.tile();
    if (!std::has_single_bit(t.block_count())) continue;
    auto one = about<v1::RenderTileRequest>(scene_);
    one.set_seed(5);
    *one.mutable_rect() = t.rect();
    one.mutable_accuracy()->set_samples(static_cast<std::uint32_t>(2 * t.block_count()));
    one.set_samples_per_block(2);
    one.set_bounces(0);
    one.set_intervals(true);
    const auto same = service_.answer(one);
    EXPECT_EQ(same.tile().SerializeAsString(), t.SerializeAsString());
  }
  EXPECT_EQ(sent.back().tile().block_count(), 12U);
  EXPECT_FALSE(sent.back().tile().upper().empty());
}

TEST_F(RenderAccuracyTest, ATimeBudgetReportsItsSampleCount) {
  v1::RenderTileRequest q = tile_request();
  for (const std::uint32_t block : {0U, 2U, 64U}) {
    for (const double budget : {1e-9, 0.3}) {
      q.mutable_accuracy()->set_time_budget_s(budget);
      if (block > 0) q.set_samples_per_block(block);
      const auto r = service_.answer(q);
      const v1::Tile& t = r.tile();
      const std::uint64_t samples = t.block_count() * t.samples_per_block();
      EXPECT_TRUE(std::has_single_bit(samples));
      if (budget < 1e-6) {
        EXPECT_EQ(samples, std::max(16U, block));
      }
      EXPECT_GE(samples, std::max(16U, block));
      if (block > 0) {
        EXPECT_EQ(t.samples_per_block(), block);
      }
      v1::RenderTileRequest again = q;
      again.mutable_accuracy()->set_samples(static_cast<std::uint32_t>(samples));
      const auto same = service_.answer(again);
      EXPECT_EQ(t.SerializeAsString(), same.tile().SerializeAsString()) << budget;
      EXPECT_EQ(r.cost().samples(), samples * 800);
    }
  }
}

TEST_F(RenderAccuracyTest, ImagesWithATimeBudgetReportTheirSampleCounts) {
  v1::RenderImageRequest q = image_request();
  for (const bool final_only : {false, true}) {
    for (const double budget : {1e-9, 0.2}) {
      q.mutable_accuracy()->set_time_budget_s(budget);
      q.set_final_only(final_only);
      const auto sent = service_.answer(q);
      std::map<Place, v1::Tile> tiles;
      for (const v1::RenderImageResponse& r : sent) {
        EXPECT_EQ(r.samples_total(), 0U);
        tiles[place(r.tile())] = r.tile();
      }
      ASSERT_EQ(tiles.size(), 6U);
      if (final_only) {
        EXPECT_EQ(sent.size(), 6U);
      }
      std::uint64_t done = 0;
      for (const auto& [where, t] : tiles) {
        const std::uint64_t area =
            std::uint64_t{t.rect().x1() - t.rect().x0()} * (t.rect().y1() - t.rect().y0());
        done += area * t.block_count() * t.samples_per_block();
        EXPECT_EQ(t.samples_per_block(), 8U);
        if (budget < 1e-6) {
          EXPECT_EQ(t.block_count(), 2U);
        }
        EXPECT_GE(t.block_count(), 2U);
        // The tiles of a picture with that count.
        v1::RenderImageRequest counted = image_request();
        counted.set_samples_per_block(8);
        counted.mutable_accuracy()->set_samples(static_cast<std::uint32_t>(8 * t.block_count()));
        counted.set_final_only(true);
        if (where != Place{0, 0} && where != Place{128, 64}) continue;
        for (const v1::RenderImageResponse& r : service_.answer(counted)) {
          if (place(r.tile()) == where) {
            EXPECT_EQ(r.tile().SerializeAsString(), t.SerializeAsString());
          }
        }
      }
      EXPECT_EQ(sent.back().samples_done(), done);
      EXPECT_EQ(sent.back().cost().samples(), done);
    }
  }
}

TEST_F(RenderAccuracyTest, ALongTimeBudgetEndsAtTheLargestSampleCount) {
  rpc::ServerOptions options = service_options();
  options.limits.max_samples = 100;
  Service service(options);
  service.load("rectangle.pbrt");
  v1::RenderTileRequest q = tile_request();
  q.mutable_accuracy()->set_time_budget_s(1e300);
  auto r = service.answer(q);
  EXPECT_EQ(r.tile().block_count() * r.tile().samples_per_block(), 64U);
  q.mutable_accuracy()->mutable_target_error()->set_relative(1e-6);
  r = service.answer(q);
  EXPECT_THAT(plane<std::uint32_t>(r.tile().samples()), ::testing::Each(64U));
  v1::RenderImageRequest image = image_request();
  image.mutable_accuracy()->set_time_budget_s(1e300);
  EXPECT_EQ(service.answer(image).back().samples_done(), 160U * 120 * 64);
}

TEST_F(RenderAccuracyTest, InvalidSettingsAreNamed) {
  v1::RenderTileRequest target = tile_request(), time = target;
  target.mutable_accuracy()->mutable_target_error()->set_relative(0.1);
  time.mutable_accuracy()->set_time_budget_s(0.1);
  const auto no_error = [](auto& q) {
    q.mutable_accuracy()->mutable_target_error()->set_relative(0);
  };
  const auto few_samples = [](auto& q) {
    q.mutable_accuracy()->mutable_target_error()->set_max_samples(63);
  };
  expect_bad_fields<v1::RenderTileRequest>(
      service_, target,
      {{"accuracy.target_error.relative", no_error},
       {"accuracy.target_error.max_samples", few_samples},
       {"first_sample", [](auto& q) { q.set_first_sample(64); }},
       {"samples_per_block", [](auto& q) { q.set_samples_per_block(8); }}});
  expect_bad_fields<v1::RenderTileRequest>(
      service_, time,
      {{"accuracy.time_budget_s", [](auto& q) { q.mutable_accuracy()->set_time_budget_s(-1); }},
       {"first_sample", [](auto& q) { q.set_first_sample(64); }},
       {"samples_per_block", [](auto& q) { q.set_samples_per_block(3); }},
       {"samples_per_block", [](auto& q) { q.set_samples_per_block(1U << 28); }}});
  v1::RenderImageRequest image = image_request();
  image.mutable_accuracy()->set_time_budget_s(0);
  expect_bad_field(service_.status(image), "accuracy.time_budget_s");
}

TEST_F(RenderAccuracyTest, CancelledTilesAndImagesEnd) {
  v1::RenderTileRequest q = tile_request();
  v1::RenderImageRequest images[] = {image_request(), image_request()};
  // Each would take hours.
  v1::TargetError* target = q.mutable_accuracy()->mutable_target_error();
  target->set_relative(1e-6);
  target->set_max_samples(1 << 20);
  *images[0].mutable_accuracy() = q.accuracy();
  images[1].mutable_accuracy()->set_time_budget_s(1e6);
  const auto cancel_once_accepted = [&](grpc::ClientContext& context) {
    return std::jthread([&] {
      while (service_.server->lanes().pending(Lane::kBulk) == 0) std::this_thread::yield();
      context.TryCancel();
    });
  };
  // These loops end only when the work was abandoned.
  const auto wait_for_the_end = [&] {
    while (service_.server->lanes().pending(Lane::kBulk) > 0) std::this_thread::yield();
  };
  wait_for_the_end();  // a load answers shortly before its job ends
  grpc::ClientContext tile_context;
  std::jthread canceller = cancel_once_accepted(tile_context);
  v1::RenderTileResponse r;
  EXPECT_EQ(service_.render.RenderTile(&tile_context, q, &r).error_code(),
            grpc::StatusCode::CANCELLED);
  for (const v1::RenderImageRequest& image : images) {
    wait_for_the_end();
    grpc::ClientContext context;
    const auto reader = service_.render.RenderImage(&context, image);
    const std::jthread soon = cancel_once_accepted(context);
    for (v1::RenderImageResponse part; reader->Read(&part);) {
    }
    EXPECT_EQ(reader->Finish().error_code(), grpc::StatusCode::CANCELLED);
  }
  wait_for_the_end();
  q.mutable_accuracy()->set_samples(8);
  r = service_.answer(q);
}

}  // namespace
}  // namespace lucerna::testing
