// The program lucerna against a lucernad: answers, exit statuses, errors.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <regex>

#include "client/testing/local_server.h"
#include "tests/e2e/run_program.h"

namespace lucerna {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::MatchesRegex;
using ::testing::Not;
using ::testing::StartsWith;

/// One server for all tests: the scene root is a directory of their own with the reference scenes
/// and a broken one.
class Cli : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    std::string name = (fs::temp_directory_path() / "lucerna_cli_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    directory_ = name;
    fs::create_directories(directory_ / "scenes");
    for (const char* file : {"point.pbrt", "sphere.pbrt", "rectangle_near.pbrt", "ball.ply"}) {
      fs::copy_file(fs::path(LUCERNA_TEST_DATA) / "reference" / file, directory_ / "scenes" / file);
    }
    fs::copy_file(fs::path(LUCERNA_TEST_DATA) / "pbrt" / "moving_point.pbrt",
                  directory_ / "scenes" / "moving_point.pbrt");
    std::ofstream(directory_ / "scenes" / "broken.pbrt") << "WorldBegin\nShape sphere\n";
    std::ofstream(directory_ / "scenes" / "lamp.pbrt")
        << "WorldBegin\nLightSource \"point\" \"spectrum I\" [500 1 600 1] \"float power\" 1000\n";
    auto server = testing::LocalServer::start({.scene_root = (directory_ / "scenes").string()});
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = std::make_unique<testing::LocalServer>(*std::move(server));
  }
  static void TearDownTestSuite() {
    server_.reset();
    if (!directory_.empty()) fs::remove_all(directory_);
  }
  void SetUp() override { ASSERT_NE(server_, nullptr); }

  static Outcome lucerna(std::vector<std::string> arguments, const std::string& input = {}) {
    arguments.insert(arguments.begin(), LUCERNA_CLI);
    return run_program(std::move(arguments), input, {{"LUCERNA_SERVER", server_->target()}});
  }
  static std::string path(const std::string& name) { return (directory_ / name).string(); }
  /// Everything that is in the tests' directory, hidden files too.
  static std::vector<std::string> files() {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(directory_)) {
      if (entry.path().filename() != "scenes") names.push_back(entry.path().filename().string());
    }
    return names;
  }

  static inline fs::path directory_;
  static inline std::unique_ptr<testing::LocalServer> server_;
};

void expect_wrong_use(const Outcome& outcome, const std::string& what) {
  EXPECT_EQ(outcome.status, 2) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr(what));
  EXPECT_THAT(outcome.out, IsEmpty());
}

void expect_no(const Outcome& outcome, const std::string& what) {
  EXPECT_EQ(outcome.status, 1) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr(what));
}

TEST_F(Cli, TellsItsVersion) {
  const Outcome outcome = lucerna({"--version"});
  EXPECT_EQ(outcome.status, 0);
  EXPECT_THAT(outcome.out, MatchesRegex("lucerna [0-9]+\\.[0-9]+\\.[0-9]+\n"));
}

TEST_F(Cli, HelpOfEachSubcommandHasAnExample) {
  for (const char* command :
       {"load", "scenes", "lights", "release", "info", "sample", "pdf", "emit", "emit-pdf", "le",
        "power", "visible", "irradiance", "render"}) {
    const Outcome outcome = lucerna({command, "--help"});
    EXPECT_EQ(outcome.status, 0) << command;
    EXPECT_THAT(outcome.out, HasSubstr(std::string("Example:\n  lucerna ") + command));
  }
}

