// Uploads, manifests and leases over the wire.
#include <gmock/gmock.h>

#include <algorithm>

#include "proto/common/sha256.h"
#include "service_fixture.h"
#include "tests/server/pbrt/pbrt_fixture.h"

namespace lucerna::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr char kScene[] = "WorldBegin\nShape \"sphere\"\nLightSource \"point\"\n";

class AssetServiceTest : public ::testing::Test {
 protected:
  explicit AssetServiceTest(std::chrono::seconds stall_time = std::chrono::hours(1))
      : service_(options(stall_time)) {}

  rpc::ServerOptions options(std::chrono::seconds stall_time) {
    rpc::ServerOptions o = service_options();
    o.assets.stall_time = stall_time;
    o.assets.directory = (files_.path() / "assets").string();
    o.assets.max_asset_bytes = 8 << 20;
    return o;
  }

  static v1::UploadAssetRequest header(const std::string& digest, std::uint64_t size,
                                       std::uint64_t offset = 0) {
    v1::UploadAssetRequest request;
    request.mutable_header()->set_sha256(digest);
    request.mutable_header()->set_size_bytes(size);
    request.mutable_header()->set_offset_bytes(offset);
    return request;
  }
  static v1::UploadAssetRequest chunk(const std::string& bytes) {
    v1::UploadAssetRequest request;
    request.set_chunk(bytes);
    return request;
  }
  /// Sends one stream of these messages.  `received_` holds the server's answer.
  grpc::Status send(const std::vector<v1::UploadAssetRequest>& requests) {
    grpc::ClientContext context;
    v1::UploadAssetResponse response;
    const auto stream = service_.scenes.UploadAsset(&context, &response);
    for (const auto& request : requests) {
      if (!stream->Write(request)) break;
    }
    stream->WritesDone();
    const grpc::Status status = stream->Finish();
    received_ = response.received_bytes();
    return status;
  }
  grpc::Status put(const std::string& bytes) {
    return send({header(sha256(bytes), bytes.size()), chunk(bytes)});
  }

  v1::FindMissingAssetsResponse find(const std::vector<std::string>& digests) {
    v1::FindMissingAssetsRequest request;
    for (const auto& digest : digests) request.add_sha256(digest);
    return service_.answer(request);
  }

  static void name(v1::LoadSceneRequest* request, const std::string& name,
                   const std::string& digest) {
    v1::NamedAsset* asset = request->mutable_manifest()->add_assets();
    asset->set_name(name);
    asset->set_sha256(digest);
  }

  SceneFiles files_;
  Service service_;
  std::uint64_t received_ = 0;
};

TEST_F(AssetServiceTest, AnUploadedSceneIsLoadedByItsManifest) {
  v1::LoadSceneRequest request;
  request.mutable_manifest()->set_main("my/room.pbrt");
  name(&request, "my/room.pbrt", sha256(kScene));
  auto response = service_.answer(request);
  EXPECT_EQ(response.scene_id(), "");
  ASSERT_EQ(response.missing_size(), 1);
  EXPECT_EQ(response.missing(0).name(), "my/room.pbrt");
  EXPECT_EQ(response.missing(0).sha256(), sha256(kScene));

  EXPECT_THAT(find({sha256(kScene), sha256("x"), sha256(kScene)}).missing_sha256(),
              ElementsAre(sha256(kScene), sha256("x")));
  ASSERT_TRUE(put(kScene).ok());
  EXPECT_EQ(received_, sizeof kScene - 1);
  EXPECT_THAT(find({sha256(kScene)}).missing_sha256(), IsEmpty());
  request.set_lease_s(60);
  response = service_.answer(request);
  EXPECT_THAT(response.missing(), IsEmpty());
  EXPECT_EQ(response.scene_id().size(), 64U);
  EXPECT_FALSE(response.already_loaded());
  EXPECT_FALSE(response.lease_id().empty());
  EXPECT_EQ(response.lease_s(), 60);
  EXPECT_GT(response.cost().wall_time_s(), 0);

  const auto scenes = service_.answer(v1::ListScenesRequest());
  ASSERT_EQ(scenes.scenes_size(), 1);
  EXPECT_EQ(scenes.scenes(0).path(), "my/room.pbrt");
  EXPECT_GT(scenes.scenes(0).leased_s(), 0);
  EXPECT_LE(scenes.scenes(0).leased_s(), 60);
}

