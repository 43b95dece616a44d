// lucerna render --tev and --preview.
#include "tests/e2e/cli_fixture.h"
#include "tests/paths.h"
#include "tests/tev_receiver.h"
// This header removes macros that Protobuf's headers need, so it comes last.
#include <OpenImageIO/imageio.h>
#include <signal.h>

#include <algorithm>

namespace lucerna {
namespace {

using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::vector<float> pixels(const std::string& path) {
  const auto file = OIIO::ImageInput::open(path);
  if (!file) return {};
  const OIIO::ImageSpec& spec = file->spec();
  std::vector<float> result(std::size_t{3} * spec.width * spec.height);
  if (!file->read_image(0, 0, 0, 3, OIIO::TypeDesc::FLOAT, result.data())) return {};
  return result;
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (std::size_t at = 0; (at = text.find(part, at)) != std::string::npos; ++at) ++n;
  return n;
}

class CliPreview : public Cli {
 protected:
  Outcome render(std::vector<std::string> arguments) {
    if (std::find(arguments.begin(), arguments.end(), "--samples") == arguments.end()) {
      arguments.insert(arguments.end(), {"--samples", "16"});
    }
    arguments.insert(arguments.begin(), {"render", "point.pbrt", "-o", picture_});
    return lucerna(std::move(arguments));
  }
  /// 160 x 120 pixels are 6 tiles of 64 x 64.
  void expect_in(const TevReceiver& viewer, std::size_t updates) {
    const std::vector<float> expected = pixels(picture_);
    ASSERT_EQ(expected.size(), 160U * 120 * 3);
    EXPECT_TRUE(TevReceiver::wait_for([&] { return viewer.images()[picture_].rgb == expected; }));
    EXPECT_GE(viewer.images()[picture_].updates, updates);
    EXPECT_THAT(viewer.faults(), IsEmpty());
  }
  /// Ends a render of minutes by this signal when a preview exists.
  Outcome interrupt(std::vector<std::string> arguments, const std::string& preview, int signal) {
    arguments.insert(arguments.begin(), {build_path("bin/lucerna"), "render"});
    arguments.insert(arguments.end(), {"--samples", "16384", "--tile-size", "8", "--preview=0.1"});
    return run_program(std::move(arguments), {}, {{"LUCERNA_SERVER", server_->target()}},
                       [&](pid_t program) {
                         EXPECT_TRUE(TevReceiver::wait_for([&] { return fs::exists(preview); }));
                         ::kill(program, signal);
                       });
  }
  void TearDown() override { fs::remove(picture_); }

