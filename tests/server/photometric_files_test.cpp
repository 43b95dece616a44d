// IES LM-63 and EULUMDAT: the standards' readings, and errors that say line and what is allowed.
// All luminaires here are made up.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "server/eulumdat.h"
#include "server/ies.h"

namespace lucerna {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr double kPi = std::numbers::pi;

struct Ies {
  std::string header = "IESNA:LM-63-2002\n[TEST] made up\n[MANUFAC] none\n";
  std::string tilt = "TILT=NONE\n";
  std::string lamps = "1 1000 1";
  std::string counts = "3 1";
  std::string type = "1";
  std::string units = "2 0 0 0\n";
  std::string ballast = "1 1 10\n";
  std::string angles = "0 45 90\n0\n";
  std::string candela = "100 50 10\n";
  std::string text() const {
    return header + tilt + lamps + " " + counts + " " + type + " " + units + ballast + angles +
           candela;
  }
};

PhotometricFile ies(const std::string& text) {
  auto file = parse_ies(text, "lamp.ies");
  EXPECT_TRUE(file.ok()) << file.status();
  return file.ok() ? *std::move(file) : PhotometricFile{};
}
std::string ies_error(const std::string& text) {
  const auto file = parse_ies(text, "lamp.ies");
  return file.ok() ? "" : std::string(file.status().message());
}
double down(const std::string& text) {
  const PhotometricFile file = ies(text);
  return file.web ? file.web->at({0, 0, 1}) : -1;
}
std::string notes(const PhotometricFile& file) {
  std::string result;
  for (const auto& n : file.notes)
    result += fmt::format("{} {} -> {}\n", n.line, n.what, n.instead);
  return result;
}

TEST(Ies, ReadsTheIntensities) {
  const PhotometricFile file = ies(Ies().text());
  ASSERT_TRUE(file.web);
  EXPECT_EQ(file.format, "IES LM-63-2002, type C");
  EXPECT_EQ(notes(file), "");
  EXPECT_EQ(file.web->at({0, 0, 1}), 100);
  EXPECT_NEAR(file.web->at({1, 0, 1}), 50, 1e-12);
  EXPECT_EQ(file.web->at({0, 0, -1}), 0);
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
  Ies odd;
  odd.header = "IESNA:LM-63-2040\n";
  EXPECT_EQ(
      notes(ies(odd.text())),
      "1 edition \"IESNA:LM-63-2040\" is none of LM-63-1986, 1991, 1995, 2002, 2019 -> read as "
      "that of 2002\n");
}

TEST(Ies, LumensScaleNothing) {
  for (const char* lamps : {"1 -1 1", "2 3500 1", "0 0 1"}) {
    Ies f;
    f.lamps = lamps;
    EXPECT_EQ(down(f.text()), 100) << lamps;
  }
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

TEST(Ies, UnitsOfLengthScaleNoCandela) {
  Ies f;
  f.units = "1 -0.5 -0.5 0\n";
  EXPECT_EQ(down(f.text()), 100);
}

TEST(Ies, TiltTablesAreReadAndTheFactorAtTiltZeroHolds) {
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
            "4 tilt factors in \"mh400.tlt\" are not read -> 1, that of a luminaire that is not "
            "tilted\n");
  f.tilt = "TILT=INCLUDE\n4\n1\n0\n1\n";
  EXPECT_THAT(ies_error(f.text()),
              StartsWith("lamp.ies:5: lamp-to-luminaire geometry = 4, allowed"));
  f.tilt = "TILT=INCLUDE\n1\n2\n10 90\n1 1\n";
  EXPECT_THAT(ies_error(f.text()), HasSubstr("tilt angle 1 = 10, allowed: 0 first"));
  f.tilt = "TILT=INCLUDE\n1\n900000000\n0 90\n1 1\n";
  EXPECT_THAT(ies_error(f.text()), HasSubstr("1800000000 numbers are claimed"));
  f.tilt = "TILT=\n";
  EXPECT_THAT(ies_error(f.text()), StartsWith("lamp.ies:4: TILT= nothing"));
  f.tilt = "";
  EXPECT_THAT(ies_error(f.text()), HasSubstr("no line \"TILT=\""));
}

TEST(Ies, EndsOfLinesOfEveryKind) {
  const std::string unix_text = Ies().text();
  for (const char* end : {"\r\n", "\r"}) {
    std::string text;
    for (const char c : unix_text) text += c == '\n' ? end : std::string(1, c);
    EXPECT_EQ(down(text), 100);
    // The line in an error stays the same.
    const std::size_t at = text.find("TILT");
    EXPECT_THAT(ies_error(text.substr(0, at) + "X" + text.substr(at)), StartsWith("lamp.ies:9:"));
  }
  EXPECT_EQ(down(unix_text.substr(0, unix_text.size() - 1)), 100);
  EXPECT_EQ(down("\xef\xbb\xbf" + unix_text), 100);
  Ies commas;
  commas.candela = "100, 50,10";
  EXPECT_EQ(down(commas.text()), 100);
  Ies wrapped;
  wrapped.angles = "0\n45\n\n90 0\n";
  wrapped.candela = "100\n50\n10";
  EXPECT_EQ(down(wrapped.text()), 100);
}

TEST(Ies, MissingPlanesAreFilledBySymmetry) {
  Ies f;
  f.counts = "2 2";
  f.angles = "0 90\n0 90\n";
  f.candela = "10 20\n10 40\n";
  auto web = ies(f.text()).web;
  for (const Vec3<double> w : {Vec3<double>{0, 1, 0}, {0, -1, 0}})
    EXPECT_NEAR(web->at(w + Vec3<double>{0, 0, 1e-9}), 40, 1e-6);
  EXPECT_NEAR(web->at({-1, 0, 1e-9}), 20, 1e-6);
  f.angles = "0 90\n0 180\n";
  web = ies(f.text()).web;
  EXPECT_NEAR(web->at({-1, 0, 1e-9}), 40, 1e-6);
  EXPECT_NEAR(web->at({0, 1, 1e-9}), 30, 1e-6);
  EXPECT_NEAR(web->at({0, -1, 1e-9}), 30, 1e-6);
  f.angles = "0 90\n90 270\n";
  web = ies(f.text()).web;
  EXPECT_NEAR(web->at({0, -1, 1e-9}), 20, 1e-6);  // H = 90
  EXPECT_NEAR(web->at({0, 1, 1e-9}), 40, 1e-6);
  EXPECT_NEAR(web->at({1, 0, 1e-9}), 30, 1e-6);
  f.angles = "0 90\n0 345\n";
  EXPECT_THAT(
      ies_error(f.text()),
      StartsWith("lamp.ies:7: horizontal angles from 0 to 345 degrees, allowed for type C"));
}

TEST(Ies, TypesAAndB) {
  Ies f;
  f.counts = "3 2";
  f.angles = "-90 0 90\n0 90\n";
  f.candela = "1 50 2\n1 10 2\n";
  f.type = "2";
  EXPECT_EQ(ies(f.text()).format, "IES LM-63-2002, type B");
  EXPECT_NEAR(down(f.text()), 50, 1e-9);
  f.type = "3";
  EXPECT_EQ(ies(f.text()).format, "IES LM-63-2002, type A");
  EXPECT_NEAR(ies(f.text()).web->at({1, 0, 0}), 50, 1e-9);
  f.type = "4";
  EXPECT_THAT(ies_error(f.text()), HasSubstr("photometric type = 4, allowed: 1 (type C)"));
}

TEST(Ies, ClaimsAreCheckedBeforeAnythingIsAllocated) {
  Ies f;
  f.counts = "1000 1000";
  EXPECT_THAT(ies_error(f.text()), HasSubstr("1002000 numbers are claimed to follow, where"));
  f.counts = "1000000000 1000000000";
  EXPECT_THAT(ies_error(f.text()), HasSubstr("numbers are claimed to follow, where"));
}

TEST(Ies, ErrorsNameLineAndWhatIsAllowed) {
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
  EXPECT_THAT(with(&Ies::units, "3 0 0 0\n"),
              HasSubstr("units = 3, allowed: 1 (feet), 2 (metres)"));
  EXPECT_THAT(with(&Ies::ballast, "0 1 10\n"), StartsWith("lamp.ies:6: ballast factor = 0"));
  EXPECT_THAT(with(&Ies::angles, "0 45 40\n0\n"), StartsWith("lamp.ies:7: vertical angle[2] = 40"));
  EXPECT_THAT(with(&Ies::candela, "100 50 -10\n"), HasSubstr("= -10 cd, allowed: finite, not neg"));
  EXPECT_EQ(with(&Ies::candela, "100 50"), "lamp.ies:9: the file ends before candela value 3");
  EXPECT_THAT(ies_error(""), StartsWith("lamp.ies:0: no line \"TILT=\""));
  Ies more;
  more.candela = "100 50 10\n[BLOCK]\n";
  EXPECT_EQ(notes(ies(more.text())), "10 more after the last candela value -> left out\n");
}

// A luminaire whose intensity is 318.3 cos V, each 5 degrees, and the standard's zonal method: the
// middles of zones of 10 degrees times their solid angles, which for a cosine is 1 / cos(5 degrees)
// times the integral.  Straight lines 5 degrees apart lose h^2 / 12 of a cosine, to 1e-6.
TEST(Ies, TotalAgreesWithTheZonalLumenSum) {
  Ies f;
  f.counts = "19 1";
  f.angles = f.candela = "";
  double zonal = 0;
  for (int v = 0; v <= 90; v += 5) {
    const double cd = 318.3 * std::cos(v * kPi / 180);
    f.angles += fmt::format("{} ", v);
    f.candela += fmt::format("{:.6f} ", std::fabs(cd));
    if (v % 10 == 5)
      zonal += cd * 2 * kPi * (std::cos((v - 5) * kPi / 180) - std::cos((v + 5) * kPi / 180));
  }
  f.angles += "\n0\n";
  const double h = 5 * kPi / 180, lost = h * h / 12;
  EXPECT_NEAR(ies(f.text()).web->flux_lm() / zonal, std::cos(h) * (1 - lost), 1e-5);
  EXPECT_NEAR(ies(f.text()).web->flux_lm() / (318.3 * kPi), 1 - lost, 1e-5);
}

struct Ldt {
  int symmetry = 1, mc = 1, ng = 3;
  std::string conversion = "1", lorl = "", sets = "1";
  std::vector<std::string> lamps{"1", "lamp", "2000", "3000", "80", "20"};
  std::vector<std::string> c{"0"}, gamma{"0", "45", "90"}, intensities{"100", "50", "10"};
  std::string end = "\n";
  std::string text() const {
    std::vector<std::string> lines{"made up",
                                   "1",
                                   std::to_string(symmetry),
                                   std::to_string(mc),
                                   "0",
                                   std::to_string(ng),
                                   "0",
                                   "report",
                                   "name",
                                   "number",
                                   "file",
                                   "date",
                                   "100",
                                   "0",
                                   "50",
                                   "100",
                                   "0",
                                   "0",
                                   "0",
                                   "0",
                                   "0",
                                   "100",
                                   lorl,
                                   conversion,
                                   "0",
                                   sets};
    const auto add = [&](const std::vector<std::string>& more) {
      lines.insert(lines.end(), more.begin(), more.end());
    };
    add(lamps);
    add(std::vector<std::string>(10, "0.5"));
    add(c), add(gamma), add(intensities);
    std::string result;
    for (const auto& line : lines) result += line + end;
    return result;
  }
};

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
  f.lamps[0] = "-1";  // absolute photometry
  EXPECT_NEAR(ldt(f.text()).web->at({0, 0, 1}), 300, 1e-12);
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

/// Intensities per 1000 lm at gamma = 90 by plane, the same 10 at gamma 0.
Ldt planes(int symmetry, const std::vector<std::string>& values) {
  Ldt f;
  f.symmetry = symmetry;
  f.mc = 8;
  f.ng = 2;
  f.c = {"0", "45", "90", "135", "180", "225", "270", "315"};
  f.gamma = {"0", "180"};
  f.lamps[2] = "1000";
  f.intensities.clear();
  for (const auto& v : values) {
    f.intensities.push_back(v);
    f.intensities.push_back(v);
  }
  return f;
}

TEST(Eulumdat, PlanesOfEachSymmetry) {
  // C90 is towards -y where +z is down.
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
  // From C270 over C0 to C90; mirrored at that plane.
  expect(planes(3, {"1", "2", "3", "4", "5"}), {3, 4, 5, 4, 3, 2, 1, 2});
  expect(planes(4, {"1", "2", "3"}), {1, 2, 3, 2, 1, 2, 3, 2});
}

TEST(Eulumdat, SetsOfLampsBeyondTheFirstAreLeftOut) {
  Ldt f;
  f.sets = "2";
  const std::vector<std::string> second{"1", "other", "5000", "4000", "80", "50"};
  f.lamps.insert(f.lamps.end(), second.begin(), second.end());
  EXPECT_EQ(ldt(f.text()).web->at({0, 0, 1}), 200);
  EXPECT_EQ(notes(ldt(f.text())), "26 2 sets of lamps -> the first of them\n");
}

// 1000/pi (1 - gamma/90) cd per 1000 lm of lamps make 2000 (1 - 2/pi) = 726.8 lm per 1000 lm.
TEST(Eulumdat, LightOutputRatioIsComparedWithTheIntensities) {
  Ldt f;
  f.intensities = {"318.30989", "159.15494", "0"};
  f.lorl = "72.7";
  EXPECT_EQ(notes(ldt(f.text())), "");
  f.lorl = "60";
  EXPECT_EQ(notes(ldt(f.text())),
            "23 a light output ratio of 60%, which makes 1200 lm -> what the intensities make, "
            "1453.52 lm\n");
}

TEST(Eulumdat, ErrorsNameLineAndWhatIsAllowed) {
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
  EXPECT_THAT(ldt_error(f.text()), HasSubstr("1000 planes of 1000 intensities are claimed"));
  f.mc = f.ng = 1000000000;
  EXPECT_THAT(ldt_error(f.text()), HasSubstr("are claimed"));
  f = {};
  f.conversion = "0";
  EXPECT_EQ(ldt_error(f.text()), "lamp.ldt:24: the conversion factor = 0, allowed: positive");
  f = {};
  f.sets = "0";
  EXPECT_THAT(ldt_error(f.text()), StartsWith("lamp.ldt:26: the number of sets of lamps = 0"));
  f = {};
  f.lamps[2] = "x";
  EXPECT_THAT(ldt_error(f.text()),
              StartsWith("lamp.ldt:29: the luminous flux of the lamps is \"x\""));
  f = {};
  f.gamma = {"0", "45", "80"};
  EXPECT_THAT(ldt_error(f.text()), StartsWith("lamp.ldt:43: vertical angles from 0 to 80"));
  f = {};
  f.intensities[1] = "-5";
  EXPECT_THAT(ldt_error(f.text()), StartsWith("lamp.ldt:48: an intensity per 1000 lm = -5"));
  EXPECT_THAT(ldt_error("made up\n"), HasSubstr("the file ends before the symmetry Isym (line 3)"));
}

/// Some bytes changed, inserted, removed or repeated.
std::string mutated(std::string text, std::mt19937& random) {
  const auto below = [&](std::size_t n) { return n == 0 ? 0 : random() % n; };
  static const char* kWords[] = {"-1", "1e308",          "999999999", "nan",
                                 "\r", "TILT=INCLUDE\n", "0 ",        "-"};
  for (std::size_t edits = 1 + below(3); edits > 0; --edits) {
    const std::size_t at = below(text.size());
    switch (below(4)) {
      case 0:
        text[at] = static_cast<char>(random());
        break;
      case 1:
        text.insert(at, kWords[below(std::size(kWords))]);
        break;
      case 2:
        text.erase(at, 1 + below(10));
        break;
      default:
        text.insert(at, text.substr(below(text.size()), below(20)));
    }
    if (text.empty()) text.push_back(' ');
  }
  return text;
}

template <typename Parse>
void check_mutations(const std::string& whole, Parse&& parse) {
  std::mt19937 random(1963);
  int errors = 0, good = 0;
  const auto check = [&](const std::string& text) {
    const auto file = parse(text);
    if (!file.ok()) {
      ++errors;
      for (const char c : std::string(file.status().message())) ASSERT_TRUE(c >= ' ' && c <= '~');
      return;
    }
    ++good;
    const double flux = file->web->flux_lm();
    ASSERT_TRUE(std::isfinite(flux) && flux >= 0) << flux;
    for (int i = 0; i < 20; ++i) {
      const Vec3<double> w{double(random()) - 2e9, double(random()) - 2e9, double(random()) - 2e9};
      const double cd = file->web->at(w);
      ASSERT_TRUE(cd >= 0 && cd <= file->web->max_cd()) << cd;
    }
  };
  for (std::size_t size = 0; size <= whole.size(); ++size) check(whole.substr(0, size));
  for (int i = 0; i < 5000; ++i) check(mutated(whole, random));
  EXPECT_GT(errors, 500);
  EXPECT_GT(good, 500);
}

TEST(Ies, BrokenFilesEndWithAWebOrAnError) {
  Ies f;
  f.tilt = "TILT=INCLUDE\n1\n2\n0 90\n1 0.9\n";
  f.counts = "3 2";
  f.angles = "0 45 90\n0 90\n";
  f.candela = "100 50 10\n100 60 20\n";
  check_mutations(f.text(), [](const std::string& t) { return parse_ies(t, "lamp.ies"); });
}

TEST(Eulumdat, BrokenFilesEndWithAWebOrAnError) {
  const std::string whole = planes(3, {"1", "2", "3", "4", "5"}).text();
  check_mutations(whole, [](const std::string& t) { return parse_eulumdat(t, "lamp.ldt"); });
}

}  // namespace
}  // namespace lucerna
