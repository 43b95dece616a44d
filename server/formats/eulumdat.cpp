#include "server/formats/eulumdat.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "server/formats/byte_order_mark.h"

namespace lucerna {
namespace {

/// Lines by their number, from 1, as the format's own description counts them.
class Lines {
 public:
  Lines(std::string_view file, std::string_view text) : file_(file), lines_(split_lines(text)) {}

  double number(std::size_t line, std::string_view what, double least, double most,
                std::string_view allowed) {
    if (!status.ok()) return 0;
    if (line > lines_.size()) {
      fail(lines_.size(), fmt::format("the file ends before {} (line {})", what, line));
      return 0;
    }
    const auto n = parse(line);
    if (!n)
      fail(line, fmt::format("{} is \"{}\", allowed: a finite number", what,
                             excerpt(trimmed(lines_[line - 1]))));
    else if (!(*n >= least && *n <= most))
      fail(line, fmt::format("{} = {}, allowed: {}", what, *n, allowed));
    return status.ok() ? *n : 0;
  }

  std::size_t whole(std::size_t line, std::string_view what, int least, int most,
                    std::string_view allowed) {
    const double n = number(line, what, least, most, allowed);
    if (status.ok() && n != std::floor(n))
      fail(line, fmt::format("{} = {}, allowed: {}", what, n, allowed));
    return status.ok() ? static_cast<std::size_t>(n) : 0;
  }

  std::vector<double> list(std::size_t line, std::size_t count, std::string_view what, double least,
                           double most, std::string_view allowed) {
    std::vector<double> result;
    if (!status.ok()) return result;
    result.reserve(count);
    for (std::size_t i = 0; i < count && status.ok(); ++i)
      result.push_back(number(line + i, what, least, most, allowed));
    return result;
  }

  std::size_t size() const { return lines_.size(); }
  bool is_number(std::size_t line) const {
    return line <= lines_.size() && parse(line).has_value();
  }
  bool blank(std::size_t line) const {
    return line > lines_.size() || trimmed(lines_[line - 1]).empty();
  }
  void fail(std::size_t line, std::string_view what) {
    if (status.ok()) status = photometric_error(file_, static_cast<int>(line), what);
  }

  absl::Status status;

 private:
  std::optional<double> parse(std::size_t line) const {
    std::string word(trimmed(lines_[line - 1]));
    std::replace(word.begin(), word.end(), ',', '.');
    return parse_number(word);
  }

