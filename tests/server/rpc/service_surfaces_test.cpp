// FindSurfaces: the surfaces that the camera sees.
#include <cmath>
#include <fstream>
#include <vector>

#include "service_fixture.h"
#include "tests/temp_directory.h"

namespace lucerna::testing {
namespace {

/// The camera is 5 m above the origin and looks down.  Place (x, y) of its 20 x 10 pixels is the
/// point (10 - x, 5 - y) of the plane z = 0: 5 m away the picture is 20 m wide, and +x is on its
/// left.
constexpr const char* kCamera = R"(
Film "rgb" "integer xresolution" [20] "integer yresolution" [10]
LookAt 0 0 5  0 0 0  0 1 0
Camera "perspective" "float fov" [90]
WorldBegin
)";

/// A floor of 6 x 6 m, whose own normal is (0, 0, -1), and a square light of 1 m at z = 1 over (-2,
/// -2).
constexpr const char* kFloorAndLight = R"(
LightSource "point" "rgb I" [90 90 90] "point3 from" [2 1 3]
AttributeBegin
ReverseOrientation
Shape "bilinearmesh" "point3 P" [-3 -3 0  3 -3 0  -3 3 0  3 3 0]
AttributeEnd
AreaLightSource "diffuse" "rgb L" [1 1 1]
Shape "bilinearmesh" "point3 P" [-2.5 -2.5 1  -1.5 -2.5 1  -2.5 -1.5 1  -1.5 -1.5 1]
)";

class SurfacesServiceTest : public ::testing::Test {
 protected:
  std::string load(const std::string& text) {
    std::ofstream(root_.path() / "scene.pbrt") << text;
    return service_.load("scene.pbrt");
  }
  grpc::Status find(const v1::FindSurfacesRequest& q) { return service_.call(q, &answer_); }
  static v1::FindSurfacesRequest request(const std::string& scene,
                                         const std::vector<float>& places) {
    auto q = about<v1::FindSurfacesRequest>(scene);
    q.mutable_places()->Add(places.begin(), places.end());
    return q;
  }
  rpc::ServerOptions options() const { return scenes_in(root_.path()); }
  bool found(int i) const {
    return (static_cast<unsigned char>(answer_.found()[i / 8]) >> (i % 8) & 1) != 0;
  }
  /// Item `i` is the surface at this world point, with this normal.
  void expect_at(int i, const Vec3& point, const Vec3& normal) const {
    EXPECT_TRUE(found(i)) << i;
    const auto& origin = answer_.points().origin_m();
    const double sums[] = {origin.x(), origin.y(), origin.z()};
    const double points[] = {point.x, point.y, point.z};
    const double normals[] = {normal.x, normal.y, normal.z};
    for (int k = 0; k < 3; ++k) {
      // The direction of the ray is rounded to floats, 6 m away.
      EXPECT_NEAR(sums[k] + answer_.points().offsets_m(3 * i + k), points[k], 4e-6) << i;
      EXPECT_NEAR(answer_.normals(3 * i + k), normals[k], 1e-7) << i;
    }
  }

  TempDirectory root_;
  Service service_{options()};
  v1::FindSurfacesResponse answer_;
};

TEST_F(SurfacesServiceTest, PlacesAreThePointsThatTheCameraSees) {
  const std::string scene = load(std::string(kCamera) + kFloorAndLight);
  // The light is 4 m from the camera, which sees (-2, -2) there over (-2.5, -2.5) of the floor.
  ASSERT_TRUE(find(request(scene, {10, 5, 8.5, 3.25, 12.5, 7.5, 1, 1, 10, 0})).ok());
  expect_at(0, {0, 0, 0}, {0, 0, 1});
  expect_at(1, {1.5, 1.75, 0}, {0, 0, 1});
  expect_at(2, {-2, -2, 1}, {0, 0, 1});
  EXPECT_FALSE(found(3));  // beside the floor
  EXPECT_FALSE(found(4));
  EXPECT_EQ(answer_.light_ids(0), 0u);
  EXPECT_EQ(answer_.light_ids(2), 2u);
  EXPECT_EQ(answer_.light_ids(3), 0u);
  EXPECT_EQ(answer_.points().offsets_m(3 * 3), 0);
  EXPECT_EQ(answer_.status_size(), 0);
  EXPECT_EQ(answer_.cost().camera_rays(), 5u);
}

