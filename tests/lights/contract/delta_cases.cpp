// The lights at a point and beams.  The expected answers do not use the code of the lights.
#include <algorithm>
#include <array>
#include <cmath>

#include "lights/models/beam_light.h"
#include "lights/models/distant_light.h"
#include "lights/models/goniometric_light.h"
#include "lights/models/point_light.h"
#include "lights/models/projection_light.h"
#include "lights/models/spot_light.h"
#include "tests/lights/contract/light_case.h"
#include "tests/lights/contract/mapped_pictures.h"

namespace lucerna::testing {
namespace {

constexpr Rgb kLevel{3, 5, 7};
constexpr Vec3 kPosition{0.25, -0.5, 1};
constexpr Vec3 kDown{0, 0, -1};

/// 0 where `wi` points from `receiver` to `target`, NaN elsewhere: a wrong direction makes the
/// expected value NaN.
double zero_if_towards(const Vec3& target, const Vec3& receiver, const Vec3& wi) {
  const Vec3 d = target - receiver;
  const bool towards = length(cross(d, wi)) < 1e-6 * length(d) && dot(d, wi) > 0;
  return towards ? 0 : NAN;
}

Frame placed(const Placement& at, const Vec3& x, const Vec3& y, const Vec3& z) {
  return {at.direction(x), at.direction(y), at.direction(z)};
}

/// Completes a light at kPosition.  `share(w)`: its intensity towards `w`, as a share of kLevel.
template <typename Share>
LightCase at_point(LightCase c, std::vector<Vec3> receivers, Region emission, Share share) {
  c.receivers = std::move(receivers);
  c.value = [share](const Vec3& receiver, const Vec3& wi) {
    const Vec3 d = kPosition - receiver;
    return kLevel * share(-d) * (1 / dot(d, d) + zero_if_towards(kPosition, receiver, wi));
  };
  c.distance_to_surface = [](const Vec3& p) { return length(p - kPosition); };
  c.emission_region = [emission](const Vec3&) { return emission; };
  c.confined = emission.half_angle_rad < kPi;
  c.value_length_power = -2;
  c.power_length_power = 0;
  // Distances count from the point itself, so that its 1/d^2 is also exact in the far field.  Then
  // directions to the point do not change, however its intensity depends on them.
  c.centre = kPosition;
  c.moved_tolerance = 1e-11;
  return c;
}

LightCase isotropic(LightCase c) {
  c = at_point(std::move(c), {{0, 0, 0}, {1, 2, 3}, {-100, 50.5, 3}, {0.25, -0.5, 1 + 0x1p-10}}, {},
               [](const Vec3&) { return 1.0; });
  // The flux through a cube of side 2 about the light: six times that through one face.
  c.power_lm = [] {
    return kLevel * (6 * simpson(-1, 1, 100, [](double x) {
                       return simpson(-1, 1, 100,
                                      [x](double y) { return std::pow(1 + x * x + y * y, -1.5); });
                     }));
  };
  return c;
}

// ---- Spots. ----

/// The falloff is from pbrt-v4's description: smoothstep in the cosine.
struct Spot {
  double cone, start;
  SpotProfile profile = SpotProfile::kSmoothstep;

