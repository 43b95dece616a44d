// Invented photometric files for tests, put together from parts.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "server/files/ies.h"
#include "server/files/photometric_file.h"

namespace lucerna::testing {

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

struct Ldt {
  int symmetry = 1, mc = 1, ng = 3;
  std::string conversion = "1", tilt = "0", lorl = "", sets = "1";
  std::vector<std::string> lamps{"1", "lamp", "2000", "3000", "80", "20"};
  /// Length, width, and four heights of the luminous area.
  std::vector<std::string> luminous_mm{"0", "0", "0", "0", "0", "0"};
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
                                   "50"};
    const auto add = [&](const std::vector<std::string>& more) {
      lines.insert(lines.end(), more.begin(), more.end());
    };
    add(luminous_mm), add({"100", lorl, conversion, tilt, sets});
    add(lamps);
    add(std::vector<std::string>(10, "0.5"));
    add(c), add(gamma), add(intensities);
    std::string result;
    for (const auto& line : lines) result += line + end;
    return result;
  }
};

/// Intensities per 1000 lm at gamma = 90 by plane; 10 at gamma 0.
inline Ldt planes(int symmetry, const std::vector<std::string>& values) {
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

/// "line what -> instead" for each note, one per line.
inline std::string notes(const PhotometricFile& file) {
  std::string result;
  for (const auto& n : file.notes)
    result += fmt::format("{} {} -> {}\n", n.line, n.what, n.instead);
  return result;
}

inline PhotometricFile ies(const std::string& text) {
  auto file = parse_ies(text, "lamp.ies");
  EXPECT_TRUE(file.ok()) << file.status();
  return file.ok() ? *std::move(file) : PhotometricFile{};
}

inline std::string ies_error(const std::string& text) {
  const auto file = parse_ies(text, "lamp.ies");
  return file.ok() ? "" : std::string(file.status().message());
}

inline double down(const std::string& text) {
  const PhotometricFile file = ies(text);
  return file.web ? file.web->at({0, 0, 1}) : -1;
}

}  // namespace lucerna::testing
