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
    v1::RenderTileRequest q;
    q.set_scene_id(scene_);
    q.mutable_rect()->set_x0(60);
    q.mutable_rect()->set_x1(100);
    q.mutable_rect()->set_y0(40);
    q.mutable_rect()->set_y1(60);
    q.set_seed(5);
    return q;
  }
  v1::RenderImageRequest image_request() const {
    v1::RenderImageRequest q;
    q.set_scene_id(scene_);
    q.set_seed(5);
    return q;
  }
  grpc::Status render(const v1::RenderTileRequest& q, v1::RenderTileResponse* r) {
    r->Clear();
    return testing::status_of([&](auto* c) { return service_.render.RenderTile(c, q, r); });
  }
  /// All sent messages, in order.
  std::vector<v1::RenderImageResponse> image(const v1::RenderImageRequest& q) {
    grpc::ClientContext context;
    const auto reader = service_.render.RenderImage(&context, q);
    std::vector<v1::RenderImageResponse> all;
    for (v1::RenderImageResponse r; reader->Read(&r);) all.push_back(r);
    const grpc::Status s = reader->Finish();
    EXPECT_TRUE(s.ok()) << s.error_message();
    return all;
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
  v1::RenderTileResponse r;
  ASSERT_TRUE(render(q, &r).ok());
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
    v1::RenderTileResponse same;
    ASSERT_TRUE(render(again, &same).ok());
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
  const auto sent = image(q);
  ASSERT_EQ(sent.size(), 12U);  // each tile once
  std::uint64_t done = 0;
  for (const v1::RenderImageResponse& r : sent) {
    for (const std::uint32_t n : plane<std::uint32_t>(r.tile().samples())) done += n;
    EXPECT_EQ(r.samples_done(), done);
    EXPECT_EQ(r.samples_total(), 0U);
    // A third of the tiles is rendered again.
    if ((&r - sent.data()) % 3 != 0) continue;
    v1::RenderTileRequest one;
    one.set_scene_id(scene_);
    one.set_seed(5);
    *one.mutable_rect() = r.tile().rect();
    *one.mutable_accuracy() = q.accuracy();
    one.set_bounces(0);
    v1::RenderTileResponse same;
    ASSERT_TRUE(render(one, &same).ok());
    EXPECT_EQ(same.tile().SerializeAsString(), r.tile().SerializeAsString());
  }
}

TEST_F(RenderAccuracyTest, ACountReportsIntervalsIfTheyAreRequested) {
  v1::RenderTileRequest q = tile_request();
  q.mutable_accuracy()->set_samples(64);
  q.set_bounces(1);
  v1::RenderTileResponse plain, r;
  ASSERT_TRUE(render(q, &plain).ok());
  for (const std::string* bytes :
       {&plain.tile().lower(), &plain.tile().upper(), &plain.tile().moments()})
    EXPECT_TRUE(bytes->empty());
  q.set_intervals(true);
  ASSERT_TRUE(render(q, &r).ok());
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
  v1::RenderTileResponse blocks, one;
  ASSERT_TRUE(render(q, &blocks).ok());
  q.set_one_sequence(true);
  ASSERT_TRUE(render(q, &one).ok());
  EXPECT_NE(one.tile().sum(), blocks.tile().sum());
  q.set_intervals(true);
  EXPECT_THAT(render(q, &one).error_message(),
              HasSubstr("one_sequence = true, allowed: false with intervals"));
  q.set_intervals(false);
  q.mutable_accuracy()->mutable_target_error()->set_relative(0.1);
  EXPECT_THAT(render(q, &one).error_message(), HasSubstr("one_sequence = true, allowed: false"));
}

TEST_F(RenderAccuracyTest, OneSequenceEndsWhereItsNumbersEnd) {
  v1::RenderTileRequest q = tile_request();
  q.mutable_accuracy()->set_samples(64);
  q.set_bounces(0);
  q.set_one_sequence(true);
  constexpr std::uint64_t kEnd = std::uint64_t{1} << 28;
  v1::RenderTileResponse r;
  q.set_first_sample(kEnd - 64);
  EXPECT_TRUE(render(q, &r).ok());
  q.set_first_sample(kEnd);
  EXPECT_THAT(render(q, &r).error_message(),
              HasSubstr("first_sample = 268435456, allowed: [0, 268435392]"));
}