  SpotLightParams params(const Placement& at) const {
    return {.position_m = at.point(kPosition),
            .axis = at.direction(kDown) * 2.0,
            .intensity_cd = kLevel,
            .cone_half_angle_rad = cone,
            .falloff_start_rad = start,
            .profile = profile};
  }
  double operator()(const Vec3& w) const {
    return falloff(std::atan2(length(cross(w, kDown)), dot(w, kDown)));
  }
  double falloff(double theta) const {
    if (theta <= start) return 1;
    if (theta >= cone) return 0;
    const double t = (std::cos(theta) - std::cos(cone)) / (std::cos(start) - std::cos(cone));
    return profile == SpotProfile::kQuartic     ? std::pow(t, 4)
           : profile == SpotProfile::kQuadratic ? t * t
                                                : 3 * t * t - 2 * t * t * t;
  }
};

const std::vector<Vec3> kBelow{
    {0.25, -0.5, -2}, {0.75, -0.25, -1}, {1, -0.5, -0.5}, {0, 0.5, -100}};

LightCase spot(const std::string& name, const Spot& spot) {
  LightCase c =
      at_point(light_case<SpotLight>(name, [=](const Placement& at) { return spot.params(at); }),
               kBelow, {kDown, spot.cone}, spot);
  c.power_lm = [=] {
    const auto ring = [&](double theta) { return spot.falloff(theta) * 2 * kPi * std::sin(theta); };
    // Not across the hard edge itself, where Simpson's rule would be wrong.
    const double edge = spot.start < spot.cone ? simpson(spot.start, spot.cone, 500, ring) : 0;
    return kLevel * (simpson(0, spot.start, 500, ring) + edge);
  };
  c.far_direction = kDown;
  return c;
}

/// A spot whose transform scales by 1, 2 and 1/2 along x, y and z.  Its cone is round in its own
/// space, where a direction has these factors taken out.
LightCase deformed_spot() {
  const Spot spot{0.7, 0.3};
  const auto params = [=](const Placement& at) {
    SpotLightParams p = spot.params(at);
    p.own_space = std::make_shared<const Frame>(placed(at, {1, 0, 0}, {0, 2, 0}, {0, 0, 0.5}));
    return p;
  };
  const auto share = [=](const Vec3& w) { return spot({w.x, w.y / 2, w.z * 2}); };
  // The widest direction is along y: tan(0.7) 2 / 0.5 is the tangent of 1.282.
  LightCase c =
      at_point(light_case<SpotLight>("deformed_spot", params), kBelow, {kDown, 1.283}, share);
  c.power_lm = [=] {
    return integrate(Region{kDown, kPi / 2}, 2000,
                     [&](const Vec3& w) { return kLevel * share(w); });
  };
  c.power_tolerance = 1e-5;  // of the grid of directions
  c.far_direction = kDown;
  return c;
}

// ---- Photometry: luminaires that hang, so light space's +z is the world's -z.  So gamma counts
// from straight down, and C counter-clockwise as seen from above. ----

constexpr double kDegree = std::numbers::pi / 180;

GoniometricLightParams hanging(const Placement& at) {
  return {.position_m = at.point(kPosition),
          .axes = placed(at, {2, 0, 0}, {0, -2, 0}, {0, 0, -2}),
          .intensity = kLevel};
}

/// A grid as in a file, looked up here: bilinear in gamma and C.
struct Grid {
  PhotometricType type;
  std::vector<double> gamma, c;  // degrees
  std::vector<double> cd;        // all gamma at the first C

