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

TEST_F(Cli, PrintsItsVersion) {
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
  expect_wrong_use(lucerna({}), "a command is required");
  expect_wrong_use(lucerna({"frobnicate"}), "frobnicate");
  expect_wrong_use(lucerna({"power"}), "SCENE");
  expect_wrong_use(lucerna({"power", "point.pbrt", "--bogus"}), "--bogus");
  expect_wrong_use(lucerna({"power", "point.pbrt", "--timeout", "-1"}), "--timeout");
  expect_wrong_use(lucerna({"power", "point.pbrt", "--light", "1.5"}), "1.5");
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
  expect_wrong_use(lucerna({"visible", "point.pbrt", "--point", "1,2,3"}), "no second points");
  expect_wrong_use(lucerna({"irradiance", "point.pbrt", "--point", "1,2,3"}), "no normals");
  expect_wrong_use(lucerna({"irradiance", "point.pbrt", "--point", "1,2,3", "--point", "2,2,3",
                            "--point", "3,2,3", "--normal", "0,0,1", "--normal", "0,0,1"}),
                   "2 times for 3 points");
}

TEST_F(Cli, ErrorsBeginWithTheNameOfTheProgram) {
  for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
           {},
           {"frobnicate"},
           {"--bogus"},
           {"power"},
           {"power", "point.pbrt", "--bogus"},
           {"power", "point.pbrt", "--timeout", "-1"},
           {"power", "point.pbrt", "--timeout"},
           {"power", "point.pbrt", "--samples", "16", "--error", "1%"},
           {"render", "point.pbrt", "-o", "x.exr", "--floor", "1"}}) {
    const Outcome outcome = lucerna(words);
    expect_wrong_use(outcome, "");
    EXPECT_THAT(outcome.err, MatchesRegex("lucerna: [^\n]*; see lucerna[a-z ]* --help\n"));
  }
}

TEST_F(Cli, UnknownWordsAreListedAsTypedWithTheNearestKnownWord) {
  expect_wrong_use(lucerna({"rendr", "point.pbrt"}), "no command rendr; did you mean render?");
  expect_wrong_use(lucerna({"frobnicate"}), "no command frobnicate; see lucerna --help");
  expect_wrong_use(lucerna({"power", "point.pbrt", "--ligth", "1"}),
                   "unexpected: --ligth 1; did you mean --light? See lucerna power --help");
  expect_wrong_use(lucerna({"render", "point.pbrt", "--ouput=x.exr"}),
                   "unexpected: --ouput=x.exr; did you mean --output?");
  expect_wrong_use(lucerna({"scenes", "--sever", "localhost"}), "did you mean --server?");
  expect_wrong_use(lucerna({"power", "point.pbrt", "one", "two", "three"}),
                   "unexpected: one two three; see");
}

TEST_F(Cli, ErrorsAreJsonUnderJson) {
  const auto error = [](const Outcome& outcome) {
    return nlohmann::json::parse(outcome.err)["error"];
  };
  Outcome outcome = lucerna({"power", "missing.pbrt", "--json"});
  EXPECT_EQ(outcome.status, 1);
  EXPECT_EQ(error(outcome)["code"], "NOT_FOUND");
  EXPECT_THAT(error(outcome)["message"], HasSubstr("missing.pbrt"));
  ASSERT_GT(error(outcome)["details"].size(), 0U);
  EXPECT_THAT(error(outcome)["details"][0]["@type"], HasSubstr("google.rpc."));
  EXPECT_EQ(outcome.err.find('\n'), outcome.err.size() - 1);
  outcome = lucerna({"irradiance", "point.pbrt", "--point", "0,0,0", "--normal", "0,0,1",
                     "--samples", "1048577", "--json"});
  EXPECT_EQ(outcome.status, 1);
  EXPECT_EQ(error(outcome)["code"], "INVALID_ARGUMENT");
  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{{"--json", "power"},
                                             {"power", "point.pbrt", "--bogus", "--json"},
                                             {"sample", "point.pbrt", "--json"}}) {
    outcome = lucerna(words);
    EXPECT_EQ(outcome.status, 2);
    EXPECT_EQ(error(outcome)["code"], "INVALID_ARGUMENT");
  }
  outcome = lucerna({"scenes", "--server", "127.0.0.1:1", "--json"});
  EXPECT_EQ(error(outcome)["code"], "UNAVAILABLE");
}

