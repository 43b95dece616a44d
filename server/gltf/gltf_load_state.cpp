#include "server/gltf/gltf_load_state.h"

#include <fmt/format.h>

#include "server/files/printable.h"

namespace lucerna::gltf {

SourceLocation LoadState::location(const std::string& pointer) const {
  // Keys of the file may be long or hold anything.
  constexpr std::size_t kMostBytes = 1000;
  const bool is_fit = pointer.size() <= kMostBytes && is_printable(pointer);
  return {
      pointer.empty() ? file : fmt::format("{}#{}", file, is_fit ? pointer : printable(pointer)), 0,
      0};
}

void LoadState::fail(const std::string& pointer, const std::string& what) const {
  fail(pointer, absl::InvalidArgumentError(what));
}

void LoadState::fail(const std::string& pointer, const absl::Status& status) const {
  throw StatusError(absl::Status(status.code(), fmt::format("{}: {}", location(pointer).file.str(),
                                                            std::string(status.message()))));
}

std::string LoadState::light_name(const std::string& pointer,
                                  std::initializer_list<std::string_view> names) {
  for (const std::string_view name : names) {
    if (name.empty()) continue;
    if (is_light_name(name)) return std::string(name);
    remark(pointer,
           fmt::format("the name \"{}\" of {} bytes, allowed: {} bytes without control characters",
                       printable(name), name.size(), kMostLightNameBytes),
           "a light without a name");
    break;
  }
  return {};
}

void LoadState::remark(const std::string& pointer, std::string what, std::string instead) {
  remarks_.add(location(pointer), std::move(what), std::move(instead));
}

void LoadState::finish_remarks() { scene.remarks = remarks_.take(file); }

void LoadState::count_unpacked(const std::string& pointer, std::uint64_t count,
                               std::uint64_t bytes_each) {
  // Counts of accessors are below 2^32 and elements below 1 KiB, so the product cannot overflow.
  unpacked_ += count * bytes_each;
  if (unpacked_ > kMostUnpackedBytes)
    fail(pointer, absl::ResourceExhaustedError(
                      fmt::format("{} elements of {} bytes bring the unpacked scene to {} bytes, "
                                  "allowed: {}",
                                  count, bytes_each, unpacked_, kMostUnpackedBytes)));
}

void LoadState::claim(const std::string& pointer, std::uint64_t count, std::uint64_t bytes_each) {
  count_unpacked(pointer, count, bytes_each);
  require(scratch_.grow(count * bytes_each));
}

void LoadState::claim_for_good(const std::string& pointer, std::uint64_t count,
                               std::uint64_t bytes_each) {
  count_unpacked(pointer, count, bytes_each);
  require(meter.keep(count * bytes_each));
}

void LoadState::poll() {
  if (stop.stop_requested()) throw StatusError(absl::CancelledError("loading was cancelled"));
  require(meter.count_lists());
}

}  // namespace lucerna::gltf