  std::string_view file_;
  std::vector<std::string_view> lines_;
};

/// The planes of which the file holds intensities: the number of the first among its C-angles, from
/// 0, and how many.
struct Planes {
  std::size_t first, count;
};

Planes planes_of(std::size_t symmetry, std::size_t angles) {
  switch (symmetry) {
    case 1:
      return {0, 1};
    case 2:
      return {0, angles / 2 + 1};
    case 3:  // from C270 over C0 to C90
      return {3 * angles / 4, angles / 2 + 1};
    case 4:
      return {0, angles / 4 + 1};
    default:
      return {0, angles};
  }
}

/// How the lines of several sets of lamps follow each other.
enum class SetOrder { kByField, kBySet, kEither, kNeither };

/// Number of lamps, flux and watts of each set are numbers (the first and the last may be blank);
/// types of lamps, whose place they would take in the other order, seldom are.
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

}  // namespace

absl::StatusOr<PhotometricFile> parse_eulumdat(std::string_view text, std::string_view name) {
  text = without_byte_order_mark(text);
  Lines lines(name, text);
  PhotometricFile file;
  file.format = "EULUMDAT";

  const std::size_t symmetry = lines.whole(3, "the symmetry Isym", 0, 4, "0, 1, 2, 3 or 4");
  const std::size_t angles =
      lines.whole(4, "the number Mc of C-planes", 1, 1'000'000'000, "a positive whole number");
  const std::size_t gammas =
      lines.whole(6, "the number Ng of intensities in a plane", 2, 1'000'000'000, "2 or more");
  if (!lines.status.ok()) return lines.status;
  const std::size_t divisor = symmetry == 2 ? 2 : symmetry >= 3 ? 4 : 1;
  if (angles % divisor != 0)
    return photometric_error(name, 4,
                             fmt::format("the number Mc of C-planes = {}, allowed for symmetry {}: "
                                         "multiples of {}",
                                         angles, symmetry, divisor));
  // The description knows no blank here and some programs refuse it; where nothing is to be
  // converted that is what it says.
  const bool unconverted = lines.size() >= 24 && lines.blank(24);
  const double conversion =
      unconverted ? 1 : lines.number(24, "the conversion factor", 1e-300, kAny, "positive");
  if (unconverted) file.notes.push_back({24, "no conversion factor for intensities", "1"});
  const std::size_t sets =
      lines.whole(26, "the number of sets of lamps", 1, 1000, "a whole number from 1");
  if (!lines.status.ok()) return lines.status;
  // Six lines a set: number of lamps, type, total luminous flux, colour temperature, colour
  // rendering, watts.
  const SetOrder order = sets == 1 ? SetOrder::kBySet : order_of_sets(lines, sets);
  if (order == SetOrder::kNeither)
    lines.fail(26, fmt::format("{} sets of lamps, allowed: numbers for lamps, luminous flux and "
                               "watts of each, field by field or set by set",
                               sets));
  lines.number(27, "the number of lamps", -1e6, 1e6, "a number");
  const std::size_t flux_line = order == SetOrder::kBySet ? 29 : 27 + 2 * sets;
  const double lamps_lm =
      lines.number(flux_line, "the luminous flux of the lamps", 1e-300, kAny, "positive");
  if (sets > 1)
    file.notes.push_back({26, fmt::format("{} sets of lamps", sets), "the first of them"});
  if (order == SetOrder::kEither)
    file.notes.push_back({26, "sets of lamps that can be read field by field or set by set",
                          "field by field, as the format's description has them"});

  // Then ten direct ratios, the C-angles, the gamma-angles, the intensities.
  const std::size_t angles_line = 27 + 6 * sets + 10;
  const std::size_t left = lines.size() >= angles_line ? lines.size() - angles_line + 1 : 0;
  const Planes planes = planes_of(symmetry, angles);
  if (angles > left || gammas > left || planes.count > (left - angles) / gammas)
    lines.fail(6, fmt::format("{} angles and {} planes of {} intensities are claimed to follow, "
                              "allowed: as many as the {} lines that are left",
                              angles, planes.count, gammas, left));
  if (!lines.status.ok()) return lines.status;
  const std::vector<double> c =
      lines.list(angles_line, angles, "a C-angle", 0, 360, "from 0 to 360 degrees");
  PhotometricWebParams web;
  web.vertical_deg =
      lines.list(angles_line + angles, gammas, "a gamma-angle", 0, 180, "from 0 to 180 degrees");
  web.intensity_cd = lines.list(angles_line + angles + gammas, planes.count * gammas,
                                "an intensity per 1000 lm", 0, kAny, "finite, not negative");
  if (auto s = check_vertical_angles(web.type, web.vertical_deg); lines.status.ok() && !s.ok())
    lines.fail(angles_line + angles, std::string(s.message()));
  if (!lines.status.ok()) return lines.status;
  const double factor = lamps_lm / 1000 * conversion;
  for (double& cd : web.intensity_cd) cd *= factor;

  for (std::size_t i = 0; i < planes.count; ++i) {
    const double angle = c[(planes.first + i) % angles];
    web.horizontal_deg.push_back(symmetry == 3 && angle >= 270 ? angle - 360 : angle);
  }
  if (symmetry == 1) web.horizontal_deg = {0};
  if (symmetry == 0 && web.horizontal_deg.back() != 360) {
    // All around: the first plane is the last one too.
    web.horizontal_deg.push_back(web.horizontal_deg.front() + 360);
    for (std::size_t j = 0; j < gammas; ++j) {
      const double cd = web.intensity_cd[j];
      web.intensity_cd.push_back(cd);
    }
  }
  auto made = PhotometricWeb::create(web);
  if (!made.ok())
    return photometric_error(
        name, static_cast<int>(angles_line),
        std::string_view(made.status().message().data(), made.status().message().size()));
  file.web = *std::move(made);

  // Both ratios may be left blank.
  for (const std::size_t line : {22, 23}) {
    if (lines.blank(line)) continue;
    const bool output = line == 23;
    const double percent =
        lines.number(line, output ? "the light output ratio" : "the downward flux fraction", 0,
                     1000, "percent, from 0");
    if (!lines.status.ok()) return lines.status;
    const double stated = percent / 100 * lamps_lm;
    if (output && stated > 0 && std::fabs(file.web->flux_lm() / conversion / stated - 1) > 0.02)
      file.notes.push_back(
          {23, fmt::format("a light output ratio of {}%, which makes {:.6g} lm", percent, stated),
           fmt::format("what the intensities make, {:.6g} lm", file.web->flux_lm())});
  }
  return file;
}

}  // namespace lucerna
