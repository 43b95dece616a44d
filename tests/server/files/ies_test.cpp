// IES LM-63: values of the standard, and errors with line and allowed values.
#include "server/files/ies.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/server/files/photometric_texts.h"

namespace lucerna {
namespace {

using testing::down;
using ::testing::HasSubstr;
using testing::Ies;
using testing::ies;
using testing::ies_error;
using testing::notes;
using ::testing::StartsWith;

TEST(Ies, ReadsTheIntensities) {
  const PhotometricFile file = ies(Ies().text());
  ASSERT_TRUE(file.web);
  EXPECT_EQ(file.format, "IES LM-63-2002, type C");
  EXPECT_EQ(notes(file), "");
  EXPECT_EQ(file.web->at({0, 0, 1}), 100);
  EXPECT_NEAR(file.web->at({1, 0, 1}), 50, 1e-12);
  EXPECT_EQ(file.web->at({0, 0, -1}), 0);
}

TEST(Ies, MoreFluxThanOfTheLampsIsNoted) {
  Ies f;
  const double lm = ies(f.text()).web->flux_lm();
  const auto notes_with = [&](const std::string& lamps) {
    f.lamps = lamps;
    return notes(ies(f.text()));
  };
  EXPECT_EQ(notes_with(fmt::format("1 {} 1", lm / 1.01)), "");
  EXPECT_EQ(notes_with(fmt::format("2 {} 1", lm)), "");
  EXPECT_EQ(notes_with("0 0 1"), "");
  EXPECT_EQ(notes_with("1 -1 1000"), "");
  EXPECT_EQ(notes_with("1 100 1"),
            fmt::format("5 1 lamp of 100 lm emits 100 lm -> the flux of the intensities is used, "
                        "{:.6g} lm\n",
                        lm));
  EXPECT_EQ(notes_with("2 100 2"),
            fmt::format("5 2 lamps of 100 lm emit 200 lm -> the flux of the intensities is used, "
                        "{:.6g} lm\n",
                        2 * lm));
  EXPECT_THAT(notes_with("1 0 1"), HasSubstr("5 1 lamp of 0 lm emits 0 lm"));
  // The ballast dims the lamps too.
  f.ballast = "0.5 1 10\n";
  EXPECT_EQ(notes_with(fmt::format("1 {} 1", lm / 1.01)), "");
  EXPECT_EQ(notes_with("1 100 1"),
            fmt::format("5 1 lamp of 100 lm emits 50 lm -> the flux of the intensities is used, "
                        "{:.6g} lm\n",
                        lm / 2));
}

TEST(Ies, EditionsByTheirFirstLine) {
  const auto format = [](const std::string& header) {
    Ies f;
    f.header = header;
    return ies(f.text()).format;
  };
  EXPECT_EQ(format(""), "IES LM-63-1986, type C");
  EXPECT_EQ(format("A lamp of 1987\nfree text\n"), "IES LM-63-1986, type C");
  EXPECT_EQ(format("IESNA91\n"), "IES LM-63-1991, type C");
  EXPECT_EQ(format("IESNA:LM-63-1995\n"), "IES LM-63-1995, type C");
  EXPECT_EQ(format("IES:LM-63-2019\n"), "IES LM-63-2019, type C");
  EXPECT_EQ(format("iesna:lm-63-2002\n"), "IES LM-63-2002, type C");
  EXPECT_EQ(format("\n\n  IESNA: LM-63-2002 \n"), "IES LM-63-2002, type C");
  EXPECT_EQ(format("IESNA86\n"), "IES LM-63-1986, type C");
  EXPECT_EQ(format("IESNA:LM-63-1986\n"), "IES LM-63-1986, type C");
  EXPECT_EQ(format("IESNA95\n"), "IES LM-63-1995, type C");
  Ies odd;
  odd.header = "IESNA:LM-63-2040\n";
  EXPECT_EQ(notes(ies(odd.text())),
            "1 unknown edition \"IESNA:LM-63-2040\", known: LM-63-1986, 1991, 1995, 2002, 2019 -> "
            "read as "
            "that of 2002\n");
}

TEST(Ies, MultipliersApplyOnceEach) {
  Ies f;
  f.lamps = "1 -1 2.5";
  f.ballast = "0.8 0.5 10\n";
  EXPECT_NEAR(down(f.text()), 100 * 2.5 * 0.8, 1e-12);
  // Up to 1991 the second number is the ballast-lamp photometric factor.
  f.header = "";
  EXPECT_NEAR(down(f.text()), 100 * 2.5 * 0.8 * 0.5, 1e-12);
  f.header = "IESNA91\n";
  EXPECT_NEAR(down(f.text()), 100 * 2.5 * 0.8 * 0.5, 1e-12);
  f.header = "IESNA:LM-63-1995\n";
  EXPECT_NEAR(down(f.text()), 100 * 2.5 * 0.8, 1e-12);
}

TEST(Ies, BallastFactorsOfZeroCountAsOne) {
  Ies f;
  f.ballast = "0 0 10\n";
  EXPECT_EQ(down(f.text()), 100);
  EXPECT_EQ(notes(ies(f.text())), "6 the ballast factor is 0 -> 1\n");
  f.header = "IESNA91\n";
  EXPECT_EQ(notes(ies(f.text())),
            "4 the ballast factor is 0 -> 1\n4 the ballast-lamp photometric factor is 0 -> 1\n");
}

TEST(Ies, UnitsOfLengthScaleNoCandela) {
  Ies f;
  f.units = "1 -0.5 -0.5 0\n";
  EXPECT_EQ(down(f.text()), 100);
}

TEST(Ies, TiltTablesAreReadAndTheFactorAtTiltZeroApplies) {
  Ies f;
  f.tilt = "TILT=INCLUDE\n1\n3\n0 45 90\n0.5 0.9 0.8\n";
  EXPECT_EQ(down(f.text()), 50);
  EXPECT_EQ(notes(ies(f.text())),
            "5 a table of factors for a tilted luminaire -> the factor at tilt 0, which is 0.5\n");
  f.tilt = "TILT=INCLUDE\n1\n2\n0 90\n1 1\n";
  EXPECT_EQ(notes(ies(f.text())), "");
  f.tilt = "TILT=mh400.tlt\n";
  EXPECT_EQ(down(f.text()), 100);
  EXPECT_EQ(notes(ies(f.text())),
            "4 tilt factors in \"mh400.tlt\" are not read -> the factor 1, for a luminaire without "
            "tilt\n");
  f.tilt = "TILT=INCLUDE\n4\n1\n0\n1\n";
  EXPECT_THAT(ies_error(f.text()),
              StartsWith("lamp.ies:5: lamp-to-luminaire geometry = 4, allowed"));
  f.tilt = "TILT=INCLUDE\n1\n2\n10 90\n1 1\n";
  EXPECT_THAT(ies_error(f.text()),
              StartsWith("lamp.ies:7: tilt angles from 10 to 90 degrees, allowed: from 0"));
  f.tilt = "TILT=INCLUDE\n1\n900000000\n0 90\n1 1\n";
  EXPECT_THAT(ies_error(f.text()),
              StartsWith("lamp.ies:6: 1800000000 numbers announced, allowed: as many"));
  f.tilt = "tilt = none\n";
  EXPECT_EQ(down(f.text()), 100);
  f.tilt = "TILT=\n";
  EXPECT_THAT(ies_error(f.text()), StartsWith("lamp.ies:4: TILT= has no value"));
  f.tilt = "";
  EXPECT_THAT(ies_error(f.text()), HasSubstr("no line \"TILT=\""));
}

TEST(Ies, EndsOfLinesOfEveryKind) {
  const std::string unix_text = Ies().text();
  for (const char* end : {"\r\n", "\r"}) {
    std::string text;
    for (const char c : unix_text) text += c == '\n' ? end : std::string(1, c);
    EXPECT_EQ(down(text), 100);
    // The line number in an error stays the same.
    const std::size_t at = text.find("TILT");
    EXPECT_THAT(ies_error(text.substr(0, at) + "X" + text.substr(at)), StartsWith("lamp.ies:9:"));
  }
  EXPECT_EQ(down(unix_text.substr(0, unix_text.size() - 1)), 100);
  // The mark is not part of the line that names the edition.
  EXPECT_EQ(ies("\xef\xbb\xbf" + unix_text).format, "IES LM-63-2002, type C");
  Ies semicolons;
  semicolons.candela = "100; 50;10";
  EXPECT_EQ(down(semicolons.text()), 100);
  Ies blanks;
  blanks.candela =
      "100\xc2\xa0"
      "50\xa0"
      "10";
  EXPECT_EQ(down(blanks.text()), 100);
  Ies commas;
  commas.candela = "100, 50,10";
  EXPECT_EQ(down(commas.text()), 100);
  Ies wrapped;
  wrapped.angles = "0\n45\n\n90 0\n";
  wrapped.candela = "100\n50\n10";
  EXPECT_EQ(down(wrapped.text()), 100);
}

TEST(Ies, SmallNegativeIntensitiesAreNoiseAboutZero) {
  Ies f;
  f.candela = "100 -0.25 -1.5\n";
  const PhotometricFile file = ies(f.text());
  EXPECT_EQ(notes(file), "9 2 negative intensities, down to -1.5 -> 0\n");
  EXPECT_EQ(file.web->at({1, 0, 1}), 0);
  EXPECT_EQ(file.web->at({0, 0, 1}), 100);
  f.candela = "100 -3 0\n";
  EXPECT_EQ(ies(f.text()).web->at({1, 0, 1}), 0);
  f.candela = "100 -3.5 0\n";
  EXPECT_EQ(ies_error(f.text()),
            "lamp.ies:9: candela value 2 = -3.5, allowed: finite, not negative, and noise down to "
            "-3% of the largest");
}

// Commas separate numbers in LM-63, so a file with decimal commas has more than it announces.
TEST(Ies, DecimalCommasAreReadIfTheCountsThenFit) {
  Ies f;
  f.candela = "100,5 80,5 0,5\n";
  PhotometricFile file = ies(f.text());
  EXPECT_THAT(notes(file),
              HasSubstr("1 decimal commas, which separate numbers in LM-63 -> read as"));
  EXPECT_EQ(file.web->at({0, 0, 1}), 100.5);
  EXPECT_NEAR(file.web->at({1, 0, 1}), 80.5, 1e-12);
  // In the header they would move all that follows.
  f.lamps = "1 -1 1,0";
  f.units = "2 0,12 0 0\n";
  f.ballast = "0,5 1,0 10\n";
  f.angles = "0,0 45,0 90,0\n0,0\n";
  file = ies(f.text());
  EXPECT_EQ(file.web->at({0, 0, 1}), 50.25);
  EXPECT_EQ(file.opening->what, "a luminous opening of 0.12 m");
  f = {};
  f.candela = "100,5;80,5;0,5\n";
  EXPECT_EQ(down(f.text()), 100.5);
  f.candela = "100,5, 80,5, 0,5\n";
  EXPECT_EQ(down(f.text()), 100.5);
  // Without blanks they are separators, as in LM-63.
  f.angles = "0,45,90\n0\n";
  f.candela = "100,50,10\n";
  EXPECT_EQ(down(f.text()), 100);
  EXPECT_EQ(notes(ies(f.text())), "");
  f.candela = "100,50,10 5\n";
  EXPECT_EQ(ies_error(f.text()),
            "lamp.ies:9: more numbers than announced, with commas between digits; commas separate "
            "numbers, allowed: decimal points");
  f = {};
  f.lamps = "1 -1 1,0";
  f.candela = "100,5 80,5 x\n";
  EXPECT_THAT(ies_error(f.text()), HasSubstr("; commas separate numbers, allowed: decimal points"));
}

// "1,000" is a thousand in some countries and one in others.
TEST(Ies, CommasOfThousandsAreNotDecimals) {
  Ies f;
  f.candela = "1,000 1,000 2,500\n";
  EXPECT_EQ(ies_error(f.text()),
            "lamp.ies:9: \"1,000\" is 1000 or 1, and no other number decides it, allowed: numbers "
            "without commas");
  // The counts fit with decimal commas only, and 0,125 has no thousands.
  f.candela = "1,000 1,000 0,125\n";
  EXPECT_EQ(down(f.text()), 1);
  f.candela = "1000,000 1,000 1,250\n";
  EXPECT_EQ(down(f.text()), 1000);
}

TEST(Ies, LuminousOpeningsAreNotedForPoints) {
  Ies f;
  EXPECT_FALSE(ies(f.text()).opening);
  f.units = "2 -0.5 0.25 0\n";
  const auto opening = ies(f.text()).opening;
  ASSERT_TRUE(opening);
  EXPECT_EQ(opening->line, 5);
  EXPECT_EQ(opening->what, "a luminous opening of 0.5 x 0.25 m");
  EXPECT_EQ(opening->instead, "a point; right from about 5 times that size on");
  f.units = "1 1 0 0\n";
  EXPECT_EQ(ies(f.text()).opening->what, "a luminous opening of 0.3048 m");
}

TEST(Ies, UnitsOfRadiantIntensityAreReported) {
  const auto unit = [](const std::string& line) {
    Ies f;
    f.header = "IESNA:LM-63-2002\n[TEST] none\n" + line + "\n";
    return ies(f.text()).flux_unit;
  };
  EXPECT_EQ(unit("[_INTENSITYUNITS] mW/sr"), "mW");
  EXPECT_EQ(unit("[_intensityunits]   W/SR "), "W");
  EXPECT_EQ(unit("[_INTENSITYUNITS] \xc2\xb5W/sr"), "uW");
  EXPECT_EQ(unit("[_INTENSITYUNITS] \xb5W / sr"), "uW");
  EXPECT_EQ(unit("[_INTENSITYUNIT] milliwatts per steradian"), "mW");
  EXPECT_EQ(unit("[_FLUXUNITS] mW"), "mW");
  EXPECT_EQ(unit("[OTHER] All values are in uW/sr."), "uW");
  EXPECT_EQ(unit("[MORE] (mW sr-1)"), "mW");
  EXPECT_EQ(unit("[_INTENSITYUNITS] umol/s/sr"), "umol/s");
  EXPECT_EQ(unit("[_PHOTONS] umol s-1 sr-1"), "umol/s");
  EXPECT_EQ(unit("[MORE] \xc2\xb5mol\xc2\xb7s\xe2\x81\xbb\xc2\xb9\xc2\xb7sr\xe2\x81\xbb\xc2\xb9"),
            "umol/s");
  EXPECT_EQ(unit("[OTHER] PPF per sr"), "umol/s");
  EXPECT_EQ(unit("[_INTENSITYUNITS] mW/ster"), "mW");
  EXPECT_EQ(unit("[_UNIT_OF_INTENSITY]W*sr^-1"), "W");
  for (const char* none :
       {"[_INTENSITYUNITS] cd", "[_INTENSITYUNITS] Candela", "[_INTENSITYUNITS]", "[_UNITS] mm",
        "[LAMP] 40 W", "[_POWERUNITS] W", "[OTHER] peak of 0.5 W/sr at 850 nm", "[MORE] in lm/W",
        "[_INPUTPOWERUNIT] mW", "[_COMMUNITY] W", "[_UNITED] W", "[_LENGTHUNITS] furlong",
        "[_RADIANTPOWER] 500 mW", "[_PPF] 70 umol/s"})
    EXPECT_EQ(unit(none), "") << none;
  // Another unit, or none that is known.
  for (const char* odd : {"[_INTENSITYUNITS] uW/cm2", "[_UNITS] cd/klm", "[_FLUXUNIT] photons"})
    EXPECT_EQ(unit(odd), "unknown") << odd;
  Ies odd;
  odd.header = "IESNA:LM-63-2002\n[_INTENSITYUNITS] uW/cm2\n";
  EXPECT_EQ(ies(odd.text()).unit->what, "intensities in \"uW/cm2\", not in cd");
  EXPECT_EQ(ies(odd.text()).unit->instead,
            "read as if in cd: lm and lx of this light are numbers in an unknown unit");
  // The flux of the file's intensities.
  const std::string lm = fmt::format("{:.0f}", ies(odd.text()).web->flux_lm());
  EXPECT_EQ(unit("[_ABSOLUTERADIANTPOWER]" + lm + " mW"), "mW");
  Ies f;
  f.header = "IESNA:LM-63-2002\n[_INTENSITYUNITS] mW/sr\n";
  const PhotometricFile file = ies(f.text());
  ASSERT_TRUE(file.unit);
  EXPECT_EQ(file.unit->line, 2);
  EXPECT_EQ(file.unit->what, "intensities in mW/sr, not in cd");
  EXPECT_EQ(file.unit->instead,
            "read as if in cd: of this light, lm stand for mW and lx for mW/m2");
}

// Values of the edition of 2019, such as 1.00010 for computer simulations.
TEST(Ies, HowAFileWasMadeScalesNothing) {
  Ies f;
  f.header = "IES:LM-63-2019\n";
  f.ballast = "1 1.10010 10\n";
  EXPECT_EQ(down(f.text()), 100);
  f.ballast = "1 x 10\n";
  EXPECT_THAT(ies_error(f.text()), StartsWith("lamp.ies:4: the second number after the sizes"));
}

TEST(Ies, ErrorsNameLineAndAllowedValues) {
  const auto with = [](std::string Ies::*field, const char* text) {
    Ies f;
    f.*field = text;
    return ies_error(f.text());
  };
  EXPECT_EQ(with(&Ies::lamps, "1 -2 1"),
            "lamp.ies:5: lumens per lamp = -2, allowed: -1 (absolute photometry) or more");
  EXPECT_EQ(with(&Ies::lamps, "1 -0.5 1"),
            "lamp.ies:5: lumens per lamp = -0.5, allowed: -1 (absolute photometry), 0 or more");
  EXPECT_THAT(with(&Ies::lamps, "1 -1 0"), HasSubstr("candela multiplier = 0, allowed: positive"));
  EXPECT_THAT(with(&Ies::lamps, "1 x 1"),
              StartsWith("lamp.ies:5: lumens per lamp is \"x\", allowed: a finite number"));
  EXPECT_THAT(with(&Ies::lamps, "1 nan 1"), HasSubstr("is \"nan\""));
  EXPECT_THAT(with(&Ies::counts, "2.5 1"), HasSubstr("the number of vertical angles = 2.5"));
  EXPECT_THAT(with(&Ies::counts, "0 1"), HasSubstr("vertical angles = 0, allowed: 2 or more"));
  EXPECT_THAT(with(&Ies::counts, "3 1.5"),
              HasSubstr("horizontal angles = 1.5, allowed: 1 or more"));
  EXPECT_THAT(with(&Ies::units, "3 0 0 0\n"),
              HasSubstr("units = 3, allowed: 1 (feet), 2 (metres)"));
  EXPECT_EQ(with(&Ies::ballast, "-1 1 10\n"),
            "lamp.ies:6: ballast factor = -1, allowed: not negative; 0 counts as 1");
  EXPECT_THAT(with(&Ies::angles, "0 45 800\n0\n"),
              StartsWith("lamp.ies:7: vertical angle 3 = 800, allowed: from -720 to 720"));
  EXPECT_THAT(with(&Ies::lamps, "1 -1 1e299"),
              StartsWith("lamp.ies:9: intensity 0 at horizontal angle 0 and vertical angle 0 = "));
  EXPECT_THAT(
      with(&Ies::angles, "0 45 40\n0\n"),
      StartsWith(
          "lamp.ies:7: vertical angle 3 = 40 degrees, allowed: more than the previous angle"));
  EXPECT_THAT(with(&Ies::candela, "100 50 -10\n"),
              StartsWith("lamp.ies:9: candela value 3 = -10, allowed: finite, not neg"));
  EXPECT_THAT(with(&Ies::candela, "100 1e999 10\n"),
              StartsWith("lamp.ies:9: candela value 2 is \"1e999\", allowed: a finite number"));
  EXPECT_EQ(with(&Ies::candela, "100 50"), "lamp.ies:9: the file ends before candela value 3");
  EXPECT_THAT(ies_error(""), StartsWith("lamp.ies:0: no line \"TILT=\""));
  Ies more;
  more.candela = "100 50 10\n[BLOCK]\n";
  EXPECT_EQ(notes(ies(more.text())), "10 text after the last candela value -> left out\n");
}

}  // namespace
}  // namespace lucerna
