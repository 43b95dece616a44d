#include "client/files/npy_file.h"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "proto/common/status_macros.h"

namespace lucerna::client {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr std::string_view kMagic("\x93NUMPY", 6);
constexpr std::size_t kMostHeaderBytes = 1 << 16;  // an array of floats needs about a hundred

struct Header {
  std::string descr;
  bool fortran_order = false;
  std::vector<std::uint64_t> shape;
};

/// Parses the dictionary literal in the form that numpy writes.
class Literal {
 public:
  explicit Literal(std::string_view text) : rest_(text) {}

  /// The header; nothing if the text is not such a dictionary.
  std::optional<Header> header() {
    Header result;
    unsigned seen = 0;
    if (!take('{')) return {};
    while (!take('}')) {
      std::string key;
      if (!string(key) || !take(':')) return {};
      if (key == "descr") {
        if (!descr(result.descr)) return {};
        seen |= 1;
      } else if (key == "fortran_order") {
        if (!boolean(result.fortran_order)) return {};
        seen |= 2;
      } else if (key == "shape") {
        if (!tuple(result.shape)) return {};
        seen |= 4;
      } else {
        return {};
      }
      if (!take(',') && !next_is('}')) return {};
    }
    if (seen != 7) return {};
    return result;
  }

 private:
  void skip_space() {
    const std::size_t at = rest_.find_first_not_of(" \t\n");
    rest_.remove_prefix(std::min(at, rest_.size()));
  }
  bool next_is(char c) {
    skip_space();
    return rest_.starts_with(c);
  }
  bool take(char c) {
    if (!next_is(c)) return false;
    rest_.remove_prefix(1);
    return true;
  }
  bool word(std::string_view text) {
    skip_space();
    if (!rest_.starts_with(text)) return false;
    rest_.remove_prefix(text.size());
    return true;
  }
  bool string(std::string& to) {
    for (const char quote : {'\'', '"'}) {
      if (!take(quote)) continue;
      const std::size_t end = rest_.find(quote);
      if (end == std::string_view::npos) return false;
      to = rest_.substr(0, end);
      rest_.remove_prefix(end + 1);
      return true;
    }
    return false;
  }
  /// A structured array has a list here, which is kept as text.
  bool descr(std::string& to) {
    if (!next_is('[')) return string(to);
    const std::size_t end = rest_.rfind(']');
    if (end == std::string_view::npos) return false;
    to = rest_.substr(0, end + 1);
    rest_.remove_prefix(end + 1);
    return true;
  }
  bool boolean(bool& to) {
    to = word("True");
    return to || word("False");
  }
  bool tuple(std::vector<std::uint64_t>& to) {
    if (!take('(')) return false;
    while (!take(')')) {
      skip_space();
      std::uint64_t value = 0;
      const auto [end, error] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), value);
      if (error != std::errc()) return false;
      rest_.remove_prefix(end - rest_.data());
      to.push_back(value);
      if (!take(',') && !next_is(')')) return false;
    }
    return true;
  }

  std::string_view rest_;
};

class NpyFile final : public VectorFile {
 public:
  explicit NpyFile(std::string path) : path_(std::move(path)), in_(path_, std::ios::binary) {}

  absl::Status open() {
    std::error_code error;
    const std::uint64_t bytes = std::filesystem::file_size(path_, error);
    if (!in_ || error) return bad("cannot be read");
    std::string text;
    LUCERNA_RETURN_IF_ERROR(read_header(text));
    const std::optional<Header> header = Literal(text).header();
    if (!header) return bad("has no valid NumPy header: " + text);
    if (header->descr != "<f4" && header->descr != "<f8")
      return bad(
          fmt::format("descr = {}, allowed: <f4 or <f8, little-endian floats", header->descr));
    if (header->fortran_order)
      return bad("fortran_order = True, allowed: False (numpy.ascontiguousarray makes it so)");
    const auto& shape = header->shape;
    if (shape.size() != 2 || (shape[1] != 3 && shape[1] != 6))
      return bad(fmt::format("shape = ({}), allowed: (n, 3) or (n, 6)", fmt::join(shape, ", ")));
    rows_ = shape[0];
    columns_ = static_cast<std::size_t>(shape[1]);
    wide_ = header->descr == "<f8";
    begin_ = static_cast<std::uint64_t>(in_.tellg());
    const std::uint64_t row = columns_ * value_bytes();
    if (rows_ > std::numeric_limits<std::uint64_t>::max() / row || bytes - begin_ != rows_ * row)
      return bad(fmt::format("holds {} bytes of numbers, its shape has {} rows of {}",
                             bytes - begin_, rows_, row));
    return absl::OkStatus();
  }

  std::uint64_t rows() const override { return rows_; }
  std::size_t columns() const override { return columns_; }

  absl::Status read(std::uint64_t first, std::span<double> values) override {
    const std::size_t bytes = values.size() * value_bytes();
    in_.clear();
    in_.seekg(static_cast<std::streamoff>(begin_ + first * columns_ * value_bytes()));
    if (!wide_) narrow_.resize(values.size());
    in_.read(
        wide_ ? reinterpret_cast<char*>(values.data()) : reinterpret_cast<char*>(narrow_.data()),
        static_cast<std::streamsize>(bytes));
    if (!in_) return bad("became shorter while it was read");
    if (!wide_) std::copy(narrow_.begin(), narrow_.end(), values.begin());
    return absl::OkStatus();
  }

 private:
  absl::Status bad(const std::string& what) const {
    return absl::InvalidArgumentError(path_ + ": " + what);
  }
  std::size_t value_bytes() const { return wide_ ? sizeof(double) : sizeof(float); }

  absl::Status read_header(std::string& text) {
    std::array<char, 8> magic{};
    in_.read(magic.data(), magic.size());
    if (!in_ || std::string_view(magic.data(), kMagic.size()) != kMagic)
      return bad("is not an NPY file");
    const int version = magic[6];
    if (version < 1 || version > 3)
      return bad(fmt::format("is of version {}, allowed: 1 to 3", version));
    std::uint32_t length = 0;
    in_.read(reinterpret_cast<char*>(&length), version == 1 ? 2 : 4);
    if (!in_ || length > kMostHeaderBytes) return bad("ends within its header");
    text.resize(length);
    in_.read(text.data(), length);
    return in_ ? absl::OkStatus() : bad("ends within its header");
  }

  std::string path_;
  std::ifstream in_;
  std::uint64_t rows_ = 0, begin_ = 0;
  std::size_t columns_ = 3;
  bool wide_ = false;
  std::vector<float> narrow_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<VectorFile>> open_npy(const std::string& path) {
  auto file = std::make_unique<NpyFile>(path);
  LUCERNA_RETURN_IF_ERROR(file->open());
  return file;
}

std::string npy_header(std::uint64_t rows, std::size_t columns) {
  constexpr std::size_t kBefore = 10, kAlignment = 64;
  std::string text =
      fmt::format("{{'descr': '<f4', 'fortran_order': False, 'shape': ({}, {}), }}", rows, columns);
  // Padding: the numbers begin at a multiple of 64, after a new line.
  const std::size_t used = kBefore + text.size() + 1;
  text += std::string((kAlignment - used % kAlignment) % kAlignment, ' ') + "\n";
  const auto length = static_cast<std::uint16_t>(text.size());
  std::string header(kMagic);
  header += {'\1', '\0', static_cast<char>(length & 0xff), static_cast<char>(length >> 8)};
  return header + text;
}

}  // namespace lucerna::client
