// lucerna render.
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
      {"render",      "sphere.pbrt", "-o",           path("a.pfm"), "--error",       "20%",
       "--floor",     "0.01",        "--confidence", "90%",         "--max-samples", "512",
       "--bounces",   "0",           "--counts",     path("n.pfm"), "--stderr",      path("e.pfm"),
       "--tile-size", "50"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const std::vector<float> counts = first_channel(path("n.pfm"));
  ASSERT_EQ(counts.size(), 160U * 120);
  const auto [least, most] = std::minmax_element(counts.begin(), counts.end());
  EXPECT_EQ(*least, 64);
  EXPECT_LE(*most, 512);
  EXPECT_GT(*most, 64);
  std::vector<float> sorted = counts;
  std::sort(sorted.begin(), sorted.end());
  EXPECT_THAT(outcome.out,
              HasSubstr("160 x 120 pixels; samples per pixel: at least 64, median " +
                        std::to_string(static_cast<int>(sorted[(sorted.size() - 1) / 2])) +
                        ", at most " + std::to_string(static_cast<int>(*most)) + "; "));
  // The tiles do not matter.
  ASSERT_EQ(lucerna({"render", "sphere.pbrt", "-o", path("b.pfm"), "--error", "20%", "--floor",
                     "0.01", "--confidence", "90%", "--max-samples", "512", "--bounces", "0",
                     "--stderr", path("f.pfm")})
                .status,
            0);
  EXPECT_EQ(first_channel(path("a.pfm")), first_channel(path("b.pfm")));
  EXPECT_EQ(first_channel(path("e.pfm")), first_channel(path("f.pfm")));
  for (const char* name : {"a.pfm", "b.pfm", "e.pfm", "f.pfm", "n.pfm"}) fs::remove(path(name));
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
