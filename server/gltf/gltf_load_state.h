// What all parts of the glTF loader share: places, errors, remarks and limits.
#pragma once

#include <absl/status/status.h>

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <stop_token>
#include <string>
#include <string_view>
#include <utility>

#include "proto/common/status_error.h"
#include "server/description/load_meter.h"
#include "server/description/remark_groups.h"
#include "server/description/scene_description.h"
#include "server/files/asset_reader.h"
#include "server/files/image_reader.h"
#include "server/files/printable.h"

namespace lucerna::gltf {

/// The most bytes of vertices, indices and pictures that one file may unpack to.  A short file may
/// name the same bytes many times, so the size of the file is no limit.
inline constexpr std::uint64_t kMostUnpackedBytes = std::uint64_t{8} << 30;

struct LoadState {
  LoadState(AssetReader& assets, SceneDescription& scene, std::stop_token stop, std::string file,
            const LoadLimits& limits)
      : assets(assets),
        scene(scene),
        stop(std::move(stop)),
        file(std::move(file)),
        meter(scene, limits),
        scratch_(limits.budget) {}

  AssetReader& assets;
  SceneDescription& scene;
  std::stop_token stop;
  std::string file;  ///< the scene file, relative to the scene root
  LoadMeter meter;

  /// "room.gltf#/nodes/3": the file and a JSON pointer [RFC6901], as the location of a thing.
  SourceLocation location(const std::string& pointer) const;

  /// Throws INVALID_ARGUMENT "room.gltf#/nodes/3: what".
  [[noreturn]] void fail(const std::string& pointer, const std::string& what) const;
  /// Throws `status` (not OK) with the place before its message.
  [[noreturn]] void fail(const std::string& pointer, const absl::Status& status) const;

  /// The first of `names` that is not empty, as the name of the light at `pointer`.  Empty, with a
  /// remark, if no light may have that name.
  std::string light_name(const std::string& pointer, std::initializer_list<std::string_view> names);

  /// Adds a remark that `what` at `pointer` is not modelled, and what happens instead.
  void remark(const std::string& pointer, std::string what, std::string instead);
  /// Moves the remarks to the scene, in groups.
  void finish_remarks();

  /// Counts bytes before they are allocated.  RESOURCE_EXHAUSTED above kMostUnpackedBytes, and if
  /// the budget refuses them.  They are counted until `end_scratch`.
  void claim(const std::string& pointer, std::uint64_t count, std::uint64_t bytes_each);
  /// The same for bytes that stay until the end of the load.
  void claim_for_good(const std::string& pointer, std::uint64_t count, std::uint64_t bytes_each);
  /// What `claim` counted is free again.
  void end_scratch() { scratch_.reset(); }

  ImageOptions image_options(Encoding encoding) const {
    return {meter.limits().max_texels, encoding, stop, meter.budget()};
  }

  /// Fails with CANCELLED if the caller has stopped the load, and with RESOURCE_EXHAUSTED if the
  /// lists of the scene exceed the budget.
  void poll();
  /// Fails if `status` is an error.
  static void require(const absl::Status& status) {
    if (!status.ok()) throw StatusError(status);
  }

 private:
  void count_unpacked(const std::string& pointer, std::uint64_t count, std::uint64_t bytes_each);

  RemarkGroups remarks_;
  std::uint64_t unpacked_ = 0;
  LoadBudget::Share scratch_;
};

}  // namespace lucerna::gltf
