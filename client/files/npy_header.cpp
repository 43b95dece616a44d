#include "client/files/npy_header.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <string_view>

namespace lucerna::client {
namespace {

constexpr std::size_t kMostHeaderBytes = 1 << 16;  // an array of floats needs about a hundred

/// Parses the dictionary literal in the form that numpy writes.
class Literal {
 public:
  explicit Literal(std::string_view text) : rest_(text) {}

  /// The header; nothing if the text is not such a dictionary.
  std::optional<NpyHeader> header() {
    NpyHeader result;
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

}  // namespace

absl::StatusOr<NpyHeader> read_npy_header(std::istream& in, const std::string& name) {
  const auto bad = [&](const std::string& what) {
    return absl::InvalidArgumentError(name + ": " + what);
  };
  std::array<char, 8> magic{};
  in.read(magic.data(), magic.size());
  if (!in || std::string_view(magic.data(), kNpyMagic.size()) != kNpyMagic)
    return bad("is not an NPY file");
  const int version = magic[6];
  if (version < 1 || version > 3)
    return bad(fmt::format("is of version {}, allowed: 1 to 3", version));
  std::uint32_t length = 0;
  in.read(reinterpret_cast<char*>(&length), version == 1 ? 2 : 4);
  if (!in || length > kMostHeaderBytes) return bad("ends within its header");
  std::string text(length, '\0');
  in.read(text.data(), length);
  if (!in) return bad("ends within its header");
  std::optional<NpyHeader> header = Literal(text).header();
  if (!header) return bad("has no valid NumPy header: " + text);
  return *std::move(header);
}

}  // namespace lucerna::client
