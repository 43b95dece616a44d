#include "server/files/ply_header.h"

#include <absl/status/status.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>

#include "proto/common/status_macros.h"
#include "server/files/printable.h"

namespace lucerna::ply {
namespace {

// A scanner's or a modeller's file has a few.  They take more memory than their text.
constexpr std::size_t kMostElements = 256;
constexpr std::size_t kMostProperties = 256;  // of all elements

absl::Status header_error(int line, const std::string& what) {
  return error(fmt::format("header line {}: {}", line, what));
}

std::optional<Type> type_named(std::string_view name) {
  if (name == "char" || name == "int8") return Type::kInt8;
  if (name == "uchar" || name == "uint8") return Type::kUint8;
  if (name == "short" || name == "int16") return Type::kInt16;
  if (name == "ushort" || name == "uint16") return Type::kUint16;
  if (name == "int" || name == "int32") return Type::kInt32;
  if (name == "uint" || name == "uint32") return Type::kUint32;
  if (name == "float" || name == "float32") return Type::kFloat;
  if (name == "double" || name == "float64") return Type::kDouble;
  return std::nullopt;
}

/// The words of a line; of a longer line, one more than any line of a header needs.
std::vector<std::string_view> words(std::string_view line) {
  constexpr std::size_t kMostWords = 6;
  std::vector<std::string_view> result;
  std::size_t at = 0;
  while (at < line.size() && result.size() < kMostWords) {
    while (at < line.size() && is_space(line[at])) ++at;
    const std::size_t begin = at;
    while (at < line.size() && !is_space(line[at])) ++at;
    if (at > begin) result.push_back(line.substr(begin, at - begin));
  }
  return result;
}

/// LF, or CR in a file whose first line ends with CR alone.
char line_end_of(std::string_view bytes) {
  const std::size_t end = std::min(bytes.find_first_of("\r\n"), bytes.size());
  return bytes.substr(end, 1) == "\r" && bytes.substr(end + 1, 1) != "\n" ? '\r' : '\n';
}

absl::Status add_property(const std::vector<std::string_view>& line, int number, Header& header) {
  if (header.elements.empty()) return header_error(number, "a property before any element");
  Property property;
  const bool list = line.size() == 5 && line[1] == "list";
  if (!list && line.size() != 3)
    return header_error(number,
                        "expected \"property TYPE NAME\" or \"property list TYPE TYPE NAME\"");
  if (list) {
    property.count_type = type_named(line[2]);
    if (!property.count_type || *property.count_type >= Type::kFloat)
      return header_error(number, fmt::format("\"{}\" cannot count a list", line[2]));
  }
  const auto type = type_named(line[list ? 3 : 1]);
  if (!type) return header_error(number, fmt::format("type \"{}\" is unknown", line[list ? 3 : 1]));
  property.type = *type;
  property.name = std::string(line.back());
  std::size_t properties = 0;
  for (const Element& element : header.elements) properties += element.properties.size();
  if (properties == kMostProperties)
    return header_error(number, fmt::format("more than {} properties", kMostProperties));
  header.elements.back().properties.push_back(std::move(property));
  return absl::OkStatus();
}

}  // namespace

std::size_t size_of(Type type) {
  constexpr std::array<std::size_t, 8> kSizes{1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

bool is_space(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

absl::Status error(const std::string& what) { return absl::InvalidArgumentError("PLY: " + what); }

absl::StatusOr<Header> parse_header(std::string_view bytes) {
  Header header;
  bytes = without_byte_order_mark(bytes);
  const char line_end = line_end_of(bytes);
  bool has_format = false;
  for (int number = 1;; ++number) {
    const std::size_t end = bytes.find(line_end);
    if (end == std::string_view::npos)
      return header_error(number, "the file ends before \"end_header\"");
    const auto line = words(bytes.substr(0, end));
    bytes.remove_prefix(end + 1);
    if (number == 1) {
      if (line.size() != 1 || line[0] != "ply") return header_error(1, "expected \"ply\"");
      continue;
    }
    if (line.empty() || line[0] == "comment" || line[0] == "obj_info") continue;
    if (line[0] == "end_header") {
      if (!has_format) return header_error(number, "no \"format\" before \"end_header\"");
      header.data = bytes;
      return header;
    }
    if (line[0] == "format") {
      if (line.size() != 3 || line[2] != "1.0")
        return header_error(number, "expected \"format ENCODING 1.0\"");
      if (line[1] == "ascii") {
        header.encoding = Encoding::kAscii;
      } else if (line[1] == "binary_little_endian") {
        header.encoding = Encoding::kLittleEndian;
      } else if (line[1] == "binary_big_endian") {
        header.encoding = Encoding::kBigEndian;
      } else {
        return header_error(number, fmt::format("format \"{}\" is unknown", line[1]));
      }
      has_format = true;
    } else if (line[0] == "element") {
      if (header.elements.size() == kMostElements)
        return header_error(number, fmt::format("more than {} elements", kMostElements));
      Element element;
      if (line.size() != 3) return header_error(number, "expected \"element NAME COUNT\"");
      element.name = std::string(line[1]);
      const auto [rest, code] =
          std::from_chars(line[2].data(), line[2].data() + line[2].size(), element.count);
      if (code != std::errc{} || rest != line[2].data() + line[2].size())
        return header_error(number, fmt::format("\"{}\" is not a count", line[2]));
      header.elements.push_back(std::move(element));
    } else if (line[0] == "property") {
      LUCERNA_RETURN_IF_ERROR(add_property(line, number, header));
    } else {
      return header_error(number, fmt::format("keyword \"{}\" is unknown", line[0]));
    }
  }
}

}  // namespace lucerna::ply
