#include "client/jobs/journal.h"

#include <fcntl.h>

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <utility>

#include "proto/common/sha256.h"

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
  auto file = OpenFile::open(path, "another job is using this journal", O_APPEND);
  if (!file.ok()) return file.status();
  std::ifstream in(path, std::ios::binary);
  std::string line(first.size(), '\0');
  in.read(line.data(), static_cast<std::streamsize>(line.size()));
  line.resize(static_cast<std::size_t>(in.gcount()));
  // Also one whose first line was cut off.
  if (!first.starts_with(line))
    return absl::FailedPreconditionError(
        path +
        ": is the journal of another job, or none: remove it, or name another journal and output");
  std::uint64_t good = line.size() == first.size() ? first.size() : 0;
  const auto end = file->size();
  if (!end.ok()) return end.status();
  for (std::array<char, kHeadBytes> head; in.read(head.data(), head.size());) {
    std::uint32_t size = 0;
    std::memcpy(&size, head.data(), sizeof size);
    if (size > *end) break;
    std::string record(size, '\0');
    if (!in.read(record.data(), size)) break;
    if (sum_of(record) != std::string(head.data() + sizeof size, kSumBytes)) break;
    if (absl::Status s = on_record(record); !s.ok()) return s;
    good += kHeadBytes + size;
  }
  if (absl::Status s = file->resize(good); !s.ok()) return s;
  if (good == 0) {
    if (absl::Status s = file->append(first); !s.ok()) return s;
  }
  return Journal(*std::move(file));
}

bool Journal::tells(const std::string& path) {
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
