// lucerna render --frames: an animation on one server and on two.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <set>

#include "lucerna/client/picture.h"
#include "lucerna/client/testing/local_server.h"
#include "tests/e2e/run_program.h"
#include "tests/paths.h"
#include "tests/temp_directory.h"

namespace lucerna {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

std::string bytes(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Two servers with moving.pbrt, whose camera and light move, and with mine.1.pbrt to mine.4.pbrt.
/// These four are the same scene with the shutter of each frame at four frames a second.
class Frames : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(directory_ / "scenes");
    const std::string scene = bytes(test_data("pbrt/moving_both.pbrt"));
    std::ofstream(directory_ / "scenes/moving.pbrt") << scene;
    const std::string shutter = "\"float shutteropen\" [0] \"float shutterclose\" [0.125]";
    const std::size_t at = scene.find(shutter);
    ASSERT_NE(at, std::string::npos);
    for (int n = 1; n <= 4; ++n) {
      const double open_s = 0.25 * (n - 1);
      std::string own = scene;
      own.replace(at, shutter.size(),
                  "\"float shutteropen\" [" + std::to_string(open_s) +
                      "] \"float shutterclose\" [" + std::to_string(open_s + 0.125) + "]");
      std::ofstream(directory_ / ("scenes/mine." + std::to_string(n) + ".pbrt")) << own;
    }
    for (auto& server : servers_) {
      auto started = testing::LocalServer::start({.scene_root = path("scenes"), .threads = 1});
      ASSERT_TRUE(started.ok()) << started.status();
      server = std::make_unique<testing::LocalServer>(*std::move(started));
    }
  }

  Outcome render(std::vector<std::string> arguments, const std::string& server = {}) const {
    arguments.insert(arguments.begin(), {build_path("bin/lucerna"), "render"});
    return run_program(std::move(arguments), {},
                       {{"LUCERNA_SERVER", server.empty() ? servers_[0]->target() : server}});
  }
  std::string path(const std::string& name) const { return (directory_ / name).string(); }
  std::string both() const { return servers_[0]->target() + "," + servers_[1]->target(); }
  /// The pictures NAME.1.pfm to NAME.4.pfm, each of which must exist.
  std::array<std::string, 4> pictures(const std::string& name) const {
    std::array<std::string, 4> all;
    for (std::size_t n = 0; n < 4; ++n) {
      all[n] = bytes(path(name + "." + std::to_string(n + 1) + ".pfm"));
      EXPECT_EQ(all[n].size(), std::string("PF\n24 16\n-1.0\n").size() + 24 * 16 * 12)
          << name << " " << n + 1;
    }
    return all;
  }
  std::vector<v1::SceneSummary> scenes(std::size_t server) const {
    const auto answer = servers_[server]->client().list_scenes({}).value();
    return {answer.scenes().begin(), answer.scenes().end()};
  }

  const TempDirectory temporary_;  // outlives the servers
  const fs::path directory_ = temporary_.path();
  std::array<std::unique_ptr<testing::LocalServer>, 2> servers_;
};

