#include "server/pictures/picture_checks.h"

#include <fmt/format.h>

#include <algorithm>

#include "server/pictures/picture_format.h"

namespace lucerna {

absl::Status bad_picture(const AssetContent& content, const std::string& what) {
  return absl::InvalidArgumentError(content.name + ": " + what);
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
      content, fmt::format("cannot be read as an image{}{}, allowed: a complete {} file",
                           why.empty() ? "" : ": ", first_line(why), name_of(format_of(content))));
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
