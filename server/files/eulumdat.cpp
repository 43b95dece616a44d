#include "server/files/eulumdat.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "lights/maths/stop_poll.h"
#include "proto/common/status_macros.h"
#include "server/files/printable.h"

namespace lucerna {
namespace {

/// Reads lines by their number, from 1, as the format's description counts them.  After the first
/// error, calls do nothing, so that callers can check `status` once for several values.
class Lines {
 public:
  /// Requires a text below 4 GiB, so that places in it take four bytes.
  Lines(std::string_view file, std::string_view text) : file_(file), text_(text) {
    // The size of the list is known before it is made: it can be longer than the text.
    std::size_t count = 0;
    for (std::string_view rest = text; !rest.empty(); ++count) take_line(rest);
    starts_.reserve(count);
    for (std::string_view rest = text; !rest.empty(); take_line(rest))
      starts_.push_back(static_cast<std::uint32_t>(text.size() - rest.size()));
    // Names precede line 13.
    for (std::size_t line = 13; line <= size() && !comma_decides_; ++line) {
      const std::string_view word = trimmed(text_of(line));
      comma_decides_ =
          word.find(',') != std::string_view::npos && is_number(line) && !ambiguous_commas(word);
    }
  }

  /// The number on a line, in [least, most].
  double number(std::size_t line, std::string_view what, double least, double most,
                std::string_view allowed) {
    if (!status.ok()) return 0;
    if (line > size()) {
      fail(size(), fmt::format("the file ends before {} (line {})", what, line));
      return 0;
    }
    const auto n = parse(line);
    if (!n)
      fail(line, fmt::format("{} is \"{}\", allowed: a finite number", what,
                             excerpt(trimmed(text_of(line)))));
    else if (!(*n >= least && *n <= most))
      fail(line, fmt::format("{} = {}, allowed: {}", what, *n, allowed));
    return status.ok() ? *n : 0;
  }

  /// Fails if the number on a line has a comma that may separate thousands.
  void check_comma(std::size_t line, std::string_view what) {
    if (comma_decides_ || !status.ok()) return;
    const std::string_view word = trimmed(text_of(line));
    if (const auto ambiguous = ambiguous_commas(word))
      fail(line, fmt::format("{} is \"{}\", which is {}", what, word, *ambiguous));
  }

  /// A whole number in [least, most].
  std::size_t whole(std::size_t line, std::string_view what, int least, int most,
                    std::string_view allowed) {
    const double n = number(line, what, least, most, allowed);
    if (status.ok() && n != std::floor(n))
      fail(line, fmt::format("{} = {}, allowed: {}", what, n, allowed));
    return status.ok() ? static_cast<std::size_t>(n) : 0;
  }

  /// One number from each of `count` lines.  The caller has checked that the lines exist.
  std::vector<double> list(std::size_t line, std::size_t count, std::string_view what, double least,
                           double most, std::string_view allowed) {
    std::vector<double> result;
    if (!status.ok()) return result;
    result.reserve(count);
    for (std::size_t i = 0; i < count && status.ok(); ++i)
      result.push_back(number(line + i, what, least, most, allowed));
    return result;
  }

  std::size_t size() const { return starts_.size(); }
  bool is_number(std::size_t line) const { return line <= size() && parse(line).has_value(); }
  /// The number on a line; 0 if there is none.
  double number_or_0(std::size_t line) const {
    return line <= size() ? parse(line).value_or(0) : 0;
  }
  /// The text of a line, for a message.
  std::string shown(std::size_t line) const { return excerpt(trimmed(text_of(line))); }
  bool blank(std::size_t line) const { return line > size() || trimmed(text_of(line)).empty(); }
  void fail(std::size_t line, std::string_view what) {
    if (status.ok()) status = photometric_error(file_, static_cast<int>(line), what);
  }

  absl::Status status;

 private:
  std::optional<double> parse(std::size_t line) const {
    std::string word(trimmed(text_of(line)));
    std::replace(word.begin(), word.end(), ',', '.');
    return parse_number(word);
  }

  std::string_view text_of(std::size_t line) const {
    std::string_view rest = text_.substr(starts_[line - 1]);
    return take_line(rest);
  }

