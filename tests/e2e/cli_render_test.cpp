// lucerna render.
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
