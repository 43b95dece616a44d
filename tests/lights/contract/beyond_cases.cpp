// The lights at infinity, with a portal and without.  The expected answers do not use the code of
// the lights.
#include <algorithm>
#include <cmath>

#include "lights/models/distant_light.h"
#include "lights/models/image_infinite_light.h"
#include "lights/models/infinite_light.h"
#include "lights/models/portal_light.h"
#include "lights/models/sun_light.h"
#include "tests/lights/contract/light_case.h"
#include "tests/lights/contract/mapped_pictures.h"

namespace lucerna::testing {
namespace {

constexpr Rgb kLevel{3, 5, 7};
constexpr Vec3 kToLight{1, 2, 2};

/// Completes a light whose rays enter through a disk of radius 4 that faces their direction and
/// touches the sphere of kScene.  Polar coordinates keep area in r^2.
LightCase beyond(LightCase c) {
  c.receivers = {{0, 0, 0}, {1e6, -3, 0x1p-40}};
  c.emission_position = [](const Vec3& w, double x, double y) {
    const double r = std::sqrt(x), phi = 2 * kPi * y;
    return Frame::around(w).world_from_local({r * std::cos(phi), r * std::sin(phi), -1}) * 4.0;
  };
  c.emission_where = [](const Vec3& position, const Vec3& w) {
    const Vec3 p = Frame::around(w).local_from_world(position) * 0.25;
    const double y = std::atan2(p.y, p.x) / (2 * kPi);
    // Outside of the disk's plane there is no place for it.
    if (std::fabs(p.z + 1) > 1e-5) return Vec2{NAN, NAN};
    return Vec2{p.x * p.x + p.y * p.y, y < 0 ? y + 1 : y};
  };
  c.emission_area_m2 = 16 * kPi;
  c.enters_by_scene_disk = true;
  return c;
}

LightCase distant() {
  LightCase c = beyond(light_case<DistantLight>("distant", [](const Placement& at) {
    return DistantLightParams{.to_light = at.direction(kToLight), .illuminance_lx = kLevel};
  }));
  c.value = [](const Vec3&, const Vec3& wi) {
    return length(wi - normalized(kToLight)) < 1e-6 ? kLevel : Rgb(NAN);
  };
  // Through the disk that the scene's sphere of radius 4 covers, ring by ring.
  c.power_lm = [] { return kLevel * simpson(0, 4, 10, [](double r) { return 2 * kPi * r; }); };
  return c;
}

/// Angular diameters: a wide lamp, and half of the sky.
LightCase sun(const std::string& name, double diameter) {
  const double half = diameter / 2;
  LightCase c = beyond(light_case<SunLight>(name, [=](const Placement& at) {
    return SunLightParams{.to_light = at.direction(kToLight),
                          .angular_diameter_rad = diameter,
                          .illuminance_lx = kLevel};
  }));
  // The radiance whose illuminance is the level: rings of the disk, weighted with their cosine.
  const Rgb radiance =
      kLevel *
      (1 / simpson(0, half, 2000, [](double t) { return 2 * kPi * std::sin(t) * std::cos(t); }));
  c.value = [=](const Vec3&, const Vec3& wi) {
    const double angle = std::atan2(length(cross(kToLight, wi)), dot(kToLight, wi));
    return angle <= half + 1e-6 ? radiance : Rgb{};
  };
  c.region = [=](const Vec3&) { return Region{normalized(kToLight), half}; };
  c.emission_region = [=](const Vec3&) { return Region{-normalized(kToLight), half}; };
  // For each direction, the flux through its disk of radius 4.
  c.power_lm = [=] {
    return radiance *
           (16 * kPi * simpson(0, half, 2000, [](double t) { return 2 * kPi * std::sin(t); }));
  };
  return c;
}

/// Light from all directions: its radiance there, and its illuminance over all of them.
struct Sky {
  std::function<Rgb(const Vec3&)> radiance = [](const Vec3&) { return kLevel; };
  std::function<Rgb()> integral = [] { return kLevel * (4 * kPi); };
  std::shared_ptr<const SphereMap> map{};
  bool rectified = false;
};

/// `Picture` is a Mapped.
template <typename Picture>
Sky pictured() {
  // Red, green and blue of a texel differ, so that a misplaced channel is noticed.
  const auto texel = [](int i) {
    const float v = Picture::kValues[static_cast<std::size_t>(i)];
    return Rgbf{v, v * 0.5F, v * (1 + static_cast<float>(i % 3))};
  };
  std::vector<Rgbf> texels;
  for (int i = 0; i < Picture::kWidth * Picture::kHeight; ++i) texels.push_back(texel(i));
  const auto in_double = [texel](int i) { return Rgb(texel(i)); };
  return {.radiance = [=](const Vec3& w) { return kLevel * Picture::shown(w, in_double); },
          .integral = [=] { return kLevel * Picture::integral(in_double); },
          .map = *SphereMap::create(
              *Image::create(Picture::kWidth, Picture::kHeight, std::move(texels)),
              Picture::kMapping, Picture::kFilter)};
}

LightCase infinite(const std::string& name, const Sky& sky) {
  LightCase c;
  if (sky.map)
    c = light_case<ImageInfiniteLight>(name, [=](const Placement& at) {
      return ImageInfiniteLightParams{
          .map = sky.map, .world_from_map = at.rigid, .radiance_cd_m2 = kLevel};
    });
  else
    c = light_case<UniformInfiniteLight>(name, [](const Placement&) {
      return UniformInfiniteLightParams{.radiance_cd_m2 = kLevel};
    });
  c = beyond(std::move(c));
  c.value = [=](const Vec3&, const Vec3& wi) { return sky.radiance(wi); };
  c.region = [](const Vec3&) { return Region{}; };
  c.emission_region = [](const Vec3&) { return Region{}; };
  // Through the disk that the scene's sphere of radius 4 covers.
  c.power_lm = [=] { return sky.integral() * (16 * kPi); };
  return c;
}

/// A window of 2 x 1.5 m in the plane z = 1; light comes from above.
LightCase portal(const std::string& name, const Sky& sky) {
  const std::array<Vec3, 4> corners{{{-1, -0.75, 1}, {-1, 0.75, 1}, {1, 0.75, 1}, {1, -0.75, 1}}};
  LightCase c = light_case<PortalLight>(name, [=](const Placement& at) {
    PortalLightParams params{.world_from_map = at.rigid, .radiance_cd_m2 = kLevel};
    params.map = sky.map;
    params.rectified = sky.rectified;
    for (std::size_t i = 0; i < 4; ++i) params.corners_m[i] = at.point(corners[i]);
    return params;
  });
  c.receivers = {{0, 0, 0}, {0.5, -0.25, -2}, {3, 1, 0}, {0.25, 0.125, 0.75}, {-8, 3, -20}};
  c.region = [=](const Vec3& receiver) {
    const Vec3 axis = normalized(Vec3{0, 0, 1} - receiver);
    double angle = 0;
    for (const Vec3& corner : corners) {
      const Vec3 to = corner - receiver;
      angle = std::fmax(angle, std::atan2(length(cross(axis, to)), dot(axis, to)));
    }
    return Region{axis, angle + 1e-6};
  };
  c.value = [=](const Vec3& receiver, const Vec3& wi) {
    const double t = (1 - receiver.z) / wi.z;
    const Vec3 through = receiver + wi * t;
    // Because wi is rounded, the ray may miss the window by a little.
    const double slack = 1e-6 * std::fabs(t);
    if (!(t > 0) || std::fabs(through.x) > 1 + slack || std::fabs(through.y) > 0.75 + slack)
      return Rgb{};
    return sky.radiance(wi);
  };
  // The area times the illuminance of the sky on it.
  c.power_lm = [=] {
    if (!sky.map) return kLevel * (3 * kPi);
    return integrate(Region{{0, 0, 1}, kPi / 2}, 1200,
                     [&](const Vec3& w) { return sky.radiance(w) * (3 * w.z); });
  };
  // The light states an error of 3e-4 of its power.  Midpoints on 1200 x 1200 cells that a
  // picture's edges cut have as large an error.
  if (sky.map) c.power_tolerance = 6e-4;
  c.emission_position = [](const Vec3&, double x, double y) {
    return Vec3{2 * x - 1, 1.5 * y - 0.75, 1};
  };
  c.emission_where = [](const Vec3& p, const Vec3&) {
    return std::fabs(p.z - 1) > 1e-6 ? Vec2{NAN, NAN} : Vec2{(p.x + 1) / 2, (p.y + 0.75) / 1.5};
  };
  c.emission_area_m2 = 3;
  c.emission_region = [](const Vec3&) { return Region{{0, 0, -1}, kPi / 2}; };
  c.emitted = [=](const Vec3&, const Vec3& w) { return w.z < 0 ? sky.radiance(-w) : Rgb(); };
  return c;
}

/// A map of four rows, resampled at the middles of 4 x 4 cells of both angles.
Sky rectified(Sky sky) {
  sky.radiance = [of = sky.radiance](const Vec3& w) {
    const auto middle = [&](double c) {
      const int cell = std::clamp(int((std::atan2(c, w.z) / kPi + 0.5) * 4), 0, 3);
      return std::tan(((cell + 0.5) / 4 - 0.5) * kPi);
    };
    return of(normalized(Vec3{middle(w.x), middle(w.y), 1}));
  };
  sky.rectified = true;
  return sky;
}

}  // namespace

void add_lights_beyond(std::vector<LightCase>& cases) {
  using enum ImageFilter;
  const Sky equal_area = pictured<Mapped<EqualArea, kNearest, PatchySquare>>();
  const Sky panorama = pictured<Mapped<LatitudeLongitude, kBilinear, GentlePanorama>>();
  cases.push_back(distant());
  cases.push_back(sun("sun", 0.2));
  cases.push_back(sun("sun_wide", 3));
  cases.push_back(infinite("infinite", {}));
  cases.push_back(infinite("sky", equal_area));
  cases.push_back(infinite("sky_bilinear", pictured<Mapped<EqualArea, kBilinear, PatchySquare>>()));
  cases.push_back(
      infinite("sky_panorama", pictured<Mapped<LatitudeLongitude, kNearest, PatchyPanorama>>()));
  cases.push_back(infinite("sky_panorama_bilinear", panorama));
  cases.push_back(portal("portal", {}));
  cases.push_back(portal("portal_sky", equal_area));
  cases.push_back(portal("portal_panorama", panorama));
  cases.push_back(portal("portal_rectified", rectified(panorama)));
}

}  // namespace lucerna::testing