  std::string_view file_, text_;
  std::vector<std::uint32_t> starts_;  // of the lines
  bool comma_decides_ = false;         // a comma of the file is a decimal comma for sure
};

/// The order of the values of several sets of lamps.
enum class SetOrder { kByField, kBySet, kEither, kNeither };

/// Finds the order by the values that can be numbers.  Number of lamps, flux and watts of each set
/// are numbers (the first and the last may be blank).  In the wrong order, lamp types are in their
/// place, which are rarely numbers.
SetOrder order_of_sets(const Lines& lines, std::size_t sets) {
  const auto fits = [&](std::size_t field_step, std::size_t set_step) {
    for (std::size_t set = 0; set < sets; ++set) {
      const auto line = [&](std::size_t field) { return 27 + field * field_step + set * set_step; };
      for (const std::size_t field : {0, 2, 5})
        if (!lines.is_number(line(field)) && (field == 2 || !lines.blank(line(field))))
          return false;
    }
    return true;
  };
  const bool by_field = fits(sets, 1), by_set = fits(1, 6);
  if (by_field) return by_set ? SetOrder::kEither : SetOrder::kByField;
  return by_set ? SetOrder::kBySet : SetOrder::kNeither;
}

/// The sizes at the beginning of the file.
struct Sizes {
  std::size_t symmetry;  ///< Isym
  std::size_t angles;    ///< Mc, number of C-planes
  std::size_t gammas;    ///< Ng, number of intensities in a plane
};

Sizes read_sizes(Lines& lines) {
  Sizes sizes;
  sizes.symmetry = lines.whole(3, "the symmetry Isym", 0, 4, "0, 1, 2, 3 or 4");
  // A file that is symmetric about the axis needs no C-angle.
  sizes.angles =
      lines.whole(4, "the number Mc of C-planes", sizes.symmetry == 1 ? 0 : 1, kMostCount,
                  sizes.symmetry == 1 ? "a whole number, not negative" : "a positive whole number");
  sizes.gammas =
      lines.whole(6, "the number Ng of intensities in a plane", 2, kMostCount, "2 or more");
  return sizes;
}

/// Sets `file.opening` from the luminous area: length and width, and its heights in four planes.
void note_opening(const Lines& lines, PhotometricFile& file) {
  constexpr double kMetres = 1e-3;  // the file has mm
  const auto size_m = [&](std::size_t line) { return kMetres * lines.number_or_0(line); };
  double height_m = 0;
  for (const std::size_t line : {18, 19, 20, 21}) height_m = std::max(height_m, size_m(line));
  file.opening = opening_note(16, {size_m(16), size_m(17), height_m});
}

/// The factor of all intensities; 1 if its line is blank or 0.  The description does not allow a
/// blank line, and some programs refuse it.  Other programs write it if nothing has to be
/// converted.
double read_conversion(Lines& lines, PhotometricFile& file) {
  const bool blank = lines.size() >= 24 && lines.blank(24);
  const double factor =
      blank ? 0 : lines.number(24, "the conversion factor", 0, kAny, "not negative; 0 counts as 1");
  if (factor != 0 || !lines.status.ok()) return factor;
  file.notes.push_back(
      {24,
       blank ? "no conversion factor for intensities" : "a conversion factor of 0 for intensities",
       "1"});
  return 1;
}

/// Adds a note about the tilt of the luminaire during the measurement, unless it is 0 or blank.
void note_tilt(const Lines& lines, PhotometricFile& file) {
  if (lines.blank(25) || (lines.is_number(25) && lines.number_or_0(25) == 0)) return;
  file.notes.push_back(
      {25, fmt::format("a tilt of \"{}\" degrees during the measurement", lines.shown(25)),
       "left out: gamma 0 is the axis of the luminaire"});
}

struct Lamps {
  std::size_t sets;
  double lm;  ///< luminous flux of the first set
};

/// The sets of lamps.  Each has six lines: number of lamps, type, total luminous flux, colour
/// temperature, colour rendering, watts.
Lamps read_lamps(Lines& lines, PhotometricFile& file) {
  Lamps lamps{};
  lamps.sets = lines.whole(26, "the number of sets of lamps", 1, 1000, "a whole number from 1");
  if (!lines.status.ok()) return lamps;
  const SetOrder order = lamps.sets == 1 ? SetOrder::kBySet : order_of_sets(lines, lamps.sets);
  if (order == SetOrder::kNeither)
    lines.fail(26, fmt::format("{} sets of lamps, allowed: numbers for lamps, luminous flux and "
                               "watts of each, field by field or set by set",
                               lamps.sets));
  if (!lines.blank(27)) lines.number(27, "the number of lamps", -1e6, 1e6, "a number");
  const std::size_t flux_line = order == SetOrder::kBySet ? 29 : 27 + 2 * lamps.sets;
  constexpr std::string_view kFlux = "the luminous flux of the lamps";
  lamps.lm = lines.number(flux_line, kFlux, 1e-300, kAny, "positive");
  lines.check_comma(flux_line, kFlux);
  if (lamps.sets > 1)
    file.notes.push_back(
        {26, fmt::format("{} sets of lamps", lamps.sets), "only the first set is used"});
  if (order == SetOrder::kEither)
    file.notes.push_back({26,
                          "sets of lamps whose order is ambiguous (field by field or set by set)",
                          "read field by field, as in the format's description"});
  return lamps;
}

/// The planes whose intensities the file has.
struct Planes {
  std::size_t first, count;  ///< of the C-angles
  double lower, upper;       ///< symmetric about these angles
};

/// With `half` steps no plane lies on a plane of symmetry.
Planes planes_of(const Sizes& sizes, bool half) {
  const std::size_t all = sizes.angles, closing = half ? 0 : 1;
  switch (sizes.symmetry) {
    case 1:
      return {0, 1, 0, 360};
    case 2:
      return {0, all / 2 + closing, 0, 180};
    case 3:  // from C270 over C0 to C90
      return {3 * all / 4, all / 2 + closing, -90, 90};
    case 4:
      return {0, all / 4 + closing, 0, 90};
    default:
      return {0, all, 0, 360};
  }
}

/// The angles of the planes, ascending.
std::vector<double> plane_angles(const Sizes& sizes, const Planes& planes,
                                 const std::vector<double>& c) {
  std::vector<double> angles;
  angles.reserve(planes.count);
  StopPoll poll;
  for (std::size_t i = 0; i < planes.count; ++i, poll()) {
    const double angle = c[(planes.first + i) % sizes.angles];
    angles.push_back(planes.lower < 0 && angle >= 180 ? angle - 360 : angle);
  }
  return angles;
}

/// Notes planes of a symmetric file that do not reach from one plane of symmetry to the other, or
/// lie at half steps between them.  Fails if they are not between them, or so few that they would
/// have another symmetry.
void check_planes(Lines& lines, std::size_t line, const Sizes& sizes, const Planes& planes,
                  const std::vector<double>& angles, PhotometricFile& file) {
  const double width = planes.upper - planes.lower;
  if (angles.front() == planes.lower && angles.back() == planes.upper) return;
  const double step = width / static_cast<double>(angles.size());
  bool even = angles.size() > 1;
  for (std::size_t i = 0; i < angles.size(); ++i)  // files have few digits
    even =
        even && std::fabs(angles[i] - planes.lower - (static_cast<double>(i) + 0.5) * step) < 1e-3;
  if (even) return;
  const double from = angles.front() - planes.lower, to = angles.back() - planes.lower;
  const bool known = width == 180 ? from >= 0 && from < 90 && to > 90 && to <= 180
                                  : from >= 0 && to <= 90 && !(from == 0 && to == 45);
  if (known && angles.size() > 1)
    return note_gap(static_cast<int>(line), horizontal_gap(PhotometricType::kC, angles), file);
  lines.fail(line,
             fmt::format("{} C-angles from {} to {} degrees, allowed for symmetry {}: from {} "
                         "to {}",
                         angles.size(), angles.front(), angles.back(), sizes.symmetry, planes.lower,
                         planes.upper));
}

/// Adds a note if there is more in the file than the intensities up to `end`.
void note_rest(const Lines& lines, std::size_t end, PhotometricFile& file) {
  for (std::size_t line = end; line <= lines.size(); ++line) {
    if (lines.blank(line)) continue;
    file.notes.push_back({static_cast<int>(line),
                          lines.is_number(line) ? "values after those of the announced planes"
                                                : "text after the last intensity",
                          "left out"});
    return;
  }
}

/// The number of lines with a number, from a line on; 0 if other lines follow that are not blank.
std::size_t numbers_from(const Lines& lines, std::size_t line) {
  std::size_t count = 0;
  while (lines.is_number(line + count)) ++count;
  for (std::size_t rest = line + count; rest <= lines.size(); ++rest)
    if (!lines.blank(rest)) return 0;
  return count;
}

/// The planes of a file that has other ones than `planes`, which its symmetry and Mc announce:
/// `stored` intensities.  Adds a note.
Planes other_planes(const Lines& lines, Sizes& sizes, Planes planes, std::size_t angles_line,
                    std::size_t stored, PhotometricFile& file) {
  const auto [symmetry, angles, gammas] = sizes;
  if (angles > planes.count && stored == angles * gammas) {
    const auto within = [&, count = angles](double lower, double upper) {
      for (std::size_t i = 0; i < count; ++i)
        if (const double c = lines.number_or_0(angles_line + i);
            !(c >= lower && c <= upper) && !(c - 360 >= lower && c - 360 <= upper))
          return false;
      return true;
    };
    // Isym 3 has the half from C270 over C0 to C90.  Some files have the other one.
    const bool far_half = symmetry == 3 && within(90, 270);
    if (far_half || (symmetry >= 2 && within(planes.lower, planes.upper))) {
      file.notes.push_back(
          {4,
           fmt::format("symmetry {}, but C-planes from {} to {} only", symmetry,
                       lines.number_or_0(angles_line), lines.number_or_0(angles_line + angles - 1)),
           "Mc is the number of planes with intensities"});
      if (far_half) return {0, angles, 90, 270};
      return {0, angles, planes.lower, planes.upper};
    }
    file.notes.push_back(
        {3, fmt::format("symmetry {}, but intensities of all {} planes", symmetry, angles),
         "all planes are used"});
    sizes.symmetry = 0;
    return {0, angles, 0, 360};
  }
  // More than half of a circle remains, so that no symmetry follows from the angles.
  if (planes.count > 2 && stored == (planes.count - 1) * gammas &&
      (symmetry != 0 || lines.number_or_0(angles_line + planes.count - 2) > 180)) {
    file.notes.push_back(
        {static_cast<int>(angles_line + angles + gammas),
         fmt::format("intensities of {} planes, announced {}", planes.count - 1, planes.count),
         "the last plane is left out"});
    --planes.count;
  }
  return planes;
}

/// The planes whose intensities are read.  Fails if the file is too short for them.
Planes planes_to_read(Lines& lines, Sizes& sizes, std::size_t angles_line, PhotometricFile& file) {
  const auto [announced, angles, gammas] = sizes;
  const std::size_t left = lines.size() >= angles_line ? lines.size() - angles_line + 1 : 0;
  // The first C-angle is 0 or half a step.
  Planes planes = planes_of(sizes, lines.number_or_0(angles_line) != 0);
  const std::size_t divisor = announced == 2 ? 2 : announced >= 3 ? 4 : 1;
  const std::size_t stored = numbers_from(lines, angles_line + angles + gammas);
  if (angles <= left) planes = other_planes(lines, sizes, planes, angles_line, stored, file);
  if (lines.status.ok() && angles % divisor != 0 && stored != angles * gammas)
    lines.fail(4, fmt::format("the number Mc of C-planes = {}, allowed for symmetry {}: multiples "
                              "of {}",
                              angles, announced, divisor));
  if (angles > left || gammas > left || planes.count > (left - angles) / gammas)
    lines.fail(6,
               fmt::format("{} angles and {} planes of {} intensities are announced, allowed: as "
                           "many as fit in the remaining {} lines",
                           angles, planes.count, gammas, left));
  return planes;
}

/// Reads the C-angles (from `angles_line` on), the gamma-angles and the intensities.  `factor`
/// multiplies the intensities.
absl::StatusOr<PhotometricWebParams> read_intensities(Lines& lines, Sizes sizes,
                                                      std::size_t angles_line, double factor,
                                                      std::string_view name,
                                                      PhotometricFile& file) {
  if (sizes.angles == 0) {
    file.notes.push_back({4, "0 C-planes", "one plane, symmetric about the axis"});
    // Some of these files have the angle of the plane.
    sizes.angles = numbers_from(lines, angles_line) % 2;
  }
  const std::size_t angles = sizes.angles, gammas = sizes.gammas;
  const std::size_t gamma_line = angles_line + angles, intensity_line = gamma_line + gammas;
  const Planes planes = planes_to_read(lines, sizes, angles_line, file);
  LUCERNA_RETURN_IF_ERROR(lines.status);
  const std::vector<double> c =
      lines.list(angles_line, angles, "a C-angle", 0, 360, "from 0 to 360 degrees");
  const std::size_t count = planes.count * gammas;
  PhotometricWebParams web;
  web.vertical_deg =
      lines.list(gamma_line, gammas, "a gamma-angle", 0, 180, "from 0 to 180 degrees");
  web.intensity_cd =
      lines.list(intensity_line, count, "an intensity per 1000 lm", -kAny, kAny, "finite");
  for (std::size_t i = 0; i < count; ++i)
    lines.check_comma(intensity_line + i, "an intensity per 1000 lm");
  if (auto s = check_vertical_angles(web.type, web.vertical_deg); lines.status.ok() && !s.ok())
    lines.fail(gamma_line, std::string(s.message()));
  LUCERNA_RETURN_IF_ERROR(lines.status);
  NoiseBelowZero noise;
  for (std::size_t i = 0; i < count; ++i)
    noise.add(web.intensity_cd[i], i + 1, static_cast<int>(intensity_line + i));
  LUCERNA_RETURN_IF_ERROR(noise.clear(
      web.intensity_cd, name, [](std::size_t) { return "an intensity per 1000 lm"; }, file));
  for (double& cd : web.intensity_cd) cd *= factor;
  note_rest(lines, intensity_line + count, file);
  note_gap(static_cast<int>(gamma_line), vertical_gap(web.type, web.vertical_deg), file);
  web.horizontal_deg = {0};
  if (sizes.symmetry == 1) return web;
  web.horizontal_deg = plane_angles(sizes, planes, c);
  if (auto s = check_horizontal_angles(web.type, web.horizontal_deg); !s.ok())
    lines.fail(angles_line, std::string(s.message()));
  if (sizes.symmetry == 0)
    note_gap(static_cast<int>(angles_line), horizontal_gap(web.type, web.horizontal_deg), file);
  else
    check_planes(lines, angles_line, sizes, planes, web.horizontal_deg, file);
  LUCERNA_RETURN_IF_ERROR(lines.status);
  return web;
}

/// Checks the downward flux fraction and the light output ratio, which may both be blank.  Adds a
/// note if the ratio differs from the intensities by more than 2%.
void check_ratios(Lines& lines, double lamps_lm, double conversion, PhotometricFile& file) {
  const auto percent = [&](std::size_t line, std::string_view what) {
    return lines.blank(line) ? 0 : lines.number(line, what, 0, 1000, "percent, from 0");
  };
  percent(22, "the downward flux fraction");
  const double output = percent(23, "the light output ratio");
  const double stated = output / 100 * lamps_lm;
  if (stated > 0 && std::fabs(file.web->flux_lm() / conversion / stated - 1) > 0.02)
    file.notes.push_back(
        {23, fmt::format("the light output ratio of {}% gives {:.6g} lm", output, stated),
         fmt::format("the flux of the intensities is used, {:.6g} lm", file.web->flux_lm())});
}

}  // namespace

absl::StatusOr<PhotometricFile> parse_eulumdat(std::string_view text, std::string_view name) {
  if (text.size() > std::numeric_limits<std::uint32_t>::max())
    return photometric_error(name, 1, "a file of 4 GiB or more, allowed: less");
  Lines lines(name, without_byte_order_mark(text));
  PhotometricFile file;
  file.format = "EULUMDAT";
  const Sizes sizes = read_sizes(lines);
  LUCERNA_RETURN_IF_ERROR(lines.status);
  note_opening(lines, file);
  const double conversion = read_conversion(lines, file);
  note_tilt(lines, file);
  const Lamps lamps = read_lamps(lines, file);
  LUCERNA_RETURN_IF_ERROR(lines.status);
  // Ten direct ratios precede the angles.
  const std::size_t angles_line = 27 + 6 * lamps.sets + 10;
  LUCERNA_ASSIGN_OR_RETURN(
      const PhotometricWebParams web,
      read_intensities(lines, sizes, angles_line, lamps.lm / 1000 * conversion, name, file));
  auto made = PhotometricWeb::create(web);
  if (!made.ok())
    return photometric_error(name, static_cast<int>(angles_line),
                             std::string(made.status().message()));
  file.web = *std::move(made);
  check_ratios(lines, lamps.lm, conversion, file);
  LUCERNA_RETURN_IF_ERROR(lines.status);
  return file;
}

}  // namespace lucerna
