#include <map>
#include <thread>

#include "server/rpc/call.h"
#include "service_fixture.h"
#include "tests/paths.h"

namespace lucerna::testing {
namespace {

class RenderServiceTest : public ::testing::Test {
 protected:
  v1::RenderTileRequest tile_request(std::uint32_t samples) const {
    auto q = about<v1::RenderTileRequest>(scene_);
    set_rect(&q, 64, 0, 128, 64);
    q.set_seed(5);
    q.mutable_accuracy()->set_samples(samples);
    return q;
  }

  Service service_;
  std::string scene_ = service_.load("rectangle.pbrt");
};

TEST_F(RenderServiceTest, TilesAreTheSameBitsOnOneThreadAndTwo) {
  const auto two = service_.answer(tile_request(4));
  EXPECT_EQ(two.tile().sum().size(), 64U * 64 * 24);
  EXPECT_EQ(two.tile().block_count(), 4U);
  EXPECT_EQ(two.cost().samples(), 64U * 64 * 4);
  EXPECT_GT(two.cost().cpu_time_s(), 0);
  rpc::ServerOptions options = service_options();
  options.lanes.threads = 1;
  Service alone(options);
  alone.load("rectangle.pbrt");
  EXPECT_EQ(alone.answer(tile_request(4)).tile().SerializeAsString(),
            two.tile().SerializeAsString());
}

TEST_F(RenderServiceTest, ImagesEndInTheBitsOfTiles) {
  auto q = about<v1::RenderImageRequest>(scene_);
  q.set_seed(5);
  q.mutable_accuracy()->set_samples(8);
  const auto sent = service_.answer(q);
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<v1::Tile>> tiles;
  std::uint64_t done = 0;
  for (const v1::RenderImageResponse& r : sent) {
    tiles[{r.tile().rect().x0(), r.tile().rect().y0()}].push_back(r.tile());
    EXPECT_GT(r.samples_done(), done);
    done = r.samples_done();
  }
  EXPECT_EQ(done, 160U * 120 * 8);
  EXPECT_EQ(sent.back().cost().samples(), done);
  ASSERT_EQ(tiles.size(), 6U);  // 3 by 2 of 64 pixels
  for (const auto& [place, passes] : tiles) {
    ASSERT_EQ(passes.size(), 4U);  // 1, 2, 4, 8 blocks
    EXPECT_EQ(passes[1].block_count(), 2U);
  }
  const v1::Tile& last = tiles[{64, 0}].back();
  const auto whole = service_.answer(tile_request(8));
  EXPECT_EQ(last.SerializeAsString(), whole.tile().SerializeAsString());
  v1::RenderTileRequest other = tile_request(8);
  other.set_seed(6);
  EXPECT_NE(last.sum(), service_.answer(other).tile().sum());
}

TEST_F(RenderServiceTest, AnyNumberOfSamplesMakesAnImage) {
  auto q = about<v1::RenderImageRequest>(scene_);
  q.mutable_accuracy()->set_samples(11);
  q.set_tile_size(160);
  q.set_final_only(true);
  const auto sent = service_.answer(q);
  ASSERT_EQ(sent.size(), 1U);
  EXPECT_EQ(sent[0].tile().block_count(), 11U);
}

// Each pixel of 160 x 120 takes 48 bytes in each of some copies.
class RenderMemory : public ::testing::Test {
 protected:
  static rpc::ServerOptions with_budget(std::uint64_t bytes) {
    rpc::ServerOptions options = service_options();
    options.scenes.memory_budget_bytes = bytes;
    return options;
  }
  static v1::RenderImageRequest picture(const std::string& scene, std::uint32_t tile_size) {
    auto q = about<v1::RenderImageRequest>(scene);
    q.mutable_accuracy()->set_samples(64);
    q.set_tile_size(tile_size);
    return q;
  }
};

TEST_F(RenderMemory, APictureThatDoesNotFitIsRefusedBeforeItStarts) {
  Service service(with_budget(2 << 20));
  const std::string scene = service.load("rectangle.pbrt");
  v1::RenderImageRequest q = picture(scene, 160);
  const grpc::Status status = service.status(q);
  expect_error(status, grpc::StatusCode::RESOURCE_EXHAUSTED, "", "RESOURCE_EXHAUSTED");
  EXPECT_THAT(status.error_message(), HasSubstr("the call needs"));
  // Smaller tiles, of which only the last are sent, fit.
  q = picture(scene, 16);
  q.set_final_only(true);
  EXPECT_TRUE(service.status(q).ok());

  auto tile = about<v1::RenderTileRequest>(scene);
  tile.mutable_accuracy()->set_samples(8);
  const auto render_tile = [&] { return service.status(tile); };
  EXPECT_EQ(render_tile().error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  set_rect(&tile, 64, 64);
  EXPECT_TRUE(render_tile().ok());
}

TEST_F(RenderMemory, PicturesShareTheBudget) {
  Service service(with_budget(10 << 20));
  const v1::RenderImageRequest q = picture(service.load("rectangle.pbrt"), 160);
  v1::RenderImageRequest endless = q;
  endless.mutable_accuracy()->set_samples(1 << 20);
  endless.set_samples_per_block(1);  // so that the first tile comes soon
  grpc::ClientContext context;
  const auto running = service.render.RenderImage(&context, endless);
  v1::RenderImageResponse r;
  ASSERT_TRUE(running->Read(&r));
  const grpc::Status refused = service.status(q);
  expect_error(refused, grpc::StatusCode::RESOURCE_EXHAUSTED, "", "MEMORY_LEASED");
  EXPECT_GT(detail<google::rpc::RetryInfo>(refused).retry_delay().seconds(), 0);
  context.TryCancel();
  while (running->Read(&r)) {
  }
  EXPECT_EQ(running->Finish().error_code(), grpc::StatusCode::CANCELLED);
  // The server drops the picture at its next step.
  bool fits = false;
  for (int i = 0; i < 100'000 && !fits; ++i) fits = service.status(q).ok();
  EXPECT_TRUE(fits);
}

TEST_F(RenderServiceTest, BadTilesAreNamed) {
  expect_bad_fields<v1::RenderTileRequest>(
      service_, tile_request(8),
      {{"rect", [](auto& q) { q.mutable_rect()->set_x1(161); }},
       {"rect", [](auto& q) { q.mutable_rect()->set_x1(64); }},
       {"accuracy.samples", [](auto& q) { q.mutable_accuracy()->set_samples(24); }},
       {"accuracy.samples", [](auto& q) { q.set_samples_per_block(16); }},
       {"samples_per_block", [](auto& q) { q.set_samples_per_block(3); }},
       {"first_sample", [](auto& q) { q.set_first_sample(4); }}});
  auto image = about<v1::RenderImageRequest>(scene_);
  image.set_tile_size(0);
  expect_bad_field(service_.status(image), "tile_size");
}

// The samples of a block are divided into eight parts, which are numbered in 32 bits.
TEST_F(RenderServiceTest, BlocksOfMoreSamplesThanCanBeNumberedAreRefused) {
  rpc::ServerOptions options = service_options();
  options.limits.max_samples = 1U << 30;
  Service service(options);
  v1::RenderTileRequest q = tile_request(1U << 29);
  service.load("rectangle.pbrt");
  q.set_samples_per_block(1U << 29);
  const grpc::Status s = service.status(q);
  expect_bad_field(s, "samples_per_block");
  EXPECT_NE(s.error_message().find("536870912, allowed: a power of two in [1, 268435456]"),
            std::string::npos)
      << s.error_message();
}

TEST_F(RenderServiceTest, ProposedSampleCountsAreRoundedForTiles) {
  Service service(scenes_in(test_data("pbrt")));
  const std::string scene = service.load("twelve_samples.pbrt");
  auto q = about<v1::RenderTileRequest>(scene);
  set_rect(&q, 4, 4);
  EXPECT_EQ(service.answer(q).cost().samples(), 4U * 4 * 8);

  auto image = about<v1::RenderImageRequest>(scene);
  image.set_tile_size(1);
  const grpc::Status refused = service.status(image);
  EXPECT_EQ(refused.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(refused.error_message(),
            "tile_size = 1, allowed: such that the picture has at most 65536 tiles, not 262144");
}

TEST_F(RenderServiceTest, CancelledRendersStopAndMakeRoom) {
  grpc::ClientContext context;
  v1::RenderTileRequest endless = tile_request(1 << 20);
  std::thread caller([&] {
    v1::RenderTileResponse r;
    EXPECT_EQ(service_.render.RenderTile(&context, endless, &r).error_code(),
              grpc::StatusCode::CANCELLED);
  });
  grpc::ClientContext image_context;
  auto image = about<v1::RenderImageRequest>(scene_);
  image.mutable_accuracy()->set_samples(1 << 20);
  image.set_samples_per_block(1);  // so that the first coarse tile comes at once
  auto reader = service_.render.RenderImage(&image_context, image);
  v1::RenderImageResponse r;
  EXPECT_TRUE(reader->Read(&r));
  context.TryCancel();
  image_context.TryCancel();
  while (reader->Read(&r)) {
  }
  EXPECT_EQ(reader->Finish().error_code(), grpc::StatusCode::CANCELLED);
  caller.join();
  // The work would take hours.  This loop ends only when it was abandoned.
  while (service_.server->lanes().pending(Lane::kBulk) > 0) std::this_thread::yield();
  EXPECT_TRUE(service_.status(tile_request(1)).ok());
}

TEST_F(RenderServiceTest, ADeadlineEndsWaitingAndWork) {
  grpc::ClientContext running;
  running.set_deadline(std::chrono::system_clock::now() + std::chrono::milliseconds(100));
  v1::RenderTileResponse r;
  EXPECT_EQ(service_.render.RenderTile(&running, tile_request(1 << 20), &r).error_code(),
            grpc::StatusCode::DEADLINE_EXCEEDED);
  while (service_.server->lanes().pending(Lane::kBulk) > 0) std::this_thread::yield();
  {
    const BusyLane busy(*service_.server, Lane::kBulk);
    grpc::ClientContext waiting;
    waiting.set_deadline(std::chrono::system_clock::now() + std::chrono::milliseconds(20));
    EXPECT_EQ(service_.render.RenderTile(&waiting, tile_request(1 << 20), &r).error_code(),
              grpc::StatusCode::DEADLINE_EXCEEDED);
  }
  while (service_.server->lanes().pending(Lane::kBulk) > 0) std::this_thread::yield();
}

TEST(Deadline, BeyondTheClockIsNever) {
  using Clock = LaneJob::Clock;
  // Clock ends in 2262.  Clients may ask for the year 13 000, and a deadline that wraps has passed.
  for (const std::int64_t s : {std::int64_t{9'223'372'036}, std::int64_t{360'000'000'000}})
    EXPECT_EQ(rpc::deadline_of(gpr_timespec{s, 0, GPR_CLOCK_REALTIME}), Clock::time_point::max());
  EXPECT_EQ(rpc::deadline_of(gpr_inf_future(GPR_CLOCK_REALTIME)), Clock::time_point::max());
  EXPECT_EQ(rpc::deadline_of(gpr_timespec{9'223'372'035, 5, GPR_CLOCK_REALTIME}),
            Clock::time_point(std::chrono::seconds(9'223'372'035) + std::chrono::nanoseconds(5)));
}

TEST_F(RenderServiceTest, AFullQueueRefusesRequests) {
  rpc::ServerOptions options = service_options();
  options.lanes.bulk_queue = 1;
  Service service(options);
  service.load("rectangle.pbrt");
  const BusyLane busy(*service.server, Lane::kBulk);
  ASSERT_TRUE(
      service.server->lanes()
          .submit(Lane::kBulk, {.run = [](const LaneJobStart&) {}, .client = "ipv4:127.0.0.1"})
          .ok());
  grpc::ClientContext context;
  v1::RenderTileResponse r;
  const grpc::Status s = service.render.RenderTile(&context, tile_request(1), &r);
  EXPECT_EQ(s.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(detail<google::rpc::RetryInfo>(s).retry_delay().seconds(), 1);
  EXPECT_EQ(detail<google::rpc::ErrorInfo>(s).reason(), "QUEUE_FULL");
  const auto& trailers = context.GetServerTrailingMetadata();
  const auto pushback = trailers.find("grpc-retry-pushback-ms");
  ASSERT_NE(pushback, trailers.end());
  EXPECT_EQ(std::string(pushback->second.data(), pushback->second.size()), "1000");
  // Small queries continue meanwhile.
  EXPECT_TRUE(service.status(about<v1::GetSceneRequest>(scene_)).ok());
}

}  // namespace
}  // namespace lucerna::testing
