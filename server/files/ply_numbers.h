// Reads the numbers of PLY files.  Only for ply.cpp.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>
#include <system_error>

#include "server/files/ply_header.h"

namespace lucerna::ply {

static_assert(std::endian::native == std::endian::little, "copies little-endian data");

/// The number at `at`.  `swapped`: its first byte is the most significant one.
template <typename T>
T load(const char* at, bool swapped) {
  std::array<char, sizeof(T)> bytes;
  std::memcpy(bytes.data(), at, sizeof(T));
  if (swapped) std::ranges::reverse(bytes);
  return std::bit_cast<T>(bytes);
}

/// Calls `f` with the C++ type.
template <typename F>
void with_type(Type type, F&& f) {
  switch (type) {
    case Type::kInt8:
      return f.template operator()<std::int8_t>();
    case Type::kUint8:
      return f.template operator()<std::uint8_t>();
    case Type::kInt16:
      return f.template operator()<std::int16_t>();
    case Type::kUint16:
      return f.template operator()<std::uint16_t>();
    case Type::kInt32:
      return f.template operator()<std::int32_t>();
    case Type::kUint32:
      return f.template operator()<std::uint32_t>();
    case Type::kFloat:
      return f.template operator()<float>();
    case Type::kDouble:
      return f.template operator()<double>();
  }
}

/// Reads one number after the other from the data.
class Numbers {
 public:
  Numbers(std::string_view data, Encoding encoding) : data_(data), encoding_(encoding) {}

  std::size_t bytes_left() const { return data_.size(); }
  Encoding encoding() const { return encoding_; }
  /// The next bytes, which the caller reads itself.  Requires that many left.
  const char* take(std::size_t bytes) {
    const char* at = data_.data();
    data_.remove_prefix(bytes);
    return at;
  }
  std::string_view rest() const { return data_; }

  /// Minimum size in bytes of a number of `type`.
  std::uint64_t least_bytes(Type type) const {
    return encoding_ == Encoding::kAscii ? 1 : size_of(type);
  }

  /// Returns false if the data end or do not contain a number.
  bool next(Type type, double& value) {
    return encoding_ == Encoding::kAscii ? next_ascii(value) : next_binary(type, value);
  }

 private:
  bool next_ascii(double& value) {
    while (!data_.empty() && is_space(data_.front())) data_.remove_prefix(1);
    if (!data_.empty() && data_.front() == '+') data_.remove_prefix(1);
    const char* end = data_.data() + data_.size();
    const auto [rest, code] = std::from_chars(data_.data(), end, value);
    if (code == std::errc::result_out_of_range) {
      value = std::strtod(std::string(data_.data(), rest).c_str(), nullptr);  // 0 or infinity
    } else if (code != std::errc{}) {
      return false;
    }
    data_.remove_prefix(static_cast<std::size_t>(rest - data_.data()));
    return data_.empty() || is_space(data_.front());
  }

  bool next_binary(Type type, double& value) {
    if (data_.size() < size_of(type)) return false;
    const char* at = take(size_of(type));
    with_type(type, [&]<typename T>() {
      value = static_cast<double>(load<T>(at, encoding_ == Encoding::kBigEndian));
    });
    return true;
  }

  std::string_view data_;
  Encoding encoding_;
};

}  // namespace lucerna::ply