  double value(std::size_t i, std::size_t j) const { return cd[i * gamma.size() + j]; }
  double at(double g, double h) const {
    if (g < gamma.front() || g > gamma.back()) return 0;
    const auto cell = [](const std::vector<double>& grid, double x) {
      std::size_t i = 0;
      while (i + 2 < grid.size() && x > grid[i + 1]) ++i;
      return i;
    };
    const std::size_t j = cell(gamma, g);
    const double t = (g - gamma[j]) / (gamma[j + 1] - gamma[j]);
    if (c.size() == 1) return value(0, j) * (1 - t) + value(0, j + 1) * t;
    const std::size_t i = cell(c, h);
    const double s = (h - c[i]) / (c[i + 1] - c[i]);
    return (value(i, j) * (1 - t) + value(i, j + 1) * t) * (1 - s) +
           (value(i + 1, j) * (1 - t) + value(i + 1, j + 1) * t) * s;
  }
  /// A direction by the type's angles V and H [degrees], from the standard's definitions.
  Vec2 angles(const Vec3& w) const {
    switch (type) {
      case PhotometricType::kC:  // from straight down, and to the left as seen from above
        return {std::atan2(std::hypot(w.x, w.y), w.z) / kDegree, std::atan2(-w.y, w.x) / kDegree};
      case PhotometricType::kB:  // from straight down towards +x; latitude towards +y
        return {std::atan2(w.x, w.z) / kDegree, std::atan2(w.y, std::hypot(w.x, w.z)) / kDegree};
      case PhotometricType::kA:  // latitude upwards; from +x towards +y
        return {std::atan2(-w.z, std::hypot(w.x, w.y)) / kDegree, std::atan2(w.y, w.x) / kDegree};
    }
    return {};
  }
  double operator()(const Vec3& w) const {
    const auto [v, h] = angles({w.x, -w.y, -w.z});
    // Grids that start at 0 are symmetric about it.  Types A and B end at 90.
    const double given = c.front() == 0 ? std::fabs(h) : h;
    return type != PhotometricType::kC && std::fabs(h) > 90 ? 0 : at(v, given);
  }
  /// Simpson's rule within each cell, where the function is smooth.  The solid angle's element is
  /// proportional to the sine of an angle from a pole, or to the cosine of a latitude.
  double integral() const {
    const std::vector<double> planes = c.size() > 1 ? c : std::vector<double>{0, 180};
    double sum = 0;
    for (std::size_t i = 0; i + 1 < planes.size(); ++i)
      for (std::size_t j = 0; j + 1 < gamma.size(); ++j)
        sum += simpson(planes[i], planes[i + 1], 100, [&](double h) {
          return simpson(gamma[j], gamma[j + 1], 100, [&](double v) {
            const double element = type == PhotometricType::kC   ? std::sin(v * kDegree)
                                   : type == PhotometricType::kB ? std::cos(h * kDegree)
                                                                 : std::cos(v * kDegree);
            return at(v, h) * element * kDegree * kDegree;
          });
        });
    return planes.front() == 0 ? 2 * sum : sum;
  }
};

LightCase luminaire(const std::string& name, const Grid& grid, const Region& emission,
                    const Vec3& far_direction = kDown,
                    std::vector<Vec3> receivers = {
                        {0.25, -0.5, -2}, {0.75, -0.25, -1}, {1, -0.75, -0.5}, {0, 0.5, -100}}) {
  const auto params = [=](const Placement& at) {
    GoniometricLightParams p = hanging(at);
    p.web = *PhotometricWeb::create({grid.type, grid.gamma, grid.c, grid.cd});
    return p;
  };
  LightCase c =
      at_point(light_case<GoniometricLight>(name, params), std::move(receivers), emission, grid);
  c.power_lm = [=] { return kLevel * grid.integral(); };
  c.far_direction = far_direction;
  return c;
}

/// `Picture` is a Mapped.
template <typename Picture>
LightCase intensity_map(const std::string& name, const Region& emission = {}) {
  const auto params = [](const Placement& at) {
    // Colours whose mean is the value, so that a single channel differs from it.
    std::vector<Rgbf> texels;
    for (const float v : Picture::kValues) texels.emplace_back(v, 0.0, 2 * v);
    GoniometricLightParams p = hanging(at);
    p.map =
        *IntensityMap::create(*Image::create(Picture::kWidth, Picture::kHeight, std::move(texels)),
                              Picture::kMapping, Picture::kFilter);
    return p;
  };
  const auto texel = [](int i) -> double { return Picture::kValues[static_cast<std::size_t>(i)]; };
  LightCase c =
      at_point(light_case<GoniometricLight>(name, params),
               {{0.3125, -0.4375, -2}, {0.75, -0.25, -1}, {0.75, -0.75, -0.5}, {0.5, -0.75, 0.25}},
               emission, [texel](const Vec3& w) {
                 return Picture::shown({w.x, -w.y, -w.z}, texel);
               });
  c.power_lm = [texel] { return kLevel * Picture::integral(texel); };
  c.far_direction = kDown;
  return c;
}

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

void add_luminaires(std::vector<LightCase>& cases) {
  using enum PhotometricType;
  using enum ImageFilter;
  cases.push_back(isotropic(light_case<GoniometricLight>("no_web", [](const Placement& at) {
    return GoniometricLightParams{.position_m = at.point(kPosition), .intensity = kLevel};
  })));
  cases.push_back(
      luminaire("web_uneven",
                {kC, {0, 30, 80, 180}, {0, 90, 180}, {9, 8, 3, 1, 9, 4, 6, 1, 9, 2, 5, 1}}, {}));
  cases.push_back(luminaire("web_down", {kC, {0, 40, 70, 90}, {0}, {100, 80, 0, 0}}, {kDown, 1.3}));
  // Measured like a floodlight, symmetric about H = 0.
  cases.push_back(luminaire(
      "web_flood", {kB, {-90, -30, 10, 90}, {0, 40, 90}, {4, 6, 8, 5, 3, 7, 9, 5, 6, 6, 6, 6}},
      {kDown, kPi / 2}));
  // Measured like a headlamp, each side separately.  It emits along +x.
  cases.push_back(luminaire("web_headlamp",
                            {kA,
                             {-90, -20, 15, 90},
                             {-90, -30, 20, 90},
                             {4, 6, 8, 5, 4, 7, 9, 5, 4, 9, 6, 5, 4, 3, 5, 5}},
                            {{1, 0, 0}, kPi / 2}, {1, 0, 0},
                            {{2, -0.5, 1}, {1, -0.75, -0.5}, {3, 1, 2}, {0.75, 0, 1.25}}));
  cases.push_back(intensity_map<Mapped<EqualArea, kNearest, PatchySquare>>("map_patchy"));
  cases.push_back(
      intensity_map<Mapped<EqualArea, kNearest, ConfinedTexels>>("map_confined", {kDown, 0.73}));
  cases.push_back(intensity_map<Mapped<EqualArea, kBilinear, GentleSquare>>("map_bilinear"));
  cases.push_back(
      intensity_map<Mapped<LatitudeLongitude, kNearest, GentlePanorama>>("map_panorama"));
  cases.push_back(
      intensity_map<Mapped<LatitudeLongitude, kBilinear, GentlePanorama>>("map_panorama_bilinear"));
}

// ---- Projections and beams.  The picture's right is the world's +y, its upper edge the world's
// +x.

constexpr int kWidth = 3, kHeight = 2;

/// Rows from the top; one texel is black.
std::shared_ptr<const Image> picture() {
  return *Image::create(kWidth, kHeight,
                        {{3, 5, 7}, {0, 0, 0}, {1, 2, 4}, {2, 1, 0.5}, {6, 6, 6}, {0.25, 1, 3}});
}

/// What a light shows: a picture or none.
struct Shown {
  bool with_picture;
  ImageFilter filter = ImageFilter::kNearest;

