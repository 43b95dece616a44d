#include "client/files/npy_file.h"

#include <fmt/format.h>

#include <bit>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string_view>
#include <utility>
#include <vector>

#include "client/files/npy_header.h"
#include "proto/common/status_macros.h"

namespace lucerna::client {
namespace {

static_assert(std::endian::native == std::endian::little);

class NpyFile final : public VectorFile {
 public:
  explicit NpyFile(std::string path) : path_(std::move(path)), in_(path_, std::ios::binary) {}

  absl::Status open() {
    std::error_code error;
    const std::uint64_t bytes = std::filesystem::file_size(path_, error);
    if (!in_ || error) return bad("cannot be read");
    LUCERNA_ASSIGN_OR_RETURN(const NpyHeader header, read_npy_header(in_, path_));
    if (header.descr != "<f4" && header.descr != "<f8")
      return bad(
          fmt::format("descr = {}, allowed: <f4 or <f8, little-endian floats", header.descr));
    if (header.fortran_order)
      return bad("fortran_order = True, allowed: False (numpy.ascontiguousarray makes it so)");
    const auto& shape = header.shape;
    if (shape.size() != 2 || (shape[1] != 3 && shape[1] != 6))
      return bad(fmt::format("shape = ({}), allowed: (n, 3) or (n, 6)", fmt::join(shape, ", ")));
    rows_ = shape[0];
    columns_ = static_cast<std::size_t>(shape[1]);
    wide_ = header.descr == "<f8";
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
  std::string header(kNpyMagic);
  header += {'\1', '\0', static_cast<char>(length & 0xff), static_cast<char>(length >> 8)};
  return header + text;
}

}  // namespace lucerna::client
