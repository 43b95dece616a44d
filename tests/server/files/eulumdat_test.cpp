// EULUMDAT: values of the format, and errors with line and allowed values.
#include "server/files/eulumdat.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/server/files/photometric_texts.h"

namespace lucerna {
namespace {

using ::testing::HasSubstr;
using testing::Ldt;
using testing::notes;
using testing::planes;
using ::testing::StartsWith;

PhotometricFile ldt(const std::string& text) {
  auto file = parse_eulumdat(text, "lamp.ldt");
  EXPECT_TRUE(file.ok()) << file.status();
  return file.ok() ? *std::move(file) : PhotometricFile{};
}
std::string ldt_error(const std::string& text) {
  const auto file = parse_eulumdat(text, "lamp.ldt");
  return file.ok() ? "" : std::string(file.status().message());
}

TEST(Eulumdat, IntensitiesAreForAThousandLumensOfTheLamps) {
  Ldt f;
  EXPECT_EQ(ldt(f.text()).web->at({0, 0, 1}), 200);
  EXPECT_EQ(ldt(f.text()).format, "EULUMDAT");
  EXPECT_EQ(notes(ldt(f.text())), "");
  f.conversion = "1,5";
  EXPECT_NEAR(ldt(f.text()).web->at({0, 0, 1}), 300, 1e-12);
  for (const char* lamps : {"-1", ""}) {  // absolute photometry, and a blank
    f.lamps[0] = lamps;
    EXPECT_NEAR(ldt(f.text()).web->at({0, 0, 1}), 300, 1e-12);
  }
}

TEST(Eulumdat, WithoutAConversionFactorIntensitiesAreUnscaled) {
  Ldt f;
  for (const char* blank : {"", "  ", "\t"}) {
    f.conversion = blank;
    EXPECT_EQ(ldt(f.text()).web->at({0, 0, 1}), 200);
    EXPECT_EQ(notes(ldt(f.text())), "24 no conversion factor for intensities -> 1\n");
  }
  f.conversion = "0.0";
  EXPECT_EQ(ldt(f.text()).web->at({0, 0, 1}), 200);
  EXPECT_EQ(notes(ldt(f.text())), "24 a conversion factor of 0 for intensities -> 1\n");
  f.conversion = "x";
  EXPECT_EQ(ldt_error(f.text()),
            "lamp.ldt:24: the conversion factor is \"x\", allowed: a finite number");
  // A file that ends before it has no blank there.
  const std::string text = f.text();
  EXPECT_THAT(ldt_error(text.substr(0, text.find("x\n"))),
              HasSubstr("the file ends before the conversion factor (line 24)"));
}

TEST(Eulumdat, EndsOfLinesAndDecimalCommas) {
  Ldt f;
  f.intensities = {"100,5", " 50 ", "1e1"};
  for (const char* end : {"\n", "\r\n", "\r"}) {
    f.end = end;
    const std::string text = f.text();
    EXPECT_NEAR(ldt(text).web->at({0, 0, 1}), 201, 1e-12);
    EXPECT_NEAR(ldt(text.substr(0, text.size() - f.end.size())).web->at({0, 0, 1}), 201, 1e-12);
  }
}

TEST(Eulumdat, CommasOfThousandsAreNotDecimals) {
  Ldt f;
  f.intensities = {"1,000", "500", "10"};
  EXPECT_EQ(ldt_error(f.text()),
            "lamp.ldt:47: an intensity per 1000 lm is \"1,000\", which is 1000 or 1, and no other "
            "number decides it, allowed: numbers without commas");
  f.intensities = {"1,000", "0,500", "10"};
  EXPECT_EQ(ldt(f.text()).web->at({0, 0, 1}), 2);
  f = {};
  f.lamps[2] = "12,500";
  EXPECT_THAT(ldt_error(f.text()), StartsWith("lamp.ldt:29: the luminous flux of the lamps is "
                                              "\"12,500\", which is 12500 or 12.5"));
  f.gamma[1] = "22,5";
  EXPECT_EQ(ldt(f.text()).web->at({0, 0, 1}), 1.25);
  // A factor of 1000 has no use.
  f = {};
  f.conversion = "1,000";
  EXPECT_EQ(ldt(f.text()).web->at({0, 0, 1}), 200);
}

TEST(Eulumdat, PlanesOfEachSymmetry) {
  // C90 points to -y, since +z is down.
  const auto at = [](const Ldt& f, double c_deg) {
    const double c = c_deg * kPi / 180;
    return ldt(f.text()).web->at({std::cos(c), -std::sin(c), 0});
  };
  const auto expect = [&](const Ldt& f, const std::vector<double>& values) {
    for (std::size_t i = 0; i < values.size(); ++i)
      EXPECT_NEAR(at(f, 45. * static_cast<double>(i)), values[i], 1e-9)
          << "symmetry " << f.symmetry << ", C" << 45 * i;
  };
  expect(planes(0, {"1", "2", "3", "4", "5", "6", "7", "8"}), {1, 2, 3, 4, 5, 6, 7, 8});
  EXPECT_NEAR(at(planes(0, {"1", "2", "3", "4", "5", "6", "7", "8"}), 337.5), 4.5, 1e-9);
  expect(planes(1, {"3"}), {3, 3, 3, 3, 3, 3, 3, 3});
  expect(planes(2, {"1", "2", "3", "4", "5"}), {1, 2, 3, 4, 5, 4, 3, 2});
  // From C270 over C0 to C90, mirrored at that plane.
  expect(planes(3, {"1", "2", "3", "4", "5"}), {3, 4, 5, 4, 3, 2, 1, 2});
  expect(planes(4, {"1", "2", "3"}), {1, 2, 3, 2, 1, 2, 3, 2});
}

TEST(Eulumdat, AboveTheLastGammaItIsDark) {
  Ldt f;
  f.gamma = {"0", "45", "140"};
  EXPECT_EQ(notes(ldt(f.text())),
            "44 vertical angles from 0 to 140 degrees -> dark outside of them\n");
  EXPECT_EQ(ldt(f.text()).web->at({0, 0, -1}), 0);
  EXPECT_NEAR(ldt(f.text()).web->at({1, 0, 0}), 2 * (50 - 40 * 45 / 95.), 1e-9);
}

// Planes at half of their distance from C0: the first and the last are equally far from the planes
// of symmetry.
TEST(Eulumdat, PlanesMayBeAtHalfSteps) {
  const auto at = [](const Ldt& f, double c_deg) {
    const double c = c_deg * kPi / 180;
    const PhotometricFile file = ldt(f.text());
    EXPECT_EQ(notes(file), "");
    return file.web->at({std::cos(c), -std::sin(c), 0});
  };
  const auto half = [](int symmetry, const std::vector<std::string>& values) {
    Ldt f = planes(symmetry, values);
    f.c = {"22,5", "67.5", "112.5", "157.5", "202.5", "247.5", "292.5", "337.5"};
    return f;
  };
  const auto expect = [&](const Ldt& f, const std::vector<double>& values) {
    for (std::size_t i = 0; i < values.size(); ++i)
      EXPECT_NEAR(at(f, 22.5 + 45. * static_cast<double>(i)), values[i], 1e-9)
          << "symmetry " << f.symmetry << ", plane " << i;
  };
  expect(half(0, {"1", "2", "3", "4", "5", "6", "7", "8"}), {1, 2, 3, 4, 5, 6, 7, 8});
  EXPECT_NEAR(at(half(0, {"1", "2", "3", "4", "5", "6", "7", "8"}), 0), 4.5, 1e-9);
  expect(half(2, {"1", "2", "3", "4"}), {1, 2, 3, 4, 4, 3, 2, 1});
  expect(half(3, {"1", "2", "3", "4"}), {3, 4, 4, 3, 2, 1, 1, 2});
  expect(half(4, {"1", "2"}), {1, 2, 2, 1, 1, 2, 2, 1});
  EXPECT_NEAR(at(half(4, {"1", "2"}), 90), 2, 1e-9);
  Ldt uneven = half(2, {"1", "2", "3", "4"});
  uneven.c[1] = "60";
  EXPECT_EQ(notes(ldt(uneven.text())),
            "43 horizontal angles from 22.5 to 157.5 degrees -> symmetric about the planes 0 and "
            "180\n");
  uneven.c = {"22.5", "67.5", "112.5", "190", "202.5", "247.5", "292.5", "337.5"};
  EXPECT_EQ(ldt_error(uneven.text()),
            "lamp.ldt:43: 4 C-angles from 22.5 to 190 degrees, allowed for symmetry 2: from 0 to "
            "180");
}

/// Intensity at gamma 90 and C.
double at_c(const PhotometricFile& file, double c_deg) {
  const double c = c_deg * kPi / 180;
  return file.web ? file.web->at({std::cos(c), -std::sin(c), 0}) : -1;
}

/// As planes(), with these C-angles.
Ldt with_c(int symmetry, const std::vector<std::string>& c,
           const std::vector<std::string>& values) {
  Ldt f = planes(symmetry, values);
  f.c = c;
  f.mc = static_cast<int>(c.size());
  return f;
}

TEST(Eulumdat, McMayCountThePlanesWithIntensities) {
  const auto expect = [](const Ldt& f, const std::string& what, const std::vector<double>& values) {
    const PhotometricFile file = ldt(f.text());
    EXPECT_EQ(notes(file), "4 " + what + " -> Mc is the number of planes with intensities\n");
    for (std::size_t i = 0; i < values.size(); ++i)
      EXPECT_NEAR(at_c(file, 45. * static_cast<double>(i)), values[i], 1e-9) << what << i;
  };
  const std::vector<std::string> five{"1", "2", "3", "4", "5"};
  expect(with_c(2, {"0", "45", "90", "135", "180"}, five),
         "symmetry 2, but C-planes from 0 to 180 only", {1, 2, 3, 4, 5, 4, 3, 2});
  expect(with_c(3, {"90", "135", "180", "225", "270"}, five),
         "symmetry 3, but C-planes from 90 to 270 only", {3, 2, 1, 2, 3, 4, 5, 4});
  expect(with_c(3, {"270", "315", "0", "45", "90"}, five),
         "symmetry 3, but C-planes from 270 to 90 only", {3, 4, 5, 4, 3, 2, 1, 2});
  expect(with_c(4, {"0", "45", "90"}, {"1", "2", "3"}),
         "symmetry 4, but C-planes from 0 to 90 only", {1, 2, 3, 2, 1, 2, 3, 2});
  EXPECT_EQ(ldt_error(with_c(2, {"0", "45", "90", "135", "180"}, {"1", "2", "3"}).text()),
            "lamp.ldt:4: the number Mc of C-planes = 5, allowed for symmetry 2: multiples of 2");
}

TEST(Eulumdat, PlanesMayBeginAnywhere) {
  Ldt f = with_c(0, {"5", "95", "185", "275"}, {"1", "2", "3", "4"});
  EXPECT_EQ(notes(ldt(f.text())), "");
  EXPECT_NEAR(at_c(ldt(f.text()), 95), 2, 1e-9);
  EXPECT_NEAR(at_c(ldt(f.text()), 320), 2.5, 1e-9);
}

TEST(Eulumdat, TheLastPlaneMayBeMissing) {
  PhotometricFile file = ldt(planes(2, {"1", "2", "3", "4"}).text());
  EXPECT_EQ(notes(file),
            "53 intensities of 4 planes, announced 5 -> the last plane is left out\n"
            "43 horizontal angles from 0 to 135 degrees -> symmetric about the planes 0 and 180\n");
  EXPECT_NEAR(at_c(file, 180), 4, 1e-9);
  EXPECT_NEAR(at_c(file, 270), 3, 1e-9);
  file = ldt(planes(0, {"1", "2", "3", "4", "5", "6", "7"}).text());
  EXPECT_EQ(
      notes(file),
      "53 intensities of 7 planes, announced 8 -> the last plane is left out\n"
      "43 horizontal angles from 0 to 270 degrees -> linear from the last plane to the first, "
      "over 90 degrees\n");
  EXPECT_NEAR(at_c(file, 315), 4, 1e-9);
  // Two planes of an eighth, or half a circle, would have another symmetry.
  EXPECT_THAT(ldt_error(planes(4, {"1", "2"}).text()), HasSubstr("allowed for symmetry 4: from 0"));
  EXPECT_THAT(ldt_error(with_c(0, {"0", "90", "180", "270"}, {"1", "2", "3"}).text()),
              HasSubstr("the file ends before an intensity"));
}

TEST(Eulumdat, SymmetryAboutTheAxisNeedsNoPlane) {
  Ldt f;
  f.mc = 0;
  EXPECT_EQ(notes(ldt(f.text())), "4 0 C-planes -> one plane, symmetric about the axis\n");
  EXPECT_EQ(ldt(f.text()).web->at({0, 0, 1}), 200);
  f.c.clear();
  EXPECT_EQ(ldt(f.text()).web->at({0, 0, 1}), 200);
  f.symmetry = 0;
  EXPECT_EQ(ldt_error(f.text()),
            "lamp.ldt:4: the number Mc of C-planes = 0, allowed: a positive whole number");
}

TEST(Eulumdat, TheTiltOfTheMeasurementIsNoted) {
  Ldt f;
  for (const char* none : {"0", "0,0", "", "-0"}) {
    f.tilt = none;
    EXPECT_EQ(notes(ldt(f.text())), "");
  }
  f.tilt = "15";
  EXPECT_EQ(
      notes(ldt(f.text())),
      "25 a tilt of \"15\" degrees during the measurement -> left out: gamma 0 is the axis of "
      "the luminaire\n");
}

TEST(Eulumdat, WhatFollowsTheAnnouncedPlanesIsNoted) {
  Ldt f = planes(4, {"1", "2", "3"});
  EXPECT_EQ(notes(ldt(f.text())), "");
  EXPECT_EQ(notes(ldt(f.text() + "\n  \n")), "");
  EXPECT_EQ(notes(ldt(f.text() + "\nmade by hand\n")),
            "60 text after the last intensity -> left out\n");
  EXPECT_EQ(notes(ldt(f.text() + "4\n4\n")),
            "59 values after those of the announced planes -> left out\n");
  // All planes of the circle are there: they tell more than the symmetry.
  f = planes(4, {"1", "2", "3", "4", "5", "6", "7", "8"});
  const PhotometricFile all = ldt(f.text());
  EXPECT_EQ(notes(all), "3 symmetry 4, but intensities of all 8 planes -> all planes are used\n");
  EXPECT_EQ(all.web->flux_lm(),
            ldt(planes(0, {"1", "2", "3", "4", "5", "6", "7", "8"}).text()).web->flux_lm());
}

TEST(Eulumdat, SmallNegativeIntensitiesAreNoiseAboutZero) {
  Ldt f;
  f.intensities = {"100", "-1", "-0,5"};
  EXPECT_EQ(notes(ldt(f.text())), "48 2 negative intensities, down to -1 -> 0\n");
  EXPECT_EQ(ldt(f.text()).web->at({1, 0, 1}), 0);
}

TEST(Eulumdat, LuminousAreasAreNotedForPoints) {
  Ldt f;
  EXPECT_FALSE(ldt(f.text()).opening);
  f.luminous_mm = {"386", "256", "0", "12", "0", "0"};
  EXPECT_EQ(ldt(f.text()).opening->what, "a luminous opening of 0.386 x 0.256 x 0.012 m");
  EXPECT_EQ(ldt(f.text()).opening->line, 16);
  f.luminous_mm = {"100", "", "", "", "", "x"};
  EXPECT_EQ(ldt(f.text()).opening->what, "a luminous opening of 0.1 m");
}

TEST(Eulumdat, SetsOfLampsBeyondTheFirstAreLeftOut) {
  Ldt f;
  f.sets = "2";
  const std::vector<std::string> second{"1", "other", "5000", "4000", "80", "50"};
  f.lamps.insert(f.lamps.end(), second.begin(), second.end());
  EXPECT_EQ(ldt(f.text()).web->at({0, 0, 1}), 200);
  EXPECT_EQ(notes(ldt(f.text())), "26 2 sets of lamps -> only the first set is used\n");
}

// The description lists the values of all sets field by field (four characters times the number of
// sets for the numbers of lamps, then the types...).  Other programs read and write set by set.
TEST(Eulumdat, SetsOfLampsInEitherOrder) {
  Ldt f;
  f.sets = "3";
  f.lamps = {"1",    "2",    "-1",   "T16 28W", "T16 2x28W", "",   "2000", "5000", "1800",
             "3000", "3000", "4000", "80",      "80",        "1B", "30",   "60",   ""};
  EXPECT_EQ(ldt(f.text()).web->at({0, 0, 1}), 200);
  EXPECT_EQ(notes(ldt(f.text())), "26 3 sets of lamps -> only the first set is used\n");
  f.sets = "2";
  f.lamps = {"1", "1", "28", "28", "2000", "5000", "3000", "3000", "80", "80", "30", "60"};
  EXPECT_EQ(ldt(f.text()).web->at({0, 0, 1}), 200);
  EXPECT_EQ(
      notes(ldt(f.text())),
      "26 2 sets of lamps -> only the first set is used\n26 sets of lamps whose order is ambiguous "
      "(field by field or set by set) -> read field by field, as in the format's description\n");
  f.lamps[0] = "x";
  EXPECT_THAT(ldt_error(f.text()), StartsWith("lamp.ldt:26: 2 sets of lamps, allowed: numbers"));
}

// 1000/pi (1 - gamma/90) cd per 1000 lm of lamps make 2000 (1 - 2/pi) = 726.8 lm per 1000 lm.
TEST(Eulumdat, LightOutputRatioIsComparedWithTheIntensities) {
  Ldt f;
  f.intensities = {"318.30989", "159.15494", "0"};
  f.lorl = "72.7";
  EXPECT_EQ(notes(ldt(f.text())), "");
  f.lorl = "60";
  EXPECT_EQ(
      notes(ldt(f.text())),
      "23 the light output ratio of 60% gives 1200 lm -> the flux of the intensities is used, "
      "1453.52 lm\n");
}

TEST(Eulumdat, ErrorsNameLineAndAllowedValues) {
  Ldt f;
  f.symmetry = 5;
  EXPECT_EQ(ldt_error(f.text()), "lamp.ldt:3: the symmetry Isym = 5, allowed: 0, 1, 2, 3 or 4");
  f = {};
  f.symmetry = 4;
  f.mc = 6;
  EXPECT_EQ(ldt_error(f.text()),
            "lamp.ldt:4: the number Mc of C-planes = 6, allowed for symmetry 4: multiples of 4");
  f = {};
  f.mc = 1000;
  f.ng = 1000;
  f.symmetry = 0;
  EXPECT_THAT(ldt_error(f.text()), StartsWith("lamp.ldt:6: 1000 angles and 1000 planes of 1000 "
                                              "intensities are announced, allowed: as many"));
  f.mc = f.ng = 1000000000;
  EXPECT_THAT(ldt_error(f.text()), HasSubstr("are announced"));
  f = {};
  f.conversion = "-1";
  EXPECT_EQ(ldt_error(f.text()),
            "lamp.ldt:24: the conversion factor = -1, allowed: not negative; 0 counts as 1");
  f = {};
  f.sets = "0";
  EXPECT_THAT(ldt_error(f.text()), StartsWith("lamp.ldt:26: the number of sets of lamps = 0"));
  f = {};
  f.lamps[2] = "x";
  EXPECT_THAT(ldt_error(f.text()),
              StartsWith("lamp.ldt:29: the luminous flux of the lamps is \"x\""));
  f = {};
  f.gamma = {"0", "45", "30"};
  EXPECT_THAT(ldt_error(f.text()),
              StartsWith("lamp.ldt:44: vertical angle[2] = 30 degrees, allow"));
  f = {};
  f.intensities[1] = "-5";
  EXPECT_THAT(ldt_error(f.text()), StartsWith("lamp.ldt:48: an intensity per 1000 lm = -5"));
  f.intensities[1] = "nan";
  EXPECT_EQ(ldt_error(f.text()),
            "lamp.ldt:48: an intensity per 1000 lm is \"nan\", allowed: a finite number");
  f = {};
  f.symmetry = f.mc = 0;
  EXPECT_EQ(ldt_error(f.text()),
            "lamp.ldt:4: the number Mc of C-planes = 0, allowed: a positive whole number");
  EXPECT_THAT(ldt_error("made up\n"), HasSubstr("the file ends before the symmetry Isym (line 3)"));
}

}  // namespace
}  // namespace lucerna
