// lucerna edit, and edits of commands that load a file.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "lucerna/client/testing/local_server.h"
#include "tests/e2e/run_program.h"
#include "tests/paths.h"
#include "tests/temp_directory.h"

namespace lucerna {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::MatchesRegex;
using ::testing::Not;
namespace fs = std::filesystem;

constexpr char kDesk[] = R"(WorldBegin
LightSource "point" "string name" "Lamp" "rgb I" [100 100 100] "point3 from" [0 0 2]
LightSource "point" "string name" "Lamp" "rgb I" [50 50 50] "point3 from" [1 0 2]
LightSource "point" "rgb I" [25 25 25] "point3 from" [0 1 2]
Shape "bilinearmesh" "point3 P" [-4 -4 0  4 -4 0  -4 4 0  4 4 0]
)";

class CliEdit : public ::testing::Test {
 protected:
  void SetUp() override {
    std::ofstream(directory_.path() / "desk.pbrt") << kDesk;
    std::ofstream(directory_.path() / "more.pbrt")
        << "WorldBegin\nLightSource \"point\" \"string name\" \"New\" \"rgb I\" [8 8 8]\n";
    std::ofstream(directory_.path() / "points.csv") << "0,0,0,0,0,1\n1,0,0,0,0,1\n";
    for (auto& server : servers_) {
      auto started = testing::LocalServer::start({.scene_root = directory_.path().string()});
      ASSERT_TRUE(started.ok()) << started.status();
      server = std::make_unique<testing::LocalServer>(*std::move(started));
    }
  }

  Outcome lucerna(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), build_path("bin/lucerna"));
    return run_program(std::move(arguments), {}, {{"LUCERNA_SERVER", servers_[0]->target()}});
  }
  std::string path(const std::string& name) const { return (directory_.path() / name).string(); }
  std::string edit(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "edit");
    const Outcome outcome = lucerna(arguments);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return outcome.out.substr(0, 64);
  }

  const TempDirectory directory_;
  std::unique_ptr<testing::LocalServer> servers_[2];
};

TEST_F(CliEdit, MakesRevisionsByIdAndByName) {
  const Outcome made = lucerna({"edit", "desk.pbrt", "--set", "3.scale=0.5"});
  EXPECT_EQ(made.status, 0) << made.err;
  EXPECT_THAT(made.out, MatchesRegex("[0-9a-f]+  made in [^\n]* s\n"));
  const std::string id = made.out.substr(0, 64);
  EXPECT_THAT(lucerna({"lights", id}).out, HasSubstr(" 12.5 cd "));
  EXPECT_THAT(lucerna({"lights", "desk.pbrt"}).out, HasSubstr(" 25 cd "));
  const std::string off = edit({id, "--set", "Lamp.on=false", "--lease", "60"});
  EXPECT_THAT(lucerna({"lights", off}).out,
              AllOf(Not(HasSubstr(" 100 cd ")), Not(HasSubstr(" 50 cd ")), HasSubstr(" 12.5 cd ")));
  EXPECT_THAT(lucerna({"scenes"}).out, HasSubstr("desk.pbrt, 3 lights edited"));
  EXPECT_THAT(lucerna({"scene", off}).out,
              HasSubstr("\nrevision of " + lucerna({"load", "desk.pbrt"}).out.substr(0, 64)));
  const std::string moved = edit({off, "--set", "3.shift=1,2,0.5", "--remove", "Lamp"});
  EXPECT_THAT(lucerna({"lights", moved}).out,
              AllOf(HasSubstr(" 1 3 2.5 "), Not(HasSubstr("Lamp"))));
  const Outcome added = lucerna({"edit", moved, "--add", "more.pbrt"});
  EXPECT_THAT(added.out, HasSubstr("new lights: "));
  EXPECT_THAT(lucerna({"lights", added.out.substr(0, 64)}).out, HasSubstr("New"));
  // The way back.
  EXPECT_EQ(edit({id, "--set", "3.scale=1"}), lucerna({"load", "desk.pbrt"}).out.substr(0, 64));
  const Outcome json = lucerna({"edit", "--json", "desk.pbrt", "--set", "3.tint=1,0.5,0.25"});
  EXPECT_THAT(json.out, HasSubstr("\"sceneId\""));
}

TEST_F(CliEdit, QueriesAndJobsCarryEdits) {
  const std::string id = edit({"desk.pbrt", "--set", "1.scale=0.25", "--remove", "2"});
  const auto rows = [&](std::vector<std::string> arguments) {
    fs::remove(path("lux.csv"));
    arguments.insert(arguments.begin(), "irradiance");
    arguments.insert(arguments.end(), {"--points", path("points.csv"), "-o", path("lux.csv")});
    const Outcome outcome = lucerna(arguments);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    std::ifstream file(path("lux.csv"));
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  const std::string of_revision = rows({id});
  EXPECT_NE(of_revision, rows({"desk.pbrt"}));
  EXPECT_EQ(of_revision, rows({"desk.pbrt", "--set", "1.scale=0.25", "--remove", "2"}));
  // The second server has never seen the scene.
  EXPECT_EQ(of_revision, rows({"desk.pbrt", "--set", "1.scale=0.25", "--remove", "2", "--servers",
                               servers_[0]->target() + "," + servers_[1]->target()}));
}

TEST_F(CliEdit, WrongEditsSayWhatIsAllowed) {
  const auto use = [&](std::vector<std::string> arguments, const std::string& what) {
    arguments.insert(arguments.begin(), {"edit", "desk.pbrt"});
    const Outcome outcome = lucerna(arguments);
    EXPECT_EQ(outcome.status, 2) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(what));
  };
  use({}, "edit requires --set, --remove or --add");
  for (const char* text : {"3", "scale=1", ".scale=1", "3.scale"})
    use({"--set", text}, "must be LIGHT.FIELD=VALUE, such as 3.scale=0.5");
  use({"--set", "3.colour=1"}, "the field must be scale, tint, on, shift or turn");
  use({"--set", "3.scale=bright"}, "scale is a number");
  use({"--set", "3.tint=1,2"}, "tint is three numbers R,G,B");
  use({"--set", "3.on=yes"}, "on is true or false");
  use({"--set", "3.shift=1"}, "shift is three numbers X,Y,Z [m]");
  use({"--set", "3.turn=0,0,1"}, "turn is an axis and an angle X,Y,Z,DEGREES");
  const auto refused = [&](std::vector<std::string> arguments, const std::string& what) {
    arguments.insert(arguments.begin(), {"edit", "desk.pbrt"});
    const Outcome outcome = lucerna(arguments);
    EXPECT_EQ(outcome.status, 1) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(what));
  };
  refused({"--set", "Sun.scale=1"}, "the scene has no light named \"Sun\"");
  refused({"--remove", "9"}, "light_id = 9, which the scene does not have");
  refused({"--set", "3.scale=-1"}, "edits[0].change.scale = -1, allowed: [0, 1000000000]");
  refused({"--add", "none.pbrt"}, "none.pbrt");
  const Outcome by_id = lucerna({"irradiance", edit({"desk.pbrt", "--set", "1.scale=2"}), "--set",
                                 "1.scale=2", "--point", "0,0,0", "--normal", "0,0,1"});
  EXPECT_EQ(by_id.status, 2);
  EXPECT_THAT(by_id.err, HasSubstr("which lucerna edit changes"));
}

}  // namespace
}  // namespace lucerna
