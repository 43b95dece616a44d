#include "server/formats/ies.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "server/formats/byte_order_mark.h"

namespace lucerna {
namespace {

enum class Edition { k1986, k1991, k1995, k2002, k2019, kOther };

struct EditionName {
  std::string_view line, name;
  Edition edition;
};
constexpr EditionName kEditions[] = {
    {"IESNA91", "IES LM-63-1991", Edition::k1991},
    {"IESNA:LM-63-1991", "IES LM-63-1991", Edition::k1991},
    {"IESNA:LM-63-1995", "IES LM-63-1995", Edition::k1995},
    {"IESNA:LM-63-2002", "IES LM-63-2002", Edition::k2002},
    {"IES:LM-63-2019", "IES LM-63-2019", Edition::k2019},
    {"IESNA:LM-63-2019", "IES LM-63-2019", Edition::k2019},
};

/// Numbers one after the other, over the ends of lines, divided by blanks and commas.
class Numbers {
 public:
  Numbers(std::string_view file, const std::vector<std::string_view>& lines, std::size_t line)
      : file_(file), lines_(lines), line_(line) {
    for (std::size_t i = line; i < lines.size(); ++i) left_ += lines[i].size() + 1;
  }

  /// The next number.  An empty result: `status` tells.
  std::optional<double> next(std::string_view what) {
    if (!status.ok()) return std::nullopt;
    if (!skip()) {
      fail(fmt::format("the file ends before {}", what));
      return std::nullopt;
    }
    const std::string_view rest = lines_[line_].substr(at_);
    const std::string_view word = rest.substr(0, rest.find_first_of(kBlanks));
    at_ += word.size();
    left_ -= word.size();
    const auto number = parse_number(word);
    if (!number) fail(fmt::format("{} is \"{}\", allowed: a finite number", what, excerpt(word)));
    return number;
  }

  double number(std::string_view what, double least, double most, std::string_view allowed) {
    const auto n = next(what);
    if (n && !(*n >= least && *n <= most))
      fail(fmt::format("{} = {}, allowed: {}", what, *n, allowed));
    return n.value_or(0);
  }

  /// A whole number in [least, most].
  int whole(std::string_view what, int least, int most, std::string_view allowed) {
    const double n = number(what, least, most, allowed);
    if (status.ok() && n != std::floor(n))
      fail(fmt::format("{} = {}, allowed: {}", what, n, allowed));
    return status.ok() ? static_cast<int>(n) : 0;
  }

  /// `count` numbers that are not negative, which the caller has found room for.
  std::vector<double> list(std::string_view what, std::size_t count) {
    std::vector<double> result;
    if (!status.ok()) return result;
    result.reserve(count);
    for (std::size_t i = 0; i < count && status.ok(); ++i)
      result.push_back(number(fmt::format("{} {}", what, i + 1), 0, kAny, "finite, not negative"));
    return result;
  }

  /// `count` ascending angles [degrees], likewise.
  std::vector<double> angles(std::string_view what, std::size_t count) {
    std::vector<double> result;
    if (!status.ok()) return result;
    result.reserve(count);
    for (std::size_t i = 0; i < count && status.ok(); ++i) {
      const double n =
          number(fmt::format("{} {}", what, i + 1), -360, 360, "from -360 to 360 degrees");
      if (status.ok() && i > 0 && !(n > result.back()))
        fail(fmt::format("{} {} = {} degrees, allowed: above the one before, which is {}", what,
                         i + 1, n, result.back()));
      result.push_back(n);
    }
    return result;
  }

  /// Fails with what `checked` says, at a line.
  void check(int line, const absl::Status& checked) {
    if (status.ok() && !checked.ok())
      status = photometric_error(
          file_, line, std::string_view(checked.message().data(), checked.message().size()));
  }

  /// Whether as many numbers can follow: each takes a digit, and a blank before the next.
  bool room_for(std::uint64_t count) {
    if (status.ok() && count > (left_ + 1) / 2)
      fail(
          fmt::format("{} numbers are claimed to follow, allowed: as many as the {} bytes that are "
                      "left can hold",
                      count, left_));
    return status.ok();
  }

