// lucerna render.
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <vector>

#include "tests/e2e/cli_fixture.h"

namespace lucerna {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST_F(Cli, RenderWritesPicturesAndNothingElse) {
  const std::vector<std::string> before = files();
  const Outcome outcome = lucerna({"render", "point.pbrt", "-o", path("a.exr"), "--samples", "4",
                                   "--bounces", "0", "--stderr", path("b.pfm")});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("160 x 120 pixels"));
  EXPECT_THAT(outcome.err, IsEmpty());  // no progress bar without a terminal
  EXPECT_EQ(
      lucerna({"render", "point.pbrt", "-o", path("c.png"), "-o", path("d.exr"), "--samples", "1"})
          .status,
      0);
  EXPECT_EQ(files().size(), before.size() + 4);
  // PF, the size, and 160 x 120 x 3 floats.
  EXPECT_EQ(fs::file_size(path("b.pfm")), std::string("PF\n160 120\n-1.0\n").size() + 230400);
  for (const char* name : {"a.exr", "b.pfm", "c.png", "d.exr"}) fs::remove(path(name));
}

TEST_F(Cli, RenderRefusesUnwritableFilesBeforeItStarts) {
  const std::vector<std::string> before = files();
  // No server is called: there is none.
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
  expect_wrong_use(render({"-o", path("a.exr"), "--interval", path("b.exr"), "--samples", "1"}),
                   "a single sample has no interval; --samples must be 2 or more");
  expect_wrong_use(render({"-o", path("a.exr"), "--interval", path("b.pfm")}), "must be .exr");
  expect_wrong_use(render({"-o", path("a.exr"), "--interval", path("a.exr")}), "is given twice");
  expect_wrong_use(render({}), "--output");
  expect_no(render({"-o", path("a.exr")}), "cannot reach");
  EXPECT_EQ(files(), before);
}

/// The values of a PFM's first channel, rows from the bottom.
std::vector<float> first_channel(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::string header;
  for (int i = 0; i < 3; ++i) std::getline(in, header);
  std::vector<float> values;
  for (float rgb[3]; in.read(reinterpret_cast<char*>(rgb), sizeof rgb);) values.push_back(rgb[0]);
  return values;
}