  const std::string picture_ = path("shown.exr");
};

TEST_F(CliPreview, TevGetsThePictureOfTheExrBitForBit) {
  const TevReceiver viewer;
  const Outcome outcome = render({"--tev", viewer.address(), "--samples", "64"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.err, IsEmpty());
  expect_in(viewer, 7);  // coarse tiles before the last
}

TEST_F(CliPreview, TevGetsThePictureOfServersThatSplitTheSamples) {
  const TevReceiver viewer;
  const Outcome outcome =
      render({"--tev", viewer.address(), "--servers", server_->target(), "--split-samples", "4"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  expect_in(viewer, 6);
}

TEST_F(CliPreview, CoarsePicturesDoNotChangeTheLast) {
  ASSERT_EQ(render({}).status, 0);
  const std::vector<float> plain = pixels(picture_);
  const TevReceiver viewer;
  ASSERT_EQ(render({"--tev", viewer.address()}).status, 0);
  EXPECT_TRUE(pixels(picture_) == plain);
}

TEST_F(CliPreview, TheViewerCannotStopTheRender) {
  ASSERT_EQ(render({}).status, 0);
  const std::vector<float> expected = pixels(picture_);
  int nobody = 0;
  {
    const TevReceiver gone;
    nobody = gone.port();
  }
  Outcome outcome = render({"--tev", "127.0.0.1:" + std::to_string(nobody)});
  EXPECT_EQ(outcome.status, 0);
  EXPECT_EQ(count(outcome.err, "Connection refused; continuing without it"), 1U) << outcome.err;
  EXPECT_EQ(count(outcome.err, "\n"), 1U) << outcome.err;
  EXPECT_TRUE(pixels(picture_) == expected);

  const TevReceiver leaves({.close_after = 5000});
  outcome = render({"--tev", leaves.address()});
  EXPECT_EQ(outcome.status, 0);
  EXPECT_LE(count(outcome.err, "\n"), 1U)
      << outcome.err;  // the sockets may have taken all bytes already
  EXPECT_TRUE(pixels(picture_) == expected);
}

TEST_F(CliPreview, AnAnimationHasAPictureForEachFrameOverOneConnection) {
  const auto animate = [&](int port) {
    return lucerna({"render", "moving_point.pbrt", "--frames", "1-3", "--samples", "1", "-o",
                    path("f.%d.exr"), "--tev", "127.0.0.1:" + std::to_string(port)});
  };
  int port = 0;
  {
    const TevReceiver viewer;
    port = viewer.port();
    const Outcome outcome = animate(port);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    for (const char* name : {"f.1.exr", "f.2.exr", "f.3.exr"}) {
      const std::vector<float> expected = pixels(path(name));
      EXPECT_FALSE(expected.empty());
      EXPECT_TRUE(
          TevReceiver::wait_for([&] { return viewer.images()[path(name)].rgb == expected; }));
      fs::remove(path(name));
    }
    EXPECT_EQ(viewer.connections(), 1U);
  }
  const Outcome alone = animate(port);
  EXPECT_EQ(alone.status, 0);
  EXPECT_EQ(count(alone.err, "Connection refused"), 1U) << alone.err;
  for (const char* name : {"f.1.exr", "f.2.exr", "f.3.exr"}) EXPECT_TRUE(fs::remove(path(name)));
}

TEST_F(CliPreview, AFailedRenderKeepsItsLastPreview) {
  const std::vector<std::string> before = files();
  // The server dies when a preview is there.  The render would take minutes.
  const auto server = testing::LocalServer::start({.scene_root = path("scenes")});
  ASSERT_TRUE(server.ok()) << server.status();
  const Outcome outcome = run_program(
      {build_path("bin/lucerna"), "render", "point.pbrt", "-o", path("early.png"), "--preview=0.1",
       "--samples", "16384", "--tile-size", "8", "--server", server->target()},
      {}, {}, [&](pid_t) {
        EXPECT_TRUE(TevReceiver::wait_for([&] { return fs::exists(path("early.png")); }));
        ::kill(server->process_id(), SIGKILL);
      });
  EXPECT_EQ(outcome.status, 1) << outcome.err;
  EXPECT_EQ(pixels(path("early.png")).size(), 160U * 120 * 3);  // of tiles that came by then
  fs::remove(path("early.png"));
  EXPECT_EQ(files(), before);
}

TEST_F(CliPreview, AnInterruptedRenderEndsWithTheSignalAndKeepsItsPreview) {
  const std::vector<std::string> before = files();
  const std::string png = path("early.png");
  for (const int signal : {SIGINT, SIGTERM}) {
    const Outcome outcome =
        interrupt({"point.pbrt", "-o", png, "-o", path("early.exr")}, png, signal);
    EXPECT_EQ(outcome.status, 128 + signal);
    EXPECT_EQ(outcome.err, "lucerna: interrupted\n");
    EXPECT_EQ(pixels(png).size(), 160U * 120 * 3);
    fs::remove(png);
    EXPECT_EQ(files(), before);
  }
}

TEST_F(CliPreview, AnAnimationKeepsOnlyFinishedFrames) {
  const std::vector<std::string> before = files();
  const std::string many = path("f.%d.png");
  for (const std::vector<std::string>& servers :
       {std::vector<std::string>{}, {"--servers", server_->target()}}) {
    std::vector<std::string> arguments{"point.pbrt", "--frames", "1-2", "-o", many};
    arguments.insert(arguments.end(), servers.begin(), servers.end());
    const Outcome outcome = interrupt(arguments, path("f.1.png"), SIGTERM);
    EXPECT_EQ(outcome.status, 143) << outcome.err;
    EXPECT_EQ(files(), before);
  }
  const Outcome again = lucerna(
      {"render", "point.pbrt", "--frames", "1-2", "-o", many, "--skip-existing", "--samples", "1"});
  EXPECT_EQ(again.status, 0) << again.err;
  EXPECT_EQ(count(again.out, "exists already"), 0U) << again.out;
  for (const char* name : {"f.1.png", "f.2.png"}) EXPECT_TRUE(fs::remove(path(name)));
}

TEST_F(CliPreview, ARedrawnPngEndsEqualToOneWithoutPreview) {
  const std::vector<std::string> before = files();
  ASSERT_EQ(render({"-o", path("plain.png"), "--exposure", "-1"}).status, 0);
  const Outcome outcome = render({"-o", path("redrawn.png"), "--exposure", "-1", "--preview=0.1"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_TRUE(pixels(path("redrawn.png")) == pixels(path("plain.png")));
  EXPECT_EQ(files().size(), before.size() + 3);
  for (const char* name : {"plain.png", "redrawn.png"}) fs::remove(path(name));
}

}  // namespace
}  // namespace lucerna