TEST_F(RenderAccuracyTest, ImagesHaveTheIntervalsOfTiles) {
  v1::RenderImageRequest q = image_request();
  q.mutable_accuracy()->set_samples(24);  // 8 blocks of 3 is no power of two
  q.set_samples_per_block(2);
  q.set_intervals(true);
  q.set_tile_size(50);
  q.set_bounces(0);
  const auto sent = image(q);
  ASSERT_FALSE(sent.empty());
  for (const v1::RenderImageResponse& message : sent) {
    const v1::Tile& t = message.tile();
    if (!std::has_single_bit(t.block_count())) continue;
    v1::RenderTileRequest one;
    one.set_scene_id(scene_);
    one.set_seed(5);
    *one.mutable_rect() = t.rect();
    one.mutable_accuracy()->set_samples(static_cast<std::uint32_t>(2 * t.block_count()));
    one.set_samples_per_block(2);
    one.set_bounces(0);
    one.set_intervals(true);
    v1::RenderTileResponse same;
    ASSERT_TRUE(render(one, &same).ok());
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
      v1::RenderTileResponse r, same;
      ASSERT_TRUE(render(q, &r).ok());
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
      ASSERT_TRUE(render(again, &same).ok());
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
      const auto sent = image(q);
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
        for (const v1::RenderImageResponse& r : image(counted)) {
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
  v1::RenderTileResponse r;
  ASSERT_TRUE(
      testing::status_of([&](auto* c) { return service.render.RenderTile(c, q, &r); }).ok());
  EXPECT_EQ(r.tile().block_count() * r.tile().samples_per_block(), 64U);
  q.mutable_accuracy()->mutable_target_error()->set_relative(1e-6);
  ASSERT_TRUE(
      testing::status_of([&](auto* c) { return service.render.RenderTile(c, q, &r); }).ok());
  EXPECT_THAT(plane<std::uint32_t>(r.tile().samples()), ::testing::Each(64U));
  v1::RenderImageRequest image = image_request();
  image.mutable_accuracy()->set_time_budget_s(1e300);
  grpc::ClientContext context;
  const auto reader = service.render.RenderImage(&context, image);
  v1::RenderImageResponse last;
  while (reader->Read(&last)) {
  }
  ASSERT_TRUE(reader->Finish().ok());
  EXPECT_EQ(last.samples_done(), 160U * 120 * 64);
}

TEST_F(RenderAccuracyTest, InvalidSettingsAreNamed) {
  v1::RenderTileResponse r;
  const auto status_with = [&](auto&& change) {
    v1::RenderTileRequest q = tile_request();
    change(q);
    return render(q, &r);
  };
  using Q = v1::RenderTileRequest;
  const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
  for (const double bad : {0.0, -1.0, nan, inf}) {
    expect_bad_field(
        status_with([&](Q& q) { q.mutable_accuracy()->mutable_target_error()->set_relative(bad); }),
        "accuracy.target_error.relative");
    expect_bad_field(status_with([&](Q& q) { q.mutable_accuracy()->set_time_budget_s(bad); }),
                     "accuracy.time_budget_s");
    v1::RenderImageRequest image = image_request();
    image.mutable_accuracy()->set_time_budget_s(bad);
    expect_bad_field(testing::status_of(
                         [&](auto* c) { return service_.render.RenderImage(c, image)->Finish(); }),
                     "accuracy.time_budget_s");
  }
  const auto target = [](Q& q) { q.mutable_accuracy()->mutable_target_error()->set_relative(0.1); };
  const auto time = [](Q& q) { q.mutable_accuracy()->set_time_budget_s(0.1); };
  expect_bad_field(status_with([&](Q& q) { target(q), q.set_first_sample(64); }), "first_sample");
  expect_bad_field(status_with([&](Q& q) { time(q), q.set_first_sample(64); }), "first_sample");
  expect_bad_field(status_with([&](Q& q) { target(q), q.set_samples_per_block(8); }),
                   "samples_per_block");
  expect_bad_field(status_with([&](Q& q) { time(q), q.set_samples_per_block(3); }),
                   "samples_per_block");
  expect_bad_field(status_with([&](Q& q) { time(q), q.set_samples_per_block(1U << 28); }),
                   "samples_per_block");
  expect_bad_field(status_with([&](Q& q) {
                     target(q), q.mutable_accuracy()->mutable_target_error()->set_max_samples(63);
                   }),
                   "accuracy.target_error.max_samples");
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
  EXPECT_TRUE(render(q, &r).ok());
}

}  // namespace
}  // namespace lucerna::testing
