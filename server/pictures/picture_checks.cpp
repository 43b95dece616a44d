#include "server/pictures/picture_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <string_view>

namespace lucerna {

absl::Status bad_picture(const AssetContent& content, const std::string& what) {
  return absl::InvalidArgumentError(content.name + ": " + what);
}

std::string known_extension(const std::string& name) {
  std::string extension = std::filesystem::path(name).extension().string();
  std::ranges::transform(extension, extension.begin(), [](unsigned char c) {
    return static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  });
  constexpr std::array<std::string_view, 8> kKnown{".exr", ".hdr",  ".pfm", ".png",
                                                   ".tif", ".tiff", ".jpg", ".jpeg"};
  return std::ranges::find(kKnown, extension) != kKnown.end() ? extension : "";
}

std::string first_line(const std::string& message) {
  constexpr std::size_t kMostBytes = 200;
  std::string line = message.substr(0, message.find('\n'));
  std::ranges::replace_if(
      line, [](char c) { return c < ' ' || c > '~'; }, '?');
  return line.substr(0, kMostBytes);
}

absl::Status unreadable_picture(const AssetContent& content, const std::string& why) {
  return bad_picture(
      content,
      fmt::format("cannot be read as an image{}{}, allowed: a complete {} file",
                  why.empty() ? "" : ": ", first_line(why), known_extension(content.name)));
}

absl::Status check_texels(const AssetContent& content, std::int64_t width, std::int64_t height,
                          std::uint64_t max_texels) {
  if (width < 1 || height < 1) return absl::OkStatus();
  // Widths and heights have 32 bits, so the product fits.
  if (static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height) <= max_texels)
    return absl::OkStatus();
  return absl::ResourceExhaustedError(fmt::format("{}: {} x {} texels, allowed: {} in all",
                                                  content.name, width, height, max_texels));
}

}  // namespace lucerna
