#include "client/library/journal.h"

#include <fcntl.h>

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <utility>

#include "proto/common/sha256.h"
#include "proto/common/status_macros.h"

namespace lucerna::client {
namespace {

// A record starts with its length and the first bytes of its SHA-256.
constexpr std::size_t kSumBytes = 8;
constexpr std::size_t kHeadBytes = sizeof(std::uint32_t) + kSumBytes;
static_assert(std::endian::native == std::endian::little);

std::string sum_of(const std::string& record) { return sha256(record).substr(0, kSumBytes); }

}  // namespace

absl::StatusOr<Journal> Journal::open(
    const std::string& path, const std::string& job,
    const std::function<absl::Status(const std::string&)>& on_record) {
  const std::string first = "lucerna journal 1 " + job + "\n";
  LUCERNA_ASSIGN_OR_RETURN(auto file,
                           OpenFile::open(path, "another job is using this journal", O_APPEND));
  std::ifstream in(path, std::ios::binary);
  std::string line(first.size(), '\0');
  in.read(line.data(), static_cast<std::streamsize>(line.size()));
  line.resize(static_cast<std::size_t>(in.gcount()));
  // An incomplete first line matches too.
  if (!first.starts_with(line))
    return absl::FailedPreconditionError(
        path +
        ": is the journal of another job, or not a journal: remove it, or choose other files");
  std::uint64_t good = line.size() == first.size() ? first.size() : 0;
  LUCERNA_ASSIGN_OR_RETURN(const auto end, file.size());
  for (std::array<char, kHeadBytes> head; in.read(head.data(), head.size());) {
    std::uint32_t size = 0;
    std::memcpy(&size, head.data(), sizeof size);
    if (size > end) break;
    std::string record(size, '\0');
    if (!in.read(record.data(), size)) break;
    if (sum_of(record) != std::string(head.data() + sizeof size, kSumBytes)) break;
    LUCERNA_RETURN_IF_ERROR(on_record(record));
    good += kHeadBytes + size;
  }
  LUCERNA_RETURN_IF_ERROR(file.resize(good));
  if (good == 0) {
    LUCERNA_RETURN_IF_ERROR(file.append(first));
  }
  return Journal(std::move(file));
}

bool Journal::has_records(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return false;  // a pipe would never end
  std::ifstream in(path, std::ios::binary);
  std::string line;
  return std::getline(in, line) && in.peek() != std::ifstream::traits_type::eof();
}

absl::Status Journal::add(const std::string& record) {
  const auto size = static_cast<std::uint32_t>(record.size());
  std::string bytes(sizeof size, '\0');
  std::memcpy(bytes.data(), &size, sizeof size);
  bytes += sum_of(record) + record;
  return file_.append(bytes);
}

}  // namespace lucerna::client
