// The program lucerna: help, wrong use, scenes, JSON.
#include <nlohmann/json.hpp>

#include "tests/e2e/cli_fixture.h"

namespace lucerna {
namespace {

using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::MatchesRegex;
using ::testing::StartsWith;

TEST_F(Cli, TellsItsVersion) {
  const Outcome outcome = lucerna({"--version"});
  EXPECT_EQ(outcome.status, 0);
  EXPECT_THAT(outcome.out, MatchesRegex("lucerna [0-9]+\\.[0-9]+\\.[0-9]+\n"));
}

TEST_F(Cli, HelpOfEachSubcommandHasAnExample) {
  for (const char* command :
       {"load", "scenes", "scene", "lights", "lease", "release", "info", "sample", "pdf", "emit",
        "emit-pdf", "le", "power", "visible", "irradiance", "render"}) {
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
                   "5000000000 is not a whole number from 1 to the server's limit (1048576");
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

TEST_F(Cli, SceneTellsWhatWasBuiltAndWhy) {
  const auto parts = [] {
    const Outcome outcome = lucerna({"scene", "point.pbrt", "--json"});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return nlohmann::json::parse(outcome.out)["parts"];
  };
  const std::size_t before = parts().size();
  ASSERT_EQ(lucerna({"irradiance", "point.pbrt", "--point", "1.2,-1.5,0", "--normal", "0,0,1",
                     "--bounces", "0", "--visibility", "shadow-maps"})
                .status,
            0);
  const auto after = parts();
  EXPECT_GT(after.size(), before);
  const Outcome outcome = lucerna({"scene", "point.pbrt"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out,
              AllOf(MatchesRegex("[0-9a-f]+  point\\.pbrt: 1 lights, [0-9]+ "
                                 "primitives, [0-9]+ kB\n(.|\n)*"),
                    ContainsRegex("\npart +memory \\[kB\\] +built in \\[ms\\] +why\n")));
  for (const auto& part : after) {
    const auto name = part["name"].get<std::string>(), why = part["why"].get<std::string>();
    EXPECT_THAT(outcome.out, ContainsRegex("\n" + name + " +[0-9.]+ +[-0-9.e+]+ +")) << name;
    EXPECT_THAT(outcome.out, HasSubstr("  " + why + "\n")) << name;
  }
  expect_no(lucerna({"scene", "missing.pbrt"}), "not_found");
}

TEST_F(Cli, ScenesThatCannotBeLoadedAreTheServersNo) {
  expect_no(lucerna({"load", "missing.pbrt"}), "not_found");
  expect_no(lucerna({"load", "../secret.pbrt"}), "the server said");
  expect_no(lucerna({"load", "/etc/passwd"}), "the server said");
  expect_no(lucerna({"power", "broken.pbrt"}), "broken.pbrt:2:");
  EXPECT_EQ(lucerna({"scenes"}).status, 0);
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

}  // namespace
}  // namespace lucerna
