// Files as people have them: other names, other encodings.
#include "server/files/read_luminaire.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/server/files/photometric_texts.h"

namespace lucerna {
namespace {

using ::testing::HasSubstr;
using testing::Ies;
using testing::Ldt;
using testing::notes;

/// "format: notes" or the error.
std::string outcome(const std::string& bytes, const std::string& name) {
  const auto file = read_luminaire(bytes, name);
  if (!file.ok()) return std::string(file.status().message());
  EXPECT_GT(file->web->at({0, 0, 1}), 0);
  return file->format + ": " + notes(*file);
}

TEST(ReadLuminaire, TheContentDecidesAndNotTheName) {
  const std::string ies = Ies().text(), ldt = Ldt().text();
  EXPECT_EQ(outcome(ies, "lamp.ies"), "IES LM-63-2002, type C: ");
  EXPECT_EQ(outcome(ldt, "LAMP.LDT"), "EULUMDAT: ");
  EXPECT_EQ(outcome(ies, "lamp.ldt"),
            "IES LM-63-2002, type C: 1 the name of a file of EULUMDAT -> read as IES LM-63-2002, "
            "type C\n");
  EXPECT_EQ(outcome(ldt, "lamp.ies"),
            "EULUMDAT: 1 the name of a file of IES -> read as EULUMDAT\n");
  EXPECT_EQ(outcome(ldt, "data:"), "EULUMDAT: ");
  Ies old;
  old.header = "a lamp\n1\n2\n3\n";
  EXPECT_THAT(outcome(old.text(), "lamp.ldt"), HasSubstr("read as IES LM-63-1986"));
  // Neither: the name decides.
  EXPECT_THAT(outcome("made up\n", "lamp.ldt"), HasSubstr("before the symmetry Isym (line 3)"));
  EXPECT_THAT(outcome("made up\n", "lamp.ies"), HasSubstr("no line \"TILT=\""));
  EXPECT_THAT(outcome("", "lamp.ies"), HasSubstr("no line \"TILT=\""));
}

TEST(ReadLuminaire, Utf16AndMarksOfTheEndAreRead) {
  const std::string text = Ies().text();
  std::string little = "\xff\xfe", big = "\xfe\xff";
  for (const char c : text) {
    little += c, little += '\0';
    big += '\0', big += c;
  }
  for (const std::string& bytes : {little, big, little + "x", "\xef\xbb\xbf" + text, text + "\x1a",
                                   text + "\x1a\r\n\x1a\n", text + std::string(3, '\0')})
    EXPECT_EQ(outcome(bytes, "lamp.ies"), "IES LM-63-2002, type C: ");
  EXPECT_EQ(outcome(Ldt().text() + "\x1a", "lamp.ldt"), "EULUMDAT: ");
}

}  // namespace
}  // namespace lucerna