  /// At (x, y) of [-1, 1]^2, y upwards; nothing outside.
  Rgb at(double x, double y) const {
    if (std::fabs(x) > 1 || std::fabs(y) > 1) return {};
    if (!with_picture) return Rgb(1);
    const auto texel = [](int i, int j) {
      static const std::shared_ptr<const Image> image = picture();
      return Rgb(image->texel(std::clamp(i, 0, kWidth - 1), std::clamp(j, 0, kHeight - 1)));
    };
    const double column = (x + 1) / 2 * kWidth, row = (1 - y) / 2 * kHeight;
    if (filter == ImageFilter::kNearest)
      return texel(static_cast<int>(std::floor(column)), static_cast<int>(std::floor(row)));
    const double i = std::floor(column - 0.5), j = std::floor(row - 0.5);
    const double s = column - 0.5 - i, t = row - 0.5 - j;
    const int c = static_cast<int>(i), r = static_cast<int>(j);
    return (texel(c, r) * (1 - s) + texel(c + 1, r) * s) * (1 - t) +
           (texel(c, r + 1) * (1 - s) + texel(c + 1, r + 1) * s) * t;
  }
};

/// The integral over [-1, 1]^2 of `f(x, y)`.  `f` may have edges or kinks only at the edges and
/// centres of the picture's texels.
template <typename F>
Rgb integrate_by_pieces(int n, F&& f) {
  const auto channel = [&](auto member) {
    double sum = 0;
    for (int j = 0; j < 2 * kHeight; ++j)
      for (int i = 0; i < 2 * kWidth; ++i) {
        const auto at = [](int k, int texels, double share) { return (k + share) / texels - 1; };
        // Values at edges belong to one piece.
        constexpr double kInside = 1e-13;
        sum += simpson(kInside, 1 - kInside, n, [&](double v) {
          return simpson(kInside, 1 - kInside, n,
                         [&](double u) { return f(at(i, kWidth, u), at(j, kHeight, v)).*member; });
        });
      }
    return sum / (kWidth * kHeight);
  };
  return {channel(&Rgb::r), channel(&Rgb::g), channel(&Rgb::b)};
}

Frame facing_down(const Placement& at) { return placed(at, {0, 3, 0}, {0.5, 0, 0}, {0, 0, -2}); }

/// `fov_rad` is the angle of the shorter side, `aspect` width over height.
LightCase projection(const std::string& name, const Shown& shown, double fov_rad, double aspect) {
  const double shorter = std::tan(fov_rad / 2);
  const Vec2 half = aspect >= 1 ? Vec2{shorter * aspect, shorter} : Vec2{shorter, shorter / aspect};
  const auto params = [=](const Placement& at) {
    return ProjectionLightParams{
        .position_m = at.point(kPosition),
        .axes = facing_down(at),
        .picture = *ProjectedPicture::create({.image = shown.with_picture ? picture() : nullptr,
                                              .filter = shown.filter,
                                              .fov_rad = fov_rad,
                                              .aspect = aspect}),
        .intensity_cd = kLevel};
  };
  LightCase c =
      at_point(light_case<ProjectionLight>(name, params),
               {{1, -2, -2}, {-0.25, -0.5, -1}, {-0.5, 0.625, -0.5}, {20, 50, -100}},
               {kDown, std::atan(std::hypot(half.x, half.y)) * 1.001}, [=](const Vec3& w) {
                 return w.z < 0 ? shown.at(w.y / -w.z / half.x, w.x / -w.z / half.y) : Rgb{};
               });
  // Over the plane at distance 1, whose x is half.x u: d omega = dA cos^3.
  c.power_lm = [=] {
    return kLevel * integrate_by_pieces(60, [&](double u, double v) {
             const double x = half.x * u, y = half.y * v;
             return shown.at(u, v) * (half.x * half.y * std::pow(1 + x * x + y * y, -1.5));
           });
  };
  c.far_direction = normalized(Vec3{-0.35, 0.1, -1});
  return c;
}

LightCase beam(const std::string& name, const Shown& shown) {
  constexpr double kAcross = 3.5, kAlong = 2;
  const auto params = [=](const Placement& at) {
    return BeamLightParams{.position_m = at.point(kPosition),
                           .axes = facing_down(at),
                           .width_m = at.length(kAcross),
                           .height_m = at.length(kAlong),
                           .illuminance_lx = kLevel,
                           .image = shown.with_picture ? picture() : nullptr,
                           .filter = shown.filter};
  };
  // The place of `p` in [-1, 1]^2 of the rectangle.
  const auto where = [](const Vec3& p) {
    const Vec3 d = p - kPosition;
    return Vec2{d.y / (kAcross / 2), d.x / (kAlong / 2)};
  };
  LightCase c = light_case<BeamLight>(name, params);
  c.receivers = {{0, 0, -2}, {1, -1.5, -3}, {-0.5, 0.75, 0.5}, {0.125, -0.375, -100}};
  c.value = [=](const Vec3& receiver, const Vec3& wi) {
    const Vec2 at = where(receiver);
    if (receiver.z >= kPosition.z) return Rgb{};
    return kLevel * shown.at(at.x, at.y) * (1 + zero_if_towards({0, 0, 1}, {}, wi));
  };
  c.distance_to_surface = [=](const Vec3& p) {
    const Vec2 at = where(p);
    return length(Vec3{p.z - kPosition.z, std::fmax(0, std::fabs(at.x) - 1) * kAcross / 2,
                       std::fmax(0, std::fabs(at.y) - 1) * kAlong / 2});
  };
  c.power_lm = [=] {
    return kLevel * integrate_by_pieces(4, [&](double u, double v) { return shown.at(u, v); }) *
           (kAcross * kAlong / 4);
  };
  c.emission_position = [](const Vec3&, double x, double y) {
    return kPosition + Vec3{(0.5 - y) * kAlong, (x - 0.5) * kAcross, 0};
  };
  c.emission_where = [=](const Vec3& p, const Vec3& w) {
    if (w != kDown || std::fabs(p.z - kPosition.z) > 1e-6) return Vec2{NAN, NAN};
    return Vec2{(1 + where(p).x) / 2, (1 - where(p).y) / 2};
  };
  c.emission_area_m2 = kAcross * kAlong;
  c.size = 2;
  c.far_field_length_power = 0;  // parallel rays
  c.far_direction = kDown;
  c.confined = true;
  c.moved_tolerance = 1e-11;
  return c;
}

}  // namespace

void add_delta_lights(std::vector<LightCase>& cases) {
  using enum ImageFilter;
  cases.push_back(isotropic(light_case<PointLight>("point", [](const Placement& at) {
    return PointLightParams{.position_m = at.point(kPosition), .intensity_cd = kLevel};
  })));
  cases.push_back(spot("spot_soft", {0.7, 0.3}));
  cases.push_back(spot("spot_hard", {0.6, 0.6}));
  cases.push_back(spot("spot_wide", {3, 1.8}));
  cases.push_back(spot("spot_quadratic", {0.8, 0.2, SpotProfile::kQuadratic}));
  cases.push_back(spot("spot_quartic", {0.9, 0.4, SpotProfile::kQuartic}));
  cases.push_back(deformed_spot());
  add_luminaires(cases);
  cases.push_back(projection("projection", {true, kNearest}, 1.2, 1.5));
  cases.push_back(projection("projection_bilinear", {true, kBilinear}, 1.2, 1.5));
  cases.push_back(projection("projection_wide", {true, kBilinear}, 2.4, 0.5));
  cases.push_back(projection("projection_even", {false}, 1.5, 3));
  cases.push_back(beam("beam", {true, kNearest}));
  cases.push_back(beam("beam_bilinear", {true, kBilinear}));
  cases.push_back(beam("beam_even", {false}));
}

}  // namespace lucerna::testing
