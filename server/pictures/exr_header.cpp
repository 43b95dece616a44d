#include "server/pictures/exr_header.h"

#include <OpenEXR/openexr.h>
#include <absl/cleanup/cleanup.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <string>

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

}  // namespace

absl::Status check_exr_header(const AssetContent& content, std::uint64_t max_texels) {
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
