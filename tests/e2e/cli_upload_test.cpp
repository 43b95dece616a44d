// lucerna load --upload: scenes from this machine.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <filesystem>
#include <fstream>

#include "lucerna/client/testing/local_server.h"
#include "lucerna/client/upload.h"
#include "tests/e2e/run_program.h"
#include "tests/paths.h"
#include "tests/temp_directory.h"

namespace lucerna {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::MatchesRegex;
using ::testing::Not;

class CliUpload : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(directory_ / "mine");
    fs::create_directories(directory_ / "theirs");
    for (const char* file : {"textured.pbrt", "screen.exr", "point.pbrt", "ball.ply"}) {
      fs::copy_file(fs::path(test_data("reference")) / file, directory_ / "mine" / file);
    }
    start();
  }
  void start(const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments{"--asset-dir", path("assets")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    server_.reset();
    auto server =
        testing::LocalServer::start({.scene_root = path("theirs"), .arguments = arguments});
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = std::make_unique<testing::LocalServer>(*std::move(server));
  }

  Outcome lucerna(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), build_path("bin/lucerna"));
    return run_program(std::move(arguments), {}, {{"LUCERNA_SERVER", server_->target()}});
  }
  std::string path(const std::string& name) const { return (directory_ / name).string(); }

  const TempDirectory temporary_;  // outlives the servers
  const fs::path directory_ = temporary_.path();
  std::unique_ptr<testing::LocalServer> server_;
};

TEST_F(CliUpload, GltfScenesBringTheirBuffers) {
  const std::string room = test_data("gltf/room.gltf");
  const Outcome loaded = lucerna({"load", "--upload", room});
  ASSERT_EQ(loaded.status, 0) << loaded.err;
  EXPECT_THAT(lucerna({"lights", "room.gltf"}).out, HasSubstr("room.gltf#/nodes/4"));
  const Outcome lux =
      lucerna({"irradiance", "room.gltf", "--point", "2.5,0,2.5", "--normal", "0,1,0"});
  EXPECT_EQ(lux.status, 0) << lux.err;
  // The folder of the server has no file of this name, and a broken file changes nothing.
  std::ofstream(directory_ / "mine" / "broken.gltf") << "{\"asset\": {\"version\": \"1.0\"}}";
  const Outcome broken = lucerna({"load", "--upload", path("mine/broken.gltf")});
  EXPECT_EQ(broken.status, 1);
  EXPECT_THAT(broken.err, HasSubstr("broken.gltf#/asset/version: found \"1.0\""));
  EXPECT_EQ(lucerna({"lights", "room.gltf"}).status, 0);
}

TEST_F(CliUpload, BlendersLevelsBecomePhotometric) {
  const std::string room = test_data("gltf/room.gltf");
  const Outcome plain = lucerna({"load", "--upload", room});
  ASSERT_EQ(plain.status, 0) << plain.err;
  const Outcome standard = lucerna({"load", "--upload", "--blender", "standard", room});
  ASSERT_EQ(standard.status, 0) << standard.err;
  const std::string id = standard.out.substr(0, 64);
  EXPECT_NE(plain.out.substr(0, 64), id);
  // The panel of the file has 731.236 cd/m2; lamps stay.
  EXPECT_THAT(lucerna({"lights", "room.gltf"}).out,
              AllOf(HasSubstr(" 499434 cd/m2"), HasSubstr(" 300 lx"), HasSubstr(" 90 cd ")));
  EXPECT_THAT(lucerna({"scene", id}).out,
              HasSubstr("\nlight levels: lamps times 1, suns times 1, emission times 683\n"));
  EXPECT_THAT(lucerna({"scene", plain.out.substr(0, 64)}).out, Not(HasSubstr("light levels")));
  EXPECT_THAT(lucerna({"inspect", "--upload", "--blender", "standard", room}).out,
              ContainsRegex("\nlight levels .*emission times 683"));

  fs::copy(test_data("gltf"), path("theirs"));
  const Outcome half =
      lucerna({"load", "--blender", "unitless", "--lumens-per-watt", "0.5", "room.gltf"});
  ASSERT_EQ(half.status, 0) << half.err;
  EXPECT_THAT(lucerna({"lights", half.out.substr(0, 64)}).out,
              AllOf(HasSubstr(" 365.618 cd/m2"), HasSubstr(" 150 lx"), HasSubstr(" 45 cd ")));
}

