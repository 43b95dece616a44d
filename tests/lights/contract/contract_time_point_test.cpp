// The contract of moving lights on lights at a point, and on beams.
#include <vector>

#include "tests/lights/contract/contract_time.h"

namespace lucerna::testing {
namespace {

struct MovingPoint : MovingCase {
  static PointLight make(const Transform& world_from_light) {
    return *PointLight::create(
        {.position_m = world_from_light.point({0.25, -0.5, 1}), .intensity_cd = level()});
  }
};

struct MovingSpot : MovingCase {
  static SpotLight make(const Transform& world_from_light) {
    return *SpotLight::create({.position_m = world_from_light.point({0.25, -0.5, 1}),
                               .axis = world_from_light.vector({1, 0, -1}),
                               .intensity_cd = level(),
                               .cone_half_angle_rad = 1.5,
                               .falloff_start_rad = 0.1});
  }
};

struct MovingLuminaire : MovingCase {
  static GoniometricLight make(const Transform& world_from_light) {
    return *GoniometricLight::create(params(world_from_light));
  }
  static GoniometricLightParams params(const Transform& world_from_light) {
    return {.position_m = world_from_light.point({0.25, -0.5, 1}),
            .axes = {world_from_light.vector({1, 0, 0}), world_from_light.vector({0, 1, 0}),
                     world_from_light.vector({0, 0, 1})},
            .intensity = level(),
            .web = *PhotometricWeb::create(
                {PhotometricType::kC,
                 {0, 60, 120, 180},
                 {0, 90, 180, 270, 360},
                 {9, 3, 1, 2, 9, 5, 4, 2, 9, 6, 2, 2, 9, 7, 1, 2, 9, 3, 1, 2}})};
  }
};

struct MovingIntensityMap : MovingCase {
  static GoniometricLight make(const Transform& world_from_light) {
    GoniometricLightParams params = MovingLuminaire::params(world_from_light);
    params.web = nullptr;
    std::vector<Rgbf> texels;
    for (int i = 0; i < 16; ++i) texels.emplace_back(static_cast<float>(1 + i * 7 % 5));
    params.map = *IntensityMap::create(*Image::create(4, 4, std::move(texels)),
                                       SphereMapping::kEqualArea, ImageFilter::kBilinear);
    return *GoniometricLight::create(params);
  }
};

struct MovingProjection : MovingCase {
  static ProjectionLight make(const Transform& world_from_light) {
    const auto image = *Image::create(1, 2, {{1, 2, 3}, {4, 5, 6}});
    return *ProjectionLight::create(
        {.position_m = world_from_light.point({0.25, -0.5, 1}),
         .axes = {world_from_light.vector({0, 1, 0}), world_from_light.vector({1, 0, 1}),
                  world_from_light.vector({1, 0, -1})},
         .picture = *ProjectedPicture::create({.image = image, .fov_rad = 2.8, .aspect = 0.5}),
         .intensity_cd = level()});
  }
};

struct MovingBeam : MovingCase {
  static BeamLight make(const Transform& world_from_light) {
    const auto image = *Image::create(1, 2, {{1, 2, 3}, {4, 5, 6}});
    return *BeamLight::create(
        {.position_m = world_from_light.point({0.25, -0.5, 1}),
         .axes = {world_from_light.vector({0, 1, 0}), world_from_light.vector({1, 0, 1}),
                  world_from_light.vector({1, 0, -1})},
         .width_m = 40,
         .height_m = 80,
         .illuminance_lx = level(),
         .image = image});
  }
};

using Cases = ::testing::Types<MovingPoint, MovingSpot, MovingLuminaire, MovingIntensityMap,
                               MovingProjection, MovingBeam>;
INSTANTIATE_TYPED_TEST_SUITE_P(Point, MovingLight, Cases);

}  // namespace
}  // namespace lucerna::testing