TEST_F(SurfacesServiceTest, TheirPointsAreReceivers) {
  const std::string scene = load(std::string(kCamera) + kFloorAndLight);
  ASSERT_TRUE(find(request(scene, {8, 4, 9.5, 4})).ok());
  auto q = about<v1::EstimateIrradianceRequest>(scene);
  q.set_bounces(0);
  *q.mutable_receivers() = answer_.points();
  *q.mutable_normals() = answer_.normals();
  const auto r = service_.answer(q);
  // The lamp of 90 cd is 3 m over (2, 1): I cos / d^2 = I h / d^3.  The square light shines
  // upwards.
  EXPECT_NEAR(r.illuminance_lx(0), 10, 1e-4);
  EXPECT_NEAR(r.illuminance_lx(1), 90 * 3 / std::pow(9 + 1.5 * 1.5, 1.5), 1e-4);
}

TEST_F(SurfacesServiceTest, PlacesOfACropCountFromItsCorner) {
  std::string text = std::string(kCamera) + kFloorAndLight;
  const std::string film = "\"integer yresolution\" [10]";
  text.replace(text.find(film), film.size(), film + " \"float cropwindow\" [0.25 0.75 0.2 1]");
  ASSERT_TRUE(find(request(load(text), {3.5, 1.25, 10, 8, 10.25, 8})).ok());
  expect_at(0, {1.5, 1.75, 0}, {0, 0, 1});  // pixel (5, 2) of the film is pixel (0, 0)
  ASSERT_EQ(answer_.status_size(), 3);
  EXPECT_EQ(answer_.status(1), v1::ITEM_STATUS_OK);  // the corner of the crop
  EXPECT_EQ(answer_.status(2), v1::ITEM_STATUS_INVALID_INPUT);
}

TEST_F(SurfacesServiceTest, SurfacesAreWhereTheyAreAtTheTime) {
  const std::string scene = load(std::string(kCamera) + R"(
ActiveTransform EndTime
Translate 0 0 1
ActiveTransform All
Shape "bilinearmesh" "point3 P" [-3 -3 0  3 -3 0  -3 3 0  3 3 0]
)");
  auto q = request(scene, {10, 5});
  ASSERT_TRUE(find(q).ok());
  expect_at(0, {0, 0, 0}, {0, 0, 1});
  q.set_time_s(0.75);
  ASSERT_TRUE(find(q).ok());
  expect_at(0, {0, 0, 0.75}, {0, 0, 1});
}

TEST_F(SurfacesServiceTest, PlacesBesideThePictureHaveAStatus) {
  const std::string scene = load(std::string(kCamera) + kFloorAndLight);
  ASSERT_TRUE(find(request(scene, {-0.5F, 5, 10, 10.5F, kNan, 5, 10, INFINITY, 10, 5})).ok());
  ASSERT_EQ(answer_.status_size(), 5);
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(answer_.status(i), v1::ITEM_STATUS_INVALID_INPUT) << i;
    EXPECT_FALSE(found(i)) << i;
  }
  EXPECT_EQ(answer_.status(4), v1::ITEM_STATUS_OK);
  expect_at(4, {0, 0, 0}, {0, 0, 1});
}

TEST_F(SurfacesServiceTest, WrongRequestsAreRefused) {
  const std::string scene = load(std::string(kCamera) + kFloorAndLight);
  expect_bad_field(find(request(scene, {1, 2, 3})), "places");
  expect_bad_field(find(request("", {1, 2})), "scene_id");
  EXPECT_EQ(find(request(std::string(64, '0'), {1, 2})).error_code(), grpc::StatusCode::NOT_FOUND);
  auto q = request(scene, {1, 2});
  q.set_time_s(kNan);
  expect_bad_field(find(q), "time_s");
  const std::vector<float> many(2 * 65537, 1);
  expect_error(find(request(scene, many)), grpc::StatusCode::RESOURCE_EXHAUSTED, "65536");
  ASSERT_TRUE(find(request(scene, {})).ok());
  EXPECT_EQ(answer_.normals_size(), 0);
}

}  // namespace
}  // namespace lucerna::testing
