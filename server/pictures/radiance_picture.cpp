#include "server/pictures/radiance_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <string>

#include "proto/common/status_macros.h"
#include "server/pictures/picture_checks.h"
#include "server/pictures/picture_colours.h"

namespace lucerna {
namespace {

constexpr std::string_view kBlank = " \t";

/// The next word of a line, which it removes.
std::string_view next_word(std::string_view& line) {
  line.remove_prefix(std::min(line.find_first_not_of(kBlank), line.size()));
  const std::string_view word = line.substr(0, line.find_first_of(kBlank));
  line.remove_prefix(word.size());
  return word;
}

/// Reads one number into each of `numbers`; false if the line does not have them.
bool read_numbers(std::string_view line, std::span<double> numbers) {
  for (double& number : numbers) {
    std::string_view word = next_word(line);
    if (word.starts_with('+')) word.remove_prefix(1);
    const char* end = word.data() + word.size();
    const auto [stop, error] = std::from_chars(word.data(), end, number);
    if (error != std::errc() || stop != end || !std::isfinite(number)) return false;
  }
  return true;
}

absl::Status bad_line(std::string_view line, const char* allowed) {
  return absl::InvalidArgumentError(
      fmt::format("header line \"{}\", allowed: {}", first_line(std::string(line)), allowed));
}

/// That of TIFF: where the first row and the first column are.  Nothing if an axis is there twice.
std::optional<int> orientation_of(std::string_view rows, std::string_view columns) {
  constexpr std::array<std::array<std::string_view, 2>, 8> kAxes{{{"-Y", "+X"},
                                                                  {"-Y", "-X"},
                                                                  {"+Y", "-X"},
                                                                  {"+Y", "+X"},
                                                                  {"+X", "-Y"},
                                                                  {"-X", "-Y"},
                                                                  {"-X", "+Y"},
                                                                  {"+X", "+Y"}}};
  const auto* found = std::ranges::find(kAxes, std::array{rows, columns});
  if (found == kAxes.end()) return std::nullopt;
  return static_cast<int>(found - kAxes.begin()) + 1;
}

}  // namespace

std::string_view RadiancePicture::next_line() {
  const std::string_view rest = bytes().substr(at_);
  std::string_view line = rest.substr(0, rest.find('\n'));
  at_ += std::min(line.size() + 1, rest.size());
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

absl::Status RadiancePicture::read_header() {
  next_line();  // "#?RADIANCE"
  for (std::string_view line = next_line(); !line.empty(); line = next_line())
    LUCERNA_RETURN_IF_ERROR(read_line(line));
  LUCERNA_RETURN_IF_ERROR(read_resolution(next_line()));
  if (!gamma_line_.empty()) m_spec.attribute("gamma line", first_line(std::string(gamma_line_)));
  if (is_xyz_) set_primaries_of_xyz(m_spec);
  if (is_xyz_ || primaries_.empty()) return absl::OkStatus();
  std::array<double, 8> values{};
  if (!read_numbers(primaries_, values)) return bad_line(primaries_, "eight chromaticities");
  std::array<float, 8> floats{};
  std::ranges::transform(values, floats.begin(), [](double v) { return static_cast<float>(v); });
  m_spec.attribute("chromaticities", OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, 8), floats.data());
  return absl::OkStatus();
}

/// Lines that begin with a blank are those of earlier pictures, and others have no meaning here.
absl::Status RadiancePicture::read_line(std::string_view line) {
  const auto value_of = [&](std::string_view name) -> std::optional<std::string_view> {
    if (!line.starts_with(name) || line.substr(name.size(), 1) != "=") return std::nullopt;
    return line.substr(name.size() + 1);
  };
  if (auto format = value_of("FORMAT")) {
    const std::string_view name = next_word(*format);
    is_xyz_ = name == "32-bit_rle_xyze";
    if (!is_xyz_ && name != "32-bit_rle_rgbe")
      return bad_line(line, "FORMAT=32-bit_rle_rgbe or 32-bit_rle_xyze");
  }
  primaries_ = value_of("PRIMARIES").value_or(primaries_);
  // Radiance has no such line.  Programs that write it disagree on which power it states.
  std::array<double, 1> gamma{};
  if (const auto value = value_of("GAMMA");
      value && !(read_numbers(*value, gamma) && gamma[0] == 1))
    gamma_line_ = line;
  std::array<double, 3> factors{1, 1, 1};
  bool ok = true;
  if (const auto exposure = value_of("EXPOSURE")) {
    ok = read_numbers(*exposure, std::span(factors).first(1));
    factors[2] = factors[1] = factors[0];
  } else if (const auto correction = value_of("COLORCORR")) {
    ok = read_numbers(*correction, factors);
  }
  if (!ok || std::ranges::any_of(factors, [](double f) { return !(f > 0); }))
    return bad_line(line, "numbers above 0");
  exposure_ = exposure_ * Rgb{factors[0], factors[1], factors[2]};
  return absl::OkStatus();
}

absl::Status RadiancePicture::read_resolution(std::string_view line) {
  std::string_view rest = line;
  const std::string_view rows = next_word(rest), row_count = next_word(rest),
                         columns = next_word(rest), column_count = next_word(rest);
  std::array<double, 2> size{};
  const auto orientation = orientation_of(rows, columns);
  constexpr double kMost = std::numeric_limits<int>::max();
  const bool ok = orientation && read_numbers(row_count, std::span(size).first(1)) &&
                  read_numbers(column_count, std::span(size).last(1)) && size[0] >= 0 &&
                  size[1] >= 0 && size[0] <= kMost && size[1] <= kMost;
  if (!ok) return bad_line(line, "-Y HEIGHT +X WIDTH, or its mirrored and turned forms");
  m_spec = OIIO::ImageSpec(static_cast<int>(size[1]), static_cast<int>(size[0]), 3,
                           OIIO::TypeDesc::FLOAT);
  m_spec.attribute("Orientation", *orientation);
  return absl::OkStatus();
}

absl::Status RadiancePicture::decode(std::uint8_t* to) {
  for (std::size_t y = 0; y < height(); ++y, to += 4 * width()) {
    if (stopped()) return absl::CancelledError();
    LUCERNA_RETURN_IF_ERROR(decode_row(to));
  }
  return absl::OkStatus();
}

absl::Status RadiancePicture::decode_row(std::uint8_t* to) {
  constexpr std::size_t kLeast = 8, kMost = 0x7fff;  // lengths of rows with runs
  const bool has_runs =
      width() >= kLeast && width() <= kMost && number(at_, 2) == 0x0202 && number(at_ + 2, 1) < 128;
  if (!has_runs) return decode_old_row(to);
  if (number(at_ + 2, 2, std::endian::big) != width())
    return absl::InvalidArgumentError(fmt::format("a row of {} texels, allowed: {}",
                                                  number(at_ + 2, 2, std::endian::big), width()));
  at_ += 4;
  for (std::size_t channel = 0; channel < 4; ++channel)
    for (std::size_t x = 0; x < width();) {
      if (at_ >= bytes().size()) return ends_early();
      const std::uint32_t head = number(at_++, 1);
      const bool is_run = head > 128;
      const std::size_t count = is_run ? head - 128 : head;
      if (count == 0 || count > width() - x)
        return absl::InvalidArgumentError(
            fmt::format("{} texels at the place {} of a row of {}", count, x, width()));
      if ((is_run ? 1 : count) > bytes().size() - at_) return ends_early();
      for (std::size_t i = 0; i < count; ++i, ++x)
        to[4 * x + channel] = static_cast<std::uint8_t>(number(is_run ? at_ : at_ + i, 1));
      at_ += is_run ? 1 : count;
    }
  return absl::OkStatus();
}

/// Single texels.  (1, 1, 1, n) repeats the texel before it.  Each further one repeats 256 times as
/// often.
absl::Status RadiancePicture::decode_old_row(std::uint8_t* to) {
  unsigned shift = 0;
  for (std::size_t x = 0; x < width();) {
    if (at_ + 4 > bytes().size()) return ends_early();
    const std::uint32_t texel = number(at_, 4);
    at_ += 4;
    if ((texel & 0xffffffU) != 0x010101U) {
      for (unsigned c = 0; c < 4; ++c) to[4 * x + c] = static_cast<std::uint8_t>(texel >> (8 * c));
      ++x;
      shift = 0;
      continue;
    }
    const std::uint64_t count = shift > 24 ? 0 : std::uint64_t{texel >> 24U} << shift;
    if (x == 0 || count > width() - x || shift > 24)
      return absl::InvalidArgumentError(
          fmt::format("a run of {} texels at the place {} of a row of {}", count, x, width()));
    for (std::uint64_t i = 0; i < count; ++i, ++x) std::copy_n(to + 4 * (x - 1), 4, to + 4 * x);
    shift += 8;
  }
  return absl::OkStatus();
}

void RadiancePicture::convert(const std::uint8_t* stored, void* to) const {
  auto* values = static_cast<float*>(to);
  for (std::size_t x = 0; x < width(); ++x, stored += 4, values += 3) {
    const double unit = stored[3] == 0 ? 0 : std::ldexp(1.0, stored[3] - (128 + 8));
    values[0] = static_cast<float>(stored[0] * unit / exposure_.r);
    values[1] = static_cast<float>(stored[1] * unit / exposure_.g);
    values[2] = static_cast<float>(stored[2] * unit / exposure_.b);
  }
}

}  // namespace lucerna
