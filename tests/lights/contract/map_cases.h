// Lights with a picture around the sphere, for the contract suites.
#pragma once

#include <memory>
#include <vector>

#include "lights/models/image_infinite_light.h"
#include "tests/lights/contract/delta_cases.h"
#include "tests/lights/contract/mapped_pictures.h"

namespace lucerna::testing {

inline const Rgb kMapLevel{3, 5, 7};

/// Red, green and blue of texel i differ, so that a misplaced channel is noticed.
inline Rgbf texel_of(float v, int i) { return {v, v * 0.5, v * (1 + static_cast<float>(i % 3))}; }

/// `Picture` is a Mapped.
template <typename Picture>
struct MapCase : CaseDefaults {
  using Light = ImageInfiniteLight;

  static std::shared_ptr<const SphereMap> map() {
    std::vector<Rgbf> texels;
    for (const float v : Picture::kValues)
      texels.push_back(texel_of(v, static_cast<int>(texels.size())));
    return *SphereMap::create(*Image::create(Picture::kWidth, Picture::kHeight, std::move(texels)),
                              Picture::kMapping, Picture::kFilter);
  }
  static ImageInfiniteLight make(const Placement& placement) {
    return *ImageInfiniteLight::create(
        {.map = map(), .world_from_map = placement.rigid, .radiance_cd_m2 = kMapLevel});
  }
  static std::vector<Vec3> receivers() { return {{0, 0, 0}, {1e6, -3, 5}}; }
  static Region region(const Vec3&) { return {}; }
  static Rgb texel(int i) {
    return Rgb(texel_of(Picture::kValues[static_cast<std::size_t>(i)], i));
  }
  static Rgb value(const Vec3&, const Vec3& w) { return kMapLevel * Picture::shown(w, texel); }
  /// Through the disk that the scene's sphere of radius 4 covers.
  static Rgb power_by_quadrature() { return kMapLevel * Picture::integral(texel) * (16 * kPi); }
};

using EqualAreaCase = MapCase<Mapped<EqualArea, ImageFilter::kNearest, PatchySquare>>;
using BilinearEqualAreaCase = MapCase<Mapped<EqualArea, ImageFilter::kBilinear, PatchySquare>>;
using LatitudeLongitudeCase =
    MapCase<Mapped<LatitudeLongitude, ImageFilter::kBilinear, GentlePanorama>>;
using NearestLatitudeLongitudeCase =
    MapCase<Mapped<LatitudeLongitude, ImageFilter::kNearest, PatchyPanorama>>;

}  // namespace lucerna::testing