TEST_F(Frames, MatchStillPicturesOfTheirTimesOnAnyServers) {
  const Outcome one =
      render({"moving.pbrt", "--frames", "1-4", "--fps", "4", "-o", path("one.%d.pfm")});
  ASSERT_EQ(one.status, 0) << one.err;
  EXPECT_EQ(std::count(one.out.begin(), one.out.end(), '\n'), 4) << one.out;
  const auto expected = pictures("one");
  EXPECT_EQ(std::set<std::string>(expected.begin(), expected.end()).size(), 4U);
  // The scene stays loaded, without a lease of this job.
  ASSERT_EQ(scenes(0).size(), 1U);
  EXPECT_EQ(scenes(0)[0].leased_s(), 0);

  const Outcome two =
      render({"moving.pbrt", "--frames", "1-4", "--fps", "4", "-o", path("two.%d.pfm"), "--servers",
              both(), "--tile-size", "8", "--split-samples", "4"});
  ASSERT_EQ(two.status, 0) << two.err;
  EXPECT_EQ(pictures("two"), expected);
  for (int n = 1; n <= 4; ++n) {
    const std::string number = std::to_string(n);
    // One frame at a time, as an array of jobs renders them.
    const Outcome alone =
        render({"moving.pbrt", "--frames", number, "--fps", "4", "-o", path("alone.%d.pfm")});
    ASSERT_EQ(alone.status, 0) << alone.err;
    // Also as the still picture of a file with that shutter.
    const Outcome plain =
        render({"mine." + number + ".pbrt", "-o", path("plain." + number + ".pfm")});
    ASSERT_EQ(plain.status, 0) << plain.err;
  }
  EXPECT_EQ(pictures("alone"), expected);
  EXPECT_EQ(pictures("plain"), expected);
  // At 8 frames a second every fourth frame is half a second apart: frame 5 has the time of frame 3
  // at 4 frames a second.
  const Outcome steps =
      render({"moving.pbrt", "--frames", "1-9:4", "--fps", "8", "-o", path("steps.%02d.pfm")});
  ASSERT_EQ(steps.status, 0) << steps.err;
  EXPECT_EQ(bytes(path("steps.01.pfm")), expected[0]);
  EXPECT_EQ(bytes(path("steps.05.pfm")), expected[2]);
  EXPECT_TRUE(fs::exists(path("steps.09.pfm")));
}

TEST_F(Frames, MayComeFromOneFileEach) {
  // The second scene is already loaded and stays loaded.
  v1::LoadSceneRequest load;
  load.set_path("mine.2.pbrt");
  const std::string second = servers_[0]->client().load_scene(load).value().scene_id();
  for (int n = 1; n <= 4; ++n) {
    const std::string number = std::to_string(n);
    ASSERT_EQ(render({"moving.pbrt", "--frames", number, "--fps", "4", "-o", path("one.%d.pfm")},
                     servers_[1]->target())
                  .status,
              0);
  }
  const auto expected = pictures("one");
  const Outcome here = render({"mine.%d.pbrt", "--frames", "1-4", "-o", path("here.%d.pfm")});
  ASSERT_EQ(here.status, 0) << here.err;
  EXPECT_EQ(pictures("here"), expected);
  ASSERT_EQ(scenes(0).size(), 1U);
  EXPECT_EQ(scenes(0)[0].scene_id(), second);

  const Outcome many = render({"mine.%d.pbrt", "--frames", "1-4", "-o", path("many.%d.pfm"),
                               "--servers", both(), "--tile-size", "8"});
  ASSERT_EQ(many.status, 0) << many.err;
  EXPECT_EQ(pictures("many"), expected);
  ASSERT_EQ(scenes(0).size(), 1U);
  ASSERT_EQ(scenes(1).size(), 1U);  // moving.pbrt
  EXPECT_EQ(scenes(1)[0].path(), "moving.pbrt");

  fs::create_directories(directory_ / "away");
  for (int n = 1; n <= 4; ++n) {
    const std::string name = "mine." + std::to_string(n) + ".pbrt";
    fs::rename(directory_ / "scenes" / name, directory_ / "away" / name);
  }
  const Outcome uploaded = render({path("away/mine.%d.pbrt"), "--frames", "1-4", "-o",
                                   path("up.%d.pfm"), "--servers", both(), "--upload"});
  ASSERT_EQ(uploaded.status, 0) << uploaded.err;
  EXPECT_EQ(pictures("up"), expected);
  EXPECT_EQ(scenes(0).size(), 1U);
  EXPECT_EQ(scenes(1).size(), 1U);
}

