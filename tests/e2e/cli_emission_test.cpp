// lucerna emit, emit-pdf, power --method and lights, about one light of each kind; units of files.
#include <algorithm>

#include "tests/e2e/cli_fixture.h"
#include "tests/paths.h"

namespace lucerna {
namespace {

using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::StartsWith;

constexpr const char* kScene = "lights/every_light.pbrt";

class CliEmission : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    auto server = testing::LocalServer::start({.scene_root = test_data()});
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = std::make_unique<testing::LocalServer>(*std::move(server));
  }
  static void TearDownTestSuite() { server_.reset(); }
  void SetUp() override { ASSERT_NE(server_, nullptr); }

  static Outcome lucerna(std::vector<std::string> arguments, const std::string& input = {}) {
    arguments.insert(arguments.begin(), build_path("bin/lucerna"));
    return run_program(std::move(arguments), input, {{"LUCERNA_SERVER", server_->target()}});
  }
  /// The output of a command, which must succeed.
  static std::string said(std::vector<std::string> arguments, const std::string& input = {}) {
    const Outcome outcome = lucerna(std::move(arguments), input);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_THAT(outcome.err, IsEmpty());
    return outcome.out;
  }

  /// The id of the first light whose row contains `what`.
  static std::string id_of(const std::string& what) {
    const std::string table = said({"lights", kScene});
    const std::size_t at = table.find(what);
    EXPECT_NE(at, std::string::npos) << what;
    if (at == std::string::npos) return "";
    const std::size_t row = table.rfind('\n', at) + 1;
    return std::to_string(std::stoi(table.substr(row)));
  }

  static inline std::unique_ptr<testing::LocalServer> server_;
};

std::ptrdiff_t lines(const std::string& text) { return std::ranges::count(text, '\n'); }

TEST_F(CliEmission, RaysHaveValueUnitAndDensities) {
  // A point light: the position is certain; all directions have the density 1 / (4 pi).
  const std::string point = without_cost(said({"emit", kScene, "--light", "1", "--count", "3"}));
  EXPECT_EQ(lines(point), 4);
  EXPECT_THAT(point, Not(HasSubstr("chosen with")));
  EXPECT_THAT(point,
              ContainsRegex("\n +1  101\\.2 -51\\.5 3\\.2 +[-0-9.e]+ [-0-9.e]+ [-0-9.e]+ +12 "
                            "6 3 +cd +certain +0\\.0795775\n"));
  // Parallel rays: the direction is certain.
  EXPECT_THAT(said({"emit", kScene, "--light", "5"}),
              ContainsRegex(" -0\\.267261 0\\.534522 -0\\.801784 +2 2 2 +lx .* certain\n"));
  // A rectangle of 1.5 m2, down.
  const std::string rectangle = id_of("rectangle 1.5 x 1 m");
  EXPECT_THAT(
      said({"emit", kScene, "--light", rectangle, "--seed", "5"}),
      ContainsRegex(" 3 +[-0-9. e]+ -0\\.[0-9]+ +12 12 12 +cd/m2 +0\\.666667 +0\\.[0-9]+\n"));
  // The seed changes the rays; there is a default.
  const auto seeded = [](const std::string& seed) {
    return without_cost(said({"emit", kScene, "--light", "1", "--count", "3", "--seed", seed}));
  };
  EXPECT_EQ(seeded("0"), point);
  EXPECT_NE(seeded("1"), point);
}

TEST_F(CliEmission, ChosenLightsHaveTheirProbability) {
  const std::string out = said({"emit", kScene, "--count", "20"});
  EXPECT_EQ(lines(without_cost(out)), 21);
  EXPECT_THAT(out, ContainsRegex("\n[0-9.e-]+ s, 20 samples\n$"));
  EXPECT_THAT(out, ContainsRegex("^light  chosen with  from \\[m\\]"));
  EXPECT_THAT(out, ContainsRegex("\n +[0-9]+ +0\\.[0-9]+ "));
  EXPECT_THAT(said({"emit", kScene, "--count", "2", "--json"}),
              AllOf(StartsWith("{\"points\":{\"originM\":{\"x\":"),
                    ContainsRegex("\"lightIds\":\\[\"[0-9]+\",\"[0-9]+\"\\]"),
                    ContainsRegex("\"selectionProbability\":\\[0\\.[0-9]+,0\\.[0-9]+\\]")));
}

