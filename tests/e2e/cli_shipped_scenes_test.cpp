// Illuminances at the points that come with the shipped scenes, from the command line.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "client/testing/local_server.h"
#include "proto/common/quantile.h"
#include "tests/e2e/run_program.h"
#include "tests/paths.h"
#include "tests/temp_directory.h"

namespace lucerna {
namespace {

/// The reading of a small flat meter.
struct Reading {
  std::array<double, 3> point, normal;
  double lux, standard_error;
};

std::vector<std::vector<double>> numbers(const std::string& path) {
  std::vector<std::vector<double>> rows;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line[0] == '#' || line[0] == 'x') continue;
    std::vector<double>& row = rows.emplace_back();
    std::istringstream fields(line);
    // The columns of the stage stand on points of the floor.
    for (std::string field;
         std::getline(fields, field, ',') && field != "OK" && field != "INSIDE_SOLID";)
      row.push_back(std::stod(field));
  }
  return rows;
}

/// Direct light at all points of a scene.  Each point must have an answer.
std::vector<Reading> direct_light(const std::string& scene) {
  const TempDirectory directory;
  const auto server = testing::LocalServer::start({.scene_root = source_path("scenes")});
  EXPECT_TRUE(server.ok()) << server.status();
  if (!server.ok()) return {};
  const std::string points = source_path("scenes/") + scene + "/points.csv";
  const std::string answers = (directory.path() / "lux.csv").string();
  const Outcome outcome =
      run_program({build_path("bin/lucerna"), "irradiance", scene + "/scene.pbrt", "--points",
                   points, "--bounces", "0", "--samples", "256", "-o", answers},
                  {}, {{"LUCERNA_SERVER", server->target()}});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  std::vector<Reading> readings;
  const auto requested = numbers(points), answered = numbers(answers);
  EXPECT_EQ(requested.size(), answered.size());
  EXPECT_GE(requested.size(), 200U);
  EXPECT_LE(requested.size(), 1000U);
  for (std::size_t i = 0; i < std::min(requested.size(), answered.size()); ++i) {
    // x, y, z and normal; x, y, z, illuminance, its RGB, standard error, bound.
    if (requested[i].size() != 6 || answered[i].size() != 9) {
      ADD_FAILURE() << "row " << i << ": " << requested[i].size() << " and " << answered[i].size();
      return {};
    }
    const std::vector<double>&a = requested[i], &t = answered[i];
    EXPECT_NEAR(std::hypot(a[3], a[4], a[5]), 1, 1e-4) << i;
    readings.push_back({{a[0], a[1], a[2]}, {a[3], a[4], a[5]}, t[3], t[7]});
  }
  return readings;
}

/// The readings in order of size [lx].
std::vector<double> sorted_lux(const std::string& scene) {
  std::vector<double> lux;
  for (const Reading& reading : direct_light(scene)) lux.push_back(reading.lux);
  std::sort(lux.begin(), lux.end());
  return lux.empty() ? std::vector<double>{std::nan("")} : lux;
}

// The sun on level ground, 78000 lx times the sine of its 27 degrees, plus the sky's 11000 lx.
// Hills and trees hide the low part of the sky.  A band of 5 degrees all around the horizon has
// 0.8% (its squared sine) of the light of an even sky.  In a sky this bright about the sun it has
// at most 4% of the sky's light, which is 1% of the total.
TEST(ShippedScenes, MeadowHasTheDaylightThatItStates) {
  const double open = 78000 * std::sin(27 * M_PI / 180) + 11000;
  const double median = quantile(sorted_lux("meadow"), 0.5);
  EXPECT_LT(median, open);
  EXPECT_GT(median, open * 0.99);
}

// EN 12464-1 requires 500 lx where people read, with the light that walls reflect.
TEST(ShippedScenes, RoomIsLitForWork) {
  const std::vector<double> lux = sorted_lux("room");
  EXPECT_GT(quantile(lux, 0.5), 150);
  EXPECT_GT(quantile(lux, 0.95), 350);
  EXPECT_LT(lux.back(), 1000);
}

// Streets are lit with 7.5 to 50 lx (EN 13201-2, classes C5 to C0); this street has shops too.
TEST(ShippedScenes, StreetIsLitAsStreetsAre) {
  const std::vector<double> lux = sorted_lux("street");
  EXPECT_GT(quantile(lux, 0.05), 7.5);
  EXPECT_LT(quantile(lux, 0.5), 100);
}

TEST(ShippedScenes, StageHasDarkPlacesAndBrightOnes) {
  const std::vector<double> lux = sorted_lux("stage");
  EXPECT_EQ(lux.front(), 0);
  EXPECT_GT(lux.back(), 100);
  EXPECT_LT(lux.back(), 1000);
}

/// The unoccluded illuminance from the lamp of the Cornell box [lx], by the midpoint rule.
double unshadowed(const Reading& at) {
  constexpr int kSteps = 200;
  const double level = 600 / (M_PI * 0.130 * 0.105);
  double sum = 0;
  for (int i = 0; i < kSteps; ++i)
    for (int j = 0; j < kSteps; ++j) {
      const double x = 0.213 + 0.130 * (i + 0.5) / kSteps - at.point[0];
      const double y = 0.5487 - at.point[1];
      const double z = 0.227 + 0.105 * (j + 0.5) / kSteps - at.point[2];
      const double here = x * at.normal[0] + y * at.normal[1] + z * at.normal[2];
      sum += std::max(0.0, here) * std::max(0.0, y) / std::pow(x * x + y * y + z * z, 2);
    }
  return level * sum * 0.130 * 0.105 / kSteps / kSteps;
}

TEST(ShippedScenes, CornellBoxHasTheLightOfItsLampMinusShadowsOfItsBlocks) {
  int lit = 0, shadowed = 0;
  const std::vector<Reading> readings = direct_light("cornell");
  for (const Reading& reading : readings) {
    const double full = unshadowed(reading);
    // Twelve standard errors of 16 blocks or more: Student's t exceeds that by chance in 1e-6
    // of runs with 400 readings.  Plus the error of the midpoint rule, near the plane of the lamp.
    const double slack = 12 * reading.standard_error + 1e-3 * full;
    EXPECT_LT(reading.lux, full + slack);
    lit += std::fabs(reading.lux - full) <= slack;
    shadowed += reading.lux == 0;
  }
  EXPECT_GT(lit, static_cast<int>(readings.size()) / 2);
  EXPECT_GT(shadowed, 10);
}

}  // namespace
}  // namespace lucerna