TEST_F(AssetServiceTest, TheLightLevelsOfBlenderMakeAnotherScene) {
  const std::string lamp =
      R"({"asset": {"version": "2.0"}, "nodes": [{"extensions": {"KHR_lights_punctual": {"light": 0}}}],
          "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point"}]}}})";
  ASSERT_TRUE(put(lamp).ok());
  v1::LoadSceneRequest request;
  request.mutable_manifest()->set_main("lamp.gltf");
  name(&request, "lamp.gltf", sha256(lamp));
  const auto plain = service_.answer(request);
  request.mutable_blender()->set_mode(v1::BLENDER_LIGHTING_MODE_UNITLESS);
  const auto bright = service_.answer(request);
  EXPECT_EQ(plain.scene_id().size(), 64U);
  EXPECT_EQ(bright.scene_id().size(), 64U);
  EXPECT_NE(bright.scene_id(), plain.scene_id());
  auto again = service_.answer(request);
  EXPECT_EQ(again.scene_id(), bright.scene_id());
  EXPECT_TRUE(again.already_loaded());

  // By name: the scene with these factors; without factors, the one used last.
  v1::LoadSceneRequest by_name;
  by_name.set_path("lamp.gltf");
  again = service_.answer(by_name);
  EXPECT_EQ(again.scene_id(), bright.scene_id());
  request.clear_blender();
  again = service_.answer(request);
  EXPECT_EQ(again.scene_id(), plain.scene_id());
  by_name.mutable_blender()->set_mode(v1::BLENDER_LIGHTING_MODE_UNITLESS);
  again = service_.answer(by_name);
  EXPECT_EQ(again.scene_id(), bright.scene_id());
  by_name.mutable_blender()->set_mode(v1::BLENDER_LIGHTING_MODE_RAW);
  expect_error(service_.call(by_name, &again), grpc::StatusCode::NOT_FOUND,
               "no uploaded scene has this name and these light "
               "levels");
}

TEST_F(AssetServiceTest, ABrokenUploadContinues) {
  const std::string bytes(3 << 20, 'x');
  const std::string digest = sha256(bytes);
  ASSERT_TRUE(send({header(digest, bytes.size()), chunk(bytes.substr(0, 1 << 20))}).ok());
  EXPECT_EQ(received_, 1U << 20);
  {
    // Cut off in the middle.
    grpc::ClientContext context;
    v1::UploadAssetResponse response;
    const auto stream = service_.scenes.UploadAsset(&context, &response);
    ASSERT_TRUE(stream->Write(header(digest, bytes.size(), 1 << 20)));
    ASSERT_TRUE(stream->Write(chunk(bytes.substr(0, 100))));
    while (find({digest}).received_bytes(0) == 1 << 20) {
    }
    context.TryCancel();
    EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::CANCELLED);
  }
  const std::uint64_t held = find({digest}).received_bytes(0);
  EXPECT_EQ(held, (1U << 20) + 100);
  // The server may still be closing the stream that was cut off.
  grpc::Status status;
  do {
    status = send({header(digest, bytes.size(), held), chunk(bytes.substr(held))});
  } while (detail<google::rpc::ErrorInfo>(status).reason() == "ASSET_BEING_UPLOADED");
  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(received_, bytes.size());
  EXPECT_THAT(find({digest}).missing_sha256(), IsEmpty());
}

TEST_F(AssetServiceTest, HeldFilesAreNotReadAgain) {
  ASSERT_TRUE(put("abc").ok());
  ASSERT_TRUE(send({header(sha256("abc"), 3)}).ok());
  EXPECT_EQ(received_, 3U);
}

TEST_F(AssetServiceTest, BytesOfAnotherDigestAreRefused) {
  const grpc::Status status = send({header(sha256("right"), 5), chunk("wrong")});
  expect_bad_field(status, "header.sha256");
  EXPECT_THAT(status.error_message(), HasSubstr(hexadecimal(sha256("wrong"))));
  EXPECT_EQ(find({sha256("right")}).received_bytes(0), 0U);
}

