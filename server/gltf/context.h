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

#include "server/assets/asset_reader.h"
#include "server/description/remark_groups.h"
#include "server/description/scene_description.h"
#include "server/formats/printable.h"

namespace lucerna::gltf {

/// Thrown within this folder and caught in load_gltf: a status whose message begins with the place.
struct Failure {
  absl::Status status;
};

/// The most bytes of vertices, indices and pictures that one file may unpack to.  A short file may
/// name the same bytes many times, so the size of the file is no limit.
inline constexpr std::uint64_t kMostUnpackedBytes = std::uint64_t{8} << 30;

struct Context {
  Context(AssetReader& assets, SceneDescription& scene, std::stop_token stop, std::string file)
      : assets(assets), scene(scene), stop(std::move(stop)), file(std::move(file)) {}

  AssetReader& assets;
  SceneDescription& scene;
  std::stop_token stop;
  std::string file;  ///< the scene file, relative to the scene root

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

  /// Counts bytes before they are allocated.  RESOURCE_EXHAUSTED above kMostUnpackedBytes.
  void claim(const std::string& pointer, std::uint64_t count, std::uint64_t bytes_each);

  /// Fails with CANCELLED if the caller has stopped the load.
  void poll() const;

 private:
  RemarkGroups remarks_;
  std::uint64_t unpacked_ = 0;
};

}  // namespace lucerna::gltf