TEST_F(CliEmission, OwnSampleValuesAreUsed) {
  // The same four numbers give the same ray.
  const std::string sphere = id_of("sphere");
  const auto rays = [&](const std::vector<std::string>& values) {
    std::vector<std::string> words = {"emit", kScene, "--light", sphere};
    for (const std::string& u : values) words.insert(words.end(), {"--u", u});
    return without_cost(said(words));
  };
  const std::string u = "0.25,0.5,0.75,0.5";
  const std::string once = rays({u}), twice = rays({u, u});
  EXPECT_EQ(twice, once + once.substr(once.find('\n') + 1));
  EXPECT_NE(rays({"0.5,0.5,0.75,0.5"}), once);
  // Without --light the fifth number chooses the light; the first light begins at 0.
  EXPECT_THAT(said({"emit", kScene, "--u", "0.25,0.5,0.75,0.5,0"}),
              ContainsRegex("\n +1 +0\\.[0-9]+ +101\\.2 -51\\.5 3\\.2 "));

  expect_wrong_use(lucerna({"emit", kScene, "--light", sphere, "--u", "nan,0.5,0.5,0.5"}),
                   "--u \"nan,0.5,0.5,0.5\": u1 = nan, allowed: [0, 1]");
  expect_wrong_use(lucerna({"emit", kScene, "--light", sphere, "--u", "0.5,2,0.5,0.5"}),
                   "u2 = 2, allowed: [0, 1]");
}

TEST_F(CliEmission, WrongUseOfEmitIsRefused) {
  expect_wrong_use(lucerna({"emit", kScene, "--light", "1", "--u", "0.5,0.5"}),
                   "--u \"0.5,0.5\", must be four numbers u1,u2,u3,u4");
  expect_wrong_use(lucerna({"emit", kScene, "--u", "0.5,0.5,0.5,0.5"}),
                   "must be five numbers u1,u2,u3,u4,u_light, or four with --light");
  expect_wrong_use(lucerna({"emit", kScene, "--light", "1", "--u", "0.5,0.5,0.5,x"}), "0.5,x");
  expect_wrong_use(
      lucerna({"emit", kScene, "--light", "1", "--count", "2", "--u", "0.5,0.5,0.5,0.5"}),
      "--u and --count: only one of them");
  expect_wrong_use(
      lucerna({"emit", kScene, "--light", "1", "--seed", "2", "--u", "0.5,0.5,0.5,0.5"}), "--seed");
  expect_wrong_use(lucerna({"emit", kScene, "--count", "0"}), "--count");
  expect_wrong_use(lucerna({"emit", kScene, "--light", "0"}), "0 is not a whole number from 1");
  expect_wrong_use(lucerna({"emit"}), "SCENE");
  const Outcome unknown = lucerna({"emit", kScene, "--light", "77"});
  EXPECT_EQ(unknown.status, 1);
  EXPECT_THAT(unknown.err, HasSubstr("77"));
}