TEST_F(AssetServiceTest, StreamsOutOfOrderAreRefused) {
  expect_bad_field(send({}), "part");
  expect_bad_field(send({chunk("abc")}), "part");
  expect_bad_field(send({header(sha256("abc"), 3), header(sha256("abc"), 3)}), "part");
  expect_bad_field(send({header("abc", 3)}), "header.sha256");
  expect_bad_field(send({header(sha256("abc"), 3, 1)}), "header.offset_bytes");
  expect_bad_field(send({header(sha256("abc"), 3), chunk("abcd")}), "chunk");
  expect_bad_field(send({header(sha256("abc"), 8 << 20), chunk(std::string((4 << 20) + 1, 'x'))}),
                   "chunk");
  EXPECT_TRUE(put("abc").ok());
}

TEST_F(AssetServiceTest, FilesOverTheLimitAreRefusedBeforeTheirBytes) {
  expect_error(send({header(sha256("abc"), (8 << 20) + 1)}), grpc::StatusCode::RESOURCE_EXHAUSTED,
               "header.size_bytes = 8388609");
}

TEST_F(AssetServiceTest, ASecondWriterMustWait) {
  grpc::ClientContext context;
  v1::UploadAssetResponse response;
  const auto stream = service_.scenes.UploadAsset(&context, &response);
  ASSERT_TRUE(stream->Write(header(sha256("abc"), 3)));
  ASSERT_TRUE(stream->Write(chunk("ab")));
  while (find({sha256("abc")}).received_bytes(0) < 2) {
  }
  const grpc::Status status = put("abc");
  expect_error(status, grpc::StatusCode::FAILED_PRECONDITION, "", "ASSET_BEING_UPLOADED");
  EXPECT_GT(detail<google::rpc::RetryInfo>(status).retry_delay().nanos(), 0);
  ASSERT_TRUE(stream->Write(chunk("c")));
  stream->WritesDone();
  ASSERT_TRUE(stream->Finish().ok());
  EXPECT_EQ(response.received_bytes(), 3U);
}

TEST_F(AssetServiceTest, ManifestsAreChecked) {
  v1::LoadSceneRequest request;
  request.mutable_manifest()->set_main("a.pbrt");
  expect_bad_field(service_.status(request), "manifest.main");
  name(&request, "a.pbrt", "short");
  expect_bad_field(service_.status(request), "manifest.assets[0].sha256");
  for (const char* bad : {"", "/a.pbrt", "../a.pbrt", "b/../a.pbrt", "./a.pbrt", "b//a", "b/"}) {
    request.mutable_manifest()->mutable_assets(0)->set_name(bad);
    expect_bad_field(service_.status(request), "manifest.assets[0].name");
  }
  request.mutable_manifest()->clear_assets();
  name(&request, "a.pbrt", sha256("a"));
  name(&request, "a.pbrt", sha256("b"));
  expect_bad_field(service_.status(request), "manifest.assets[1].name");
  request.mutable_manifest()->mutable_assets()->RemoveLast();
  request.set_lease_s(-1);
  expect_bad_field(service_.status(request), "lease_s");

  v1::FindMissingAssetsRequest find;
  find.add_sha256("short");
  expect_bad_field(service_.status(find), "sha256[0]");
}

