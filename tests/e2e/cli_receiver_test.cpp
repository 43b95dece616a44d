// lucerna visible and irradiance, and options that many commands share.
#include "tests/e2e/cli_fixture.h"

namespace lucerna {
namespace {

using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;

TEST_F(Cli, VisibilityOfSegmentsAndRays) {
  // Through the box (half a metre about (0.8, 0.2), 1.2 m high) and over it.
  const Outcome segments = lucerna({"visible", "point.pbrt", "--points", "-"},
                                   "0.8,-1.8,0.5,0.8,2.2,0.5\n0.8,-1.8,1.5,0.8,2.2,1.5\n");
  EXPECT_EQ(segments.status, 0) << segments.err;
  EXPECT_THAT(segments.out, ContainsRegex("0\\.8 2\\.2 0\\.5 +no\n"));
  EXPECT_THAT(segments.out, ContainsRegex("0\\.8 2\\.2 1\\.5 +yes\n"));
  // The wall is at y = 3.
  const auto ray = [](const std::string& length) {
    return lucerna({"visible", "point.pbrt", "--point", "0.8,-1.8,1.5", "--direction", "0,1,0",
                    "--length", length})
        .out;
  };
  EXPECT_THAT(ray("4"), HasSubstr("yes"));
  EXPECT_THAT(ray("5"), Not(HasSubstr("yes")));
}

TEST_F(Cli, ItemWithoutAnswerIsShownInItsRowAndMakesTheStatusOne) {
  const Outcome outcome = lucerna({"irradiance", "point.pbrt", "--bounces", "0", "--points", "-"},
                                  "1.2,-1.5,0,0,0,1\n1.2,-1.5,0,0,0,0\nnan,0,0,0,0,1\n");
  EXPECT_EQ(outcome.status, 1) << outcome.err;
  EXPECT_THAT(outcome.out,
              ContainsRegex("0\\.97656[23] .*\n.* INVALID_INPUT\n *nan .* INVALID_INPUT\n"));
}

TEST_F(Cli, SharesOfAnItemWithoutAnswerAreNotExact) {
  const Outcome outcome =
      lucerna({"irradiance", "point.pbrt", "--per-light", "--points", "-"}, "1.2,-1.5,0,0,0,0\n");
  EXPECT_EQ(outcome.status, 1) << outcome.err;
  EXPECT_THAT(outcome.out, ContainsRegex("\nlight .*\n +1 +1\\.2 +-1\\.5 +0 +0 +INVALID_INPUT\n"));
}

TEST_F(Cli, IrradianceAndPicturesTakeSamplingMethods) {
  const auto irradiance = [](std::vector<std::string> more) {
    more.insert(more.begin(), {"irradiance", "rectangle_near.pbrt", "--point", "-1.25,-0.75,1.25",
                               "--normal", "0,0,1", "--bounces", "0", "--samples", "16", "--json"});
    const Outcome outcome = lucerna(more);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return outcome.out.substr(0, outcome.out.find(']'));
  };
  const std::string by_area = irradiance({"--area-sampling", "low-distortion"});
  EXPECT_NE(by_area, irradiance({"--area-sampling", "solid-angle"}));
  EXPECT_EQ(by_area, irradiance({"--area-sampling",
                                 "kraemer"}));  // methods by area differ on triangles only
  const auto picture = [](const std::string& name, const std::string& way) {
    const Outcome outcome = lucerna({"render", "rectangle_near.pbrt", "-o", path(name), "--samples",
                                     "1", "--bounces", "0", "--area-sampling", way});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    std::ifstream file(path(name), std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), {}};
    fs::remove(path(name));
    return bytes;
  };
  const std::string bytes = picture("way.pfm", "low-distortion");
  EXPECT_GT(bytes.size(), 100U);
  EXPECT_EQ(bytes, picture("way.pfm", "low-distortion"));
  EXPECT_NE(bytes, picture("way.pfm", "solid-angle"));
  expect_wrong_use(lucerna({"render", "rectangle_near.pbrt", "-o", path("way.pfm"),
                            "--area-sampling", "sideways"}),
                   "sideways");
}

TEST_F(Cli, TimeIsTheMomentOfAMovingLight) {
  // 18 cd at (2 t, 0, 3): at 1 s d^2 = 4 + 9 = 13 m2, and 18 * 3 / 13^1.5 lx on the floor.
  const auto with = [](std::vector<std::string> arguments, const char* time) {
    arguments.insert(arguments.begin() + 1, "moving_point.pbrt");
    arguments.insert(arguments.end(), {"--time", time});
    const Outcome outcome = lucerna(std::move(arguments));
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return outcome.out;
  };
  EXPECT_THAT(with({"sample", "--point", "0,0,0", "--light", "1"}, "1"), HasSubstr("1.38462"));
  EXPECT_THAT(with({"sample", "--point", "0,0,0", "--light", "1"}, "0"), HasSubstr("  2 2 2  lx"));
  EXPECT_THAT(with({"irradiance", "--point", "0,0,0", "--normal", "0,0,1", "--bounces", "0"}, "1"),
              HasSubstr("1.15207"));
  EXPECT_THAT(with({"emit", "--light", "1"}, "1"), HasSubstr(" 2 0 3 "));
  // The density of a direction is 1 / (4 pi) at the position of the point light, and 0 elsewhere.
  const std::vector<std::string> emit_pdf = {"emit-pdf", "--light",     "1",     "--point",
                                             "2,0,3",    "--direction", "0,0,-1"};
  EXPECT_THAT(with(emit_pdf, "1"), HasSubstr("0.0795775"));
  EXPECT_THAT(with(emit_pdf, "1.5"), Not(HasSubstr("0.0795775")));
  // These commands accept a time without effect.
  with({"pdf", "--light", "1", "--point", "0,0,0", "--direction", "0,0,1"}, "1");
  with({"le", "--point", "0,0,1", "--direction", "0,0,1"}, "1");
  with({"visible", "--point", "0,0,1", "--to", "0,0,2"}, "1");
  with({"render", "-o", path("a.pfm"), "--samples", "4"}, "1");
  const auto bytes = [](const std::string& name) {
    std::ifstream file(path(name), std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  const std::string at_one = bytes("a.pfm");
  with({"render", "-o", path("a.pfm"), "--samples", "4"}, "0");
  EXPECT_NE(bytes("a.pfm"), at_one);
  fs::remove(path("a.pfm"));
  expect_wrong_use(lucerna({"le", "moving_point.pbrt", "--point", "0,0,1", "--direction", "0,0,1",
                            "--time", "nan"}),
                   "nan is not a finite number");
}

}  // namespace
}  // namespace lucerna
