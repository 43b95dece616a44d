// IES LM-63: the angles of planes, which end early or go on by symmetry, and types A and B.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "server/files/ies.h"
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

TEST(Ies, MissingPlanesAreFilledBySymmetry) {
  Ies f;
  f.counts = "2 2";
  f.angles = "0 90\n0 90\n";
  f.candela = "10 20\n10 40\n";
  auto web = ies(f.text()).web;
  for (const Vec3& w : {Vec3{0, 1, 0}, {0, -1, 0}})
    EXPECT_NEAR(web->at(w + Vec3{0, 0, 1e-9}), 40, 1e-6);
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
}

TEST(Ies, ThePlaneAt360MayBeLeftOut) {
  Ies f;
  f.counts = "2 4";
  f.angles = "0 90\n0 90 180 270\n";
  f.candela = "1 1\n2 2\n3 3\n4 4\n";
  const PhotometricFile open = ies(f.text());
  EXPECT_EQ(notes(open), "");
  EXPECT_NEAR(open.web->at({1, 1, 1e-9}), 2.5, 1e-6);  // H = 315
  f.counts = "2 5";
  f.angles = "0 90\n0 90 180 270 360\n";
  f.candela += "1 1\n";
  EXPECT_EQ(open.web->flux_lm(), ies(f.text()).web->flux_lm());
}