TEST_F(AssetServiceTest, LeasesAreRenewedAndEnded) {
  const std::string id = service_.load("point.pbrt");
  const auto renew = [&](double seconds, const std::string& lease, v1::RenewLeaseResponse* out) {
    auto request = about<v1::RenewLeaseRequest>(id);
    request.set_lease_s(seconds);
    request.set_lease_id(lease);
    return service_.call(request, out);
  };
  const auto release = [&](const std::string& lease, v1::ReleaseSceneResponse* out) {
    auto request = about<v1::ReleaseSceneRequest>(id);
    request.set_lease_id(lease);
    return service_.call(request, out);
  };
  v1::RenewLeaseResponse mine, yours, again;
  expect_bad_field(renew(0, "", &mine), "lease_s");
  expect_bad_field(renew(NAN, "", &mine), "lease_s");
  EXPECT_EQ(renew(5, "none", &mine).error_code(), grpc::StatusCode::NOT_FOUND);
  ASSERT_TRUE(renew(500, "", &mine).ok());
  ASSERT_TRUE(renew(1e9, "", &yours).ok());
  EXPECT_EQ(yours.lease_s(), 86400);
  EXPECT_NE(mine.lease_id(), yours.lease_id());
  ASSERT_TRUE(renew(1000, mine.lease_id(), &again).ok());
  EXPECT_EQ(again.lease_id(), mine.lease_id());
  EXPECT_EQ(again.lease_s(), 1000);

  v1::ReleaseSceneResponse released;
  expect_error(release("", &released), grpc::StatusCode::FAILED_PRECONDITION,
               "leased for another 86");
  ASSERT_TRUE(release(mine.lease_id(), &released).ok());
  EXPECT_TRUE(released.still_loaded());
  ASSERT_TRUE(release(yours.lease_id(), &released).ok());
  EXPECT_FALSE(released.still_loaded());
  EXPECT_EQ(release("", &released).error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(renew(5, "", &mine).error_code(), grpc::StatusCode::NOT_FOUND);
}

TEST(MemoryBudget, LeasesThatLeaveNoRoomAreReportedWithARetryDelay) {
  rpc::ServerOptions options = service_options();
  options.scenes.memory_budget_bytes = 1 << 20;  // point.pbrt takes the larger part of it
  Service service(options);
  v1::LoadSceneRequest request;
  request.set_path("point.pbrt");
  request.set_lease_s(7200);
  auto response = service.answer(request);
  grpc::Status status = grpc::Status::OK;
  // All loaded scenes are leased, so one of these does not fit.
  for (const char* path : {"spot.pbrt", "rectangle.pbrt", "sphere.pbrt", "disk.pbrt"}) {
    request.set_path(path);
    status = service.call(request, &response);
    if (!status.ok()) break;
  }
  expect_error(status, grpc::StatusCode::RESOURCE_EXHAUSTED, "", "MEMORY_LEASED");
  const auto retry = detail<google::rpc::RetryInfo>(status);
  EXPECT_GT(retry.retry_delay().seconds(), 3600);
  EXPECT_LE(retry.retry_delay().seconds(), 7200);
}

class StalledUploadTest : public AssetServiceTest {
 protected:
  StalledUploadTest() : AssetServiceTest(std::chrono::seconds(1)) {}
};

TEST_F(StalledUploadTest, TheServerEndsItAndKeepsWhatArrived) {
  const std::string bytes = "abcdef";
  const auto stall_after = [&](const std::vector<v1::UploadAssetRequest>& requests) {
    grpc::ClientContext context;
    // The message below tells the server's end from this one.
    context.set_deadline(std::chrono::system_clock::now() + std::chrono::minutes(2));
    v1::UploadAssetResponse response;
    const auto stream = service_.scenes.UploadAsset(&context, &response);
    for (const auto& request : requests) stream->Write(request);
    expect_error(stream->Finish(), grpc::StatusCode::DEADLINE_EXCEEDED,
                 "the upload sent less than 65536 bytes in 1 s");
  };
  stall_after({});
  // A busy machine may pause between the messages for so long that the server ends the stream
  // before.  A client then sends again what is missing.
  std::uint64_t held = 0;
  for (int i = 0; i < 100 && held < 3; ++i) {
    stall_after({header(sha256(bytes), bytes.size()), chunk("abc")});
    held = find({sha256(bytes)}).received_bytes(0);
  }
  ASSERT_EQ(held, 3U);
  grpc::Status rest;
  for (int i = 0; i < 100 && received_ < bytes.size(); ++i)
    rest = send({header(sha256(bytes), bytes.size(), held), chunk("def")});
  EXPECT_TRUE(rest.ok()) << rest.error_message();
  EXPECT_EQ(received_, bytes.size());
}

TEST_F(StalledUploadTest, EmptyAndTinyChunksDoNotKeepItAlive) {
  for (const std::string& bytes : {std::string(), std::string("a")}) {
    grpc::ClientContext context;
    v1::UploadAssetResponse response;
    const auto stream = service_.scenes.UploadAsset(&context, &response);
    stream->Write(header(sha256(bytes), 1 << 20));
    // A server that counts messages reads all of them, which takes a minute.
    int sent = 0;
    for (; sent < 6000 && stream->Write(chunk(bytes)); ++sent)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    EXPECT_LT(sent, 6000);
    expect_error(stream->Finish(), grpc::StatusCode::DEADLINE_EXCEEDED,
                 "less than 65536 bytes in 1 s");
  }
}

TEST_F(AssetServiceTest, NamesOfScenesAreBounded) {
  v1::LoadSceneRequest request;
  request.set_path(std::string(5000, 'a'));
  expect_error(service_.status(request), grpc::StatusCode::INVALID_ARGUMENT,
               "path = 5000 bytes, allowed: at most 4096 bytes");
}

}  // namespace
}  // namespace lucerna::testing
