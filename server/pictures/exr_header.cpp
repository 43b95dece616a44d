#include "server/pictures/exr_header.h"

#include <OpenEXR/openexr.h>
#include <absl/cleanup/cleanup.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <functional>
#include <string>
#include <string_view>

#include "proto/common/status_macros.h"
#include "server/pictures/picture_checks.h"

namespace lucerna {
namespace {

/// The file in memory, and the first error of its header.
struct HeaderFile {
  const std::string& bytes;
  exr_result_t code = EXR_ERR_SUCCESS;
  std::string message;
};

HeaderFile& file_of(exr_const_context_t context) {
  void* file = nullptr;
  exr_get_user_data(context, &file);
  return *static_cast<HeaderFile*>(file);
}

void keep_first_error(exr_const_context_t context, exr_result_t code, const char* message) {
  HeaderFile& file = file_of(context);
  if (file.code != EXR_ERR_SUCCESS) return;
  file.code = code;
  file.message = message;
}

std::int64_t size_of(exr_const_context_t, void* file) {
  return static_cast<std::int64_t>(static_cast<HeaderFile*>(file)->bytes.size());
}

std::int64_t read(exr_const_context_t, void* file, void* to, std::uint64_t size,
                  std::uint64_t offset, exr_stream_error_func_ptr_t) {
  const std::string& bytes = static_cast<HeaderFile*>(file)->bytes;
  if (offset >= bytes.size()) return 0;
  const std::uint64_t n = std::min<std::uint64_t>(size, bytes.size() - offset);
  std::memcpy(to, bytes.data() + offset, n);
  return static_cast<std::int64_t>(n);
}

std::uint32_t number(std::string_view bytes, std::size_t at) {
  return static_cast<std::uint32_t>(number_at(bytes, at, 4, std::endian::little));
}

/// Whether the channels at `list` end where `size` bytes do.
bool ends_after(std::string_view list, std::size_t size) {
  constexpr std::size_t kAfterName = 16;  // type, linearity and sampling
  std::size_t at = 0;
  while (at < size && list[at] != '\0') {
    at = list.find('\0', at);
    if (at == std::string_view::npos) return false;
    at += 1 + kAfterName;
  }
  return at + 1 == size;
}

/// The C library reads the channels within the size of the attribute, and the C++ library reads up
/// to an empty name.  If they end at different bytes, the libraries disagree about all attributes
/// behind them.
bool has_whole_channel_lists(std::string_view bytes) {
  constexpr std::string_view kType("\0chlist", 8);  // the end of the name, the type and its end
  const std::boyer_moore_horspool_searcher searcher(kType.begin(), kType.end());
  for (auto found = bytes.begin();;) {
    found = std::search(found, bytes.end(), searcher);
    if (found == bytes.end()) return true;
    found += kType.size();
    const std::string_view rest(found, bytes.end());
    constexpr std::size_t kSizeBytes = 4;
    if (rest.size() < kSizeBytes) return false;
    const std::uint32_t size = number(rest, 0);
    if (size > rest.size() - kSizeBytes || !ends_after(rest.substr(kSizeBytes), size)) return false;
  }
}

/// The libraries take a time that grows with the square of these numbers, and cannot be stopped.
/// Headers that end early are left to them.
absl::Status check_counts(const AssetContent& content) {
  constexpr std::size_t kMostAttributes = 2048, kMostChannels = 1024;
  constexpr std::size_t kVersion = 4, kFirst = 8, kAfterName = 16;
  constexpr std::uint32_t kHasParts = 0x1000;
  const std::string_view bytes = content.bytes;
  const auto end_of_text = [&](std::size_t at) { return bytes.find('\0', at); };
  std::size_t attributes = 0, channels = 0;
  for (std::size_t at = kFirst; at < bytes.size();) {
    if (bytes[at] == '\0') {  // the end of a header
      if ((number(bytes, kVersion) & kHasParts) == 0 || bytes.substr(at, 2).ends_with('\0')) break;
      ++at;
      continue;
    }
    const std::size_t name_end = end_of_text(at);
    const std::size_t type_end = name_end < bytes.size() ? end_of_text(name_end + 1) : name_end;
    if (type_end >= bytes.size()) break;
    const std::string_view type = bytes.substr(name_end + 1, type_end - name_end - 1);
    const std::uint32_t size = number(bytes, type_end + 1);
    at = type_end + 1 + sizeof size;
    ++attributes;
    if (type == "chlist")
      for (std::size_t i = at; i < at + size && i < bytes.size() && bytes[i] != '\0'; ++channels)
        if ((i = end_of_text(i)) < bytes.size()) i += 1 + kAfterName;
    at += size;
  }
  if (channels > kMostChannels)
    return bad_picture(content,
                       fmt::format("{} channels, allowed: at most {}", channels, kMostChannels));
  if (attributes > kMostAttributes)
    return bad_picture(
        content, fmt::format("{} attributes, allowed: at most {}", attributes, kMostAttributes));
  return absl::OkStatus();
}

}  // namespace

absl::Status check_exr_header(const AssetContent& content, std::uint64_t max_texels) {
  LUCERNA_RETURN_IF_ERROR(check_counts(content));
  HeaderFile file{content.bytes, EXR_ERR_SUCCESS, ""};
  exr_context_initializer_t options = EXR_DEFAULT_CONTEXT_INITIALIZER;
  options.error_handler_fn = &keep_first_error;
  options.user_data = &file;
  options.read_fn = &read;
  options.size_fn = &size_of;
  exr_context_t context = nullptr;
  const exr_result_t result = exr_start_read(&context, "picture", &options);
  const absl::Cleanup finish = [&] {
    if (context != nullptr) exr_finish(&context);
  };
  // The C library skips a wrong attribute, and the C++ library reads it.
  if (result != EXR_ERR_SUCCESS || file.code != EXR_ERR_SUCCESS)
    return unreadable_picture(content, file.message);
  if (!has_whole_channel_lists(content.bytes))
    return unreadable_picture(content, "the list of channels does not end with its attribute");
  int parts = 0;
  exr_get_count(context, &parts);
  for (int part = 0; part < parts; ++part) {
    exr_attr_box2i_t window{};
    exr_get_data_window(context, part, &window);
    const auto extent = [](std::int64_t low, std::int64_t high) { return high - low + 1; };
    LUCERNA_RETURN_IF_ERROR(check_texels(content, extent(window.min.x, window.max.x),
                                         extent(window.min.y, window.max.y), max_texels));
  }
  return absl::OkStatus();
}

}  // namespace lucerna
