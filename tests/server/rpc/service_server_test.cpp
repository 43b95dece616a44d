#include <grpcpp/generic/generic_stub.h>

#include <thread>

#include "server/rpc/messages/errors.h"
#include "server/rpc/messages/paging.h"
#include "service_fixture.h"
#include "tests/server/rpc/health_client.h"

namespace lucerna::testing {
namespace {

using HealthResponse = grpc::health::v1::HealthCheckResponse;

/// The answer of server reflection to one request, as bytes.
std::string reflect(Service& service, const std::string& request,
                    const std::string& version = "v1alpha") {
  grpc::GenericStub stub(service.channel);
  grpc::ClientContext context;
  grpc::CompletionQueue queue;
  const auto next = [&] {
    void* tag = nullptr;
    bool ok = false;
    return queue.Next(&tag, &ok) && ok;
  };
  auto stream = stub.PrepareCall(
      &context, "/grpc.reflection." + version + ".ServerReflection/ServerReflectionInfo", &queue);
  stream->StartCall(nullptr);
  EXPECT_TRUE(next());
  const grpc::Slice slice(request);
  stream->Write(grpc::ByteBuffer(&slice, 1), nullptr);
  EXPECT_TRUE(next());
  grpc::ByteBuffer answer;
  stream->Read(&answer, nullptr);
  EXPECT_TRUE(next());
  stream->WritesDone(nullptr);
  next();
  grpc::Status status;
  stream->Finish(&status, nullptr);
  next();
  grpc::Slice all;
  EXPECT_TRUE(answer.DumpToSingleSlice(&all).ok());
  return {reinterpret_cast<const char*>(all.begin()), all.size()};
}

TEST(ServerTest, HealthIsReportedForEachServiceAndChangesWhileDraining) {
  Service service;
  EXPECT_EQ(health(service, ""), HealthResponse::SERVING);
  EXPECT_EQ(health(service, "lucerna.v1.RenderService"), HealthResponse::SERVING);
  service.server->begin_drain();
  EXPECT_EQ(health(service, ""), HealthResponse::NOT_SERVING);
  EXPECT_EQ(health(service, "lucerna.v1.RenderService"), HealthResponse::NOT_SERVING);
  expect_error(service.status(v1::GetServerInfoRequest()), grpc::StatusCode::UNAVAILABLE, "",
               "DRAINING");
}

TEST(ServerTest, RunningCallsEndWhileDraining) {
  Service service;
  const std::string scene = service.load("point.pbrt");
  auto busy = std::make_unique<BusyLane>(*service.server, Lane::kBulk);
  std::promise<grpc::Status> answer;
  std::thread caller([&] {
    auto q = about<v1::RenderTileRequest>(scene);
    q.mutable_accuracy()->set_samples(1);
    answer.set_value(service.status(q));
  });
  while (service.server->lanes().pending(Lane::kBulk) < 3) std::this_thread::yield();
  std::thread drain([&] { service.server->drain(std::chrono::hours(1)); });
  while (health(service, "") == HealthResponse::SERVING) std::this_thread::yield();
  busy.reset();
  const grpc::Status status = answer.get_future().get();
  EXPECT_TRUE(status.ok()) << status.error_code() << ": " << status.error_message();
  caller.join();
  drain.join();
}

TEST(ServerTest, DrainingEndsCallsThatTakeTooLong) {
  Service service;
  const std::string scene = service.load("point.pbrt");
  std::thread caller([&] {
    auto q = about<v1::RenderTileRequest>(scene);
    q.mutable_accuracy()->set_samples(1 << 20);
    EXPECT_FALSE(service.status(q).ok());
  });
  while (service.server->lanes().pending(Lane::kBulk) == 0) std::this_thread::yield();
  service.server->drain(std::chrono::milliseconds(10));
  caller.join();
}

TEST(ServerTest, ReflectionListsTheServicesAndDescribesHealth) {
  Service service;
  const std::string services = reflect(service, std::string("\x3a\x00", 2));  // list_services: ""
  for (const char* name :
       {"lucerna.v1.SceneService", "lucerna.v1.LightingService", "lucerna.v1.RenderService",
        "lucerna.v1.AdminService", "grpc.health.v1.Health"}) {
    EXPECT_NE(services.find(name), std::string::npos) << name;
  }
  // file_containing_symbol
  const std::string health = reflect(service, std::string("\x22\x15") + "grpc.health.v1.Health");
  EXPECT_NE(health.find("HealthCheckRequest"), std::string::npos);
  const std::string lighting =
      reflect(service, std::string("\x22\x1a") + "lucerna.v1.LightingService");
  EXPECT_NE(lighting.find("EstimateIrradiance"), std::string::npos);
  EXPECT_EQ(reflect(service, std::string("\x22\x1a") + "lucerna.v1.LightingService", "v1"),
            lighting);
  // Its imports come with it.
  EXPECT_NE(lighting.find("lucerna/v1/accuracy.proto"), std::string::npos);
  // file_by_filename, file_containing_symbol, file_containing_extension, nothing
  const std::string file = reflect(service, std::string("\x1a\x19") + "lucerna/v1/accuracy.proto");
  EXPECT_NE(file.find("ItemStatus"), std::string::npos);
  for (const std::string request : {"\x22\x06no.one", "\x2a\x02\x10\x01", "\x32\x06no.one", ""}) {
    EXPECT_NE(reflect(service, request).find("not found"), std::string::npos) << request;
  }
}

TEST(ServerTest, ABusyPortIsAnError) {
  Service service;
  rpc::ServerOptions options = service_options();
  options.listen = service.server->address();
  const auto second = rpc::Server::start(options);
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(std::string(second.status().message()),
            "cannot listen on " + options.listen + ": address in use");
}

TEST(ServerTest, WrongOptionsAreErrors) {
  rpc::ServerOptions options = service_options();
  options.listen = "127.0.0.1";
  EXPECT_EQ(rpc::Server::start(options).status().code(), absl::StatusCode::kInvalidArgument);
  options = service_options();
  options.scenes.root = "/no/such/directory";
  EXPECT_FALSE(rpc::Server::start(options).ok());
  options = service_options();
  options.scenes.isa = "abacus";
  EXPECT_EQ(rpc::Server::start(options).status().code(), absl::StatusCode::kInvalidArgument);
  options = service_options();
  options.load = {"none.pbrt"};
  EXPECT_EQ(rpc::Server::start(options).status().code(), absl::StatusCode::kNotFound);
}

TEST(ServerTest, LoadsScenesBeforeItServes) {
  rpc::ServerOptions options = service_options();
  options.load = {"point.pbrt", "spot.pbrt"};
  const Service service(options);
  EXPECT_EQ(service.server->scenes().size(), 2U);
}

TEST(Errors, InternalErrorsRevealNothing) {
  for (const absl::Status& s : {absl::InternalError("/secret/path: boom"),
                                absl::UnknownError("boom"), absl::DataLossError("boom")}) {
    const rpc::WireError wire = rpc::to_wire(s);
    EXPECT_EQ(wire.code, 13);
    EXPECT_EQ(wire.message.find("boom"), std::string::npos);
    EXPECT_EQ(wire.details.find("boom"), std::string::npos);
  }
}

TEST(Errors, CodesAreThoseOfGrpc) {
  EXPECT_EQ(rpc::to_wire(absl::CancelledError("")).code, grpc::StatusCode::CANCELLED);
  EXPECT_EQ(rpc::to_wire(absl::InvalidArgumentError("")).code, grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(rpc::to_wire(absl::DeadlineExceededError("")).code,
            grpc::StatusCode::DEADLINE_EXCEEDED);
  EXPECT_EQ(rpc::to_wire(absl::NotFoundError("")).code, grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(rpc::to_wire(absl::ResourceExhaustedError("")).code,
            grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(rpc::to_wire(absl::FailedPreconditionError("")).code,
            grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_EQ(rpc::to_wire(absl::UnavailableError("")).code, grpc::StatusCode::UNAVAILABLE);
}

TEST(Errors, LongTextsKeepBeginningAndEnd) {
  EXPECT_EQ(rpc::shortened("lumen", 5), "lumen");
  EXPECT_EQ(rpc::shortened("0123456789abcdef", 12), "01234567...cdef");
  // Two bytes per letter: none is cut.
  EXPECT_EQ(rpc::shortened("aéééééééé", 12), "aééé...éé");
}

TEST(Errors, LongNamesReachTheCaller) {
  Service service;
  grpc::ClientContext load_context, get_context;
  v1::LoadSceneRequest load;
  load.set_path("../" + std::string(20000, 'a'));
  v1::LoadSceneResponse loaded;
  expect_error(service.scenes.LoadScene(&load_context, load, &loaded),
               grpc::StatusCode::INVALID_ARGUMENT, "4096");
  v1::GetSceneRequest get;
  for (int i = 0; i < 10000; ++i) *get.mutable_scene_id() += "é";
  v1::GetSceneResponse got;
  const grpc::Status unknown = service.scenes.GetScene(&get_context, get, &got);
  EXPECT_EQ(unknown.error_code(), grpc::StatusCode::NOT_FOUND) << unknown.error_message();
}

TEST(Paging, TokensBelongToTheirList) {
  const std::string token = rpc::page_token("lights", std::size_t{12});
  EXPECT_EQ(*rpc::page_start("lights", token, 20), 12U);
  EXPECT_FALSE(rpc::page_start("power", token, 20).ok());
  EXPECT_FALSE(rpc::page_start("lights", token, 11).ok());
  // Any other character makes another token.
  for (std::size_t i = 0; i < token.size(); ++i) {
    for (const char c : {'A', 'b', '0', '-', '=', ' '}) {
      std::string other = token;
      other[i] = c;
      if (other == token) continue;
      const auto start = rpc::page_start("lights", other, 20);
      // The last character holds bits that belong to no byte.
      EXPECT_TRUE(!start.ok() || (i + 1 == token.size() && *start == 12)) << other;
    }
  }
}

}  // namespace
}  // namespace lucerna::testing
