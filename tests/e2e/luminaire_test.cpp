// Luminaires from photometric files and pictures, from the file to the command line.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <numbers>

#include "client/testing/local_server.h"
#include "tests/e2e/run_program.h"
#include "tests/paths.h"
#include "tests/temp_directory.h"

namespace lucerna {
namespace {

namespace fs = std::filesystem;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kPi = std::numbers::pi;

/// A street lantern as a laboratory writes it: type C, quadrants, one angle every 2.5 degrees.
double candela(double v_deg, double h_deg) {
  const double v = v_deg * kPi / 180, h = h_deg * kPi / 180;
  return 900 * std::cos(v) * (1 + 0.5 * std::sin(h) * std::sin(h) * std::sin(v));
}

constexpr double kStep = 2.5;

std::string lantern_ies() {
  std::string text =
      "IESNA:LM-63-2002\r\n[TEST] none\r\n[MANUFAC] made for this test\r\nTILT=NONE\r\n"
      "1 4000 1 37 10 1 2 0.3 0.6 0.1\r\n1 1 36\r\n";
  for (int i = 0; i <= 36; ++i) text += fmt::format("{} ", kStep * i);
  text += "\r\n";
  for (int k = 0; k <= 9; ++k) text += fmt::format("{} ", 10 * k);
  for (int k = 0; k <= 9; ++k) {
    text += "\r\n";
    for (int i = 0; i <= 36; ++i)
      text += fmt::format("{:.2f} ", std::fabs(candela(kStep * i, 10 * k)));
  }
  return text;
}

/// The luminaire's lumens by the method of laboratory reports.  It sums zonal constants of 5
/// degrees, 2 pi (cos a - cos b), times the candela at the middle of the zone, averaged over all
/// planes.  In a quadrant file, a turn contains the first and last planes twice and the others four
/// times.
double report_lumens() {
  double sum = 0;
  for (int zone = 0; zone < 18; ++zone) {
    const double a = 5 * zone * kPi / 180, b = 5 * (zone + 1) * kPi / 180;
    double mean = 0;
    for (int k = 0; k <= 9; ++k)
      mean += candela(5 * zone + kStep, 10 * k) * (k == 0 || k == 9 ? 2 : 4) / 36;
    sum += mean * 2 * kPi * (std::cos(a) - std::cos(b));
  }
  return sum;
}

class Luminaires : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    directory_ = std::make_unique<TempDirectory>();
    write("lantern.ies", lantern_ies());
    write("lantern.pbrt",
          "WorldBegin\nTranslate 0 0 5\nRotate 180 1 0 0\n"
          "LightSource \"goniometric\" \"string filename\" \"lantern.ies\"\n");
    write("broken.ies",
          "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 2 1 1 2 0 0 0\n1 1 10\n0 90\n0\n5 x\n");
    write("broken.pbrt",
          "WorldBegin\nLightSource \"goniometric\" \"string filename\" \"broken.ies\"\n");
    fs::copy_file(test_data("reference/gonio.exr"), directory_->path() / "gonio.exr");
    write("picture.pbrt",
          "WorldBegin\nLightSource \"goniometric\" \"string filename\" \"gonio.exr\"\n"
          "  \"float power\" 800\nLightSource \"goniometric\" \"rgb I\" [7 7 7]\n");
    for (const char* file : {"radiant.ies", "radiant.pbrt", "radiant_and_lamp.pbrt"})
      fs::copy_file(fs::path(test_data("luminaires")) / file, directory_->path() / file);
    auto server = testing::LocalServer::start({.scene_root = directory_->path().string()});
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = std::make_unique<testing::LocalServer>(*std::move(server));
  }
  static void TearDownTestSuite() {
    server_.reset();
    directory_.reset();
  }
  void SetUp() override { ASSERT_NE(server_, nullptr); }

  static void write(const char* name, const std::string& text) {
    std::ofstream(directory_->path() / name, std::ios::binary) << text;
  }
  static Outcome lucerna(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), build_path("bin/lucerna"));
    return run_program(std::move(arguments), {}, {{"LUCERNA_SERVER", server_->target()}});
  }

  static inline std::unique_ptr<TempDirectory> directory_;
  static inline std::unique_ptr<testing::LocalServer> server_;
};