TEST_F(Cli, SizesAndNumbersBelowTheirLeastAreRefused) {
  expect_wrong_use(lucerna({"render", "point.pbrt", "-o", "x.exr", "--tile-size", "-1"}),
                   "--tile-size: -1 is not a whole number from 1");
  expect_wrong_use(lucerna({"render", "point.pbrt", "-o", "x.exr", "--bounces", "-1"}),
                   "--bounces: -1 is not a whole number from 0");
  expect_wrong_use(
      lucerna({"render", "point.pbrt", "-o", "x.exr", "--servers", "a", "--split-samples", "-1"}),
      "--split-samples: -1 is not a whole number from 1");
  expect_wrong_use(lucerna({"emit", "point.pbrt", "--count", "-1"}),
                   "--count: -1 is not a whole number from 1");
  expect_wrong_use(lucerna({"load", "point.pbrt", "--lease", "-1"}),
                   "-1 is not a finite number above 0");
}

TEST_F(Cli, UnmodelledFeaturesAreCountedBesideAnswers) {
  std::ofstream(path("scenes/empty.ply"))
      << "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\n"
         "property float z\nelement face 0\nproperty list uchar int vertex_indices\nend_header\n";
  const std::string empty = "Shape \"plymesh\" \"string filename\" \"empty.ply\"\n";
  std::ofstream(path("scenes/odd.pbrt")) << "WorldBegin\nLightSource \"point\"\n" + empty + empty +
                                                "Material \"hair\"\nShape \"disk\"\n";
  const std::string counted =
      "2 surfaces left out, 1 material taken as diffuse: lucerna scene odd.pbrt --remarks\n";
  const std::vector<std::string> first = {"irradiance", "odd.pbrt", "--point",   "0,0,1",
                                          "--normal",   "0,0,1",    "--bounces", "0"};
  const Outcome new_scene = lucerna(first);
  EXPECT_EQ(new_scene.status, 0);
  EXPECT_THAT(new_scene.out, ::testing::EndsWith("\n" + counted));
  EXPECT_THAT(new_scene.err, HasSubstr("mesh \"empty.ply\" is empty; left out\n"));
  const Outcome known_scene = lucerna(first);
  EXPECT_THAT(known_scene.out, ::testing::EndsWith("\n" + counted));
  EXPECT_EQ(known_scene.err, "");
  const Outcome picture = lucerna({"render", "odd.pbrt", "-o", path("odd.pfm"), "--samples", "1"});
  EXPECT_THAT(picture.out, ::testing::EndsWith("\n" + counted));
  std::ofstream(path("odd.csv")) << "0,0,1,0,0,1\n";
  EXPECT_THAT(
      lucerna({"irradiance", "odd.pbrt", "--points", path("odd.csv"), "-o", path("odd.npy")}).out,
      ::testing::EndsWith("\n" + counted));
  for (const char* file : {"odd.csv", "odd.npy", "odd.pfm"}) fs::remove(path(file));
  EXPECT_THAT(lucerna({"power", "odd.pbrt"}).out, ::testing::EndsWith("\n" + counted));
  EXPECT_THAT(lucerna({"lights", "odd.pbrt"}).out, ::testing::EndsWith("\n" + counted));
  EXPECT_THAT(lucerna({"power", "odd.pbrt", "--json"}).out, ::testing::Not(HasSubstr("left out")));

  const Outcome remarks = lucerna({"scene", "odd.pbrt", "--remarks"});
  EXPECT_EQ(remarks.status, 0);
  // Two of the three are equal.
  EXPECT_EQ(std::count(remarks.out.begin(), remarks.out.end(), '\n'), 2) << remarks.out;
  EXPECT_THAT(remarks.out, HasSubstr("odd.pbrt:3:17 and 1 more place: mesh \"empty.ply\""));
  EXPECT_THAT(remarks.out, HasSubstr("odd.pbrt:5:1: material \"hair\" is not modelled; "));
  EXPECT_EQ(lucerna({"scene", "point.pbrt", "--remarks"}).out, "");

  const std::string id =
      nlohmann::json::parse(lucerna({"load", "odd.pbrt", "--json"}).out)["sceneId"];
  EXPECT_THAT(lucerna({"power", id}).out,
              HasSubstr("diffuse: lucerna scene " + id.substr(0, 12) + " --remarks\n"));
  for (const std::string& name : {std::string("odd.pbrt"), id, id.substr(0, 5)}) {
    const Outcome strict = lucerna({"--strict", "power", name});
    expect_no(strict, "not modelled (--strict): 2 surfaces left out, 1 material");
    EXPECT_EQ(strict.out, "");
    EXPECT_EQ(lucerna({"--strict", "power", name, "--json"}).status, 1);
  }
  EXPECT_EQ(lucerna({"--strict", "load", "odd.pbrt"}).status, 1);
  EXPECT_EQ(lucerna({"--strict", "power", "point.pbrt"}).status, 0);
  expect_no(lucerna({"--strict", "render", "odd.pbrt", "-o", path("odd.pfm"), "--servers",
                     server_->target()}),
            "not modelled (--strict): 2 surfaces left out");
  EXPECT_FALSE(fs::exists(path("odd.pfm")));
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

TEST_F(Cli, AnAbsentServerIsReportedWithTheCommandThatStartsOne) {
  // No program listens on port 1 (tcpmux).
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
  expect_no(lucerna({"power", id.substr(0, 12)}),
            "no loaded scene has an id that begins with these digits");
  expect_no(lucerna({"power", id.substr(0, 3)}),
            "the first digits of a scene id must be 4 or more, these are 3");
}

TEST_F(Cli, AvailableScenesAreTheFilesUnderTheRoot) {
  const Outcome outcome = lucerna({"scenes", "--available"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, ContainsRegex("(^|\n)point\\.pbrt\n(.*\n)*sphere\\.pbrt\n"));
  EXPECT_THAT(outcome.out, ContainsRegex("\n[0-9]+ files under /.*/scenes\n$"));
  const auto json = nlohmann::json::parse(lucerna({"scenes", "--available", "--json"}).out);
  EXPECT_GT(json["paths"].size(), 5U);
}

TEST_F(Cli, ScenePrintsTheBuiltPartsAndTheirReasons) {
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

TEST_F(Cli, ScenesThatCannotBeLoadedAreServerErrors) {
  expect_no(lucerna({"load", "missing.pbrt"}), "not_found");
  expect_no(lucerna({"load", "../secret.pbrt"}), "the server reported");
  expect_no(lucerna({"load", "/etc/passwd"}), "the server reported");
  expect_no(lucerna({"power", "broken.pbrt"}), "broken.pbrt:2:");
  EXPECT_EQ(lucerna({"scenes"}).status, 0);
}

TEST_F(Cli, JsonIsTheAnswersMessage) {
  const Outcome outcome = lucerna({"irradiance", "point.pbrt", "--point", "1.2,-1.5,0", "--normal",
                                   "0,0,1", "--bounces", "0", "--json"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, AllOf(StartsWith("{\"irradianceLx\":["),
                                 ContainsRegex("\"illuminanceLx\":\\[0\\.97656[0-9]*\\]")));
  EXPECT_THAT(lucerna({"--json", "power", "point.pbrt"}).out,
              ContainsRegex("\"powerLm\":125\\.6637"));
  EXPECT_THAT(lucerna({"info", "--json"}).out, HasSubstr("\"maxBatchItems\":"));
  EXPECT_THAT(lucerna({"lights", "point.pbrt", "--json"}).out,
              HasSubstr("\"intensityCd\":{\"r\":10"));
  EXPECT_THAT(lucerna({"scenes", "--json"}).out, StartsWith("{\"scenes\":["));
}

}  // namespace
}  // namespace lucerna