TEST(Ies, AnglesThatEndEarlyAreNoted) {
  Ies f;
  f.angles = "0 45 80\n0\n";
  EXPECT_EQ(notes(ies(f.text())),
            "7 vertical angles from 0 to 80 degrees -> dark outside of them\n");
  EXPECT_EQ(ies(f.text()).web->at({1, 0, 0.1}), 0);
  f.counts = "2 3";
  f.angles = "0 90\n0 40 80\n";
  f.candela = "9 3\n9 6\n9 9\n";
  EXPECT_EQ(notes(ies(f.text())),
            "8 horizontal angles from 0 to 80 degrees -> symmetric about the planes 0 and 90\n");
  EXPECT_NEAR(ies(f.text()).web->at({0, 1, 1e-9}), 9, 1e-6);
  f.type = "2";
  f.counts = "2 2";
  f.angles = "-30 30\n0 40\n";
  f.candela = "9 9\n9 9\n";
  EXPECT_EQ(notes(ies(f.text())),
            "7 vertical angles from -30 to 30 degrees -> dark outside of them\n"
            "8 horizontal angles from 0 to 40 degrees -> symmetric about 0, and dark beyond 40\n");
  // 9 cd over 60 degrees about the axis, times 2 sin(40 degrees).
  EXPECT_NEAR(ies(f.text()).web->flux_lm(), 9 * kPi / 3 * 2 * std::sin(40 * kPi / 180), 1e-12);
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

// All planes of type A meet at V = 90, and H = 90 of type B is one direction.
TEST(Ies, PolesOfTypesAAndBAreOneDirection) {
  Ies f;
  f.counts = "3 3";
  f.angles = "-90 0 90\n-90 0 90\n";
  f.candela = "1 50 2\n1 50 3\n1 50 7\n";
  f.type = "3";
  EXPECT_EQ(notes(ies(f.text())),
            "9 intensities from 2 to 7 at V = 90, which is one direction -> their mean in this "
            "direction, and the file's beside it\n");
  const auto at = [&](const Vec3& w) { return ies(f.text()).web->at(w); };
  // The mean over the azimuth, with any rounding.
  for (const double x : {0., -0., 1e-17, -1e-17})
    EXPECT_NEAR(at({x, 0, -1}), (2 + 2 * 3 + 7) / 4., 1e-12) << x;
  EXPECT_NEAR(at({-0., -0., 1}), 1, 1e-12);
  f.type = "2";
  EXPECT_THAT(notes(ies(f.text())), HasSubstr("9 intensities from 1 to 50 at H = -90, which is"));
  EXPECT_THAT(notes(ies(f.text())), HasSubstr("9 intensities from 1 to 50 at H = 90, which is"));
  for (const double z : {0., -0., -1e-17})
    EXPECT_NEAR(at({0, 1, z}), (1 + 2 * 50 + 7) / 4., 1e-12) << z;
}

// As one plane of type C, about the beam: +x for type A, +z for type B.
TEST(Ies, OnePlaneOfTypesAAndBIsSymmetricAboutTheBeam) {
  Ies f;
  f.counts = "10 1";
  f.angles = "0 10 20 30 40 50 60 70 80 90\n0\n";
  f.candela = "100 98 94 87 77 64 50 34 17 0\n";
  const auto c = ies(f.text()).web;
  for (const char* type : {"2", "3"}) {
    f.type = type;
    const PhotometricFile file = ies(f.text());
    EXPECT_EQ(notes(file),
              "7 vertical angles from 0 to 90 degrees -> dark outside of them\n"
              "8 one horizontal angle, 0 degrees -> symmetric about the direction V = H = 0\n");
    EXPECT_NEAR(file.web->flux_lm() / c->flux_lm(), 1, 1e-4);
    for (int i = 0; i < 100; ++i) {
      const double angle = 0.9 * i * kPi / 180, turn = 0.7 * i;
      const double r = std::sin(angle), z = std::cos(angle);
      const Vec3 about_z{r * std::cos(turn), r * std::sin(turn), z};
      const Vec3 beam = f.type == "2" ? about_z : Vec3{z, r * std::cos(turn), r * std::sin(turn)};
      EXPECT_NEAR(file.web->at(beam), c->at(about_z), 0.05) << type << " " << i;
    }
  }
  // Both sides of the beam.
  f.type = "2";
  f.counts = "3 1";
  f.angles = "-60 0 60\n0\n";
  f.candela = "10 50 20\n";
  EXPECT_NEAR(ies(f.text()).web->at({std::sqrt(3.) - 1e-9, 0, 1}), 15, 1e-6);
  EXPECT_NEAR(ies(f.text()).web->at({0, std::sqrt(3.) - 1e-9, 1}), 15, 1e-6);
  EXPECT_NEAR(ies(f.text()).web->at({1, 1, 1}), ies(f.text()).web->at({-1, 1, 1}), 1e-9);
  f.angles = "-60 0 60\n90\n";
  EXPECT_THAT(ies_error(f.text()), HasSubstr("1 horizontal angle, allowed: 2 or more"));
}

TEST(Ies, HorizontalAnglesMayGoBeyondACircle) {
  Ies f;
  f.counts = "2 5";
  f.angles = "0 90\n90 180 270 360 450\n";
  f.candela = "1 1\n2 2\n3 3\n4 4\n1 1\n";
  EXPECT_EQ(notes(ies(f.text())), "");
  EXPECT_NEAR(ies(f.text()).web->at({1, 0, 1e-9}), 4, 1e-6);   // H = 0
  EXPECT_NEAR(ies(f.text()).web->at({0, -1, 1e-9}), 1, 1e-6);  // H = 90
}

// LM-63-1986 has the number 1 for types A and C.
TEST(Ies, NegativeVerticalAnglesInTheFirstEditionAreTypeA) {
  Ies f;
  f.header = "a headlamp\n";
  f.counts = "3 2";
  f.angles = "-90 0 90\n-90 90\n";
  f.candela = "0 50 0\n0 50 0\n";
  EXPECT_EQ(ies(f.text()).format, "IES LM-63-1986, type A");
  EXPECT_NEAR(ies(f.text()).web->at({1, 0, 0}), 50, 1e-9);
  f.header = "IESNA91\n";
  EXPECT_THAT(ies_error(f.text()),
              StartsWith("lamp.ies:5: vertical angles from -90 to 90 degrees, allowed for type C"));
}

}  // namespace
}  // namespace lucerna