TEST_F(Cli, RenderStopsEachPixelAtAnError) {
  const Outcome outcome = lucerna(
      {"render",      "small.pbrt", "-o",           path("a.pfm"), "--error",       "20%",
       "--floor",     "0.01",       "--confidence", "90%",         "--max-samples", "512",
       "--bounces",   "0",          "--counts",     path("n.pfm"), "--stderr",      path("e.pfm"),
       "--tile-size", "17"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const std::vector<float> counts = first_channel(path("n.pfm"));
  ASSERT_EQ(counts.size(), 54U * 40);
  const auto [least, most] = std::minmax_element(counts.begin(), counts.end());
  EXPECT_EQ(*least, 64);
  EXPECT_LE(*most, 512);
  EXPECT_GT(*most, 64);
  std::vector<float> sorted = counts;
  std::sort(sorted.begin(), sorted.end());
  EXPECT_THAT(outcome.out,
              HasSubstr("54 x 40 pixels; samples per pixel: at least 64, median " +
                        std::to_string(static_cast<int>(sorted[(sorted.size() - 1) / 2])) +
                        ", at most " + std::to_string(static_cast<int>(*most)) + "; "));
  // The tiles do not matter.
  ASSERT_EQ(lucerna({"render", "small.pbrt", "-o", path("b.pfm"), "--error", "20%", "--floor",
                     "0.01", "--confidence", "90%", "--max-samples", "512", "--bounces", "0",
                     "--stderr", path("f.pfm")})
                .status,
            0);
  EXPECT_EQ(first_channel(path("a.pfm")), first_channel(path("b.pfm")));
  EXPECT_EQ(first_channel(path("e.pfm")), first_channel(path("f.pfm")));
  for (const char* name : {"a.pfm", "b.pfm", "e.pfm", "f.pfm", "n.pfm"}) fs::remove(path(name));
}

/// A floor whose lamp shines through a slit, and a camera of 8 x 8 pixels.
constexpr char kSlit[] = R"(
LookAt 0 0 1  0 0 0  0 1 0
Camera "perspective" "float fov" 20
Film "rgb" "integer xresolution" 8 "integer yresolution" 8 "float iso" 100 "float exposuretime" 1
WorldBegin
Shape "bilinearmesh" "point3 P" [-9 -9 0  9 -9 0  -9 9 0  9 9 0]
Shape "bilinearmesh" "point3 P" [-9 -9 2  -.001 -9 2  -9 9 2  -.001 9 2]
Shape "bilinearmesh" "point3 P" [.001 -9 2  9 -9 2  .001 9 2  9 9 2]
AreaLightSource "diffuse" "rgb L" [9 9 9]
Shape "bilinearmesh" "point3 P" [-1 -1 3  -1 1 3  1 -1 3  1 1 3]
)";

TEST_F(Cli, RenderSaysWhichPixelsSawNoLight) {
  std::ofstream(path("scenes/slit.pbrt")) << kSlit;
  const auto render = [](std::vector<std::string> more) {
    std::vector<std::string> arguments = {"render", "slit.pbrt", "--bounces",
                                          "0",      "-o",        path("a.pfm")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return lucerna(arguments);
  };
  const Outcome outcome = render({"--samples", "64", "--stderr", path("e.pfm"), "--interval",
                                  path("i.exr"), "--counts", path("n.pfm")});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const std::vector<float> values = first_channel(path("a.pfm")),
                           errors = first_channel(path("e.pfm"));
  const auto without = static_cast<std::size_t>(std::count(values.begin(), values.end(), 0.0F));
  ASSERT_GT(without, 1U);
  ASSERT_LT(without, 64U);
  EXPECT_THAT(outcome.out, HasSubstr("e.pfm: standard errors, upper bounds at " +
                                     std::to_string(without) + " pixels without light; "));
  EXPECT_THAT(outcome.out, HasSubstr("i.exr: 95% confidence intervals; "));
  // PFM has its rows from the bottom, EXR from the top.
  const auto in = OIIO::ImageInput::open(path("i.exr"));
  ASSERT_NE(in, nullptr);
  EXPECT_THAT(in->spec().channelnames, ::testing::ElementsAre("Y", "lower.Y", "upper.Y"));
  EXPECT_THAT(std::string(in->spec().get_string_attribute("ImageDescription")),
              HasSubstr("95% confidence intervals"));
  std::vector<float> intervals(8 * 8 * 3);
  ASSERT_TRUE(in->read_image(0, 0, 0, 3, OIIO::TypeDesc::FLOAT, intervals.data()));
  for (std::size_t y = 0; y < 8; ++y)
    for (std::size_t x = 0; x < 8; ++x) {
      const float* interval = &intervals[3 * (8 * (7 - y) + x)];
      EXPECT_NEAR(interval[0], values[8 * y + x], 1e-6);
      EXPECT_LE(interval[1], interval[0]);
      EXPECT_GT(interval[2], interval[0]);
      EXPECT_GT(errors[8 * y + x], 0);
      if (values[8 * y + x] == 0) {
        EXPECT_EQ(errors[8 * y + x], interval[2]);
      }
    }
  // One of these files needs the same blocks as both.  Without them there is one sequence.
  ASSERT_EQ(render({"--samples", "64", "--json", "--stderr", path("e.pfm")}).status, 0);
  EXPECT_EQ(first_channel(path("a.pfm")), values);
  ASSERT_EQ(render({"--samples", "64", "--json"}).status, 0);
  EXPECT_NE(first_channel(path("a.pfm")), values);
  // A target error has the same intervals.
  const Outcome target =
      render({"--error", "50%", "--max-samples", "64", "--interval", path("i.exr"), "--json"});
  ASSERT_EQ(target.status, 0) << target.err;
  EXPECT_THAT(target.out, HasSubstr("\"pixelsWithoutLight\":"));
  for (const char* name : {"a.pfm", "e.pfm", "i.exr", "n.pfm", "scenes/slit.pbrt"})
    fs::remove(path(name));
}

TEST_F(Cli, RenderSaysThatPicturesMayMissLight) {
  std::ofstream(path("scenes/ball.pbrt"))
      << "Film \"rgb\" \"integer xresolution\" 8 \"integer yresolution\" 8\n"
         "Camera \"perspective\"\nWorldBegin\nLightSource \"point\"\n"
         "Translate 0 0 5 Material \"dielectric\" Shape \"sphere\"\n";
  const auto render = [&](std::vector<std::string> more) {
    std::vector<std::string> arguments = {"render",      "ball.pbrt", "-o",
                                          path("a.pfm"), "--samples", "2"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return lucerna(std::move(arguments)).out;
  };
  constexpr const char* kMissing = "light by way of curved smooth surfaces may be missing";
  EXPECT_THAT(render({}), HasSubstr(kMissing));
  EXPECT_THAT(render({"--json"}), HasSubstr("\"mayMissLight\":true"));
  EXPECT_THAT(render({"--bounces", "0"}), ::testing::Not(HasSubstr(kMissing)));
  for (const char* name : {"a.pfm", "scenes/ball.pbrt"}) fs::remove(path(name));
}

TEST_F(Cli, RenderStopsWhenTheTimeIsOver) {
  const Outcome outcome = lucerna(
      {"render", "point.pbrt", "-o", path("a.exr"), "--budget", "0.2", "--counts", path("n.pfm")});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const std::vector<float> counts = first_channel(path("n.pfm"));
  const auto [least, most] = std::minmax_element(counts.begin(), counts.end());
  EXPECT_GE(*least, 16);
  EXPECT_THAT(outcome.out,
              HasSubstr("at least " + std::to_string(static_cast<int>(*least)) + ", median "));
  EXPECT_THAT(outcome.out,
              HasSubstr(", at most " + std::to_string(static_cast<int>(*most)) + "; "));
  for (const char* name : {"a.exr", "n.pfm"}) fs::remove(path(name));
}

TEST_F(Cli, RenderRefusesStopRulesThatExcludeEachOther) {
  const auto render = [](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(),
                     {"render", "point.pbrt", "--server", "127.0.0.1:1", "-o", path("a.exr")});
    return lucerna(std::move(arguments));
  };
  expect_wrong_use(render({"--error", "1%", "--samples", "4"}), "--samples");
  expect_wrong_use(render({"--error", "1%", "--budget", "4"}), "--budget");
  expect_wrong_use(render({"--error", "-1%"}), "fraction above 0");
  expect_wrong_use(render({"--floor", "1"}), "--error");
  expect_wrong_use(render({"--servers", "127.0.0.1:1", "--budget", "4"}),
                   "--budget: not with --servers");
  expect_wrong_use(render({"--servers", "127.0.0.1:1", "--error", "1%", "--split-samples", "8"}),
                   "--split-samples: not with --error");
  expect_wrong_use(render({"--counts", path("n.png")}), "must be .exr or .pfm");
  expect_wrong_use(render({"--counts", path("a.exr")}), "is given twice");
}

TEST_F(Cli, TimeoutEndsARenderAndLeavesNoFile) {
  const std::vector<std::string> before = files();
  const Outcome outcome = lucerna(
      {"render", "point.pbrt", "-o", path("a.exr"), "--samples", "32768", "--timeout", "0.3"});
  expect_no(outcome, "no answer within --timeout 0.3 s");
  EXPECT_EQ(files(), before);
}

}  // namespace
}  // namespace lucerna
