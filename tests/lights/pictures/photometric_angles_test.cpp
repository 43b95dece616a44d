// Angles of photometric files: the ranges that are read, the planes that symmetry adds, and what is
// said about ranges that the standard does not have.
#include "lights/pictures/photometric_angles.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "lights/pictures/photometric_web.h"
#include "tests/lights/pictures/angle_range.h"

namespace lucerna {
namespace {

using enum PhotometricType;
using testing::range;

/// "angle:plane ..." of all planes.
std::string planes(PhotometricType type, const std::vector<double>& degrees) {
  std::string text;
  for (const PhotometricPlane& plane : all_planes(type, degrees))
    text += fmt::format("{}{}:{}", text.empty() ? "" : " ", plane.deg, plane.of);
  return text;
}

std::string gap(const std::optional<AngleGap>& found) {
  return found ? found->what + " -> " + found->instead : "";
}
std::string across(PhotometricType type, const std::vector<double>& h) {
  return gap(horizontal_gap(type, h));
}
std::string along(PhotometricType type, const std::vector<double>& v) {
  return gap(vertical_gap(type, v));
}

TEST(PhotometricAngles, TheStandardsRangesHaveNoGap) {
  for (const auto& v : {range(0, 90, 30), range(0, 180, 30), range(90, 180, 30)})
    EXPECT_EQ(along(kC, v), "");
  for (const auto& h : {std::vector<double>{0}, range(0, 90, 30), range(0, 180, 30),
                        range(90, 270, 30), range(-90, 90, 30), range(0, 360, 30)})
    EXPECT_EQ(across(kC, h), "");
  for (const auto type : {kA, kB}) {
    EXPECT_EQ(along(type, range(-90, 90, 30)), "");
    EXPECT_EQ(across(type, range(-90, 90, 30)), "");
    EXPECT_EQ(across(type, range(0, 90, 30)), "");
  }
}

TEST(PhotometricAngles, TheFirstPlaneClosesTheCircle) {
  EXPECT_EQ(planes(kC, {0}), "0:0 360:0");
  EXPECT_EQ(planes(kC, {0, 90, 180, 270}), "0:0 90:1 180:2 270:3 360:0");
  EXPECT_EQ(planes(kC, {0, 90, 180, 270, 360}), "0:0 90:1 180:2 270:3 360:4");
  EXPECT_EQ(planes(kC, {45, 135, 225, 315}), "45:0 135:1 225:2 315:3 405:0");
  EXPECT_EQ(planes(kC, {-180, -60, 60}), "-180:0 -60:1 60:2 180:0");
  for (const auto& h : {range(0, 345, 15), range(7.5, 352.5, 15), range(-180, 170, 10)})
    EXPECT_EQ(across(kC, h), "");
  EXPECT_EQ(across(kC, range(0, 270, 10)),
            "horizontal angles from 0 to 270 degrees -> linear from the last plane to the first, "
            "over 90 degrees");
  EXPECT_EQ(across(kC, {30}), "one horizontal angle, 30 degrees -> symmetric about the axis");
}

TEST(PhotometricAngles, PlanesThatEndEarlyContinueBySymmetry) {
  EXPECT_EQ(planes(kC, {0, 40, 80}),
            "0:0 40:1 80:2 100:2 140:1 180:0 220:1 260:2 280:2 320:1 360:0");
  EXPECT_EQ(planes(kC, {0, 60, 120}), "0:0 60:1 120:2 240:2 300:1 360:0");
  EXPECT_EQ(planes(kC, {0, 45}), "0:0 45:1 90:0 135:1 180:0 225:1 270:0 315:1 360:0");
  EXPECT_EQ(planes(kC, {22.5, 67.5}),
            "22.5:0 67.5:1 112.5:1 157.5:0 202.5:0 247.5:1 292.5:1 337.5:0 382.5:0");
  EXPECT_EQ(planes(kC, {-60, 0, 60}), "-60:0 0:1 60:2 120:2 180:1 240:0 300:0");
  EXPECT_EQ(across(kC, range(0, 85, 5)),
            "horizontal angles from 0 to 85 degrees -> symmetric about the planes 0 and 90");
  EXPECT_EQ(across(kC, range(0, 175, 5)),
            "horizontal angles from 0 to 175 degrees -> symmetric about the planes 0 and 180");
  EXPECT_EQ(across(kC, range(95, 265, 10)),
            "horizontal angles from 95 to 265 degrees -> symmetric about the planes 90 and 270");
}

TEST(PhotometricAngles, WhatIsOutsideOfPartialRangesIsDark) {
  EXPECT_EQ(along(kC, {0, 140}), "vertical angles from 0 to 140 degrees -> dark outside of them");
  EXPECT_EQ(along(kC, {5, 90}), "vertical angles from 5 to 90 degrees -> dark outside of them");
  EXPECT_EQ(along(kB, {0, 90}), "vertical angles from 0 to 90 degrees -> dark outside of them");
  EXPECT_EQ(across(kA, {-30, 40}),
            "horizontal angles from -30 to 40 degrees -> dark outside of them");
  EXPECT_EQ(across(kB, {0, 40}),
            "horizontal angles from 0 to 40 degrees -> symmetric about 0, and dark beyond 40");
  EXPECT_EQ(planes(kB, {0, 40}), "-40:1 0:0 40:1");
  EXPECT_EQ(planes(kA, {10, 40}), "10:0 40:1");
  // 5 cd within 40 degrees of the plane, 30 of the beam: 5 * (60 degrees) * 2 sin(40 degrees).
  const auto web = *PhotometricWeb::create({kA, {-40, 40}, {-30, 30}, {5, 5, 5, 5}});
  EXPECT_NEAR(web->flux_lm(), 5 * kPi / 3 * 2 * std::sin(40 * kPi / 180), 1e-12);
  EXPECT_EQ(web->at({1, 0, 0}), 5);
  EXPECT_EQ(web->at({0, 1, 0}), 0);
  EXPECT_EQ(web->at({0.3, 0, 1}), 0);
}

// The standard ends at 90 degrees.
TEST(PhotometricAngles, TypeAMayGoAllAround) {
  EXPECT_EQ(across(kA, range(-180, 180, 90)),
            "horizontal angles from -180 to 180 degrees -> all around, although the standard has "
            "-90 to 90 only");
  EXPECT_EQ(across(kA, range(0, 180, 90)),
            "horizontal angles from 0 to 180 degrees -> all around, although the standard has -90 "
            "to 90 only");
  EXPECT_EQ(across(kA, {0, 120}),
            "horizontal angles from 0 to 120 degrees -> symmetric about 0, and dark beyond 120");
  EXPECT_EQ(planes(kA, {-90, 90}), "-90:0 90:1");
  EXPECT_EQ(planes(kA, {0, 90, 180}), "-180:2 -90:1 0:0 90:1 180:2");
  EXPECT_EQ(planes(kA, {0, 90, 180, 270}), "0:0 90:1 180:2 270:3 360:0");
  EXPECT_EQ(planes(kA, {-180, -90, 0, 90, 180}), "-180:0 -90:1 0:2 90:3 180:4");
  // 3 cd in front, 1 cd behind.
  const auto web = *PhotometricWeb::create(
      {kA, {-90, 0, 90}, {-180, -90, 0, 90, 180}, {1, 1, 1, 2, 2, 2, 3, 3, 3, 2, 2, 2, 1, 1, 1}});
  EXPECT_NEAR(web->flux_lm(), 2 * 4 * kPi, 1e-12);
  EXPECT_NEAR(web->at({-1, 1e-12, 0}), 1, 1e-9);
  EXPECT_NEAR(web->at({-1, -1e-12, 0}), 1, 1e-9);
  EXPECT_NEAR(web->at({0, 1, 0}), 2, 1e-9);
  EXPECT_GE(web->cone().half_angle_rad, kPi);
  EXPECT_NEAR(web->downward_flux_lm(), 4 * kPi, 1e-12);
  // The grid of one side: the cone holds all of its light.
  const auto side = *PhotometricWeb::create({kA, {-60, 0, 60}, {90, 135}, {1, 1, 1, 1, 1, 1}});
  for (const double v : {-60., 0., 60.})
    for (const double az : {90., 135.}) {
      const double a = az * kPi / 180, e = v * kPi / 180;
      const Vec3 w{std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), -std::sin(e)};
      EXPECT_GE(dot(side->cone().axis, w), std::cos(side->cone().half_angle_rad) - 1e-9);
    }
}

// Wherever the planes begin, a direction finds its two planes.
TEST(PhotometricAngles, PlanesMayBeginAnywhere) {
  for (const double first : {-360., -200., -7.5, 0., 7.5, 90., 200., 355.}) {
    PhotometricWebParams params{kC, {0, 180}, {}, {}};
    for (int i = 0; i < 36; ++i) {
      params.horizontal_deg.push_back(first + 10 * i);
      params.intensity_cd.insert(params.intensity_cd.end(), 2, i);
    }
    const auto web = PhotometricWeb::create(params);
    ASSERT_TRUE(web.ok()) << web.status();
    for (int i = 0; i < 36; ++i) {
      const double h = (first + 10 * i + 4) * kPi / 180, next = i < 35 ? i + 1 : 0;
      EXPECT_NEAR((*web)->at({std::cos(h), -std::sin(h), 0.1}), 0.6 * i + 0.4 * next, 1e-9)
          << first << " " << i;
    }
  }
}

TEST(PhotometricAngles, ErrorsHaveTheAllowedAngles) {
  const auto v = [](PhotometricType type, const std::vector<double>& degrees) {
    return std::string(check_vertical_angles(type, degrees).message());
  };
  const auto h = [](PhotometricType type, const std::vector<double>& degrees) {
    return std::string(check_horizontal_angles(type, degrees).message());
  };
  EXPECT_EQ(v(kC, {0}), "1 vertical angle, allowed: 2 or more");
  EXPECT_EQ(v(kC, {-1, 90}),
            "vertical angles from -1 to 90 degrees, allowed for type C: from 0 "
            "to 180");
  EXPECT_EQ(v(kB, {-91, 90}),
            "vertical angles from -91 to 90 degrees, allowed for types A and B: "
            "from -90 to 90");
  EXPECT_EQ(v(kC, {0, 90, 80}),
            "vertical angle[2] = 80 degrees, allowed: ascending, within 720 degrees of 0");
  EXPECT_EQ(h(kC, {}), "0 horizontal angles, allowed: 1 or more");
  EXPECT_EQ(h(kC, {-10, 355}),
            "horizontal angles from -10 to 355 degrees, allowed for types A and C: over 360 "
            "degrees at most");
  EXPECT_EQ(h(kA, {0}), "1 horizontal angle, allowed: 2 or more for types A and B");
  EXPECT_EQ(h(kB, {0, 100}),
            "horizontal angles from 0 to 100 degrees, allowed for type B: from -90 to 90");
}

}  // namespace
}  // namespace lucerna
