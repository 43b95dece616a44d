// Goniometric lights with pictures for the contract suites.  They hang like those with webs: the
// map's +z is the world's -z.
#pragma once

#include <array>

#include "lights/models/goniometric_light.h"
#include "tests/lights/contract/delta_cases.h"
#include "tests/lights/contract/mapped_pictures.h"

namespace lucerna::testing {

/// `Picture` is a Mapped.
template <typename Picture>
struct MapLightCase : LocalDeltaCase {
  using Light = GoniometricLight;
  // A direction's rounding to float is 6e-8.  The slope is at most 9 per radian in relative terms:
  // a factor of 5 from one texel to the next, half a radian away.  Both value and evaluation have
  // this error.
  static constexpr double kTolerance =
      Picture::kFilter == ImageFilter::kBilinear ? 1e-6 : LocalDeltaCase::kTolerance;
  static Vec3 far_direction() { return {0, 0, -1}; }
  static Vec3 map_from_world(const Vec3& w) { return {w.x, -w.y, -w.z}; }
  static GoniometricLightParams params(const Placement& placement) {
    // Colours whose mean is the value, so that a single channel differs from it.
    std::vector<Rgbf> texels;
    for (const float v : Picture::kValues) texels.emplace_back(v, 0.0, 2 * v);
    return {.position_m = placement.point(position()),
            .axes = {placement.direction({2, 0, 0}), placement.direction({0, -2, 0}),
                     placement.direction({0, 0, -2})},
            .intensity = kDeltaLevel,
            .map = *IntensityMap::create(
                *Image::create(Picture::kWidth, Picture::kHeight, std::move(texels)),
                Picture::kMapping, Picture::kFilter)};
  }
  static GoniometricLight make(const Placement& placement) {
    return *GoniometricLight::create(params(placement));
  }
  static std::vector<Vec3> receivers() {
    return {{0.25, -0.5, -2}, {0.75, -0.25, -1}, {0.75, -0.75, -0.5}, {0.5, -0.75, 0.25}};
  }
  static double texel(int i) { return Picture::kValues[static_cast<std::size_t>(i)]; }
  static Rgb value(const Vec3& receiver, const Vec3& wi) {
    const Vec3 d = position() - receiver;
    return kDeltaLevel * (Picture::shown(map_from_world(-wi), texel) / dot(d, d) +
                          zero_if_towards(position(), receiver, wi));
  }
  static Rgb power_by_quadrature() { return kDeltaLevel * Picture::integral(texel); }
};

/// Lit within 0.7228 rad of the axis: the corners of the lit square lie at r = 1/2, and cos theta =
/// 1 - r^2.
struct ConfinedTexels {
  static constexpr int kWidth = 8, kHeight = 8;
  static constexpr std::array<float, 64> kValues = [] {
    std::array<float, 64> values{};
    values[27] = 1, values[28] = 2, values[35] = 3, values[36] = 4;
    return values;
  }();
};
using PatchyMapCase = MapLightCase<Mapped<EqualArea, ImageFilter::kNearest, PatchySquare>>;
using ConfinedMapCase = MapLightCase<Mapped<EqualArea, ImageFilter::kNearest, ConfinedTexels>>;
using BilinearMapCase = MapLightCase<Mapped<EqualArea, ImageFilter::kBilinear, GentleSquare>>;
using NearestPanoramaCase =
    MapLightCase<Mapped<LatitudeLongitude, ImageFilter::kNearest, GentlePanorama>>;
using BilinearPanoramaCase =
    MapLightCase<Mapped<LatitudeLongitude, ImageFilter::kBilinear, GentlePanorama>>;

}  // namespace lucerna::testing