TEST_F(CliUpload, QueriesAndJobsLoadWithBlendersLevels) {
  const std::string room = test_data("gltf/room.gltf");
  const auto id_with = [&](const std::string& mode) {
    return lucerna({"load", "--upload", "--blender", mode, room}).out.substr(0, 64);
  };
  const std::string standard = id_with("standard"), raw = id_with("raw");
  const auto lux = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "irradiance");
    arguments.insert(arguments.end(), {"--point", "2.5,0,2.5", "--normal", "0,1,0", "--seed", "1"});
    const Outcome outcome = lucerna(arguments);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    const std::size_t row = outcome.out.find('\n') + 1;  // the lines below it have times and names
    return outcome.out.substr(row, outcome.out.find('\n', row) - row);
  };
  EXPECT_NE(lux({standard}), lux({raw}));
  EXPECT_EQ(lux({"--blender", "standard", "room.gltf"}), lux({standard}));
  EXPECT_EQ(lux({"--blender", "raw", "room.gltf"}), lux({raw}));
  const Outcome both =
      lucerna({"irradiance", "--blender", "raw", raw, "--point", "0,0,0", "--normal", "0,1,0"});
  EXPECT_EQ(both.status, 2);
  EXPECT_THAT(both.err, HasSubstr("--blender requires the path of a file"));

  std::ofstream(directory_ / "points.csv") << "x,y,z,nx,ny,nz\n2.5,0,2.5,0,1,0\n";
  const auto rows = [&](std::vector<std::string> arguments) {
    fs::remove(directory_ / "lux.csv");
    arguments.insert(arguments.begin(), "irradiance");
    arguments.insert(arguments.end(),
                     {"--points", path("points.csv"), "-o", path("lux.csv"), "--seed", "1"});
    const Outcome outcome = lucerna(arguments);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    std::ifstream file(directory_ / "lux.csv");
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  const std::string of_raw = rows({raw});
  EXPECT_NE(of_raw, rows({standard}));
  EXPECT_EQ(of_raw, rows({"--blender", "raw", "--upload", room}));
  EXPECT_EQ(of_raw, rows({"--blender", "raw", "--servers", server_->target(), "room.gltf"}));
}

TEST_F(CliUpload, WrongOptionsAboutBlenderAreRefused) {
  const auto use = [&](std::vector<std::string> arguments, const std::string& what) {
    arguments.insert(arguments.begin(), "load");
    const Outcome outcome = lucerna(arguments);
    EXPECT_EQ(outcome.status, 2) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(what));
  };
  use({"--blender", "spec", "room.glb"}, "spec is not one of standard, unitless, raw");
  use({"--lumens-per-watt", "100", "room.glb"}, "--lumens-per-watt requires --blender");
  for (const char* value : {"0", "-1", "nan", "1000001"})
    use({"--blender", "raw", "--lumens-per-watt", value, "room.glb"},
        std::string(value) + " is not a number above 0, at most 1000000");
  const Outcome pbrt =
      lucerna({"load", "--upload", "--blender", "standard", path("mine/point.pbrt")});
  EXPECT_EQ(pbrt.status, 1);
  EXPECT_THAT(pbrt.err, HasSubstr("blender = BLENDER_LIGHTING_MODE_STANDARD for \"point.pbrt\", "
                                  "allowed: only for .gltf and .glb files"));
}

TEST_F(CliUpload, LoadsFilesThatTheServerDoesNotHave) {
  EXPECT_EQ(lucerna({"load", "textured.pbrt"}).status, 1);
  const Outcome first = lucerna({"load", "--upload", path("mine/textured.pbrt")});
  ASSERT_EQ(first.status, 0) << first.err;
  EXPECT_THAT(first.out, MatchesRegex("[0-9a-f]+  loaded in [^\n]* s\n"));
  EXPECT_THAT(first.err, IsEmpty());  // no progress bar without a terminal
  const Outcome again = lucerna({"load", "--upload", path("mine/textured.pbrt")});
  EXPECT_THAT(again.out, HasSubstr("was loaded already"));
  const Outcome scenes = lucerna({"scenes"});
  EXPECT_THAT(scenes.out, HasSubstr("textured.pbrt"));
  // Its name on the server is enough.
  EXPECT_EQ(lucerna({"lights", "textured.pbrt"}).status, 0);
  EXPECT_THAT(lucerna({"lights", "none.pbrt"}).err, HasSubstr("--upload"));
  // The same files give the same id on any machine.
  fs::copy(path("mine"), path("theirs"));
  const Outcome local = lucerna({"load", "textured.pbrt"});
  EXPECT_EQ(local.out.substr(0, 64), first.out.substr(0, 64));
  EXPECT_THAT(local.out, HasSubstr("was loaded already"));
}

TEST_F(CliUpload, MissingFilesAreErrorsOfTheScene) {
  fs::remove(directory_ / "mine/screen.exr");
  const Outcome outcome = lucerna({"load", "--upload", path("mine/textured.pbrt")});
  EXPECT_EQ(outcome.status, 1);
  EXPECT_THAT(outcome.err, HasSubstr("textured.pbrt:"));
  EXPECT_THAT(outcome.err, HasSubstr("file \"screen.exr\" does not exist"));
  const Outcome none = lucerna({"load", "--upload", path("mine/none.pbrt")});
  EXPECT_EQ(none.status, 2);
  EXPECT_THAT(none.err, HasSubstr("none.pbrt: no such file"));
  EXPECT_THAT(none.err, Not(HasSubstr("the server reported")));
  const Outcome flags = lucerna({"load", "--asset-root", path("mine"), "point.pbrt"});
  EXPECT_EQ(flags.status, 2);
  EXPECT_THAT(flags.err, HasSubstr("--asset-root requires --upload"));
}

