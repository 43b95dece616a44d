#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "service_fixture.h"
#include "tests/server/pbrt/pbrt_fixture.h"

namespace lucerna::testing {
namespace {

class SceneServiceTest : public ::testing::Test {
 protected:
  grpc::Status load(const std::string& path, v1::LoadSceneResponse* response) {
    v1::LoadSceneRequest request;
    request.set_path(path);
    return service_.call(request, response);
  }
  Service service_;
};

TEST_F(SceneServiceTest, ListsTheImageOfAnAreaLight) {
  const std::string id = service_.load("textured.pbrt");
  const auto lights = service_.answer(about<v1::ListLightsRequest>(id));
  ASSERT_EQ(lights.lights_size(), 1);
  const v1::Light& light = lights.lights(0);
  EXPECT_FALSE(light.delta());
  EXPECT_NEAR(light.area_m2(), 2.4 * 1.6, 1e-6);
  EXPECT_EQ(light.diffuse_area().shape(), v1::AREA_SHAPE_BILINEAR_MESH);
  EXPECT_EQ(light.diffuse_area().primitives(), 1U);
  EXPECT_TRUE(light.diffuse_area().two_sided());
  EXPECT_EQ(light.diffuse_area().radiance_cd_m2().g(), 5);
  const v1::ImageInfo& image = light.diffuse_area().image();
  EXPECT_EQ(image.name(), "screen.exr");
  EXPECT_EQ(image.filter(), v1::IMAGE_FILTER_BILINEAR);
  EXPECT_EQ(image.width(), 16U);
  EXPECT_EQ(image.height(), 16U);
  EXPECT_GT(light.power_lm(), 0);
  EXPECT_EQ(light.power_error_lm(), 0);

  const auto scene = service_.answer(about<v1::GetSceneRequest>(id));
  const auto is_images = [](const v1::ScenePart& part) { return part.name() == "images"; };
  EXPECT_EQ(std::count_if(scene.parts().begin(), scene.parts().end(), is_images), 1);
}

TEST_F(SceneServiceTest, LoadsListsAndReleasesAScene) {
  v1::LoadSceneResponse loaded, again;
  ASSERT_TRUE(load("point.pbrt", &loaded).ok());
  EXPECT_EQ(loaded.scene_id().size(), 64U);
  EXPECT_FALSE(loaded.already_loaded());
  ASSERT_TRUE(load("point.pbrt", &again).ok());
  EXPECT_EQ(again.scene_id(), loaded.scene_id());
  EXPECT_TRUE(again.already_loaded());
  EXPECT_EQ(service_.server->scenes().builds(), 1U);

  auto get = about<v1::GetSceneRequest>(loaded.scene_id());
  auto scene = service_.answer(get);
  EXPECT_EQ(scene.summary().path(), "point.pbrt");
  EXPECT_EQ(scene.summary().lights(), 1U);
  EXPECT_EQ(scene.summary().image_width(), 160U);
  EXPECT_EQ(scene.summary().samples_per_pixel(), 1024U);
  EXPECT_EQ(scene.summary().bounces(), 0U);  // maxdepth 1
  ASSERT_EQ(scene.assets_size(), 2);         // the file and its ball
  EXPECT_EQ(scene.assets(0).name(), "point.pbrt");
  EXPECT_EQ(scene.assets(1).name(), "ball.ply");
  EXPECT_GT(scene.parts_size(), 0);

  const auto lights = service_.answer(about<v1::ListLightsRequest>(loaded.scene_id()));
  ASSERT_EQ(lights.lights_size(), 1);
  EXPECT_EQ(lights.lights(0).source(), "point.pbrt:10:1");
  EXPECT_TRUE(lights.lights(0).delta());
  EXPECT_DOUBLE_EQ(lights.lights(0).point().position_m().y(), -1.5);
  EXPECT_NEAR(lights.lights(0).power_lm(), 125.66370614359172, 1e-9);  // 4 pi 10 cd

  auto release = about<v1::ReleaseSceneRequest>(loaded.scene_id());
  auto nothing = service_.answer(release);
  expect_error(service_.call(get, &scene), grpc::StatusCode::NOT_FOUND, "", "SCENE_NOT_LOADED");
  EXPECT_EQ(service_.call(release, &nothing).error_code(), grpc::StatusCode::NOT_FOUND);
}

TEST_F(SceneServiceTest, ListsInPages) {
  for (const char* name : {"point.pbrt", "spot.pbrt", "sphere.pbrt"}) service_.load(name);
  v1::ListScenesRequest request;
  request.set_page_size(2);
  const auto first = service_.answer(request);
  EXPECT_EQ(first.scenes_size(), 2);
  ASSERT_FALSE(first.next_page_token().empty());
  request.set_page_token(first.next_page_token());
  auto second = service_.answer(request);
  ASSERT_EQ(second.scenes_size(), 1);
  EXPECT_GT(second.scenes(0).scene_id(), first.scenes(1).scene_id());
  EXPECT_TRUE(second.next_page_token().empty());
  request.set_page_token("garbage");
  expect_bad_field(service_.call(request, &second), "page_token");
  request.set_page_size(100000);
  expect_bad_field(service_.call(request, &second), "page_size");
}

TEST_F(SceneServiceTest, PagesOfLightsBelongToOneScene) {
  v1::ListLightsRequest request;
  v1::ListLightsResponse page;
  const auto list = [&](const std::string& scene, const std::string& token) {
    request.set_scene_id(scene);
    request.set_page_token(token);
    page.Clear();
    return service_.call(request, &page);
  };
  const std::string many = service_.load("many_points.pbrt");
  const std::string other = service_.load("many_triangles.pbrt");
  request.set_page_size(2);
  ASSERT_TRUE(list(many, "").ok());
  const std::string token = page.next_page_token();
  ASSERT_FALSE(token.empty());
  expect_bad_field(list(other, token), "page_token");
  // Pages may have another size.
  request.set_page_size(1);
  ASSERT_TRUE(list(many, token).ok());
  ASSERT_EQ(page.lights_size(), 1);
  EXPECT_EQ(page.lights(0).id(), 3U);

  // A token of another call.
  v1::EstimatePowerRequest power;
  v1::EstimatePowerResponse powers;
  power.set_scene_id(many);
  power.set_page_size(2);
  power.set_page_token(token);
  const auto estimate = [&] { return service_.call(power, &powers); };
  expect_bad_field(estimate(), "page_token");
  power.clear_page_token();
  ASSERT_TRUE(estimate().ok());
  expect_bad_field(list(many, powers.next_page_token()), "page_token");
  v1::ListScenesRequest scenes;
  scenes.set_page_token(token);
  expect_bad_field(service_.status(scenes), "page_token");
}

TEST_F(SceneServiceTest, AvailableScenesComeInPagesRelativeToTheRoot) {
  const std::string root = service_options().scenes.root;
  v1::ListAvailableScenesRequest request;
  v1::ListAvailableScenesResponse all;
  const auto list = [&](v1::ListAvailableScenesResponse* r) { return service_.call(request, r); };
  ASSERT_TRUE(list(&all).ok());
  EXPECT_EQ(std::filesystem::canonical(all.root()), std::filesystem::canonical(root));
  EXPECT_FALSE(all.incomplete());
  EXPECT_NE(std::find(all.paths().begin(), all.paths().end(), "point.pbrt"), all.paths().end());
  for (const std::string& path : all.paths())
    EXPECT_TRUE(std::filesystem::is_regular_file(root + "/" + path)) << path;

  std::vector<std::string> by_pages;
  request.set_page_size(3);
  do {
    v1::ListAvailableScenesResponse page;
    ASSERT_TRUE(list(&page).ok());
    EXPECT_LE(page.paths_size(), 3);
    by_pages.insert(by_pages.end(), page.paths().begin(), page.paths().end());
    request.set_page_token(page.next_page_token());
  } while (!request.page_token().empty());
  EXPECT_EQ(by_pages, std::vector<std::string>(all.paths().begin(), all.paths().end()));
  request.set_page_token("garbage");
  expect_bad_field(list(&all), "page_token");
}

TEST_F(SceneServiceTest, AnAbsolutePathInsideOfTheRootIsTheSameScene) {
  v1::LoadSceneResponse relative, absolute;
  ASSERT_TRUE(load("point.pbrt", &relative).ok());
  const grpc::Status s = load(service_options().scenes.root + "/point.pbrt", &absolute);
  ASSERT_TRUE(s.ok()) << s.error_message();
  EXPECT_EQ(absolute.scene_id(), relative.scene_id());
  EXPECT_TRUE(absolute.already_loaded());
}

TEST_F(SceneServiceTest, NotFoundNamesTheRootAndTheUpload) {
  v1::LoadSceneResponse response;
  const grpc::Status s = load("nothing.pbrt", &response);
  EXPECT_EQ(s.error_code(), grpc::StatusCode::NOT_FOUND);
  for (const char* part : {"\"nothing.pbrt\" does not exist", "/reference\"", "upload"})
    EXPECT_NE(s.error_message().find(part), std::string::npos) << s.error_message();
}

TEST_F(SceneServiceTest, AnEmptyIdIsABadFieldOfEveryCall) {
  for (const grpc::Status& s :
       {service_.status(v1::GetSceneRequest()), service_.status(v1::ListLightsRequest()),
        service_.status(v1::RenewLeaseRequest()), service_.status(v1::ReleaseSceneRequest())})
    expect_bad_field(s, "scene_id");
}

TEST_F(SceneServiceTest, PathsOutOfTheRootAllHaveTheSameError) {
  v1::LoadSceneResponse response;
  for (const char* path : {"../README.md", "/etc/passwd", "/etc/no-such-file", "a/../../x"}) {
    const grpc::Status s = load(path, &response);
    EXPECT_EQ(s.error_code(), grpc::StatusCode::INVALID_ARGUMENT) << path;
    EXPECT_NE(s.error_message().find(path), std::string::npos);
    EXPECT_NE(s.error_message().find("leaves the scene root"), std::string::npos);
  }
  EXPECT_EQ(load("nothing.pbrt", &response).error_code(), grpc::StatusCode::NOT_FOUND);
  expect_bad_field(load("", &response), "path");
  EXPECT_TRUE(load("point.pbrt", &response).ok());  // and the server still works
}

TEST_F(SceneServiceTest, GetServerInfoDescribesTheServer) {
  const auto info = service_.answer(v1::GetServerInfoRequest());
  EXPECT_EQ(info.version(), "test");
  EXPECT_EQ(info.threads(), 2U);
  EXPECT_EQ(info.limits().max_batch_items(), 65536U);
  EXPECT_EQ(info.fingerprint().digest().size(), 32U);
  EXPECT_NE(info.fingerprint().embree().find("3.13"), std::string::npos);
  EXPECT_NE(info.fingerprint().libm().find("glibc"), std::string::npos);
}

}  // namespace
TEST(ServicePanel, ReportsItsPhotometryAndHasItsRadiance) {
  const SceneFiles files;
  // 200 cd towards C0 at 60 degrees, 100 cd straight down, nothing in the other half.
  files.write("lamp.ies",
              "TILT=NONE\n1 -1 1 3 3 1 2 0.5 0.5 0\n1 1 10\n0 60 90\n0 90 180\n"
              "100 200 0\n100 0 0\n100 0 0\n");
  files.write("scene.pbrt",
              "WorldBegin\nAreaLightSource \"diffuse\" \"string profile\" \"lamp.ies\" "
              "Shape \"bilinearmesh\" \"point3 P\" [0 0 0 2 0 0 0 1 0 2 1 0]");
  Service service(scenes_in(files.path()));
  const std::string id = service.load("scene.pbrt");
  const auto lights = service.answer(about<v1::ListLightsRequest>(id));
  ASSERT_EQ(lights.lights_size(), 1);
  const v1::DiffuseAreaLight& area = lights.lights(0).diffuse_area();
  EXPECT_EQ(area.profile().name(), "lamp.ies");
  EXPECT_EQ(area.profile().format(), "IES LM-63-1986, type C");
  EXPECT_NEAR(area.profile().flux_lm(), lights.lights(0).power_lm(), 1e-9);
  EXPECT_EQ(lights.lights(0).power_error_lm(), 0);
  EXPECT_FALSE(area.has_image());
  // Flux / (pi A).
  EXPECT_NEAR(area.radiance_cd_m2().g(), lights.lights(0).power_lm() / (2 * std::numbers::pi),
              1e-9);

  // Looking at its middle from 60 degrees off its normal, towards C0 and away from it.
  auto request = about<v1::LeRequest>(id);
  for (const float x : {1.0F, -1.0F}) {
    for (const float v : {1 + x * std::sqrt(3.0F), 0.5F, 1.0F})
      request.mutable_points()->add_offsets_m(v);
    for (const float v : {-x * std::sqrt(3.0F), 0.0F, -1.0F}) request.add_directions(v);
  }
  const auto seen = service.answer(request);
  // I / (A cos): 200 / (2 / 2).
  EXPECT_NEAR(seen.radiance_cd_m2()[1], 200, 1e-3);
  EXPECT_NEAR(seen.radiance_cd_m2()[4], 0, 1e-3);
}

}  // namespace lucerna::testing
