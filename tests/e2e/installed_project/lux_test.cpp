// A test that a user of an installed Lucerna writes.
#include <gtest/gtest.h>

#include "lucerna/client/batches.h"
#include "lucerna/client/client.h"
#include "lucerna/client/picture.h"
#include "lucerna/client/points.h"
#include "lucerna/client/testing/local_server_test.h"

namespace {

namespace v1 = lucerna::v1;

class Lux : public lucerna::testing::LocalServerTest {
 protected:
  lucerna::testing::LocalServerOptions options() const override { return {.scene_root = SCENES}; }
};

TEST_F(Lux, UnderAPointLightFollowsTheInverseSquareLaw) {
  v1::LoadSceneRequest load;
  load.set_path("point.pbrt");
  const auto loaded = client().load_scene(load);
  ASSERT_TRUE(loaded.ok()) << loaded.status();

  v1::EstimateIrradianceRequest request;
  request.set_scene_id(loaded->scene_id());
  const lucerna::client::Double3 floor[] = {{1.2, -1.5, 0}};
  *request.mutable_receivers() = lucerna::client::make_points(floor);
  for (const float n : {0.0F, 0.0F, 1.0F}) request.add_normals(n);
  request.set_bounces(0);
  const auto answer = lucerna::client::estimate_irradiance_in_batches(client(), request);
  ASSERT_TRUE(answer.ok()) << answer.status();
  // 10 cd, 3.2 m above.
  EXPECT_FLOAT_EQ(answer->illuminance_lx(0), 10 / (3.2F * 3.2F));
}

TEST_F(Lux, PictureIsPutTogether) {
  v1::LoadSceneRequest load;
  load.set_path("point.pbrt");
  const auto loaded = client().load_scene(load);
  ASSERT_TRUE(loaded.ok()) << loaded.status();
  v1::RenderImageRequest request;
  request.set_scene_id(loaded->scene_id());
  request.mutable_accuracy()->set_samples(4);
  lucerna::client::PictureAssembler assembler;
  const absl::Status status = client().render_image(
      request, [&](const auto& response) { return assembler.add(response.tile()).ok(); });
  ASSERT_TRUE(status.ok()) << status;
  const auto picture = assembler.picture();
  ASSERT_TRUE(picture.ok()) << picture.status();
  EXPECT_EQ(picture->width, 160U);
  EXPECT_EQ(picture->height, 120U);
  EXPECT_EQ(picture->standard_error.size(), picture->pixels.size());
}

// The server decodes it with a library of its own, which it must find from where it is installed.
TEST_F(Lux, ASceneMayHaveAPicture) {
  v1::LoadSceneRequest load;
  load.set_path("environment.pbrt");
  const auto loaded = client().load_scene(load);
  EXPECT_TRUE(loaded.ok()) << loaded.status();
}

TEST_F(Lux, EachTestHasAServerOfItsOwn) {
  const auto scenes = client().list_scenes({});
  ASSERT_TRUE(scenes.ok()) << scenes.status();
  EXPECT_EQ(scenes->scenes_size(), 0);
}

}  // namespace
