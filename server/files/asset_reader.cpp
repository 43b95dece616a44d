#include "server/files/asset_reader.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <limits>
#include <string_view>
#include <utility>

#include "proto/common/sha256.h"
#include "proto/common/status_macros.h"
#include "server/files/directory_source.h"

namespace lucerna {
namespace {

constexpr std::size_t kChunkBytes = 1 << 20;

std::string joined(const std::vector<std::string>& parts) {
  return fmt::format("{}", fmt::join(parts, "/"));
}

absl::Status too_much(const std::string& name, std::uint64_t limit) {
  return absl::ResourceExhaustedError(fmt::format(
      "file \"{}\": the scene's files together exceed the limit of {} bytes", name, limit));
}

/// The product, or the largest number.
std::uint64_t saturated(std::uint64_t a, std::uint64_t b) {
  std::uint64_t product = 0;
  return __builtin_mul_overflow(a, b, &product) ? std::numeric_limits<std::uint64_t>::max()
                                                : product;
}

/// The last four bytes as a number, the lowest byte first.
std::uint64_t last_number(std::string_view bytes) {
  std::uint64_t number = 0;
  for (std::size_t i = 0; i < 4 && i < bytes.size(); ++i)
    number = number << 8U | static_cast<unsigned char>(bytes[bytes.size() - 1 - i]);
  return number;
}

absl::Status cancelled() { return absl::CancelledError("loading was cancelled"); }

absl::Status unpacks_too_far(const std::string& name, std::size_t packed,
                             const AssetReaderOptions& options) {
  return absl::ResourceExhaustedError(fmt::format(
      "file \"{}\": its {} bytes unpack to more than the limit, the larger of {} bytes and {} "
      "times its size",
      name, packed, options.max_unpacked_bytes, options.max_unpacked_ratio));
}

}  // namespace

AssetReader::AssetReader(std::unique_ptr<FileSource> source, const AssetReaderOptions& options)
    : source_(std::move(source)), options_(options), remaining_bytes_(options.max_total_bytes) {}

absl::StatusOr<AssetReader> AssetReader::open(const std::string& root,
                                              const AssetReaderOptions& options) {
  auto source = DirectorySource::open_root(root, options.use_openat2);
  if (!source.ok()) return source.status();
  return AssetReader(*std::move(source), options);
}

absl::StatusOr<std::string> AssetReader::resolve(const std::string& name,
                                                 const std::string& relative_to) const {
  if (name.empty()) return absl::InvalidArgumentError("file name \"\" is empty");
  if (name.find('\0') != std::string::npos)
    return absl::InvalidArgumentError("file name contains a zero byte");
  if (name.front() == '/') return leaves_root(name);
  std::vector<std::string> path = path_components(relative_to);
  if (!path.empty()) path.pop_back();
  for (std::string& part : path_components(name)) {
    if (part.empty() || part == ".") continue;
    if (part != "..") {
      path.push_back(std::move(part));
    } else if (path.empty()) {
      return leaves_root(name);
    } else {
      path.pop_back();
    }
  }
  if (path.empty())
    return absl::InvalidArgumentError(fmt::format("\"{}\" is not a regular file", name));
  return joined(path);
}

absl::StatusOr<AssetContent> AssetReader::read(const std::string& name,
                                               const std::string& relative_to) {
  auto path = resolve(name, relative_to);
  if (!path.ok()) return path.status();
  auto file = source_->open(*path, name);
  if (!file.ok()) return file.status();
  if (file->size > remaining_bytes_) return too_much(name, options_.max_total_bytes);

  AssetContent content{*path, {}, LoadBudget::Share(options_.budget)};
  LUCERNA_RETURN_IF_ERROR(content.share.resize(file->size));
  content.bytes.resize(file->size);
  const bool is_new = seen_.insert(content.name).second;
  Sha256 sha;
  std::size_t done = 0;
  while (done < content.bytes.size()) {
    if (options_.stop.stop_requested()) return cancelled();
    const std::int64_t n = read_fully(file->fd.get(), content.bytes.data() + done,
                                      std::min(kChunkBytes, content.bytes.size() - done));
    if (n < 0) return unreadable(name);
    if (n == 0) break;  // the file became shorter
    const auto read = static_cast<std::size_t>(n);
    if (is_new) sha.add(std::string_view(content.bytes).substr(done, read));
    done += read;
  }
  content.bytes.resize(done);
  remaining_bytes_ -= done;
  if (is_new) assets_.push_back({content.name, sha.finish(), done});
  return content;
}

absl::StatusOr<AssetContent> AssetReader::read_unpacked(const std::string& name,
                                                        const std::string& relative_to) {
  auto packed = read(name, relative_to);
  if (!packed.ok() || packed->bytes.compare(0, 2, "\x1f\x8b") != 0) return packed;

  z_stream stream{};
  constexpr int kGzipOnly = 15 + 16;
  if (inflateInit2(&stream, kGzipOnly) != Z_OK) return unreadable(name);
  const std::unique_ptr<z_stream, int (*)(z_stream*)> end(&stream, &inflateEnd);
  std::string& in = packed->bytes;
  const std::uint64_t limit =
      std::max(options_.max_unpacked_bytes, saturated(in.size(), options_.max_unpacked_ratio));
  LoadBudget::Share share(options_.budget);
  std::string out;
  // A file of one member below 4 GiB ends with its unpacked size.  [RFC1952, 2.3.1]
  if (const std::uint64_t stated = last_number(in); stated <= limit) {
    LUCERNA_RETURN_IF_ERROR(share.resize(stated));
    out.reserve(stated);
  }
  std::string chunk(kChunkBytes, '\0');
  std::size_t consumed = 0;
  int result = Z_OK;
  while (result == Z_OK) {
    if (options_.stop.stop_requested()) return cancelled();
    // zlib counts in 32 bits, so it reads one part at a time.
    const std::size_t part = std::min<std::size_t>(in.size() - consumed, std::size_t{1} << 30);
    stream.next_in = reinterpret_cast<Bytef*>(in.data() + consumed);
    stream.avail_in = static_cast<uInt>(part);
    stream.next_out = reinterpret_cast<Bytef*>(chunk.data());
    stream.avail_out = static_cast<uInt>(chunk.size());
    result = inflate(&stream, Z_NO_FLUSH);
    consumed += part - stream.avail_in;
    const std::size_t produced = chunk.size() - stream.avail_out;
    if (produced > remaining_bytes_) return too_much(name, options_.max_total_bytes);
    if (out.size() + produced > limit) return unpacks_too_far(name, in.size(), options_);
    remaining_bytes_ -= produced;
    if (out.size() + produced > out.capacity()) {
      // The copy to more room needs both.
      const std::size_t more = std::min<std::uint64_t>(limit, 2 * (out.size() + produced));
      LUCERNA_RETURN_IF_ERROR(share.resize(out.size() + more));
      out.reserve(more);
      LUCERNA_RETURN_IF_ERROR(share.resize(out.capacity()));
    }
    out.append(chunk, 0, produced);
    if (result == Z_STREAM_END && consumed < in.size()) result = inflateReset(&stream);
  }
  if (result != Z_STREAM_END)
    return absl::InvalidArgumentError(
        fmt::format("file \"{}\": its gzip data are broken or incomplete", name));
  packed->bytes = std::move(out);
  packed->share = std::move(share);
  return packed;
}

absl::StatusOr<std::vector<Asset>> AssetReader::rehash(const std::vector<Asset>& assets) {
  std::vector<Asset> now;
  std::string chunk(kChunkBytes, '\0');
  for (const Asset& asset : assets) {
    auto path = resolve(asset.name, "");
    if (!path.ok()) return path.status();
    auto file = source_->open(*path, asset.name);
    if (!file.ok()) return file.status();
    Sha256 sha;
    std::uint64_t bytes = 0;
    for (std::int64_t n = 1; n > 0;) {
      n = read_fully(file->fd.get(), chunk.data(), chunk.size());
      if (n < 0) return unreadable(asset.name);
      sha.add(std::string_view(chunk).substr(0, static_cast<std::size_t>(n)));
      bytes += static_cast<std::uint64_t>(n);
    }
    now.push_back({asset.name, sha.finish(), bytes});
  }
  return now;
}

}  // namespace lucerna
