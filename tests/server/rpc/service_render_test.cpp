#include <map>
#include <thread>

#include "server/rpc/call.h"
#include "service_fixture.h"
#include "tests/paths.h"

namespace lucerna::testing {
namespace {

class RenderServiceTest : public ::testing::Test {
 protected:
  grpc::Status tile(Service& service, const v1::RenderTileRequest& q, v1::RenderTileResponse* r) {
    return status_of([&](auto* c) { return service.render.RenderTile(c, q, r); });
  }
  v1::RenderTileRequest tile_request(std::uint32_t samples) const {
    v1::RenderTileRequest q;
    q.set_scene_id(scene_);
    q.mutable_rect()->set_x0(64);
    q.mutable_rect()->set_x1(128);
    q.mutable_rect()->set_y1(64);
    q.set_seed(5);
    q.mutable_accuracy()->set_samples(samples);
    return q;
  }

  Service service_;
  std::string scene_ = service_.load("rectangle.pbrt");
};

TEST_F(RenderServiceTest, TilesAreTheSameBitsOnOneThreadAndTwo) {
  v1::RenderTileResponse two, one;
  ASSERT_TRUE(tile(service_, tile_request(4), &two).ok());
  EXPECT_EQ(two.tile().sum().size(), 64U * 64 * 24);
  EXPECT_EQ(two.tile().block_count(), 4U);
  EXPECT_EQ(two.cost().samples(), 64U * 64 * 4);
  EXPECT_GT(two.cost().cpu_time_s(), 0);
  rpc::ServerOptions options = service_options();
  options.lanes.threads = 1;
  Service alone(options);
  alone.load("rectangle.pbrt");
  ASSERT_TRUE(tile(alone, tile_request(4), &one).ok());
  EXPECT_EQ(one.tile().SerializeAsString(), two.tile().SerializeAsString());
}

TEST_F(RenderServiceTest, ImagesEndInTheBitsOfTiles) {
  v1::RenderImageRequest q;
  q.set_scene_id(scene_);
  q.set_seed(5);
  q.mutable_accuracy()->set_samples(8);
  grpc::ClientContext context;
  auto reader = service_.render.RenderImage(&context, q);
  v1::RenderImageResponse r;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<v1::Tile>> tiles;
  std::uint64_t done = 0;
  while (reader->Read(&r)) {
    tiles[{r.tile().rect().x0(), r.tile().rect().y0()}].push_back(r.tile());
    EXPECT_GT(r.samples_done(), done);
    done = r.samples_done();
  }
  ASSERT_TRUE(reader->Finish().ok());
  EXPECT_EQ(done, 160U * 120 * 8);
  EXPECT_EQ(r.cost().samples(), done);
  ASSERT_EQ(tiles.size(), 6U);  // 3 by 2 of 64 pixels
  for (const auto& [place, passes] : tiles) {
    ASSERT_EQ(passes.size(), 4U);  // 1, 2, 4, 8 blocks
    EXPECT_EQ(passes[1].block_count(), 2U);
  }
  v1::RenderTileResponse whole;
  ASSERT_TRUE(tile(service_, tile_request(8), &whole).ok());
  const v1::Tile& last = tiles[{64, 0}].back();
  EXPECT_EQ(last.SerializeAsString(), whole.tile().SerializeAsString());
  v1::RenderTileRequest other = tile_request(8);
  other.set_seed(6);
  ASSERT_TRUE(tile(service_, other, &whole).ok());
  EXPECT_NE(last.sum(), whole.tile().sum());
}

TEST_F(RenderServiceTest, AnyNumberOfSamplesMakesAnImage) {
  v1::RenderImageRequest q;
  q.set_scene_id(scene_);
  q.mutable_accuracy()->set_samples(11);
  q.set_tile_size(160);
  q.set_final_only(true);
  grpc::ClientContext context;
  auto reader = service_.render.RenderImage(&context, q);
  v1::RenderImageResponse r;
  int n = 0;
  while (reader->Read(&r)) ++n;
  ASSERT_TRUE(reader->Finish().ok());
  EXPECT_EQ(n, 1);
  EXPECT_EQ(r.tile().block_count(), 11U);
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
    v1::RenderImageRequest q;
    q.set_scene_id(scene);
    q.mutable_accuracy()->set_samples(64);
    q.set_tile_size(tile_size);
    return q;
  }
  static grpc::Status render(Service& service, const v1::RenderImageRequest& q) {
    return status_of([&](auto* c) {
      const auto reader = service.render.RenderImage(c, q);
      for (v1::RenderImageResponse r; reader->Read(&r);) {
      }
      return reader->Finish();
    });
  }
};

TEST_F(RenderMemory, APictureThatDoesNotFitIsRefusedBeforeItStarts) {
  Service service(with_budget(2 << 20));
  const std::string scene = service.load("rectangle.pbrt");
  v1::RenderImageRequest q = picture(scene, 160);
  const grpc::Status status = render(service, q);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(detail<google::rpc::ErrorInfo>(status).reason(), "RESOURCE_EXHAUSTED");
  EXPECT_THAT(status.error_message(), HasSubstr("the call needs"));
  // Smaller tiles, of which only the last are sent, fit.
  q = picture(scene, 16);
  q.set_final_only(true);
  EXPECT_TRUE(render(service, q).ok());

  v1::RenderTileRequest tile;
  tile.set_scene_id(scene);
  tile.mutable_accuracy()->set_samples(8);
  v1::RenderTileResponse r;
  const auto render_tile = [&] {
    return status_of([&](auto* c) { return service.render.RenderTile(c, tile, &r); });
  };
  EXPECT_EQ(render_tile().error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  tile.mutable_rect()->set_x1(64);
  tile.mutable_rect()->set_y1(64);
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
  const grpc::Status refused = render(service, q);
  EXPECT_EQ(refused.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(detail<google::rpc::ErrorInfo>(refused).reason(), "MEMORY_LEASED");
  EXPECT_GT(detail<google::rpc::RetryInfo>(refused).retry_delay().seconds(), 0);
  context.TryCancel();
  while (running->Read(&r)) {
  }
  EXPECT_EQ(running->Finish().error_code(), grpc::StatusCode::CANCELLED);
  // The server drops the picture at its next step.
  bool fits = false;
  for (int i = 0; i < 100'000 && !fits; ++i) fits = render(service, q).ok();
  EXPECT_TRUE(fits);
}

TEST_F(RenderServiceTest, BadTilesAreNamed) {
  v1::RenderTileResponse r;
  v1::RenderTileRequest q = tile_request(8);
  q.mutable_rect()->set_x1(161);
  expect_bad_field(tile(service_, q, &r), "rect");
  q = tile_request(8);
  q.mutable_rect()->set_x1(64);
  expect_bad_field(tile(service_, q, &r), "rect");
  q = tile_request(24);
  expect_bad_field(tile(service_, q, &r), "accuracy.samples");
  q = tile_request(8);
  q.set_samples_per_block(3);
  expect_bad_field(tile(service_, q, &r), "samples_per_block");
  q.set_samples_per_block(16);
  expect_bad_field(tile(service_, q, &r), "accuracy.samples");
  q = tile_request(8);
  q.set_first_sample(4);
  expect_bad_field(tile(service_, q, &r), "first_sample");
  v1::RenderImageRequest image;
  image.set_scene_id(scene_);
  image.set_tile_size(0);
  expect_bad_field(
      status_of([&](auto* c) { return service_.render.RenderImage(c, image)->Finish(); }),
      "tile_size");
}

// The samples of a block are divided into eight parts, which are numbered in 32 bits.
TEST_F(RenderServiceTest, BlocksOfMoreSamplesThanCanBeNumberedAreRefused) {
  rpc::ServerOptions options = service_options();
  options.limits.max_samples = 1U << 30;
  Service service(options);
  v1::RenderTileRequest q = tile_request(1U << 29);
  service.load("rectangle.pbrt");
  q.set_samples_per_block(1U << 29);
  v1::RenderTileResponse r;
  const grpc::Status s = tile(service, q, &r);
  expect_bad_field(s, "samples_per_block");
  EXPECT_NE(s.error_message().find("536870912, allowed: a power of two in [1, 268435456]"),
            std::string::npos)
      << s.error_message();
}

TEST_F(RenderServiceTest, ProposedSampleCountsAreRoundedForTiles) {
  rpc::ServerOptions options = service_options();
  options.scenes.root = test_data("pbrt");
  Service service(options);
  const std::string scene = service.load("twelve_samples.pbrt");
  v1::RenderTileRequest q;
  q.set_scene_id(scene);
  q.mutable_rect()->set_x1(4);
  q.mutable_rect()->set_y1(4);
  v1::RenderTileResponse r;
  const grpc::Status status = tile(service, q, &r);
  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(r.cost().samples(), 4U * 4 * 8);

  v1::RenderImageRequest image;
  image.set_scene_id(scene);
  image.set_tile_size(1);
  grpc::ClientContext context;
  const grpc::Status refused = service.render.RenderImage(&context, image)->Finish();
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
  v1::RenderImageRequest image;
  image.set_scene_id(scene_);
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
  v1::RenderTileResponse next;
  EXPECT_TRUE(tile(service_, tile_request(1), &next).ok());
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
  v1::GetSceneRequest get;
  get.set_scene_id(scene_);
  v1::GetSceneResponse scene;
  EXPECT_TRUE(status_of([&](auto* c) { return service.scenes.GetScene(c, get, &scene); }).ok());
}

}  // namespace
}  // namespace lucerna::testing