// Two rules for one integral.  Zones of 5 degrees take a cosine that is too large by 1 / cos(2.5
// degrees), 0.1%.  Straight lines every 2.5 degrees are 0.02% too small.
TEST_F(Luminaires, PowerIsTheTotalOfTheLaboratorysReport) {
  const Outcome outcome = lucerna({"power", "lantern.pbrt"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const std::size_t row = outcome.out.find("goniometric");
  ASSERT_NE(row, std::string::npos) << outcome.out;
  const double lumens = std::stod(outcome.out.substr(row + std::string("goniometric").size()));
  EXPECT_NEAR(lumens / report_lumens(), 1, 2e-3) << outcome.out;
  EXPECT_THAT(outcome.out.substr(row), HasSubstr("exact"));
}

TEST_F(Luminaires, AreListedWithFileFormatAndLumens) {
  const Outcome file = lucerna({"lights", "lantern.pbrt"});
  ASSERT_EQ(file.status, 0) << file.err;
  EXPECT_THAT(
      file.out,
      ContainsRegex("goniometric +lantern.ies \\(IES LM-63-2002, type C, [0-9.]+ lm\\) +0 0 5"));
  const Outcome picture = lucerna({"lights", "picture.pbrt"});
  ASSERT_EQ(picture.status, 0) << picture.err;
  EXPECT_THAT(picture.out, ContainsRegex("image gonio.exr \\(64 x 64 px, equal-area, nearest\\), "
                                         "[0-9.]+ cd at 1 +0 0 0.* +800 +exact +yes"));
  EXPECT_THAT(picture.out, ContainsRegex("goniometric +7 cd +0 0 0 +87.9646 +exact"));
}

// 20 mW/sr at a distance of 2 m.
TEST_F(Luminaires, TheUnitOfTheFileIsInTheHeadings) {
  const std::vector<std::string> at = {"--point", "0,0,2", "--normal", "0,0,-1", "--bounces", "0"};
  const auto irradiance = [&](const std::string& scene, std::vector<std::string> more = {}) {
    std::vector<std::string> words = {"irradiance", scene};
    words.insert(words.end(), at.begin(), at.end());
    words.insert(words.end(), more.begin(), more.end());
    const Outcome outcome = lucerna(words);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return outcome.out;
  };
  const std::string alone = irradiance("radiant.pbrt", {"--per-light"});
  EXPECT_THAT(alone, HasSubstr("illuminance [mW/m2]"));
  EXPECT_THAT(alone, HasSubstr("RGB [mW/m2]"));
  EXPECT_THAT(alone, HasSubstr("share [mW/m2]"));
  EXPECT_THAT(alone, Not(HasSubstr("[lx]")));
  const std::string two = irradiance("radiant_and_lamp.pbrt", {"--per-light"});
  EXPECT_THAT(two, HasSubstr("illuminance [mixed]"));
  EXPECT_THAT(two, ContainsRegex("1 .* 5 +exact +mW/m2\n"));
  EXPECT_THAT(two, ContainsRegex("2 .* exact +lx\n"));
  EXPECT_THAT(irradiance("radiant.pbrt", {"--output", "csv"}), HasSubstr("illuminance [mW/m2]"));
  EXPECT_THAT(irradiance("lantern.pbrt"), HasSubstr("illuminance [lx]"));
}

TEST_F(Luminaires, ABrokenFileIsNamedWithItsLineAndNothingIsLoaded) {
  const Outcome outcome = lucerna({"lights", "broken.pbrt"});
  EXPECT_EQ(outcome.status, 1);
  EXPECT_THAT(outcome.err, HasSubstr("broken.ies:7: candela value 2 is \"x\", allowed: a finite "
                                     "number"));
  EXPECT_EQ(outcome.out, "");
  EXPECT_EQ(lucerna({"lights", "broken.pbrt"}).status, 1);
}

}  // namespace
}  // namespace lucerna
