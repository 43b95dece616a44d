// Illuminances at the points that come with the shipped scenes, from the command line.
#include <gtest/gtest.h>

#include <algorithm>
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

/// Direct light at all points of a scene [lx], in order of size.  Each point must have an answer.
std::vector<double> sorted_lux(const std::string& scene) {
  const TempDirectory directory;
  const auto server = testing::LocalServer::start({.scene_root = source_path("scenes")});
  EXPECT_TRUE(server.ok()) << server.status();
  if (!server.ok()) return {std::nan("")};
  const std::string points = source_path("scenes/") + scene + "/points.csv";
  const std::string answers = (directory.path() / "lux.csv").string();
  const Outcome outcome =
      run_program({build_path("bin/lucerna"), "irradiance", scene + "/scene.pbrt", "--points",
                   points, "--bounces", "0", "--samples", "256", "-o", answers},
                  {}, {{"LUCERNA_SERVER", server->target()}});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  const auto requested = numbers(points), answered = numbers(answers);
  EXPECT_EQ(requested.size(), answered.size());
  EXPECT_GE(requested.size(), 200U);
  EXPECT_LE(requested.size(), 1000U);
  for (const std::vector<double>& row : requested) {  // x, y, z and normal
    EXPECT_EQ(row.size(), 6U);
    if (row.size() == 6) {
      EXPECT_NEAR(std::hypot(row[3], row[4], row[5]), 1, 1e-4);
    }
  }
  std::vector<double> lux;
  for (const std::vector<double>& row : answered) {
    // x, y, z, illuminance, its RGB, standard error, bound.
    EXPECT_EQ(row.size(), 9U);
    lux.push_back(row.size() == 9 ? row[3] : std::nan(""));
  }
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

// 600 lm half a metre above the floor, and two blocks.
TEST(ShippedScenes, CornellBoxHasShadowsAndLight) {
  const std::vector<double> lux = sorted_lux("cornell");
  EXPECT_EQ(lux.front(), 0);
  EXPECT_GT(lux.back(), 100);
}

TEST(ShippedScenes, StageHasDarkPlacesAndBrightOnes) {
  const std::vector<double> lux = sorted_lux("stage");
  EXPECT_EQ(lux.front(), 0);
  EXPECT_GT(lux.back(), 100);
  EXPECT_LT(lux.back(), 1000);
}

}  // namespace
}  // namespace lucerna
