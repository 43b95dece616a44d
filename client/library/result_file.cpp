#include "client/library/result_file.h"

#include <bit>
#include <string_view>

#include "proto/common/status_macros.h"

namespace lucerna::client {

static_assert(std::endian::native == std::endian::little);

absl::StatusOr<ResultFile> ResultFile::open(const std::string& path, const std::string& header,
                                            std::uint64_t rows, std::size_t columns, Other other) {
  LUCERNA_ASSIGN_OR_RETURN(auto file, OpenFile::open(path, "another process is writing it"));
  const std::uint64_t size = header.size() + rows * columns * sizeof(float);
  LUCERNA_ASSIGN_OR_RETURN(const auto now, file.size());
  bool fits = now == size;
  if (fits) {
    std::string there(header.size(), '\0');
    LUCERNA_RETURN_IF_ERROR(file.read(0, there.data(), there.size()));
    fits = there == header;
  }
  if (!fits && now > 0 && other == Other::kKeep)
    return absl::FailedPreconditionError(path + ": has other contents");
  if (!fits) {
    // A full disk should fail now rather than after hours.
    LUCERNA_RETURN_IF_ERROR(file.reserve(size));
    if (absl::Status s = file.write(0, header); !s.ok()) {
      file.resize(0).IgnoreError();
      return s;
    }
  }
  return ResultFile(std::move(file), header.size(), rows, columns);
}

absl::Status ResultFile::write(std::uint64_t first, std::span<const float> values) {
  return file_.write(begin_ + first * columns_ * sizeof(float),
                     {reinterpret_cast<const char*>(values.data()), values.size_bytes()});
}

absl::Status ResultFile::read(std::uint64_t first, std::span<float> values) const {
  return file_.read(begin_ + first * columns_ * sizeof(float),
                    reinterpret_cast<char*>(values.data()), values.size_bytes());
}

}  // namespace lucerna::client