TEST_F(CliEmission, DensitiesAreThoseOfTheLight) {
  // On the rectangle of 1.5 m2, straight down, at 60 degrees and up; and below it.
  const std::string rectangle = id_of("rectangle 1.5 x 1 m");
  const std::string out = said({"emit-pdf", kScene, "--light", rectangle, "--points", "-"},
                               "101.5,-48.5,3,0,0,-5\n101.5,-48.5,3,0,1.7320508,-1\n"
                               "101.5,-48.5,3,0,0,1\n101.5,-48.5,2,0,0,-1\n");
  EXPECT_THAT(out, ContainsRegex(" 3  0 0 -5 +0\\.666667 +0\\.31831\n"));        // 1 / pi
  EXPECT_THAT(out, ContainsRegex(" 0 1\\.73205 -1 +0\\.666667 +0\\.159155\n"));  // cos 60 / pi
  EXPECT_THAT(out, ContainsRegex(" 3  0 0 1 +[0-9.]+ +0\n"));
  EXPECT_THAT(out, ContainsRegex(" 2  0 0 -1 +0 +0\n"));
  EXPECT_THAT(
      said({"emit-pdf", kScene, "--light", "1", "--point", "101.2,-51.5,3.2", "--direction",
            "0,0,1", "--json"}),
      AllOf(StartsWith("{\"pdfPositionPerM2\":[0]"), HasSubstr("\"pdfDirectionPerSr\":[0.07957")));
  // Points of a file, one with no answer.
  const Outcome bad = lucerna({"emit-pdf", kScene, "--light", rectangle, "--points", "-"},
                              "101.5,-48.5,3,0,0,0\n101.5,-48.5,3,0,0,-1\n");
  EXPECT_EQ(bad.status, 1) << bad.err;
  EXPECT_THAT(bad.out, ContainsRegex("0 0 0 .*INVALID_INPUT\n.*0 0 -1 +0\\.666667 "));
  expect_wrong_use(lucerna({"emit-pdf", kScene, "--light", "1", "--point", "0,0,0"}),
                   "no directions");
  expect_wrong_use(lucerna({"emit-pdf", kScene, "--point", "0,0,0", "--direction", "0,0,1"}),
                   "--light");
  expect_wrong_use(lucerna({"emit-pdf", kScene, "--light", "1", "--direction", "0,0,1"}),
                   "no points");
}

TEST_F(CliEmission, ApproximatePowerHasItsError) {
  // A spot of 40 cd, full light within 18 degrees, none beyond 30.  The edge, of height
  // cos 18 - cos 30 = 0.0850311, counts 1/5 if it is quartic and 1/2 in textbooks.  The difference
  // is 40 2 pi 0.3 0.0850311 lm.
  const std::string exact = said({"power", kScene, "--light", "2", "--light", "3"});
  EXPECT_THAT(exact, ContainsRegex("\n +2  spot +22\\.9862 +exact "));
  EXPECT_THAT(exact, ContainsRegex("\n +3  spot +16\\.575 +exact "));
  EXPECT_EQ(said({"power", kScene, "--light", "2", "--light", "3", "--method", "exact"}), exact);
  const std::string books =
      said({"power", kScene, "--light", "2", "--light", "3", "--method", "approximate"});
  EXPECT_THAT(books, ContainsRegex("\n +2  spot +22\\.9862 +exact "));
  EXPECT_THAT(books, ContainsRegex("\n +3  spot +22\\.9862 +6\\.41119 "));
  EXPECT_THAT(books, ContainsRegex("\nall +45\\.9723 +6\\.41119 "));
  EXPECT_THAT(said({"power", kScene, "--light", "3", "--method", "approximate", "--json"}),
              ContainsRegex("\"powerLm\":22\\.98.*\"errorLm\":6\\.41"));
  expect_wrong_use(lucerna({"power", kScene, "--method", "best"}),
                   "--method: best is not one of exact, approximate, sampled; ");
}

