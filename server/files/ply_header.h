// Parses the header of a PLY file.  [Turk94]
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace lucerna::ply {

enum class Encoding { kAscii, kLittleEndian, kBigEndian };
enum class Type { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };

struct Property {
  std::string name;
  Type type{};
  std::optional<Type> count_type;  ///< set for lists
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

struct Header {
  Encoding encoding{};
  std::vector<Element> elements;
  std::string_view data;  ///< everything after the header
};

/// Size in bytes of a number in binary data.
std::size_t size_of(Type type);

/// Whether the character separates numbers and words.
bool is_space(char c);

/// Returns INVALID_ARGUMENT "PLY: what".
absl::Status error(const std::string& what);

/// Parses up to and including the line "end_header"; the result refers to `bytes`.  Errors: "PLY:
/// header line N: ...".
absl::StatusOr<Header> parse_header(std::string_view bytes);

}  // namespace lucerna::ply
