#include "service_fixture.h"

namespace lucerna::testing {
namespace {

class SceneServiceTest : public ::testing::Test {
 protected:
  grpc::Status load(const std::string& path, v1::LoadSceneResponse* response) {
    v1::LoadSceneRequest request;
    request.set_path(path);
    return ask([&](auto* c) { return service_.scenes.LoadScene(c, request, response); });
  }
  Service service_;
};

TEST_F(SceneServiceTest, LoadsListsAndReleasesAScene) {
  v1::LoadSceneResponse loaded, again;
  ASSERT_TRUE(load("point.pbrt", &loaded).ok());
  EXPECT_EQ(loaded.scene_id().size(), 64U);
  EXPECT_FALSE(loaded.already_loaded());
  ASSERT_TRUE(load("point.pbrt", &again).ok());
  EXPECT_EQ(again.scene_id(), loaded.scene_id());
  EXPECT_TRUE(again.already_loaded());
  EXPECT_EQ(service_.server->scenes().builds(), 1U);

  v1::GetSceneRequest get;
  get.set_scene_id(loaded.scene_id());
  v1::GetSceneResponse scene;
  ASSERT_TRUE(ask([&](auto* c) { return service_.scenes.GetScene(c, get, &scene); }).ok());
  EXPECT_EQ(scene.summary().path(), "point.pbrt");
  EXPECT_EQ(scene.summary().lights(), 1U);
  EXPECT_EQ(scene.summary().image_width(), 160U);
  EXPECT_EQ(scene.summary().samples_per_pixel(), 1024U);
  EXPECT_EQ(scene.summary().bounces(), 0U);  // maxdepth 1
  ASSERT_EQ(scene.assets_size(), 2);         // the file and its ball
  EXPECT_EQ(scene.assets(0).name(), "point.pbrt");
  EXPECT_EQ(scene.assets(1).name(), "ball.ply");
  EXPECT_GT(scene.parts_size(), 0);

  v1::ListLightsRequest list;
  list.set_scene_id(loaded.scene_id());
  v1::ListLightsResponse lights;
  ASSERT_TRUE(ask([&](auto* c) { return service_.scenes.ListLights(c, list, &lights); }).ok());
  ASSERT_EQ(lights.lights_size(), 1);
  EXPECT_EQ(lights.lights(0).source(), "point.pbrt:10:1");
  EXPECT_TRUE(lights.lights(0).delta());
  EXPECT_DOUBLE_EQ(lights.lights(0).point().position_m().y(), -1.5);
  EXPECT_NEAR(lights.lights(0).power_lm(), 125.66370614359172, 1e-9);  // 4 pi 10 cd

  v1::ReleaseSceneRequest release;
  release.set_scene_id(loaded.scene_id());
  v1::ReleaseSceneResponse nothing;
  EXPECT_TRUE(
      ask([&](auto* c) { return service_.scenes.ReleaseScene(c, release, &nothing); }).ok());
  const grpc::Status gone = ask([&](auto* c) { return service_.scenes.GetScene(c, get, &scene); });
  EXPECT_EQ(gone.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(detail<google::rpc::ErrorInfo>(gone).reason(), "SCENE_NOT_LOADED");
  EXPECT_EQ(
      ask([&](auto* c) { return service_.scenes.ReleaseScene(c, release, &nothing); }).error_code(),
      grpc::StatusCode::NOT_FOUND);
}

TEST_F(SceneServiceTest, ListsInPages) {
  for (const char* name : {"point.pbrt", "spot.pbrt", "sphere.pbrt"}) service_.load(name);
  v1::ListScenesRequest request;
  request.set_page_size(2);
  v1::ListScenesResponse first, second;
  ASSERT_TRUE(ask([&](auto* c) { return service_.scenes.ListScenes(c, request, &first); }).ok());
  EXPECT_EQ(first.scenes_size(), 2);
  ASSERT_FALSE(first.next_page_token().empty());
  request.set_page_token(first.next_page_token());
  ASSERT_TRUE(ask([&](auto* c) { return service_.scenes.ListScenes(c, request, &second); }).ok());
  ASSERT_EQ(second.scenes_size(), 1);
  EXPECT_GT(second.scenes(0).scene_id(), first.scenes(1).scene_id());
  EXPECT_TRUE(second.next_page_token().empty());
  request.set_page_token("garbage");
  expect_bad_field(ask([&](auto* c) { return service_.scenes.ListScenes(c, request, &second); }),
                   "page_token");
  request.set_page_size(100000);
  expect_bad_field(ask([&](auto* c) { return service_.scenes.ListScenes(c, request, &second); }),
                   "page_size");
}

TEST_F(SceneServiceTest, PathsThatLeaveTheRootAreAllRefusedAlike) {
  v1::LoadSceneResponse response;
  for (const char* path : {"../README.md", "/etc/passwd", "/etc/no-such-file", "a/../../x"}) {
    const grpc::Status s = load(path, &response);
    EXPECT_EQ(s.error_code(), grpc::StatusCode::INVALID_ARGUMENT) << path;
    EXPECT_NE(s.error_message().find(path), std::string::npos);
    EXPECT_NE(s.error_message().find("leaves the scene root"), std::string::npos);
  }
  EXPECT_EQ(load("nothing.pbrt", &response).error_code(), grpc::StatusCode::NOT_FOUND);
  expect_bad_field(load("", &response), "path");
  EXPECT_TRUE(load("point.pbrt", &response).ok());  // and it serves on
}

TEST_F(SceneServiceTest, WhatComesLaterIsUnimplementedWithASentence) {
  v1::LoadSceneRequest manifest;
  manifest.mutable_manifest()->set_main("a.pbrt");
  v1::LoadSceneResponse loaded;
  v1::FindMissingAssetsResponse missing;
  v1::EditLightsResponse edited;
  v1::RenewLeaseResponse renewed;
  v1::UploadAssetResponse uploaded;
  v1::GetStatsResponse stats;
  const auto upload = [&](grpc::ClientContext* c) {
    auto writer = service_.scenes.UploadAsset(c, &uploaded);
    writer->Write({});
    return writer->Finish();
  };
  for (const grpc::Status& s :
       {ask([&](auto* c) { return service_.scenes.LoadScene(c, manifest, &loaded); }),
        ask([&](auto* c) { return service_.scenes.FindMissingAssets(c, {}, &missing); }),
        ask([&](auto* c) { return service_.scenes.EditLights(c, {}, &edited); }),
        ask([&](auto* c) { return service_.scenes.RenewLease(c, {}, &renewed); }), ask(upload),
        ask([&](auto* c) { return service_.admin.GetStats(c, {}, &stats); })}) {
    EXPECT_EQ(s.error_code(), grpc::StatusCode::UNIMPLEMENTED);
    EXPECT_GT(s.error_message().size(), 20U);
    EXPECT_EQ(detail<google::rpc::ErrorInfo>(s).reason(), "NOT_IMPLEMENTED");
  }
}

TEST_F(SceneServiceTest, TellsWhatTheServerIs) {
  v1::GetServerInfoResponse info;
  ASSERT_TRUE(ask([&](auto* c) { return service_.admin.GetServerInfo(c, {}, &info); }).ok());
  EXPECT_EQ(info.version(), "test");
  EXPECT_EQ(info.threads(), 2U);
  EXPECT_EQ(info.limits().max_batch_items(), 65536U);
  EXPECT_EQ(info.fingerprint().digest().size(), 32U);
  EXPECT_NE(info.fingerprint().embree().find("3.13"), std::string::npos);
  EXPECT_NE(info.fingerprint().libm().find("glibc"), std::string::npos);
}

}  // namespace
}  // namespace lucerna::testing
