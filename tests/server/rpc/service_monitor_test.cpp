// What a server records of its calls, and what it does with malformed and with long calls.
#include <gmock/gmock.h>
#include <grpcpp/generic/generic_stub.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <thread>
#include <vector>

#include "server/rpc/time_model.h"
#include "service_fixture.h"

namespace lucerna::testing {
namespace {

using ::testing::HasSubstr;

/// A server that keeps the records of its calls.
class Monitored : public ::testing::Test {
 protected:
  rpc::ServerOptions options() {
    rpc::ServerOptions options = service_options();
    options.on_call = [this](const monitor::CallRecord& record) {
      const std::lock_guard lock(mutex_);
      records_.push_back(record);
    };
    return options;
  }
  monitor::CallRecord last() {
    const std::lock_guard lock(mutex_);
    EXPECT_FALSE(records_.empty());
    return records_.empty() ? monitor::CallRecord() : records_.back();
  }
  std::vector<monitor::CallRecord> records() {
    const std::lock_guard lock(mutex_);
    return records_;
  }

 private:
  std::mutex mutex_;
  std::vector<monitor::CallRecord> records_;
};

v1::SampleLiRequest li(const std::string& scene, int items) {
  auto q = about<v1::SampleLiRequest>(scene);
  q.mutable_receivers()->mutable_offsets_m()->Resize(3 * items, 0.5F);
  q.mutable_seed();
  return q;
}

/// Sends bytes as the request of a unary call.
grpc::Status send_bytes(Service& service, grpc::ClientContext& context, const std::string& method,
                        const std::string& bytes) {
  grpc::TemplatedGenericStub<grpc::ByteBuffer, grpc::ByteBuffer> stub(service.channel);
  const grpc::Slice slice(bytes);
  const grpc::ByteBuffer request(&slice, 1);
  grpc::ByteBuffer response;
  std::promise<grpc::Status> done;
  stub.UnaryCall(&context, method, {}, &request, &response,
                 [&](grpc::Status status) { done.set_value(std::move(status)); });
  return done.get_future().get();
}

std::string trailer(const grpc::ClientContext& context, const char* name) {
  const auto& trailers = context.GetServerTrailingMetadata();
  const auto found = trailers.find(name);
  return found == trailers.end() ? "" : std::string(found->second.data(), found->second.size());
}

TEST_F(Monitored, CallsAreRecorded) {
  Service service(options());
  const std::string scene = service.load("point.pbrt");
  EXPECT_EQ(last().call, monitor::Call::kLoadScene);
  EXPECT_EQ(last().scene_id, scene);
  EXPECT_TRUE(last().queued);
  EXPECT_EQ(last().lane, Lane::kBulk);

  grpc::ClientContext context;
  context.AddMetadata("x-request-id", "my-id.1");
  context.AddMetadata("traceparent", "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01");
  v1::SampleLiResponse answer;
  ASSERT_TRUE(service.lighting.SampleLi(&context, li(scene, 7), &answer).ok());
  const monitor::CallRecord record = last();
  EXPECT_EQ(record.call, monitor::Call::kSampleLi);
  EXPECT_EQ(record.code, 0);
  EXPECT_EQ(record.request_id, "my-id.1");
  EXPECT_EQ(trailer(context, "x-request-id"), "my-id.1");
  EXPECT_EQ(record.traceparent, "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01");
  EXPECT_THAT(record.peer, HasSubstr("127.0.0.1:"));
  EXPECT_EQ(record.scene_id, scene);
  EXPECT_EQ(record.items, 7U);
  EXPECT_EQ(record.samples, answer.cost().samples());
  EXPECT_EQ(record.request_bytes, li(scene, 7).ByteSizeLong());
  EXPECT_EQ(record.response_bytes, answer.ByteSizeLong());
  EXPECT_GT(record.compute_s, 0);
}

TEST_F(Monitored, ACallWithoutAUsableIdGetsOne) {
  Service service(options());
  for (const char* id : {"", "with space"}) {
    grpc::ClientContext context;
    if (id[0] != '\0') context.AddMetadata("x-request-id", id);
    v1::GetServerInfoResponse info;
    ASSERT_TRUE(service.admin.GetServerInfo(&context, {}, &info).ok());
    EXPECT_EQ(trailer(context, "x-request-id").size(), 16U);
    EXPECT_EQ(last().request_id, trailer(context, "x-request-id"));
  }
}

// A scene id of a request may be any text.
TEST_F(Monitored, RecordsHoldNoTextOfTheRequest) {
  Service service(options());
  auto q = about<v1::GetSceneRequest>("my secret");
  v1::GetSceneResponse r;
  grpc::ClientContext context;
  EXPECT_EQ(service.scenes.GetScene(&context, q, &r).error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(last().code, grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(last().scene_id, "");
}

TEST_F(Monitored, StreamsAreRecordedOnce) {
  Service service(options());
  auto q = about<v1::RenderImageRequest>(service.load("point.pbrt"));
  q.mutable_accuracy()->set_samples(2);
  q.set_final_only(true);
  grpc::ClientContext context;
  const auto reader = service.render.RenderImage(&context, q);
  v1::Cost cost;
  for (v1::RenderImageResponse part; reader->Read(&part);) cost = part.cost();
  ASSERT_TRUE(reader->Finish().ok());
  const monitor::CallRecord record = last();
  EXPECT_EQ(record.call, monitor::Call::kRenderImage);
  EXPECT_EQ(record.items, 160U * 120U);
  EXPECT_EQ(record.samples, cost.samples());
  EXPECT_EQ(record.samples, 2 * record.items);
  EXPECT_EQ(trailer(context, "x-request-id"), record.request_id);

  const auto stats = service.answer(v1::GetStatsRequest());
  for (const v1::CallStats& call : stats.calls()) {
    const bool self = call.method() == "lucerna.v1.AdminService/GetStats";  // it still runs
    EXPECT_EQ(call.succeeded(), self ? 0U : 1U) << call.method();
    EXPECT_EQ(call.running(), self ? 1U : 0U) << call.method();
  }
}

TEST_F(Monitored, StatisticsDescribeTheServer) {
  Service service(options());
  service.load("point.pbrt");
  service.load("point.pbrt");
  const auto stats = service.answer(v1::GetStatsRequest());
  EXPECT_EQ(stats.scenes(), 1U);
  EXPECT_EQ(stats.scenes_built(), 1U);
  EXPECT_EQ(stats.already_loaded(), 1U);
  EXPECT_EQ(stats.leases(), 0U);
  EXPECT_EQ(stats.scene_bytes(), service.server->scenes().bytes());
  std::uint64_t parts = 0;
  for (const v1::PartBytes& part : stats.parts()) parts += part.bytes();
  EXPECT_EQ(parts, stats.scene_bytes());
  EXPECT_EQ(stats.lanes_size(), 2);
  EXPECT_EQ(stats.lanes(1).name(), "bulk");
  const auto& counts = stats.lanes(1).wait().counts();
  EXPECT_EQ(std::accumulate(counts.begin(), counts.end(), std::uint64_t{0}), 2U);  // two loads
  EXPECT_GT(stats.uptime_s(), 0);
  EXPECT_GT(stats.process().resident_bytes(), 1'000'000U);
  EXPECT_GT(stats.process().open_descriptors(), 2U);
  EXPECT_GT(stats.process().threads(), 4U);
}

TEST_F(Monitored, MalformedMessagesAreInvalidAndHaveAReason) {
  Service service(options());
  grpc::ClientContext bytes_context, text_context;
  expect_error(send_bytes(service, bytes_context, "/lucerna.v1.SceneService/GetScene",
                          "\x0a\x05"
                          "abc"),
               grpc::StatusCode::INVALID_ARGUMENT,
               "5 bytes that are not a message of the type "
               "lucerna.v1.GetSceneRequest",
               "MALFORMED_MESSAGE");
  EXPECT_EQ(last().code, grpc::StatusCode::INVALID_ARGUMENT);
  // The parser names the field of a text that is not UTF-8.
  expect_error(
      send_bytes(service, text_context, "/lucerna.v1.SceneService/GetScene", "\x0a\x02\xff\xfe"),
      grpc::StatusCode::INVALID_ARGUMENT, "lucerna.v1.GetSceneRequest.scene_id");
}

TEST_F(Monitored, OtherCallsAreRecorded) {
  auto service = std::make_unique<Service>(options());
  const auto code = [&](const std::string& method) {
    grpc::ClientContext context;
    return send_bytes(*service, context, method, "").error_code();
  };
  EXPECT_EQ(code("/grpc.health.v1.Health/Check"), grpc::StatusCode::OK);
  EXPECT_EQ(code("/lucerna.v1.SceneService/NoSuchCall"), grpc::StatusCode::UNIMPLEMENTED);
  EXPECT_EQ(code("/of.Others/Call"), grpc::StatusCode::UNIMPLEMENTED);
  EXPECT_EQ(code("/lucerna.v1.SceneService/GetScene"), grpc::StatusCode::INVALID_ARGUMENT);
  service.reset();  // gRPC destroys the calls shortly after their answers
  struct Seen {
    monitor::Call call;
    int code;
    bool operator==(const Seen&) const = default;
  };
  std::vector<Seen> seen;
  for (const monitor::CallRecord& record : records()) {
    seen.push_back({record.call, record.code});
    EXPECT_THAT(record.peer, HasSubstr("127.0.0.1"));
    EXPECT_EQ(record.request_id.size(), 16U);
    EXPECT_GE(record.total_s, 0);
  }
  EXPECT_THAT(seen, ::testing::UnorderedElementsAre(
                        Seen{monitor::Call::kHealthCheck, 0}, Seen{monitor::Call::kUnknown, 12},
                        Seen{monitor::Call::kUnknown, 12}, Seen{monitor::Call::kGetScene, 3}));
}

// gRPC's own parser would end the stream as if it were complete.
TEST_F(Monitored, AMalformedPartOfAnUploadIsInvalid) {
  Service service(options());
  for (const char* method :
       {"/lucerna.v1.SceneService/UploadAsset", "/lucerna.v1.RenderService/RenderImage"}) {
    grpc::ClientContext context;
    expect_error(send_bytes(service, context, method, "\xff\xff\xff"),
                 grpc::StatusCode::INVALID_ARGUMENT, "", "MALFORMED_MESSAGE");
  }
}

TEST_F(Monitored, ACallWithoutADeadlineEndsAtTheServersLimit) {
  rpc::ServerOptions limited = options();
  limited.max_call_s = 1e-6;
  Service service(limited);
  // A load may take longer than the limit, so it has a deadline.
  grpc::ClientContext of_load;
  of_load.set_deadline(std::chrono::system_clock::now() + std::chrono::minutes(10));
  v1::LoadSceneRequest load;
  load.set_path("rectangle.pbrt");
  v1::LoadSceneResponse loaded;
  const grpc::Status load_status = service.scenes.LoadScene(&of_load, load, &loaded);
  ASSERT_TRUE(load_status.ok()) << load_status.error_message();
  const std::string& scene = loaded.scene_id();
  auto tile = about<v1::RenderTileRequest>(scene);
  tile.mutable_accuracy()->set_samples(1 << 20);  // takes hours
  v1::RenderTileResponse r;
  expect_error(service.call(tile, &r), grpc::StatusCode::DEADLINE_EXCEEDED,
               "the call computed for 1e-06 s");
  auto image = about<v1::RenderImageRequest>(scene);
  image.mutable_accuracy()->set_samples(1 << 20);
  grpc::ClientContext context;
  const auto reader = service.render.RenderImage(&context, image);
  for (v1::RenderImageResponse part; reader->Read(&part);) {
  }
  EXPECT_THAT(reader->Finish().error_message(), HasSubstr("the call computed for 1e-06 s"));
  // A client that sets a deadline may compute longer.
  grpc::ClientContext patient;
  patient.set_deadline(std::chrono::system_clock::now() + std::chrono::minutes(10));
  tile.mutable_accuracy()->set_samples(64);
  EXPECT_TRUE(service.render.RenderTile(&patient, tile, &r).ok());
  EXPECT_GT(last().compute_s, limited.max_call_s);
}

TEST(TimeModel, RefusesOnlyWhatEvenTheEasiestSceneCannotDo) {
  rpc::TimeModel model;
  constexpr auto kCall = monitor::Call::kRenderTile;
  EXPECT_EQ(model.least_seconds(kCall, 100), 0);  // nothing is known
  model.learn(kCall, 10, 5);
  model.learn(kCall, 10, 1);
  for (int i = 0; i < 5; ++i) model.learn(kCall, 10, 8);
  EXPECT_EQ(model.least_seconds(kCall, 100), 0);  // seven calls say too little
  model.learn(kCall, 10, 8);
  EXPECT_NEAR(model.least_seconds(kCall, 100), 0.5 * 100 * 0.1 * std::pow(1.01, 6), 1e-9);
  EXPECT_EQ(model.least_seconds(monitor::Call::kSampleLi, 100), 0);
  for (int i = 0; i < 1000; ++i) model.learn(kCall, 10, 8);  // the easy scene is not used any more
  EXPECT_DOUBLE_EQ(model.least_seconds(kCall, 100), 0.5 * 100 * 0.8);
}

TEST(TimeModel, ExpectsTheMeanOfTheLastCalls) {
  rpc::TimeModel model;
  constexpr auto kCall = monitor::Call::kRenderTile;
  EXPECT_EQ(model.expected_seconds(kCall, 100), 0);  // nothing is known
  model.learn(kCall, 10, 4);
  EXPECT_DOUBLE_EQ(model.expected_seconds(kCall, 100), 40);
  model.learn(kCall, 10, 5);
  EXPECT_DOUBLE_EQ(model.expected_seconds(kCall, 100), 41);
  for (int i = 0; i < 1000; ++i) model.learn(kCall, 10, 8);
  EXPECT_NEAR(model.expected_seconds(kCall, 100), 80, 1e-9);
}

TEST_F(Monitored, WorkThatCannotMeetItsDeadlineIsNotStarted) {
  Service service(options());
  auto tile = about<v1::RenderTileRequest>(service.load("rectangle.pbrt"));
  tile.mutable_accuracy()->set_samples(256);
  set_rect(&tile, 16, 16);
  for (int i = 0; i < 8; ++i) EXPECT_TRUE(service.status(tile).ok());
  // These tiles take longer than a millisecond, and the next takes 300000 times as long.
  tile.clear_rect();
  tile.mutable_accuracy()->set_samples(1 << 20);
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::minutes(2));
  v1::RenderTileResponse r;
  expect_error(service.call(&context, tile, &r), grpc::StatusCode::DEADLINE_EXCEEDED,
               "the work was not started: it takes about");
  EXPECT_EQ(last().compute_s, 0);
}

// Each stream renders until the buffers of gRPC are full.  Their steps are short, and the tile of
// the same client takes turns with them.
TEST_F(Monitored, StreamsThatNobodyReadsDoNotDelayATile) {
  Service service(options());
  const std::string scene = service.load("rectangle.pbrt");
  auto image = about<v1::RenderImageRequest>(scene);
  image.mutable_accuracy()->set_samples(1 << 20);
  std::vector<std::unique_ptr<grpc::ClientContext>> contexts;
  std::vector<std::unique_ptr<grpc::ClientReader<v1::RenderImageResponse>>> streams;
  for (int i = 0; i < 30; ++i) {
    contexts.push_back(std::make_unique<grpc::ClientContext>());
    streams.push_back(service.render.RenderImage(contexts.back().get(), image));
  }
  while (service.server->lanes().pending(Lane::kBulk) < 30) std::this_thread::yield();
  auto tile = about<v1::RenderTileRequest>(scene);
  set_rect(&tile, 8, 8);
  tile.mutable_accuracy()->set_samples(1);
  EXPECT_TRUE(service.status(tile).ok());
  // 30 streams had a step before the tile if they were first come, first served.
  const auto stats = service.answer(v1::GetStatsRequest());
  EXPECT_GE(stats.lanes(1).waiting(), 20U);
  for (const auto& context : contexts) context->TryCancel();
  for (const auto& stream : streams) stream->Finish();
}

}  // namespace
}  // namespace lucerna::testing