TEST_F(CliEmission, LightsOfEachKindHaveTheirUnits) {
  const std::string out = said({"lights", kScene});
  const auto row = [](const std::string& what, const std::string& where, const std::string& rest) {
    return ContainsRegex("\n *[0-9]+  " + what + " +" + where + " +" + rest + " +lights/every");
  };
  EXPECT_THAT(out, row("point +7\\.05926 cd \\(RGB 12 6 3\\)", "101\\.2 -51\\.5 3\\.2",
                       "88\\.7092 +exact +yes"));
  EXPECT_THAT(
      out, row("spot +half angle 30 deg, edge 12 deg, 40 cd",
               "102 -52\\.5 3\\.5 towards -0\\.4216 0\\.527 -0\\.7379", "22\\.9862 +exact +yes"));
  EXPECT_THAT(out, ContainsRegex("spot +half angle 30 deg, edge 12 deg \\(quartic\\), 40 cd "));
  EXPECT_THAT(out, ContainsRegex("spot +half angle 20 deg, hard edge, 40 cd "));
  EXPECT_THAT(out,
              row("distant +2 lx", "from 0\\.2673 -0\\.5345 0\\.8018", "\\*[0-9.]+ +exact +yes"));
  EXPECT_THAT(out, row("sun +30 deg across, 3 lx", "from -0\\.2673 -0\\.5345 0\\.8018",
                       "\\*[0-9.]+ +exact +no"));
  EXPECT_THAT(out, row("uniform infinite +0\\.5 cd/m2", "all around", "\\*[0-9.]+ +exact +no"));
  EXPECT_THAT(out, ContainsRegex("image infinite +image reference/sky\\.exr \\(128 x 128 px, "
                                 "equal-area, [a-z]+\\), 0\\.5 cd/m2 at 1 +all around "));
  EXPECT_THAT(out, row("goniometric +lights/downlight\\.ies \\(IES LM-63-2002, type C, "
                       "456\\.637 lm\\)",
                       "100 -49 3 towards 0 0 -1, C0 to 1 0 0, within 90 deg of 0 0 -1",
                       "456\\.637 +exact +yes"));
  EXPECT_THAT(out, row("area +triangle, 10 cd/m2", "98 -52 3 to 99 -51 3, facing 0 0 -1",
                       "0\\.5 +15\\.708 +exact +no"));
  EXPECT_THAT(out, row("area +rectangle 1\\.5 x 1 m, 12 cd/m2",
                       "101 -49 3 to 102\\.5 -48 3, facing 0 0 -1", "1\\.5 +56\\.5487 +exact +no"));
  EXPECT_THAT(out, row("area +rectangle 1 x 0\\.5 m, 5 cd/m2, two-sided",
                       "97 -49 2 to 97 -48 2\\.5", "0\\.5 +15\\.708 +exact +no"));
  EXPECT_THAT(out, row("area +sphere of diameter 0\\.7 m, 12 cd/m2",
                       "100\\.35 -51\\.55 2\\.25 to 101\\.05 -50\\.85 2\\.95",
                       "1\\.53938 +58\\.0333 +exact +no"));
  EXPECT_THAT(out, row("area +disk of diameter 0\\.8 m, 20 cd/m2",
                       "98\\.9 -51\\.6 2\\.6 to 99\\.7 -50\\.8 2\\.6, facing 0 0 -1",
                       "0\\.502655 +31\\.5827 +exact +no"));
  EXPECT_THAT(out, row("area +cylinder of diameter 0\\.12 m, length 2 m, 14 cd/m2",
                       "99 -50\\.66 2\\.74 to 101 -50\\.54 2\\.86, along 1 0 0",
                       "0\\.753982 +33\\.1619 +exact +no"));
}

// 20 mW/sr at a distance of 2 m.
TEST_F(CliEmission, TheUnitOfTheFileIsInTheHeadings) {
  const std::vector<std::string> at = {"--point", "0,0,2", "--normal", "0,0,-1", "--bounces", "0"};
  const auto irradiance = [&](const std::string& scene, std::vector<std::string> more = {}) {
    std::vector<std::string> words = {"irradiance", "luminaires/" + scene};
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
  EXPECT_THAT(
      said({"irradiance", "reference/point.pbrt", "--point", "1.2,-1.5,0", "--normal", "0,0,1"}),
      HasSubstr("illuminance [lx]"));
}

}  // namespace
}  // namespace lucerna