TEST_F(Cli, WrongFlagsAndNumbersAreWrongUse) {
  expect_wrong_use(lucerna({}), "subcommand");
  expect_wrong_use(lucerna({"frobnicate"}), "frobnicate");
  expect_wrong_use(lucerna({"power"}), "SCENE");
  expect_wrong_use(lucerna({"power", "point.pbrt", "--bogus"}), "--bogus");
  expect_wrong_use(lucerna({"power", "point.pbrt", "--timeout", "-1"}), "--timeout");
  expect_wrong_use(lucerna({"power", "point.pbrt", "--light", "one"}), "one");
  expect_wrong_use(lucerna({"sample", "point.pbrt", "--point", "0,0,0", "--light", "-1"}),
                   "-1 is not a whole number from 1");
  expect_wrong_use(lucerna({"power", "point.pbrt", "--light", "-1"}),
                   "-1 is not a whole number from 1");
  expect_wrong_use(lucerna({"power", "point.pbrt", "--timeout", "nan"}),
                   "nan is not a finite number above 0");
  expect_wrong_use(lucerna({"render", "point.pbrt", "-o", "x.png", "--exposure", "nan"}),
                   "nan is not a number from -100 to 100");
  expect_wrong_use(lucerna({"render", "point.pbrt", "-o", "x.png", "--samples", "5000000000"}),
                   "5000000000 is not a whole number from 1 to 4294967295");
  expect_wrong_use(lucerna({"power", ""}), "SCENE is empty");
  expect_wrong_use(lucerna({"sample", "point.pbrt"}), "no points");
  expect_wrong_use(lucerna({"sample", "point.pbrt", "--point", "1,2"}), "\"1,2\"");
  expect_wrong_use(lucerna({"sample", "point.pbrt", "--point", "1,2,3", "--u", "0.5"}), "--u");
  expect_wrong_use(lucerna({"sample", "point.pbrt", "--point", "1,2,3", "--samples", "0"}),
                   "--samples");
  expect_wrong_use(lucerna({"pdf", "point.pbrt", "--point", "1,2,3", "--light", "1"}),
                   "no directions");
  expect_wrong_use(lucerna({"visible", "point.pbrt", "--point", "1,2,3"}), "nowhere to look");
  expect_wrong_use(lucerna({"irradiance", "point.pbrt", "--point", "1,2,3"}), "no normals");
  expect_wrong_use(lucerna({"irradiance", "point.pbrt", "--point", "1,2,3", "--point", "2,2,3",
                            "--point", "3,2,3", "--normal", "0,0,1", "--normal", "0,0,1"}),
                   "2 times for 3 points");
}

TEST_F(Cli, ErrorsInFilesOfPointsNameFileAndLine) {
  std::ofstream(path("bad.csv")) << "x,y,z\n0,0,0\n0,zero,0\n";
  const Outcome outcome =
      lucerna({"irradiance", "point.pbrt", "--normal", "0,0,1", "--points", path("bad.csv")});
  fs::remove(path("bad.csv"));
  expect_wrong_use(outcome, path("bad.csv") + ":3: column 2: \"zero\"");
  expect_wrong_use(lucerna({"irradiance", "point.pbrt", "--points", path("none.csv")}),
                   "cannot be opened");
  expect_wrong_use(lucerna({"irradiance", "point.pbrt", "--points", "-"}, "1,2\n"),
                   "standard input:1: 2 columns");
}

TEST_F(Cli, ServerThatIsNotThereIsSaidToBeStarted) {
  // Port 1 (tcpmux) is listened to by nobody.
  const Outcome outcome = lucerna({"scenes", "--server", "127.0.0.1:1"});
  expect_no(outcome, "cannot reach a server at 127.0.0.1:1");
  EXPECT_THAT(outcome.err, HasSubstr("lucernad --listen 127.0.0.1:1 --scene-root DIR"));
}