  /// To the next number: false where there is none.
  bool skip() {
    while (line_ < lines_.size()) {
      const std::size_t found = lines_[line_].find_first_not_of(kBlanks, at_);
      const std::size_t end = std::min(found, lines_[line_].size());
      left_ -= end - at_;
      at_ = end;
      if (found != std::string_view::npos) return true;
      if (line_ + 1 == lines_.size()) return false;
      ++line_;
      at_ = 0;
      --left_;
    }
    return false;
  }

  /// From 1; the last one where there is no more.
  int line() const { return static_cast<int>(std::min(line_ + 1, lines_.size())); }
  void fail(std::string_view what) {
    if (status.ok()) status = photometric_error(file_, line(), what);
  }

  absl::Status status;

 private:
  static constexpr std::string_view kBlanks = " \t,\f\v";
  std::string_view file_;
  const std::vector<std::string_view>& lines_;
  std::size_t line_, at_ = 0;
  std::uint64_t left_ = 0;
};

bool equals_ignoring_case(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) {
    const auto upper = [](char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 32) : c; };
    return upper(x) == upper(y);
  });
}

/// The table that follows TILT=INCLUDE.  The factor at tilt 0, where the luminaire was measured.
double read_tilt(Numbers& numbers, PhotometricFile& file) {
  const int line = numbers.line();
  numbers.whole("lamp-to-luminaire geometry", 1, 3, "1, 2 or 3");
  const auto pairs = static_cast<std::size_t>(
      numbers.whole("the number of tilt angles", 1, 1'000'000'000, "a positive whole number"));
  if (!numbers.room_for(2 * std::uint64_t{pairs})) return 0;
  numbers.skip();
  const int angles_line = numbers.line();
  const std::vector<double> angles = numbers.angles("tilt angle", pairs);
  if (numbers.status.ok() && !(angles.front() == 0 && angles.back() <= 180))
    numbers.check(angles_line,
                  absl::InvalidArgumentError(fmt::format(
                      "tilt angles from {} to {} degrees, allowed: from 0 to 180 at most",
                      angles.front(), angles.back())));
  const std::vector<double> factors = numbers.list("tilt factor", pairs);
  if (!numbers.status.ok()) return 0;
  if (std::any_of(factors.begin(), factors.end(), [](double f) { return f != 1; }))
    file.notes.push_back({line, "a table of factors for a tilted luminaire",
                          fmt::format("the factor at tilt 0, which is {}", factors[0])});
  return factors[0];
}

}  // namespace

absl::StatusOr<PhotometricFile> parse_ies(std::string_view text, std::string_view name) {
  text = without_byte_order_mark(text);
  const std::vector<std::string_view> lines = split_lines(text);
  PhotometricFile file;

  Edition edition = Edition::k1986;
  std::string_view edition_name = "IES LM-63-1986";
  if (!lines.empty() && trimmed(lines[0]).starts_with("IES")) {
    edition = Edition::kOther;
    for (const EditionName& e : kEditions)
      if (trimmed(lines[0]) == e.line) edition = e.edition, edition_name = e.name;
  }
  if (edition == Edition::kOther) {
    // A later edition, or a label that is no edition: the format has not changed since 1995.
    file.notes.push_back(
        {1,
         fmt::format("edition \"{}\" is none of LM-63-1986, 1991, 1995, 2002, 2019",
                     excerpt(trimmed(lines[0]))),
         "read as that of 2002"});
    edition_name = "IES LM-63-2002";
  }

  // Keywords, or free text in the edition of 1986, up to the line of the tilt.
  std::size_t tilt = 0;
  const auto is_tilt = [](std::string_view line) {
    return equals_ignoring_case(trimmed(line).substr(0, 5), "TILT=");
  };
  while (tilt < lines.size() && !is_tilt(lines[tilt])) ++tilt;
  if (tilt == lines.size())
    return photometric_error(name, static_cast<int>(lines.size()),
                             "no line \"TILT=\", allowed: TILT=NONE, TILT=INCLUDE, TILT=<file>");
  const std::string_view tilt_of = trimmed(trimmed(lines[tilt]).substr(5));
  Numbers numbers(name, lines, tilt + 1);
  double factor = 1;
  if (equals_ignoring_case(tilt_of, "INCLUDE")) {
    numbers.skip();
    factor = read_tilt(numbers, file);
  } else if (!equals_ignoring_case(tilt_of, "NONE")) {
    if (tilt_of.empty())
      return photometric_error(name, static_cast<int>(tilt) + 1,
                               "TILT= nothing, allowed: NONE, INCLUDE, the name of a file");
    file.notes.push_back({static_cast<int>(tilt) + 1,
                          fmt::format("tilt factors in \"{}\" are not read", excerpt(tilt_of)),
                          "1, that of a luminaire that is not tilted"});
  }

  numbers.whole("the number of lamps", 0, 1'000'000, "a whole number, not negative");
  const double lumens =
      numbers.number("lumens per lamp", -1, kAny, "-1 (absolute photometry) or more");
  if (numbers.status.ok() && lumens < 0 && lumens != -1)
    numbers.fail(
        fmt::format("lumens per lamp = {}, allowed: -1 (absolute photometry), 0 or more", lumens));
  const auto positive = [&](std::string_view what) {
    return numbers.number(what, 1e-300, kAny, "positive");
  };
  factor *= positive("candela multiplier");
  const auto vertical = static_cast<std::uint64_t>(
      numbers.whole("the number of vertical angles", 2, 1'000'000'000, "2 or more"));
  const auto horizontal = static_cast<std::uint64_t>(
      numbers.whole("the number of horizontal angles", 1, 1'000'000'000, "1 or more"));
  const int type = numbers.whole("photometric type", 1, 3, "1 (type C), 2 (type B), 3 (type A)");
  numbers.whole("units", 1, 2, "1 (feet), 2 (metres)");
  // Negative sizes tell of rounded shapes.
  for (const char* size : {"width", "length", "height"})
    numbers.number(size, -kAny, kAny, "finite");
  factor *= positive("ballast factor");
  // The second number is without meaning in the editions of 1995 and 2002; in that of 2019 it says
  // how the file was made.
  if (edition == Edition::k1986 || edition == Edition::k1991)
    factor *= positive("ballast-lamp photometric factor");
  else
    numbers.next("the second number after the sizes");
  numbers.number("input watts", -kAny, kAny, "finite");
  if (!numbers.room_for(vertical + horizontal + vertical * horizontal)) return numbers.status;

  PhotometricWebParams web;
  web.type = type == 1   ? PhotometricType::kC
             : type == 2 ? PhotometricType::kB
                         : PhotometricType::kA;
  numbers.skip();
  const int vertical_line = numbers.line();
  web.vertical_deg = numbers.angles("vertical angle", vertical);
  // The edition of 1986 has one number for types A and C, of which the latter has no such angles.
  if (edition == Edition::k1986 && type == 1 && numbers.status.ok() && web.vertical_deg.front() < 0)
    web.type = PhotometricType::kA;
  numbers.check(vertical_line, check_vertical_angles(web.type, web.vertical_deg));
  numbers.skip();
  const int horizontal_line = numbers.line();
  web.horizontal_deg = numbers.angles("horizontal angle", horizontal);
  numbers.check(horizontal_line, check_horizontal_angles(web.type, web.horizontal_deg));
  numbers.skip();
  const int candela_line = numbers.line();
  web.intensity_cd = numbers.list("candela value", vertical * horizontal);
  if (!numbers.status.ok()) return numbers.status;
  if (numbers.skip())
    file.notes.push_back({numbers.line(), "more after the last candela value", "left out"});
  for (double& cd : web.intensity_cd) cd *= factor;

  auto made = PhotometricWeb::create(web);
  if (!made.ok())
    return photometric_error(
        name, candela_line,
        std::string_view(made.status().message().data(), made.status().message().size()));
  file.web = *std::move(made);
  file.format = fmt::format("{}, type {}", edition_name,
                            web.type == PhotometricType::kC   ? 'C'
                            : web.type == PhotometricType::kB ? 'B'
                                                              : 'A');
  return file;
}

}  // namespace lucerna
