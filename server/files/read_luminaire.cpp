#include "server/files/read_luminaire.h"

#include <fmt/format.h>

#include <string>

#include "server/files/eulumdat.h"
#include "server/files/ies.h"
#include "server/files/printable.h"

namespace lucerna {
namespace {

/// ASCII of a text in UTF-16 with a byte-order mark, with '?' for other characters; empty for other
/// texts.  Both formats are ASCII but for names.
std::string ascii_of_utf16(std::string_view bytes) {
  const bool little = bytes.starts_with("\xff\xfe"), big = bytes.starts_with("\xfe\xff");
  std::string text;
  if (!little && !big) return text;
  text.reserve(bytes.size() / 2);
  for (std::size_t i = 2; i + 1 < bytes.size(); i += 2) {
    const char low = bytes[little ? i : i + 1], high = bytes[little ? i + 1 : i];
    text += high == 0 && low >= 0 ? low : '?';
  }
  return text;
}

enum class Kind { kIes, kEulumdat, kUnknown };

Kind kind_of(std::string_view text) {
  // Symmetry and numbers of angles of EULUMDAT.
  bool numbers = true;
  for (int line = 1; !text.empty(); ++line) {
    const std::string_view found = trimmed(take_line(text));
    if (line == 1 && upper_case(found.substr(0, 3)) == "IES") return Kind::kIes;
    if (upper_case(found.substr(0, 4)) == "TILT" && trimmed(found.substr(4)).starts_with('='))
      return Kind::kIes;
    if (line == 3 || line == 4 || line == 6) numbers = numbers && parse_number(found).has_value();
    if (line == 6 && numbers) return Kind::kEulumdat;
  }
  return Kind::kUnknown;
}

}  // namespace

absl::StatusOr<PhotometricFile> read_luminaire(std::string_view bytes, std::string_view name) {
  const std::string decoded = ascii_of_utf16(bytes);
  std::string_view text = decoded.empty() ? without_byte_order_mark(bytes) : decoded;
  // Blanks may follow the mark.
  const std::size_t end = text.find_last_not_of(std::string_view(" \t\r\n\x1a\0", 6)) + 1;
  if (text.find_first_of(std::string_view("\x1a\0", 2), end) != std::string_view::npos)
    text = text.substr(0, end);
  const bool named_eulumdat = upper_case(name).ends_with(".LDT");
  const Kind kind = kind_of(text);
  const bool eulumdat = kind == Kind::kUnknown ? named_eulumdat : kind == Kind::kEulumdat;
  auto file = eulumdat ? parse_eulumdat(text, name) : parse_ies(text, name);
  if (file.ok() && eulumdat != named_eulumdat &&
      (named_eulumdat || upper_case(name).ends_with(".IES")))
    file->notes.push_back({1,
                           fmt::format("the name of a file of {}", eulumdat ? "IES" : "EULUMDAT"),
                           fmt::format("read as {}", file->format)});
  return file;
}

}  // namespace lucerna
