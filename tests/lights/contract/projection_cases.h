// Projection lights and beams for the contract suites.  They hang at position() and emit downwards.
// The picture's right is the world's +y, its upper edge the world's +x.
#pragma once

#include <algorithm>
#include <array>

#include "lights/models/beam_light.h"
#include "lights/models/projection_light.h"
#include "tests/lights/contract/delta_cases.h"

namespace lucerna::testing {

inline constexpr int kPictureWidth = 3, kPictureHeight = 2;

/// Rows from the top; one texel is black.
inline std::vector<Rgbf> picture_texels() {
  return {{3, 5, 7}, {0, 0, 0}, {1, 2, 4}, {2, 1, 0.5}, {6, 6, 6}, {0.25, 1, 3}};
}

inline std::shared_ptr<const Image> picture() {
  return *Image::create(kPictureWidth, kPictureHeight, picture_texels());
}

/// The picture at (x, y) of [-1, 1]^2, y upwards, computed without the light's code.
inline Rgb read_by_hand(ImageFilter filter, double x, double y) {
  const auto texel = [](int i, int j) {
    i = std::clamp(i, 0, kPictureWidth - 1);
    j = std::clamp(j, 0, kPictureHeight - 1);
    return Rgb(picture_texels()[static_cast<std::size_t>(j * kPictureWidth + i)]);
  };
  const double column = (x + 1) / 2 * kPictureWidth, row = (1 - y) / 2 * kPictureHeight;
  if (filter == ImageFilter::kNearest)
    return texel(static_cast<int>(std::floor(column)), static_cast<int>(std::floor(row)));
  const double i = std::floor(column - 0.5), j = std::floor(row - 0.5);
  const double s = column - 0.5 - i, t = row - 0.5 - j;
  const int c = static_cast<int>(i), r = static_cast<int>(j);
  return (texel(c, r) * (1 - s) + texel(c + 1, r) * s) * (1 - t) +
         (texel(c, r + 1) * (1 - s) + texel(c + 1, r + 1) * s) * t;
}

/// The integral over [-1, 1]^2 of `f(x, y)`.  `f` may have edges or kinks only at the edges and
/// centres of the picture's texels.
template <typename F>
Rgb integrate_by_pieces(int n, F&& f) {
  const auto channel = [&](auto member) {
    double sum = 0;
    for (int j = 0; j < 2 * kPictureHeight; ++j)
      for (int i = 0; i < 2 * kPictureWidth; ++i) {
        const auto at = [](int k, int texels, double share) { return (k + share) / texels - 1; };
        // Values at edges belong to one piece.
        constexpr double kInside = 1e-13;
        sum += simpson(kInside, 1 - kInside, n, [&](double v) {
          return simpson(kInside, 1 - kInside, n, [&](double u) {
            return f(at(i, kPictureWidth, u), at(j, kPictureHeight, v)).*member;
          });
        });
      }
    return sum / (kPictureWidth * kPictureHeight);
  };
  return {channel(&Rgb::r), channel(&Rgb::g), channel(&Rgb::b)};
}

/// `kFovMilliradians` is the angle of the shorter side; width over height is kAspect / 2; with a
/// picture or without.
template <ImageFilter kFilter, bool kWithPicture, int kFovMilliradians, int kTwiceAspect>
struct ProjectionCase : LocalDeltaCase {
  using Light = ProjectionLight;
  static constexpr bool kConfined = true;
  static Vec2 half() {
    const double shorter = std::tan(kFovMilliradians * 0.5e-3);
    const double aspect = kTwiceAspect / 2.0;
    return aspect >= 1 ? Vec2{shorter * aspect, shorter} : Vec2{shorter, shorter / aspect};
  }
  static Vec3 far_direction() { return normalized(Vec3{-0.35, 0.1, -1}); }
  static ProjectionLight make(const Placement& placement) {
    return *ProjectionLight::create(
        {.position_m = placement.point(position()),
         .axes = {placement.direction({0, 3, 0}), placement.direction({0.5, 0, 0}),
                  placement.direction({0, 0, -2})},
         .picture = *ProjectedPicture::create({.image = kWithPicture ? picture() : nullptr,
                                               .filter = kFilter,
                                               .fov_rad = kFovMilliradians * 1e-3,
                                               .aspect = kTwiceAspect / 2.0}),
         .intensity_cd = kDeltaLevel});
  }
  static std::vector<Vec3> receivers() {
    return {{1, -2, -2}, {-0.25, -0.5, -1}, {-0.5, 0.625, -0.5}, {20, 50, -100}};
  }
  static Rgb read(double x, double y) {
    return kWithPicture ? read_by_hand(kFilter, x, y) : Rgb(1);
  }
  static Rgb value(const Vec3& receiver, const Vec3& wi) {
    const Vec3 d = receiver - position();
    if (d.z >= 0) return {};
    const double x = d.y / -d.z / half().x, y = d.x / -d.z / half().y;
    if (std::fabs(x) > 1 || std::fabs(y) > 1) return {};
    return kDeltaLevel * read(x, y) * (1 / dot(d, d) + zero_if_towards(position(), receiver, wi));
  }
  /// Over the plane at distance 1, whose x is half().x u: d omega = dA cos^3.
  static Rgb power_by_quadrature() {
    const Vec2 h = half();
    return kDeltaLevel * integrate_by_pieces(60, [&](double u, double v) {
             const double x = h.x * u, y = h.y * v;
             return read(u, v) * (h.x * h.y * std::pow(1 + x * x + y * y, -1.5));
           });
  }
  static Region emission_region(const Vec3&) {
    return {{0, 0, -1}, std::atan(std::hypot(half().x, half().y)) * 1.001};
  }
};
using NearestProjectionCase = ProjectionCase<ImageFilter::kNearest, true, 1200, 3>;
using BilinearProjectionCase = ProjectionCase<ImageFilter::kBilinear, true, 1200, 3>;
using WideBilinearProjectionCase = ProjectionCase<ImageFilter::kBilinear, true, 2400, 1>;
using EvenProjectionCase = ProjectionCase<ImageFilter::kNearest, false, 1500, 6>;

template <ImageFilter kFilter, bool kWithPicture>
struct BeamCase : CaseDefaults {
  using Light = BeamLight;
  static constexpr double kSize = 2;
  static constexpr int kFarFieldLengthPower = 0;  // parallel rays
  static constexpr bool kConfined = true;
  static constexpr double kWidth = 3.5, kHeight = 2;
  static Vec3 position() { return {0.25, -0.5, 1}; }
  static Vec3 far_direction() { return {0, 0, -1}; }
  static BeamLight make(const Placement& placement) {
    return *BeamLight::create(
        {.position_m = placement.point(position()),
         .axes = {placement.direction({0, 3, 0}), placement.direction({0.5, 0, 0}),
                  placement.direction({0, 0, -2})},
         .width_m = placement.length(kWidth),
         .height_m = placement.length(kHeight),
         .illuminance_lx = kDeltaLevel,
         .image = kWithPicture ? picture() : nullptr,
         .filter = kFilter});
  }
  static std::vector<Vec3> receivers() {
    return {{0, 0, -2}, {1, -1.5, -3}, {-0.5, 0.75, 0.5}, {0.125, -0.375, -100}};
  }
  /// The place of `p` in [-1, 1]^2 of the rectangle.
  static Vec2 where(const Vec3& p) {
    const Vec3 d = p - position();
    return {d.y / (kWidth / 2), d.x / (kHeight / 2)};
  }
  static Rgb read(double x, double y) {
    return kWithPicture ? read_by_hand(kFilter, x, y) : Rgb(1);
  }
  static Rgb value(const Vec3& receiver, const Vec3& wi) {
    const Vec2 at = where(receiver);
    if (receiver.z >= position().z || std::fabs(at.x) > 1 || std::fabs(at.y) > 1) return {};
    return kDeltaLevel * read(at.x, at.y) * (1 + zero_if_towards({0, 0, 1}, {}, wi));
  }
  static double distance_to_surface(const Vec3& p) {
    const Vec2 at = where(p);
    return length(Vec3{p.z - position().z, std::fmax(0, std::fabs(at.x) - 1) * kWidth / 2,
                       std::fmax(0, std::fabs(at.y) - 1) * kHeight / 2});
  }
  static Rgb power_by_quadrature() {
    return kDeltaLevel * integrate_by_pieces(4, [](double u, double v) { return read(u, v); }) *
           (kWidth * kHeight / 4);
  }
  static Vec3 emission_position(const Vec3&, double x, double y) {
    return position() + Vec3{(0.5 - y) * kHeight, (x - 0.5) * kWidth, 0};
  }
  static Vec2 emission_where(const Vec3& p, const Vec3& w) {
    if (w != Vec3{0, 0, -1} || std::fabs(p.z - position().z) > 1e-6) return {NAN, NAN};
    const Vec2 at = where(p);
    return {(1 + at.x) / 2, (1 - at.y) / 2};
  }
  static double emission_area_m2() { return kWidth * kHeight; }
};
using NearestBeamCase = BeamCase<ImageFilter::kNearest, true>;
using BilinearBeamCase = BeamCase<ImageFilter::kBilinear, true>;
using EvenBeamCase = BeamCase<ImageFilter::kNearest, false>;

}  // namespace lucerna::testing
