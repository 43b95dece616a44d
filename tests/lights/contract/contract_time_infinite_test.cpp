// The contract of moving lights on lights at infinity, with a portal and without.
#include <vector>

#include "tests/lights/contract/contract_time.h"

namespace lucerna::testing {
namespace {

struct MovingDistant : MovingCase {
  static DistantLight make(const Transform& world_from_light) {
    return *DistantLight::create(
        {.to_light = world_from_light.vector({1, 2, 3}), .illuminance_lx = level()});
  }
};

struct MovingSun : MovingCase {
  static SunLight make(const Transform& world_from_light) {
    return *SunLight::create({.to_light = world_from_light.vector({1, 2, 3}),
                              .angular_diameter_rad = 0.3,
                              .illuminance_lx = level()});
  }
};

struct MovingInfinite : MovingCase {
  static UniformInfiniteLight make(const Transform&) {
    return *UniformInfiniteLight::create({.radiance_cd_m2 = level()});
  }
};

template <SphereMapping kMapping, ImageFilter kFilter>
struct MovingSky : MovingCase {
  static ImageInfiniteLight make(const Transform& world_from_light) {
    std::vector<Rgbf> texels;
    for (int i = 0; i < 16; ++i)
      texels.push_back(Rgbf(static_cast<float>(1 + i * i % 7)) * Rgbf{1, 0.5, 2});
    return *ImageInfiniteLight::create(
        {.map = *SphereMap::create(*Image::create(4, 4, std::move(texels)), kMapping, kFilter),
         .world_from_map = world_from_light,
         .radiance_cd_m2 = level()});
  }
};

struct MovingPortal : MovingCase {
  static PortalLight make(const Transform& world_from_light) {
    std::vector<Rgbf> texels;
    for (int i = 0; i < 16; ++i) texels.emplace_back(static_cast<float>(1 + i % 5));
    PortalLightParams params{
        .map = *SphereMap::create(*Image::create(4, 4, std::move(texels)),
                                  SphereMapping::kEqualArea, ImageFilter::kBilinear),
        .world_from_map = world_from_light,
        .radiance_cd_m2 = level()};
    const Vec3 corners[] = {{0, 0, 1}, {0, 2, 1}, {3, 2, 1}, {3, 0, 1}};
    for (std::size_t i = 0; i < 4; ++i) params.corners_m[i] = world_from_light.point(corners[i]);
    return *PortalLight::create(params);
  }
};

using Cases = ::testing::Types<MovingDistant, MovingSun, MovingInfinite,
                               MovingSky<SphereMapping::kEqualArea, ImageFilter::kNearest>,
                               MovingSky<SphereMapping::kEqualArea, ImageFilter::kBilinear>,
                               MovingSky<SphereMapping::kLatitudeLongitude, ImageFilter::kNearest>,
                               MovingSky<SphereMapping::kLatitudeLongitude, ImageFilter::kBilinear>,
                               MovingPortal>;
INSTANTIATE_TYPED_TEST_SUITE_P(Infinite, MovingLight, Cases);

}  // namespace
}  // namespace lucerna::testing