TEST_F(Frames, ResumeAfterAnInterruption) {
  fs::rename(path("scenes/mine.3.pbrt"), path("late.pbrt"));
  const std::vector<std::string> all{"mine.%d.pbrt",
                                     "--frames",
                                     "1-4",
                                     "-o",
                                     path("go.%d.pfm"),
                                     "--stderr",
                                     path("err.%d.pfm"),
                                     "--skip-existing",
                                     "--servers",
                                     both(),
                                     "--journal",
                                     path("journal.%d")};
  const Outcome first = render(all);
  EXPECT_EQ(first.status, 1);
  EXPECT_THAT(first.err, HasSubstr("file \"mine.3.pbrt\" does not exist"));
  EXPECT_TRUE(fs::exists(path("go.2.pfm")));
  EXPECT_FALSE(fs::exists(path("go.3.pfm")));
  fs::rename(path("late.pbrt"), path("scenes/mine.3.pbrt"));
  fs::remove(path("err.1.pfm"));  // incomplete, so it is rendered again
  const std::string kept = "not a picture";
  std::ofstream(path("go.2.pfm")) << kept;
  const Outcome second = render(all);
  ASSERT_EQ(second.status, 0) << second.err;
  EXPECT_THAT(second.out, HasSubstr("go.2.pfm: exists already\n"));
  EXPECT_THAT(second.out, Not(HasSubstr("go.1.pfm: exists already\n")));
  EXPECT_EQ(std::count(second.out.begin(), second.out.end(), '\n'), 4) << second.out;
  EXPECT_EQ(bytes(path("go.2.pfm")), kept);
  for (int n = 1; n <= 4; ++n) {
    EXPECT_TRUE(fs::exists(path("err." + std::to_string(n) + ".pfm")));
    EXPECT_FALSE(fs::exists(path("journal." + std::to_string(n))));
  }
  // Without the flag every frame is rendered again.
  const Outcome third =
      render({"moving.pbrt", "--frames", "2", "--fps", "4", "-o", path("go.%d.pfm"), "--json"});
  ASSERT_EQ(third.status, 0) << third.err;
  EXPECT_THAT(third.out, HasSubstr("samplesTotal"));
  EXPECT_NE(bytes(path("go.2.pfm")), kept);
}

TEST_F(Frames, FollowTheTimeAndShutterOptions) {
  const auto run = [&](std::vector<std::string> arguments, const std::string& name) {
    arguments.insert(arguments.begin(), "moving.pbrt");
    arguments.insert(arguments.end(), {"-o", path(name)});
    const Outcome outcome = render(std::move(arguments));
    EXPECT_EQ(outcome.status, 0) << outcome.err;
  };
  run({"--frames", "1-3", "--fps", "4", "--time", "0.125"}, "at.%d.pfm");
  run({"--time", "0.625"}, "alone.pfm");
  EXPECT_EQ(bytes(path("at.3.pfm")), bytes(path("alone.pfm")));
  EXPECT_NE(bytes(path("at.3.pfm")), bytes(path("at.1.pfm")));
  run({"--frames", "3", "--fps", "4", "--shutter", "0.5"}, "long.%d.pfm");
  v1::LoadSceneRequest load;
  load.set_path("moving.pbrt");
  v1::RenderImageRequest request;
  request.set_scene_id(servers_[0]->client().load_scene(load).value().scene_id());
  request.set_final_only(true);
  request.set_one_sequence(true);  // as the program without files of errors
  request.mutable_shutter()->set_offset_s(0.5);
  request.mutable_shutter()->set_length_s(0.5);
  client::PictureAssembler picture;
  ASSERT_TRUE(servers_[0]
                  ->client()
                  .render_image(request,
                                [&](const v1::RenderImageResponse& response) {
                                  EXPECT_TRUE(picture.add(response.tile()).ok());
                                  return true;
                                })
                  .ok());
  // PFM stores its rows from the bottom up.
  const std::string file = bytes(path("long.3.pfm"));
  const auto pixels = picture.picture().value().pixels;
  const std::size_t row = 24 * 3 * sizeof(float), header = file.size() - 16 * row;
  for (std::size_t y = 0; y < 16; ++y)
    EXPECT_TRUE(file.substr(header + (15 - y) * row, row) ==
                std::string(reinterpret_cast<const char*>(pixels.data()) + y * row, row))
        << "row " << y;
}

