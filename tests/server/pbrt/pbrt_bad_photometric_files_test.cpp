// Gives every parameter that takes a photometric file every kind of unusual or broken file.  Either
// the light is right, or an error has the place of the parameter, its name, the file, and what is
// allowed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/server/formats/photometric_texts.h"
#include "tests/server/formats/picture_texts.h"
#include "tests/server/pbrt/bad_files.h"

namespace lucerna {
namespace {

using testing::even_pfm;
using testing::expect_error;
using ::testing::HasSubstr;
using testing::Ies;
using testing::Ldt;
using testing::load;
using testing::message;
using testing::Outcome;

struct ProfileUser {
  const char* parameter;
  std::string source;
};

const std::vector<ProfileUser>& profile_users() {
  static const std::vector<ProfileUser> users{
      {"filename",
       "Translate 0 0 2 Rotate 180 1 0 0 LightSource \"goniometric\" \"string filename\" FILE"},
      {"profile",
       "AreaLightSource \"diffuse\" \"string profile\" FILE \"bool twosided\" true "
       "ReverseOrientation Translate 0 0 2 Shape \"disk\""},
      {"profile",
       "AreaLightSource \"diffuse\" \"string profile\" FILE \"bool twosided\" true "
       "ReverseOrientation Shape \"bilinearmesh\" \"point3 P\" [-1 -1 2 1 -1 2 -1 1 2 1 1 2]"},
  };
  return users;
}

template <typename File, typename Change>
std::string changed(Change&& change) {
  File f;
  change(f);
  return f.text();
}

TEST(PbrtBadFiles, BrokenPhotometricFilesAreErrorsForEveryParameter) {
  const auto ies = [](auto change) { return changed<Ies>(change); };
  const auto ldt = [](auto change) { return changed<Ldt>(change); };
  const std::string whole_ies = Ies().text(), whole_ldt = Ldt().text();
  struct Case {
    const char* name;
    std::string bytes;
    const char* what;
  };
  const Case kFiles[] = {
      {"empty.ies", "", "empty.ies:0: no line \"TILT=\", allowed: TILT=NONE"},
      {"words.ies", "no photometry\n", "words.ies:1: no line \"TILT=\""},
      {"picture.ies", even_pfm(2, 2, 1), "no line \"TILT=\", allowed"},
      {"short.ies", whole_ies.substr(0, whole_ies.size() / 2), "the file ends before "},
      {"short_values.ies", whole_ies.substr(0, whole_ies.size() - 4),
       "the file ends before candela value 3"},
      {"angles.ies", ies([](Ies& f) { f.angles = "0 90 45\n0\n"; }),
       "angles.ies:7: vertical angle 3 = 45 degrees, allowed: more than the previous angle, 90"},
      {"plane.ies", ies([](Ies& f) { f.angles = "0 45 90\n0 0\n", f.counts = "3 2"; }),
       "plane.ies:8: horizontal angle 2 = 0 degrees, allowed: more than the previous angle"},
      {"nan.ies", ies([](Ies& f) { f.candela = "100 nan 10\n"; }),
       "nan.ies:9: candela value 2 is \"nan\", allowed: a finite number"},
      {"infinite.ies", ies([](Ies& f) { f.candela = "100 1e999 10\n"; }),
       "infinite.ies:9: candela value 2 is \"1e999\", allowed: a finite number"},
      {"negative.ies", ies([](Ies& f) { f.candela = "100 -50 10\n"; }),
       "negative.ies:9: candela value 2 = -50, allowed: finite, not negative"},
      {"none.ies", ies([](Ies& f) { f.counts = "0 1"; }),
       "none.ies:5: the number of vertical angles = 0, allowed: 2 or more"},
      {"fraction.ies", ies([](Ies& f) { f.counts = "3 1.5"; }),
       "fraction.ies:5: the number of horizontal angles = 1.5, allowed: 1 or more"},
      {"more.ies", ies([](Ies& f) { f.counts = "4 1"; }), "allowed"},
      {"huge.ies", ies([](Ies& f) { f.counts = "1000000000 1000000000"; }),
       "numbers announced, allowed: as many as"},
      {"million.ies", ies([](Ies& f) { f.counts = "1000 1000"; }),
       "1002000 numbers announced, allowed: as many as"},
      {"multiplier.ies", ies([](Ies& f) { f.lamps = "1 1000 0"; }),
       "multiplier.ies:5: candela multiplier = 0, allowed: positive"},
      {"empty.ldt", "", "empty.ldt:0: the file ends before the symmetry Isym"},
      {"picture.ldt", even_pfm(2, 2, 1),
       "picture.ldt:3: the symmetry Isym = -1, allowed: 0, 1, 2, 3 or 4"},
      {"short.ldt", whole_ldt.substr(0, whole_ldt.size() / 2), "short.ldt:"},
      {"short_values.ldt", whole_ldt.substr(0, whole_ldt.size() - 3),
       "short_values.ldt:48: the file ends before an intensity per 1000 lm (line 49)"},
      {"angles.ldt", ldt([](Ldt& f) {
         f.gamma = {"0", "90", "45"};
       }),
       "allowed"},
      {"nan.ldt", ldt([](Ldt& f) { f.intensities[1] = "nan"; }),
       "nan.ldt:48: an intensity per 1000 lm is \"nan\", allowed: a finite number"},
      {"negative.ldt", ldt([](Ldt& f) { f.intensities[1] = "-9"; }),
       "negative.ldt:48: an intensity per 1000 lm = -9, allowed: finite, not negative"},
      {"none.ldt", ldt([](Ldt& f) { f.symmetry = f.mc = 0; }),
       "none.ldt:4: the number Mc of C-planes = 0, allowed: a positive whole number"},
      {"more.ldt", ldt([](Ldt& f) { f.ng = 30; }),
       "more.ldt:6: 1 angles and 1 planes of 30 intensities are announced, allowed"},
      {"huge.ldt", ldt([](Ldt& f) { f.mc = f.ng = 1000000000; }), "announced, allowed: as many as"},
      {"symmetry.ldt", ldt([](Ldt& f) { f.symmetry = 5; }),
       "symmetry.ldt:3: the symmetry Isym = 5, allowed: 0, 1, 2, 3 or 4"},
  };
  for (const ProfileUser& user : profile_users())
    for (const Case& c : kFiles) {
      SCOPED_TRACE(std::string(user.parameter) + ", " + c.name);
      const Outcome o = load(user.source, user.parameter, c.name, c.bytes);
      expect_error(o, user.parameter, c.name);
      EXPECT_EQ(o.status.code(), absl::StatusCode::kInvalidArgument);
      EXPECT_THAT(message(o.status), HasSubstr(c.what));
    }
}

}  // namespace
}  // namespace lucerna
