#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "client/terminal/point_options.h"

namespace lucerna {
namespace {

using cli::Double3;
using cli::PointSet;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

absl::StatusOr<PointSet> csv(const std::string& text) {
  std::istringstream input(text);
  return cli::read_csv(input, "desks.csv");
}

TEST(Csv, ReadsPoints) {
  const auto set = csv("0,1,2\n-0.5,1e-3,+4\n");
  ASSERT_TRUE(set.ok()) << set.status();
  EXPECT_THAT(set->points, ElementsAre(Double3{0, 1, 2}, Double3{-0.5, 0.001, 4}));
  EXPECT_THAT(set->seconds, IsEmpty());
}

TEST(Csv, ReadsNormals) {
  const auto set = csv("1,2,3,0,0,1\n");
  ASSERT_TRUE(set.ok()) << set.status();
  EXPECT_THAT(set->points, ElementsAre(Double3{1, 2, 3}));
  EXPECT_THAT(set->seconds, ElementsAre(Double3{0, 0, 1}));
}

TEST(Csv, HeaderCommentsBlanksAndForeignLineEndsAreSkipped) {
  const auto set = csv("\xef\xbb\xbf# desks\r\n\r\nX [m], y [m] ,z [m]\r\n 1 ,\t2, 3\r\n\n4,5,6");
  ASSERT_TRUE(set.ok()) << set.status();
  EXPECT_THAT(set->points, ElementsAre(Double3{1, 2, 3}, Double3{4, 5, 6}));
}

TEST(Csv, EmptyFileHasNoPoints) {
  ASSERT_TRUE(csv("").ok());
  EXPECT_THAT(csv("x,y,z\n")->points, IsEmpty());
}

TEST(Csv, NanIsSentToTheServer) {
  const auto set = csv("nan,inf,0\n");
  ASSERT_TRUE(set.ok()) << set.status();
  EXPECT_TRUE(std::isnan(set->points[0][0]));
  EXPECT_TRUE(std::isinf(set->points[0][1]));
}

TEST(Csv, ErrorsNameFileAndLine) {
  const auto message = [](const std::string& text) {
    const auto set = csv(text);
    EXPECT_EQ(set.status().code(), absl::StatusCode::kInvalidArgument) << text;
    return std::string(set.status().message());
  };
  EXPECT_EQ(message("x,y,z\n1,2,3\n1,oops,3\n"), "desks.csv:3: column 2: \"oops\" is not a number");
  EXPECT_EQ(message("1,2\n"), "desks.csv:1: 2 columns, must be 3 or 6: x,y,z[,nx,ny,nz]");
  EXPECT_EQ(message("1,2,3\n\n1,2,3,0,0,1\n"), "desks.csv:3: 6 columns, but 3 in the lines before");
  EXPECT_EQ(message("x,y,z,nx,ny,nz\n1,2,3\n"),
            "desks.csv:2: 3 columns, but 6 in the lines before");
  EXPECT_EQ(message("a,b,c\n"), "desks.csv:1: column 1: \"a\" is not a number");
  EXPECT_EQ(message("1,2,3\nx,y,z\n"), "desks.csv:2: column 1: \"x\" is not a number");
  EXPECT_EQ(message("1,2,1e999\n"), "desks.csv:1: column 3: \"1e999\" is not a number");
  EXPECT_EQ(message("1,,3\n"), "desks.csv:1: column 2: \"\" is not a number");
  EXPECT_EQ(message("1;2;3\n"), "desks.csv:1: 1 column, must be 3 or 6: x,y,z[,nx,ny,nz]");
}

TEST(Triple, IsThreeNumbers) {
  using cli::Triple;
  EXPECT_EQ(*cli::parse_triple("0,1.5,-2", Triple::kPoint), (Double3{0, 1.5, -2}));
  EXPECT_EQ(*cli::parse_triple("0,0,0", Triple::kPoint), (Double3{0, 0, 0}));
  for (const char* bad : {"", "1,2", "1,2,3,4", "1,2,3,4,5,6", "1,2,3x", "1 2 3", "0x1,2,3",
                          "nan,0,0", "0,inf,0", "0,0,-inf"}) {
    EXPECT_EQ(cli::parse_triple(bad, Triple::kPoint).status().code(),
              absl::StatusCode::kInvalidArgument)
        << bad;
    EXPECT_EQ(cli::parse_triple(bad, Triple::kDirection).status().code(),
              absl::StatusCode::kInvalidArgument)
        << bad;
  }
}

TEST(Triple, DirectionsAreFloatsAndNotZero) {
  using cli::Triple;
  // The smallest float is 1.4e-45; values below half of it round to 0.
  EXPECT_TRUE(cli::parse_triple("0,0,1e-44", Triple::kDirection).ok());
  EXPECT_TRUE(cli::parse_triple("0,0,1e-46", Triple::kPoint).ok());
  EXPECT_TRUE(cli::parse_triple("0,0,1e39", Triple::kPoint).ok());
  for (const char* bad : {"0,0,0", "0,-0,0", "0,0,1e-46", "0,0,1e39"}) {
    EXPECT_EQ(cli::parse_triple(bad, Triple::kDirection).status().code(),
              absl::StatusCode::kInvalidArgument)
        << bad;
  }
}

TEST(SampleValues, AreWithinTheirRanges) {
  EXPECT_THAT(*cli::parse_sample_values("0,1", 2, false), ElementsAre(0, 1));
  EXPECT_THAT(*cli::parse_sample_values("0,1,0.5,1,0.999", 4, true),
              ElementsAre(0, 1, 0.5, 1, 0.999));
  const auto message = [](const char* text, std::size_t count, bool chooses_light) {
    return std::string(cli::parse_sample_values(text, count, chooses_light).status().message());
  };
  EXPECT_EQ(message("nan,0", 2, false), "\"nan,0\": u1 = nan, allowed: [0, 1]");
  EXPECT_EQ(message("0,0,-0.5,0", 4, false), "\"0,0,-0.5,0\": u3 = -0.5, allowed: [0, 1]");
  EXPECT_EQ(message("0,1.5,0", 2, true), "\"0,1.5,0\": u2 = 1.5, allowed: [0, 1]");
  EXPECT_EQ(message("0,0,1", 2, true), "\"0,0,1\": u_light = 1, allowed: [0, 1)");
  EXPECT_EQ(message("0,0", 2, true),
            "\"0,0\", must be three numbers u1,u2,u_light, or two with --light");
  EXPECT_EQ(message("0,x", 2, false), "\"0,x\", must be two numbers u1,u2");
}

TEST(Numbers, MayBeAnyCount) {
  EXPECT_THAT(*cli::parse_numbers("0.25"), ElementsAre(0.25));
  EXPECT_THAT(*cli::parse_numbers("0,1.5, -2 ,1e3,+4"), ElementsAre(0, 1.5, -2, 1000, 4));
  EXPECT_TRUE(std::isnan((*cli::parse_numbers("1,nan"))[1]));
  for (const char* bad : {"", "1,", ",1", "1,,2", "1 2", "one", "0x1", "1e999", "+-1"}) {
    EXPECT_EQ(cli::parse_numbers(bad).status().code(), absl::StatusCode::kInvalidArgument) << bad;
  }
  EXPECT_EQ(std::string(cli::parse_numbers("1,two").status().message()), "\"two\" is not a number");
}

TEST(MakePoints, ASharedCoordinateIsExact) {
  // 0.1 is not a float: only an origin keeps it.
  const std::vector<Double3> points = {{0.1, 0, 5}, {0.1, 1, 1}};
  const v1::Points batch = client::make_points(points);
  EXPECT_EQ(batch.origin_m().x(), 0.1);
  EXPECT_EQ(batch.origin_m().y(), 0);
  EXPECT_EQ(batch.origin_m().z(), 0);
  EXPECT_THAT(batch.offsets_m(), ElementsAre(0, 0, 5, 0, 1, 1));
}

TEST(MakePoints, FarPointsKeepTheirDifferences) {
  const std::vector<Double3> points = {{1e8, 0, 0}, {1e8 + 0.25, 0, 0}};
  const v1::Points batch = client::make_points(points);
  EXPECT_EQ(batch.origin_m().x() + batch.offsets_m(0), 1e8);
  EXPECT_EQ(batch.origin_m().x() + batch.offsets_m(3), 1e8 + 0.25);
}

TEST(MakePoints, PointsAroundZeroHaveNoOrigin) {
  const std::vector<Double3> points = {{-1, 0, 3}, {1, 2, 0}};
  EXPECT_FALSE(client::make_points(points).has_origin_m());
}

TEST(MakePoints, APointThatIsNotFiniteDoesNotMoveTheOrigin) {
  const double bad = std::nan("");
  const std::vector<Double3> points = {
      {bad, 0, 0}, {1e8, 0.5, 0}, {1e8 + 0.25, HUGE_VAL, 0}, {1e8 + 1, 0.5, 0}};
  EXPECT_EQ(client::make_points(points).origin_m().x(), 1e8 + 0.5);
  EXPECT_EQ(client::make_points(points).origin_m().y(), 0.5);
}

TEST(MakePoints, PartsWithOneOriginGiveTheWhole) {
  const std::vector<Double3> points = {{0.1, 5, 1e6}, {0.1, 1, 1e6 + 0.1}, {0.1, 2, 1e6 - 0.3}};
  client::PointOrigin origin;
  for (const Double3& point : points) origin.add(point);
  const v1::Points whole = client::make_points(points);
  const auto first_two = std::span(points).first(2);
  const v1::Points part = client::make_points(first_two, origin.origin());
  EXPECT_EQ(part.origin_m().z(), whole.origin_m().z());
  EXPECT_TRUE(
      std::equal(part.offsets_m().begin(), part.offsets_m().end(), whole.offsets_m().begin()));
  // With an origin for each part they differ.
  EXPECT_NE(client::make_points(first_two).origin_m().z(), whole.origin_m().z());
}

TEST(MakePoints, OriginIsFiniteForAnyPoints) {
  const double bad = std::nan("");
  for (const double first : {bad, HUGE_VAL, -HUGE_VAL, 1.0}) {
    for (const double second : {bad, HUGE_VAL, -HUGE_VAL, 1e308}) {
      const std::vector<Double3> points = {{first, 0, 0}, {second, 0, 0}};
      EXPECT_TRUE(std::isfinite(client::make_points(points).origin_m().x()))
          << first << ' ' << second;
    }
  }
}

}  // namespace
}  // namespace lucerna