TEST_F(Cli, ScenesAreNamedByPathIdAndPrefix) {
  Outcome outcome = lucerna({"load", "point.pbrt"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const std::string id = outcome.out.substr(0, 64);
  EXPECT_THAT(id, MatchesRegex("[0-9a-f]+"));
  EXPECT_THAT(lucerna({"load", "point.pbrt"}).out, StartsWith(id + "  was loaded already"));
  const std::string power = lucerna({"power", "point.pbrt"}).out;
  EXPECT_EQ(lucerna({"power", id}).out, power);
  EXPECT_EQ(lucerna({"power", id.substr(0, 12)}).out, power);
  EXPECT_THAT(lucerna({"scenes"}).out, ContainsRegex(id + " .*point\\.pbrt"));

  EXPECT_THAT(lucerna({"release", id.substr(0, 12)}).out, HasSubstr("released"));
  expect_no(lucerna({"power", id}), "not_found");
  expect_no(lucerna({"power", id.substr(0, 12)}), "no id of a loaded scene begins so");
}

TEST_F(Cli, ScenesThatCannotBeLoadedAreTheServersNo) {
  expect_no(lucerna({"load", "missing.pbrt"}), "not_found");
  expect_no(lucerna({"load", "../secret.pbrt"}), "the server said");
  expect_no(lucerna({"load", "/etc/passwd"}), "the server said");
  expect_no(lucerna({"power", "broken.pbrt"}), "broken.pbrt:2:");
  EXPECT_EQ(lucerna({"scenes"}).status, 0);
}

TEST_F(Cli, LightsAreListedWithKindPlaceAndFlux) {
  const Outcome outcome = lucerna({"lights", "point.pbrt"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out,
              ContainsRegex(" 1  point +10 cd +1\\.2 -1\\.5 3\\.2 +125\\.66[34] +exact "
                            "+yes +point\\.pbrt:"));
  // A radius of 0.35 about (0.7, -1.2, 2.6): 4 pi 0.35^2 = 1.53938 m2.
  EXPECT_THAT(lucerna({"lights", "sphere.pbrt"}).out,
              ContainsRegex("area +sphere of diameter 0\\.7 m, 12 cd/m2 +0\\.35 -1\\.55 2\\.25 to "
                            "1\\.05 -0\\.85 2\\.95 +1\\.53938 +58\\.033[0-9] +exact +no "));
}

TEST_F(Cli, PowerIsTheIntegralOfTheIntensity) {
  const Outcome outcome = lucerna({"power", "point.pbrt"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  // 4 pi 10 lm
  EXPECT_THAT(outcome.out, ContainsRegex(" 1  point +125\\.664 "));
  EXPECT_THAT(outcome.out, ContainsRegex("all +125\\.664 "));
  // pi L A = pi 12 4 pi 0.35^2 = 58.0331 lm
  EXPECT_THAT(lucerna({"power", "sphere.pbrt"}).out, ContainsRegex(" 1  area +58\\.0333 "));
  expect_no(lucerna({"power", "point.pbrt", "--light", "77"}), "77");
}

TEST_F(Cli, SampleOfAPointLightIsItsIlluminance) {
  // Straight below, 3.2 m: 10 / 3.2^2 lx.
  const Outcome outcome =
      lucerna({"sample", "point.pbrt", "--point", "1.2,-1.5,0", "--light", "1", "--visible"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(
      outcome.out,
      ContainsRegex("0\\.97656[23] 0\\.97656[23] 0\\.97656[23] +lx +0 0 1 +3\\.2 +delta +yes"));
  const Outcome chosen =
      lucerna({"sample", "point.pbrt", "--point", "1.2,-1.5,0", "--u", "0.5,0.5,0.25"});
  EXPECT_EQ(chosen.status, 0) << chosen.err;
  EXPECT_THAT(chosen.out, ContainsRegex("chosen with"));
}

TEST_F(Cli, PdfIsZeroBesideALightAndNotTowardsIt) {
  // Straight below the sphere's centre.
  const Outcome outcome = lucerna({"pdf", "sphere.pbrt", "--light", "1", "--points", "-"},
                                  "x,y,z,nx,ny,nz\n0.7,-1.2,0,0,0,1\n0.7,-1.2,0,1,0,0\n");
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, ContainsRegex("0 0 1 +[1-9][0-9.]*\n"));
  EXPECT_THAT(outcome.out, ContainsRegex("1 0 0 +0\n"));
}

TEST_F(Cli, DensityIsThatOfTheWayThatWasAskedFor) {
  const auto pdf = [](const std::string& way) {
    return lucerna({"pdf", "sphere.pbrt", "--light", "1", "--point", "0.7,-1.2,0", "--direction",
                    "0,0,1", "--area-sampling", way})
        .out;
  };
  // A sphere of radius 0.35 at 2.6 m: 1 / (2 pi (1 - sqrt(1 - (0.35 / 2.6)^2))) = 17.485.
  EXPECT_THAT(pdf("solid-angle"), ContainsRegex("0 0 1 +17\\.485"));
  // By area: 2.25^2 / (4 pi 0.35^2) = 3.2887.
  for (const char* way :
       {"square-root", "kraemer", "parallelogram", "rejection", "low-distortion"}) {
    EXPECT_THAT(pdf(way), ContainsRegex("0 0 1 +3\\.288[67]")) << way;
  }
  for (const char* way : {"automatic", "cosine-solid-angle"}) {
    EXPECT_THAT(pdf(way), ContainsRegex("0 0 1 +17\\.485")) << way;
  }
  expect_wrong_use(lucerna({"pdf", "sphere.pbrt", "--light", "1", "--point", "0,0,0", "--direction",
                            "0,0,1", "--area-sampling", "sideways"}),
                   "--area-sampling");
}

TEST_F(Cli, SamplesFollowTheNormalThatIsGivenWithoutAskingForVisibility) {
  // Under a light that covers most of the sky: by the cosine samples move to where the surface
  // looks, and the density that is told with them is what `pdf` tells of their direction.
  const auto sample = [](const std::string& way, std::vector<std::string> more) {
    std::vector<std::string> words = {"sample",  "rectangle_near.pbrt", "--light", "1", "--u",
                                      "0.5,0.5", "--area-sampling",     way};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome outcome = lucerna(words, "-1.25,-0.75,1.25,1,0,0.25\n");
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return outcome.out;
  };
  const std::vector<std::string> point = {"--point", "-1.25,-0.75,1.25"};
  const std::vector<std::string> with_normal = {"--point", "-1.25,-0.75,1.25", "--normal",
                                                "1,0,0.25"};
  const std::string followed = sample("cosine-solid-angle", with_normal);
  EXPECT_NE(followed, sample("cosine-solid-angle", point));
  EXPECT_EQ(sample("cosine-solid-angle", point), sample("solid-angle", point));
  EXPECT_EQ(sample("solid-angle", with_normal), sample("solid-angle", point));
  EXPECT_EQ(sample("cosine-solid-angle", {"--points", "-"}), followed);
  // "... cd/m2  WI  DISTANCE  PDF"
  const std::regex row("cd/m2 +([-0-9.e]+) ([-0-9.e]+) ([-0-9.e]+) +[0-9.]+ +([0-9.]+)");
  std::smatch m;
  ASSERT_TRUE(std::regex_search(followed, m, row)) << followed;
  const std::string wi = m[1].str() + "," + m[2].str() + "," + m[3].str();
  const Outcome told =
      lucerna({"pdf", "rectangle_near.pbrt", "--light", "1", "--point", "-1.25,-0.75,1.25",
               "--direction", wi, "--normal", "1,0,0.25", "--area-sampling", "cosine-solid-angle"});
  EXPECT_EQ(told.status, 0) << told.err;
  std::smatch n;
  const std::regex density(m[3].str() + " +([0-9.]+)\n");
  ASSERT_TRUE(std::regex_search(told.out, n, density)) << told.out;
  // Six digits were printed of the direction.
  EXPECT_NEAR(std::stod(n[1]) / std::stod(m[4]), 1, 1e-4);
}

TEST_F(Cli, WaysToSampleAreAlsoOfIrradianceAndPictures) {
  const auto irradiance = [](std::vector<std::string> more) {
    more.insert(more.begin(), {"irradiance", "rectangle_near.pbrt", "--point", "-1.25,-0.75,1.25",
                               "--normal", "0,0,1", "--bounces", "0", "--samples", "16", "--json"});
    const Outcome outcome = lucerna(more);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return outcome.out.substr(0, outcome.out.find(']'));
  };
  const std::string by_area = irradiance({"--area-sampling", "low-distortion"});
  EXPECT_NE(by_area, irradiance({"--area-sampling", "solid-angle"}));
  EXPECT_EQ(by_area, irradiance({"--area-sampling", "kraemer"}));  // differs on triangles alone
  const auto picture = [](const std::string& name, const std::string& way) {
    const Outcome outcome = lucerna({"render", "rectangle_near.pbrt", "-o", path(name), "--samples",
                                     "1", "--bounces", "0", "--area-sampling", way});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    std::ifstream file(path(name), std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), {}};
    fs::remove(path(name));
    return bytes;
  };
  const std::string bytes = picture("way.pfm", "low-distortion");
  EXPECT_GT(bytes.size(), 100U);
  EXPECT_EQ(bytes, picture("way.pfm", "low-distortion"));
  EXPECT_NE(bytes, picture("way.pfm", "solid-angle"));
  expect_wrong_use(lucerna({"render", "rectangle_near.pbrt", "-o", path("way.pfm"),
                            "--area-sampling", "sideways"}),
                   "sideways");
}

TEST_F(Cli, LeIsTheRadianceOfTheLightThatARayMeets) {
  // From below the sphere's centre, up and aside.
  const Outcome outcome =
      lucerna({"le", "sphere.pbrt", "--points", "-"}, "0.7,-1.2,0,0,0,1\n0.7,-1.2,0,1,0,1\n");
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, ContainsRegex("0 0 1 +12 12 12 +1\n"));
  EXPECT_THAT(outcome.out, ContainsRegex("1 0 1 +0 0 0 +none\n"));
  expect_no(
      lucerna({"le", "sphere.pbrt", "--point", "0,0,1", "--direction", "0,0,1", "--light", "77"}),
      "77");
  expect_wrong_use(lucerna({"le", "sphere.pbrt", "--point", "0,0,1"}), "no directions");
}

TEST_F(Cli, TimeIsTheMomentOfWhatMoves) {
  // 18 cd at (2 t, 0, 3): at 1 s d^2 = 4 + 9 = 13 m2, and 18 * 3 / 13^1.5 lx on the floor.
  const auto with = [](std::vector<std::string> arguments, const char* time) {
    arguments.insert(arguments.begin() + 1, "moving_point.pbrt");
    arguments.insert(arguments.end(), {"--time", time});
    const Outcome outcome = lucerna(std::move(arguments));
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return outcome.out;
  };
  EXPECT_THAT(with({"sample", "--point", "0,0,0", "--light", "1"}, "1"), HasSubstr("1.38462"));
  EXPECT_THAT(with({"sample", "--point", "0,0,0", "--light", "1"}, "0"), HasSubstr("  2 2 2  lx"));
  EXPECT_THAT(with({"irradiance", "--point", "0,0,0", "--normal", "0,0,1", "--bounces", "0"}, "1"),
              HasSubstr("1.15207"));
  EXPECT_THAT(with({"emit", "--light", "1"}, "1"), HasSubstr(" 2 0 3 "));
  // Densities: of a point light's direction from where it is, 1 / (4 pi), and 0 from elsewhere.
  const std::vector<std::string> emit_pdf = {"emit-pdf", "--light",     "1",     "--point",
                                             "2,0,3",    "--direction", "0,0,-1"};
  EXPECT_THAT(with(emit_pdf, "1"), HasSubstr("0.0795775"));
  EXPECT_THAT(with(emit_pdf, "1.5"), Not(HasSubstr("0.0795775")));
  // Here time has no effect, but it is taken.
  with({"pdf", "--light", "1", "--point", "0,0,0", "--direction", "0,0,1"}, "1");
  with({"le", "--point", "0,0,1", "--direction", "0,0,1"}, "1");
  with({"visible", "--point", "0,0,1", "--to", "0,0,2"}, "1");
  with({"render", "-o", path("a.pfm"), "--samples", "4"}, "1");
  const auto bytes = [](const std::string& name) {
    std::ifstream file(path(name), std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  const std::string at_one = bytes("a.pfm");
  with({"render", "-o", path("a.pfm"), "--samples", "4"}, "0");
  EXPECT_NE(bytes("a.pfm"), at_one);
  fs::remove(path("a.pfm"));
  expect_wrong_use(lucerna({"le", "moving_point.pbrt", "--point", "0,0,1", "--direction", "0,0,1",
                            "--time", "nan"}),
                   "nan is not a finite number");
}

// Flat from 500 to 600 nm.  By adding up the CIE's table, the end entries halved: its mean there is
// 0.80920, so 1000 lm are 1000 / (683 * 0.80920) = 1.80935 W, a hundredth of it in each nanometre.
TEST_F(Cli, WattsAndWavelengthsAreToldOfLightsWithSpectra) {
  EXPECT_THAT(lucerna({"power", "lamp.pbrt", "--wavelength", "499,555", "--wavelength", "600"}).out,
              AllOf(HasSubstr("flux [W]"), HasSubstr("at 499 555 600 nm [W/nm]"),
                    ContainsRegex(" 1  point +1000 +exact +1\\.80935 .* 0 0\\.0180935 "
                                  "0\\.0180935\n")));
  EXPECT_THAT(lucerna({"lights", "lamp.pbrt"}).out,
              ContainsRegex("spectrum 500 to 600 nm, 1\\.80935 W"));
  EXPECT_THAT(lucerna({"power", "point.pbrt"}).out, Not(HasSubstr("[W]")));
  // 2 m away: 0.0180935 / (4 pi 2^2) W/m2/nm.
  const char* const value = "0\\.000359959";
  EXPECT_THAT(
      lucerna({"sample", "lamp.pbrt", "--point", "0,0,2", "--light", "1", "--wavelength", "555"})
          .out,
      AllOf(HasSubstr("at 555 nm"), ContainsRegex(std::string(value) + " +W/m2/nm")));
  EXPECT_THAT(lucerna({"irradiance", "lamp.pbrt", "--point", "0,0,2", "--normal", "0,0,-1",
                       "--bounces", "0", "--wavelength", "555,700"})
                  .out,
              ContainsRegex(std::string(value) + " 0\n"));
  EXPECT_THAT(lucerna({"emit", "lamp.pbrt", "--light", "1", "--wavelength", "555"}).out,
              ContainsRegex("0\\.00143984 +W/sr/nm"));
  // Up at the sphere of 12 cd/m2: white, so D65, 12 of its W/m2/sr/nm per lm/m2/sr.
  EXPECT_THAT(lucerna({"le", "sphere.pbrt", "--point", "0.7,-1.2,0", "--direction", "0,0,1",
                       "--wavelength", "560"})
                  .out,
              AllOf(HasSubstr("at 560 nm [W/m2/sr/nm]"), ContainsRegex("12 12 12 +0\\.000166263")));
  expect_no(lucerna({"irradiance", "lamp.pbrt", "--point", "0,0,2", "--normal", "0,0,-1",
                     "--wavelength", "555"}),
            "surfaces have a colour and no spectrum");
  expect_no(lucerna({"power", "lamp.pbrt", "--wavelength", "20"}), "wavelengths_nm[0] = 20");
  expect_wrong_use(lucerna({"power", "lamp.pbrt", "--wavelength", "blue"}), "blue");
}

TEST_F(Cli, VisibilityIsAskedForSegmentsAndRays) {
  // Through the box (half a metre about (0.8, 0.2), 1.2 m high) and over it.
  const Outcome segments = lucerna({"visible", "point.pbrt", "--points", "-"},
                                   "0.8,-1.8,0.5,0.8,2.2,0.5\n0.8,-1.8,1.5,0.8,2.2,1.5\n");
  EXPECT_EQ(segments.status, 0) << segments.err;
  EXPECT_THAT(segments.out, ContainsRegex("0\\.8 2\\.2 0\\.5 +no\n"));
  EXPECT_THAT(segments.out, ContainsRegex("0\\.8 2\\.2 1\\.5 +yes\n"));
  // The wall is at y = 3.
  const auto ray = [](const std::string& length) {
    return lucerna({"visible", "point.pbrt", "--point", "0.8,-1.8,1.5", "--direction", "0,1,0",
                    "--length", length})
        .out;
  };
  EXPECT_THAT(ray("4"), HasSubstr("yes"));
  EXPECT_THAT(ray("5"), Not(HasSubstr("yes")));
}

TEST_F(Cli, DirectIrradianceOfAPointLightIsExactByHand) {
  const Outcome outcome = lucerna({"irradiance", "point.pbrt", "--point", "1.2,-1.5,0", "--normal",
                                   "0,0,2", "--bounces", "0", "--per-light"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, ContainsRegex("1\\.2 +-1\\.5 +0 +0\\.97656[23] "));
  EXPECT_THAT(outcome.out, ContainsRegex("light +x \\[m\\]"));
}

TEST_F(Cli, ItemWithoutAnswerIsShownInItsRowAndMakesTheStatusOne) {
  const Outcome outcome = lucerna({"irradiance", "point.pbrt", "--bounces", "0", "--points", "-"},
                                  "1.2,-1.5,0,0,0,1\n1.2,-1.5,0,0,0,0\nnan,0,0,0,0,1\n");
  EXPECT_EQ(outcome.status, 1) << outcome.err;
  EXPECT_THAT(outcome.out,
              ContainsRegex("0\\.97656[23] .*\n.* INVALID_INPUT\n *nan .* INVALID_INPUT\n"));
}

TEST_F(Cli, JsonIsTheAnswersMessage) {
  const Outcome outcome = lucerna({"irradiance", "point.pbrt", "--point", "1.2,-1.5,0", "--normal",
                                   "0,0,1", "--bounces", "0", "--json"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, AllOf(StartsWith("{\"irradiance_lx\":["),
                                 ContainsRegex("\"illuminance_lx\":\\[0\\.97656[0-9]*\\]")));
  EXPECT_THAT(lucerna({"--json", "power", "point.pbrt"}).out,
              ContainsRegex("\"power_lm\":125\\.6637"));
  EXPECT_THAT(lucerna({"info", "--json"}).out, HasSubstr("\"max_batch_items\":"));
  EXPECT_THAT(lucerna({"lights", "point.pbrt", "--json"}).out,
              HasSubstr("\"intensity_cd\":{\"r\":10"));
  EXPECT_THAT(lucerna({"scenes", "--json"}).out, StartsWith("{\"scenes\":["));
}

TEST_F(Cli, RenderWritesPicturesAndNothingElse) {
  const std::vector<std::string> before = files();
  const Outcome outcome = lucerna({"render", "point.pbrt", "-o", path("a.exr"), "--samples", "4",
                                   "--bounces", "0", "--stderr", path("b.pfm")});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("160 x 120 pixels"));
  EXPECT_THAT(outcome.err, IsEmpty());  // no progress bar where there is no terminal
  EXPECT_EQ(
      lucerna({"render", "point.pbrt", "-o", path("c.png"), "-o", path("d.exr"), "--samples", "1"})
          .status,
      0);
  EXPECT_EQ(files().size(), before.size() + 4);
  // PF, the size, and 160 x 120 x 3 floats.
  EXPECT_EQ(fs::file_size(path("b.pfm")), std::string("PF\n160 120\n-1.0\n").size() + 230400);
  for (const char* name : {"a.exr", "b.pfm", "c.png", "d.exr"}) fs::remove(path(name));
}

TEST_F(Cli, RenderFindsOutBeforehandWhatItCannotWrite) {
  const std::vector<std::string> before = files();
  // Nobody is asked: the server is not there.
  const auto render = [](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"render", "point.pbrt", "--server", "127.0.0.1:1"});
    return lucerna(std::move(arguments));
  };
  expect_wrong_use(render({"-o", path("a.jpg")}), "must be .exr, .png or .pfm");
  expect_wrong_use(render({"-o", path("no/such/a.exr")}), "No such file or directory");
  expect_wrong_use(render({"-o", path("a.exr"), "--stderr", path("a.exr")}), "is given twice");
  expect_wrong_use(render({"-o", path("a.exr"), "--stderr", path("b.gif")}), "b.gif");
  expect_wrong_use(render({"-o", path("a.exr"), "--stderr", path("b.exr"), "--samples", "1"}),
                   "--samples must be 2 or more");
  expect_wrong_use(render({}), "--output");
  expect_no(render({"-o", path("a.exr")}), "cannot reach");
  EXPECT_EQ(files(), before);
}

TEST_F(Cli, TimeoutEndsARenderAndLeavesNothing) {
  const std::vector<std::string> before = files();
  const Outcome outcome = lucerna(
      {"render", "point.pbrt", "-o", path("a.exr"), "--samples", "32768", "--timeout", "0.3"});
  expect_no(outcome, "no answer within --timeout 0.3 s");
  EXPECT_EQ(files(), before);
}

}  // namespace
}  // namespace lucerna