TEST_F(CliUpload, SendsFilesOutsideOfTheFolderOnlyWithAssetRoot) {
  fs::create_directories(directory_ / "mine/scenes");
  std::ofstream(path("mine/scenes/room.pbrt"))
      << "WorldBegin\nShape \"plymesh\" \"string filename\" \"../ball.ply\"\n";
  const std::string room = path("mine/scenes/room.pbrt");
  const Outcome narrow = lucerna({"load", "--upload", room});
  EXPECT_EQ(narrow.status, 1);
  EXPECT_THAT(narrow.err, HasSubstr("leaves the scene root"));
  const Outcome wide = lucerna({"load", "--upload", room, "--asset-root", path("mine")});
  EXPECT_EQ(wide.status, 0) << wide.err;
}

TEST_F(CliUpload, LeasesArePrintedRenewedAndEnded) {
  const Outcome loaded = lucerna({"load", "--upload", path("mine/point.pbrt"), "--lease", "86400"});
  ASSERT_EQ(loaded.status, 0) << loaded.err;
  const std::string id = loaded.out.substr(0, 64);
  const std::size_t at = loaded.out.find("lease ");
  ASSERT_NE(at, std::string::npos) << loaded.out;
  const std::string lease = loaded.out.substr(at + 6, 32);
  // The time that is left, in the column before the path.
  const std::string scenes = lucerna({"scenes"}).out;
  EXPECT_THAT(scenes, ContainsRegex(id + ".* [1-9][0-9]* +point.pbrt"));
  EXPECT_THAT(lucerna({"lease", id, "--for", "72000", "--id", lease}).out,
              HasSubstr(lease + " for 72000 s"));
  const Outcome refused = lucerna({"release", id});
  EXPECT_EQ(refused.status, 1);
  EXPECT_THAT(refused.err, HasSubstr("leased for another"));
  const Outcome another = lucerna({"lease", id, "--for", "86400"});
  EXPECT_EQ(another.status, 0) << another.err;
  EXPECT_THAT(lucerna({"release", id, "--lease", lease}).out, HasSubstr("others keep it"));
  EXPECT_THAT(lucerna({"release", id, "--lease", another.out.substr(6, 32)}).out,
              HasSubstr("released"));
  EXPECT_EQ(lucerna({"lease", id, "--for", "0"}).status, 2);
}

TEST_F(CliUpload, TheServersLimitsArePrintedAndEnforced) {
  start({"--max-asset-bytes", "1KiB", "--asset-budget", "1MiB", "--memory-budget", "64MiB"});
  const Outcome info = lucerna({"info"});
  EXPECT_THAT(info.out, HasSubstr("1024 bytes"));
  EXPECT_THAT(info.out, HasSubstr("1048576 bytes"));
  EXPECT_THAT(info.out, HasSubstr("67108864 bytes"));
  const Outcome refused = lucerna({"load", "--upload", path("mine/point.pbrt")});
  EXPECT_EQ(refused.status, 1);
  EXPECT_THAT(refused.err, HasSubstr("header.size_bytes"));
}

TEST_F(CliUpload, ARestartedServerStillHasTheFiles) {
  ASSERT_EQ(lucerna({"load", "--upload", path("mine/textured.pbrt")}).status, 0);
  const int process = server_->process_id();
  ASSERT_EQ(::kill(process, SIGKILL), 0);
  start();
  std::vector<std::string> sent;
  const auto loaded = client::upload_scene(
      server_->client(), path("mine/textured.pbrt"),
      {.progress = [&](const client::UploadProgress& p) { sent.push_back(p.name); }});
  ASSERT_TRUE(loaded.ok()) << loaded.status();
  EXPECT_FALSE(loaded->already_loaded());
  EXPECT_THAT(sent, IsEmpty());
}

TEST_F(CliUpload, AStoppedUploadIsResumed) {
  // A picture of 24 MB that no scene can read; only the upload matters.
  std::string bytes(24 << 20, '\0');
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<char>(i * i >> 7);
  std::ofstream(path("mine/big.pbrt"), std::ios::binary) << bytes;
  std::stop_source stop;
  const auto stopped = client::upload_scene(server_->client(), path("mine/big.pbrt"),
                                            {.progress =
                                                 [&](const client::UploadProgress& p) {
                                                   if (p.sent_bytes >= 16 << 20)
                                                     stop.request_stop();
                                                 }},
                                            {.stop = stop.get_token()});
  EXPECT_EQ(stopped.status().code(), absl::StatusCode::kCancelled) << stopped.status();
  std::uint64_t first = 0, calls = 0;
  const auto loaded = client::upload_scene(server_->client(), path("mine/big.pbrt"),
                                           {.progress = [&](const client::UploadProgress& p) {
                                             if (calls++ == 0) first = p.sent_bytes;
                                           }});
  EXPECT_EQ(loaded.status().code(), absl::StatusCode::kInvalidArgument) << loaded.status();
  EXPECT_THAT(std::string(loaded.status().message()), HasSubstr("big.pbrt:1:1"));
  EXPECT_GT(first, 0U);
}

}  // namespace
}  // namespace lucerna
