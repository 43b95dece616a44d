#include "server/files/ies.h"

#include <absl/strings/ascii.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "lights/maths/stop_poll.h"
#include "proto/common/status_macros.h"
#include "server/files/ies_numbers.h"
#include "server/files/ies_unit.h"
#include "server/files/printable.h"

namespace lucerna {
namespace {

/// An edition of LM-63.
struct Edition {
  std::string_view name;
  int year;
};
constexpr double kMetresPerFoot = 0.3048;
constexpr Edition k1986{"IES LM-63-1986", 1986};
constexpr Edition k2002{"IES LM-63-2002", 2002};
constexpr Edition kEditions[] = {
    k1986, {"IES LM-63-1991", 1991}, {"IES LM-63-1995", 1995}, k2002, {"IES LM-63-2019", 2019}};

/// The edition that the first line with text names: "IESNA91", "IESNA:LM-63-2002".  Files of 1986
/// have no such line.
Edition edition_of(std::string_view text, PhotometricFile& file) {
  std::string_view first;
  int line = 0;
  for (; !text.empty() && first.empty(); ++line) first = trimmed(take_line(text));
  std::string label = upper_case(first);
  std::erase_if(label, [](char c) { return !absl::ascii_isalnum(static_cast<unsigned char>(c)); });
  std::string_view year = label;
  if (!year.starts_with("IES")) return k1986;
  for (const std::string_view part : {"IES", "NA", "LM63"})
    if (year.starts_with(part)) year.remove_prefix(part.size());
  for (const Edition& edition : kEditions)
    if (const std::string number = std::to_string(edition.year);
        year == number || year == number.substr(2))
      return edition;
  // A later edition or an unknown label.  The format has not changed since 1995.
  file.notes.push_back(
      {line,
       fmt::format("unknown edition \"{}\", known: LM-63-1986, 1991, 1995, 2002, 2019",
                   excerpt(first)),
       "read as that of 2002"});
  return k2002;
}

/// The line "TILT=".
struct TiltLine {
  std::string_view value;  ///< after the equals sign
  std::string_view rest;   ///< the lines after it
  int line;
};

/// Keywords precede the line; in the edition of 1986, free text.
absl::StatusOr<TiltLine> find_tilt(std::string_view text, std::string_view name) {
  int line = 0;
  while (!text.empty()) {
    const std::string_view found = trimmed(take_line(text));
    ++line;
    const std::size_t equals = std::min(found.find('='), found.size());
    if (equals < found.size() && upper_case(trimmed(found.substr(0, equals))) == "TILT")
      return TiltLine{trimmed(found.substr(equals + 1)), text, line};
  }
  return photometric_error(name, line,
                           "no line \"TILT=\", allowed: TILT=NONE, TILT=INCLUDE, TILT=<file>");
}

/// Reads the table that follows TILT=INCLUDE.  Returns the factor at tilt 0, the position in which
/// the luminaire was measured.
double read_tilt_table(IesNumbers& numbers, PhotometricFile& file) {
  const int line = numbers.line();
  numbers.whole("lamp-to-luminaire geometry", 1, 3, "1, 2 or 3");
  const std::size_t pairs =
      numbers.count("the number of tilt angles", 1, "a positive whole number");
  if (!numbers.room_for(2 * std::uint64_t{pairs})) return 0;
  numbers.skip();
  const int angles_line = numbers.line();
  const std::vector<double> angles = numbers.angles("tilt angle", pairs);
  if (numbers.status.ok() && !(angles.front() == 0 && angles.back() <= 180))
    numbers.check(angles_line,
                  absl::InvalidArgumentError(fmt::format(
                      "tilt angles from {} to {} degrees, allowed: from 0 to 180 at most",
                      angles.front(), angles.back())));
  const std::vector<double> factors = numbers.list("tilt factor", pairs, 0, "finite, not negative");
  if (!numbers.status.ok()) return 0;
  if (std::any_of(factors.begin(), factors.end(), [](double f) { return f != 1; }))
    file.notes.push_back({line, "a table of factors for a tilted luminaire",
                          fmt::format("the factor at tilt 0, which is {}", factors[0])});
  return factors[0];
}

/// The factor that "TILT=" specifies.
absl::StatusOr<double> read_tilt(const TiltLine& tilt, std::string_view name, IesNumbers& numbers,
                                 PhotometricFile& file) {
  const auto& [value, rest, line] = tilt;
  if (upper_case(value) == "NONE") return 1;
  if (upper_case(value) == "INCLUDE") {
    numbers.skip();
    return read_tilt_table(numbers, file);
  }
  if (value.empty())
    return photometric_error(name, line,
                             "TILT= has no value, allowed: NONE, INCLUDE or the name of a file");
  file.notes.push_back({line, fmt::format("tilt factors in \"{}\" are not read", excerpt(value)),
                        "the factor 1, for a luminaire without tilt"});
  return 1;
}

/// The two lines of numbers before the angles.
struct IesHeader {
  std::size_t vertical, horizontal;  ///< number of angles
  PhotometricType type;
  double factor;  ///< of every candela value, including the tilt factor
  int lamps;
  double lamp_lm;   ///< of each lamp; -1: absolute photometry
  int lamps_line;   ///< of the file
  double operated;  ///< the flux of the lamps in use, as a share of their rated flux
};

IesHeader read_header(IesNumbers& numbers, const Edition& edition, double tilt_factor,
                      PhotometricFile& file) {
  IesHeader header;
  numbers.skip();
  header.lamps_line = numbers.line();
  header.lamps = numbers.whole("the number of lamps", 0, 1'000'000, "a whole number, not negative");
  header.lamp_lm = numbers.number("lumens per lamp", -1, kAny, "-1 (absolute photometry) or more");
  if (numbers.status.ok() && header.lamp_lm < 0 && header.lamp_lm != -1)
    numbers.fail(fmt::format("lumens per lamp = {}, allowed: -1 (absolute photometry), 0 or more",
                             header.lamp_lm));
  const double multiplier = numbers.positive("candela multiplier");
  header.vertical = numbers.count("the number of vertical angles", 2, "2 or more");
  header.horizontal = numbers.count("the number of horizontal angles", 1, "1 or more");
  const int type = numbers.whole("photometric type", 1, 3, "1 (type C), 2 (type B), 3 (type A)");
  header.type = type == 1   ? PhotometricType::kC
                : type == 2 ? PhotometricType::kB
                            : PhotometricType::kA;
  const double unit_m =
      numbers.whole("units", 1, 2, "1 (feet), 2 (metres)") == 1 ? kMetresPerFoot : 1;
  // Negative sizes stand for rounded shapes.
  const auto size = [&](const char* what) { return numbers.number(what, -kAny, kAny, "finite"); };
  const double width = size("width"), length = size("length"), height = size("height");
  file.opening = opening_note(numbers.line(), {width * unit_m, length * unit_m, height * unit_m});
  // Factors of 0 would make every such file dark.
  const auto ballast_factor = [&](std::string_view what) {
    const double factor = numbers.number(what, 0, kAny, "not negative; 0 counts as 1");
    if (!numbers.status.ok() || factor != 0) return factor;
    file.notes.push_back({numbers.line(), fmt::format("the {} is 0", what), "1"});
    return 1.0;
  };
  header.operated = tilt_factor * ballast_factor("ballast factor");
  // The second number is a factor up to 1991, has no meaning in 1995 and 2002, and describes how
  // the file was made in 2019.
  if (edition.year <= 1991)
    header.operated *= ballast_factor("ballast-lamp photometric factor");
  else
    numbers.next("the second number after the sizes");
  numbers.number("input watts", -kAny, kAny, "finite");
  header.factor = multiplier * header.operated;
  return header;
}

/// Adds a note for each pole of types A and B at which planes differ, although it is one direction.
void note_poles(const PhotometricWebParams& web, int line, PhotometricFile& file) {
  const bool across = web.type == PhotometricType::kB;  // the pole is H = 90; otherwise V = 90
  if (web.type == PhotometricType::kC) return;
  const std::size_t vertical = web.vertical_deg.size(), horizontal = web.horizontal_deg.size();
  const std::vector<double>& latitudes = across ? web.horizontal_deg : web.vertical_deg;
  for (std::size_t i = 0; i < latitudes.size(); ++i) {
    if (std::fabs(latitudes[i]) != 90) continue;
    double least = kAny, most = 0;
    for (std::size_t k = 0; k < (across ? vertical : horizontal); ++k) {
      const double cd = web.intensity_cd[across ? i * vertical + k : k * vertical + i];
      least = std::min(least, cd), most = std::max(most, cd);
    }
    if (least == most) continue;
    file.notes.push_back({line,
                          fmt::format("intensities from {:.6g} to {:.6g} at {} = {}, which is one "
                                      "direction",
                                      least, most, across ? "H" : "V", latitudes[i]),
                          "their mean in this direction, and the file's beside it"});
  }
}

/// The most vertical angles of a plane that `revolve` writes out.
constexpr std::size_t kMostRevolved = 1000;

/// Makes a web of types A or B of the one plane H = 0: symmetric about V = H = 0, like type C about
/// its axis.  The distances from this direction are the file's vertical angles.
void revolve(PhotometricWebParams& web) {
  const auto side = [&](double v) -> std::optional<double> {
    const auto next = std::lower_bound(web.vertical_deg.begin(), web.vertical_deg.end(), v);
    if (next == web.vertical_deg.end()) return std::nullopt;
    const auto i = static_cast<std::size_t>(next - web.vertical_deg.begin());
    if (*next == v) return web.intensity_cd[i];
    if (i == 0) return std::nullopt;
    return std::lerp(web.intensity_cd[i - 1], web.intensity_cd[i],
                     (v - *(next - 1)) / (*next - *(next - 1)));
  };
  // Where the plane has both sides, their mean.
  const auto at = [&](double deg) {
    const auto one = side(deg), other = side(-deg);
    if (one && other) return (*one + *other) / 2;
    return one ? *one : other.value_or(0);
  };
  std::vector<double> file{0}, distances{0}, cd;
  for (const double v : web.vertical_deg) file.push_back(std::fabs(v));
  std::sort(file.begin(), file.end());
  // The web is bilinear in V and H, which steps of at most a degree make round.
  StopPoll poll;
  for (std::size_t i = 1; i < file.size(); ++i, poll()) {
    const double step = file[i] - file[i - 1], parts = std::ceil(step);
    for (int k = 1; k < parts; ++k) distances.push_back(file[i - 1] + step * k / parts);
    if (step > 0) distances.push_back(file[i]);
  }
  std::vector<double> vertical(distances);
  for (const double v : distances)
    if (v > 0) vertical.insert(vertical.begin(), -v);
  constexpr double kDegree = kPi / 180;
  for (const double h : distances)
    for (const double v : vertical) {
      poll();
      const double cos = std::cos(h * kDegree) * std::cos(v * kDegree);
      // Exact where one of the angles is the distance.
      cd.push_back(at(h == 0   ? std::fabs(v)
                      : v == 0 ? h
                               : std::min(90.0, std::acos(std::clamp(cos, -1.0, 1.0)) / kDegree)));
    }
  web.vertical_deg = std::move(vertical), web.horizontal_deg = std::move(distances);
  web.intensity_cd = std::move(cd);
}

/// Reads the angles and the intensities into `file`.  Returns the photometric type.
absl::StatusOr<PhotometricType> read_candela(IesNumbers& numbers, const IesHeader& header,
                                             const Edition& edition, std::string_view name,
                                             PhotometricFile& file) {
  PhotometricWebParams web;
  web.type = header.type;
  numbers.skip();
  const int vertical_line = numbers.line();
  web.vertical_deg = numbers.angles("vertical angle", header.vertical);
  // The edition of 1986 uses 1 for types A and C; only type A has negative vertical angles.
  if (edition.year == 1986 && web.type == PhotometricType::kC && numbers.status.ok() &&
      web.vertical_deg.front() < 0)
    web.type = PhotometricType::kA;
  numbers.check(vertical_line, check_vertical_angles(web.type, web.vertical_deg));
  numbers.skip();
  const int horizontal_line = numbers.line();
  web.horizontal_deg = numbers.angles("horizontal angle", header.horizontal);
  const bool one_plane = web.type != PhotometricType::kC &&
                         web.horizontal_deg == std::vector<double>{0} &&
                         header.vertical <= kMostRevolved;
  if (!one_plane)
    numbers.check(horizontal_line, check_horizontal_angles(web.type, web.horizontal_deg));
  numbers.skip();
  const int candela_line = numbers.line();
  const auto candela_value = [](std::size_t i) { return fmt::format("candela value {}", i); };
  const std::size_t count = header.vertical * header.horizontal;
  NoiseBelowZero noise;
  web.intensity_cd.reserve(count);
  for (std::size_t i = 1; i <= count && numbers.status.ok(); ++i) {
    web.intensity_cd.push_back(numbers.number(candela_value(i), -kAny, kAny, "finite"));
    noise.add(web.intensity_cd.back(), i, numbers.line());
  }
  LUCERNA_RETURN_IF_ERROR(numbers.status);
  note_gap(vertical_line, vertical_gap(web.type, web.vertical_deg), file);
  if (one_plane)
    file.notes.push_back({horizontal_line, "one horizontal angle, 0 degrees",
                          "symmetric about the direction V = H = 0"});
  else
    note_gap(horizontal_line, horizontal_gap(web.type, web.horizontal_deg), file);
  LUCERNA_RETURN_IF_ERROR(noise.clear(web.intensity_cd, name, candela_value, file));
  if (one_plane)
    revolve(web);
  else
    note_poles(web, candela_line, file);
  for (double& cd : web.intensity_cd) cd *= header.factor;
  auto made = PhotometricWeb::create(web);
  if (!made.ok())
    return photometric_error(name, candela_line, std::string(made.status().message()));
  file.web = *std::move(made);
  return web.type;
}

/// Adds a note if more light leaves the luminaire than its lamps emit, by more than 2%, and both
/// are in lm.
void check_flux(const IesHeader& header, PhotometricFile& file) {
  if (header.lamp_lm < 0 || header.lamps == 0 || !(header.operated > 0)) return;
  if (!file.flux_unit.empty()) return;
  const double lamps_lm = header.lamps * header.lamp_lm;
  if (file.web->flux_lm() / header.operated <= 1.02 * lamps_lm) return;
  file.notes.push_back(
      {header.lamps_line,
       fmt::format("{} {} of {:.6g} lm {} {:.6g} lm", header.lamps,
                   header.lamps == 1 ? "lamp" : "lamps", header.lamp_lm,
                   header.lamps == 1 ? "emits" : "emit", lamps_lm * header.operated),
       fmt::format("the flux of the intensities is used, {:.6g} lm", file.web->flux_lm())});
}

char letter(PhotometricType type) {
  return type == PhotometricType::kC ? 'C' : type == PhotometricType::kB ? 'B' : 'A';
}

/// What follows the last candela value.
enum class Rest { kNothing, kText, kNumber };

struct Reading {
  PhotometricFile file;
  Rest rest;
  int rest_line;
  absl::Status ambiguous;  ///< as IesNumbers has it
};

absl::StatusOr<Reading> read(std::string_view text, std::string_view name, Comma comma) {
  Reading reading{};
  PhotometricFile& file = reading.file;
  const Edition edition = edition_of(text, file);
  LUCERNA_ASSIGN_OR_RETURN(const TiltLine tilt, find_tilt(text, name));
  IesNumbers numbers(name, tilt.rest, tilt.line, comma);
  LUCERNA_ASSIGN_OR_RETURN(const double tilt_factor, read_tilt(tilt, name, numbers, file));
  const IesHeader header = read_header(numbers, edition, tilt_factor, file);
  const std::uint64_t vertical = header.vertical, horizontal = header.horizontal;
  if (!numbers.room_for(vertical + horizontal + vertical * horizontal)) return numbers.status;
  LUCERNA_ASSIGN_OR_RETURN(const PhotometricType type,
                           read_candela(numbers, header, edition, name, file));
  note_unit(text.substr(0, text.size() - tilt.rest.size()), file);
  reading.rest = !numbers.skip()       ? Rest::kNothing
                 : numbers.at_number() ? Rest::kNumber
                                       : Rest::kText;
  reading.rest_line = numbers.line();
  reading.ambiguous = numbers.ambiguous();
  if (reading.rest != Rest::kNothing)
    file.notes.push_back({numbers.line(), "text after the last candela value", "left out"});
  check_flux(header, file);
  file.format = fmt::format("{}, type {}", edition.name, letter(type));
  return reading;
}

/// Whether a comma stands between two digits.
bool has_comma_in_number(std::string_view text) {
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  for (std::size_t i = 1; i + 1 < text.size(); ++i)
    if (text[i] == ',' && is_digit(text[i - 1]) && is_digit(text[i + 1])) return true;
  return false;
}

}  // namespace

absl::StatusOr<PhotometricFile> parse_ies(std::string_view text, std::string_view name) {
  text = without_byte_order_mark(text);
  auto reading = read(text, name, Comma::kSeparator);
  const bool whole = reading.ok() && reading->rest != Rest::kNumber;
  if (whole || !has_comma_in_number(text)) {
    if (!reading.ok()) return reading.status();
    return std::move(reading->file);
  }
  // A file with decimal commas seems to have more numbers than it announces.
  auto decimal = read(text, name, Comma::kDecimal);
  if (decimal.ok() && decimal->rest != Rest::kNumber) {
    if (!decimal->ambiguous.ok()) return decimal->ambiguous;
    decimal->file.notes.push_back({1, "decimal commas, which separate numbers in LM-63",
                                   "read as decimal points, which gives the announced counts"});
    return std::move(decimal->file);
  }
  constexpr std::string_view kAllowed = "commas separate numbers, allowed: decimal points";
  if (reading.ok())
    return photometric_error(
        name, reading->rest_line,
        fmt::format("more numbers than announced, with commas between digits; {}", kAllowed));
  return absl::Status(reading.status().code(),
                      fmt::format("{}; {}", std::string(reading.status().message()), kAllowed));
}

}  // namespace lucerna