TEST_F(Frames, WrongOptionsAreRefusedBeforeAnyCall) {
  const auto before = std::distance(fs::directory_iterator(directory_), {});
  const auto wrong = [&](std::vector<std::string> arguments, const std::string& what) {
    arguments.insert(arguments.begin(), {"--server", "127.0.0.1:1"});  // no server is called
    const Outcome outcome = render(std::move(arguments));
    EXPECT_EQ(outcome.status, 2) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(what));
    EXPECT_EQ(outcome.out, "");
  };
  const std::string out = path("a.%d.pfm");
  wrong({"m.pbrt", "--frames", "4-1", "-o", out}, "--frames: \"4-1\" ends before it begins");
  wrong({"m.pbrt", "--frames", "1-4", "-o", path("a.pfm")}, "has no place for the frame's number");
  wrong({"m.pbrt", "--frames", "1-4", "-o", path("%d.%d.pfm")}, "has 2 places");
  wrong({"m.pbrt", "--frames", "1-4", "-o", path("%x.pfm")}, "\"%x.p\"");
  wrong({"m.pbrt", "--frames", "1-4", "-o", path("a.%d.jpg")}, "must be .exr, .png or .pfm");
  wrong({"m.pbrt", "--frames", "1-4", "-o", path("no/a.%d.pfm")}, "No such file or directory");
  wrong({"m.pbrt", "--frames", "1-4", "-o", path("%d/a.pfm")}, "No such file or directory");
  wrong({"m.pbrt", "--frames", "1-4", "-o", out, "--stderr", path("b.pfm")}, "--stderr: ");
  wrong({"m.pbrt", "--frames", "1-4", "-o", out, "--stderr", path("a.%01d.pfm")},
        "frame 1 would write");
  wrong({"m.pbrt", "--frames", "1-11", "-o", out, "-o", path("a.1%d.pfm")},
        "frames 1 and 11 would both write");
  wrong({"%d.%s.pbrt", "--frames", "1-4", "-o", out}, "SCENE: ");
  wrong({"%d.pbrt", "--frames", "1-4", "-o", out, "--fps", "24"}, "has its own shutter");
  wrong({"%d.pbrt", "--frames", "1-4", "-o", out, "--shutter", "1"}, "has its own shutter");
  wrong({"m.pbrt", "--frames", "1-4", "-o", out, "--fps", "0"}, "0 is not a finite number above 0");
  wrong({"m.pbrt", "--frames", "1-4", "-o", out, "--fps", "-24"}, "is not a finite number above 0");
  wrong({"m.pbrt", "--frames", "1-4", "-o", out, "--shutter", "1", "--time", "0"},
        "a moment has no length");
  wrong({"m.pbrt", "--frames", "1-4", "-o", out, "--servers", "a:1", "--journal", path("j")},
        "--journal: ");
  wrong({"m.pbrt", "--frames", "1-4", "-o", out, "--journal", path("j%d")},
        "--journal requires --servers");
  wrong({"m.pbrt", "--frames", "1-4", "-o", path("a.%d.png"), "--preview=1", "--skip-existing"},
        "a preview would count as a finished picture");
  wrong({"m.pbrt", "-o", out, "--fps", "24"}, "--fps requires --frames");
  wrong({"m.pbrt", "-o", out, "--shutter", "1"}, "--shutter requires --frames");
  wrong({"m.pbrt", "-o", out, "--skip-existing"}, "--skip-existing requires --frames");
  EXPECT_EQ(std::distance(fs::directory_iterator(directory_), {}), before);
}

}  // namespace
}  // namespace lucerna
