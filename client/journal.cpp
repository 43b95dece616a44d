#include "client/journal.h"

#include <array>
#include <bit>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>

#include "proto/sha256.h"

namespace lucerna::client {
namespace {

// Length, then the beginning of the bytes' SHA-256.
constexpr std::size_t kSumBytes = 8;
constexpr std::size_t kHeadBytes = sizeof(std::uint32_t) + kSumBytes;
static_assert(std::endian::native == std::endian::little);

std::string sum_of(const std::string& record) { return sha256(record).substr(0, kSumBytes); }

}  // namespace

absl::StatusOr<Journal> Journal::open(
    const std::string& path, const std::string& job,
    const std::function<absl::Status(const std::string&)>& on_record) {
  const std::string first = "lucerna journal 1 " + job + "\n";
  std::uint64_t good = 0;
  if (std::ifstream in(path, std::ios::binary); in) {
    std::string line(first.size(), '\0');
    in.read(line.data(), static_cast<std::streamsize>(line.size()));
    line.resize(static_cast<std::size_t>(in.gcount()));
    // Also one whose first line was cut off.
    if (!first.starts_with(line))
      return absl::FailedPreconditionError(
          path + ": is the journal of another job, or none: remove it, or name another");
    good = line.size() == first.size() ? first.size() : 0;
    for (std::array<char, kHeadBytes> head; in.read(head.data(), head.size());) {
      std::uint32_t size = 0;
      std::memcpy(&size, head.data(), sizeof size);
      std::error_code error;
      if (size > std::filesystem::file_size(path, error)) break;
      std::string record(size, '\0');
      if (!in.read(record.data(), size)) break;
      if (sum_of(record) != std::string(head.data() + sizeof size, kSumBytes)) break;
      if (absl::Status s = on_record(record); !s.ok()) return s;
      good += kHeadBytes + size;
    }
    std::error_code error;
    std::filesystem::resize_file(path, good, error);
    if (error) return absl::UnknownError(path + ": " + error.message());
  }
  std::ofstream out(path, std::ios::binary | std::ios::app);
  if (good == 0) out << first << std::flush;
  if (!out) return absl::UnknownError(path + ": cannot be written");
  return Journal(path, std::move(out));
}

absl::Status Journal::add(const std::string& record) {
  const auto size = static_cast<std::uint32_t>(record.size());
  std::string bytes(sizeof size, '\0');
  std::memcpy(bytes.data(), &size, sizeof size);
  bytes += sum_of(record) + record;
  out_.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  out_.flush();
  return out_ ? absl::OkStatus() : absl::UnknownError(path_ + ": cannot be written");
}

}  // namespace lucerna::client
