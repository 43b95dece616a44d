// The state that all parts of the reader share.
#pragma once

#include <absl/status/statusor.h>

#include <cstddef>
#include <map>
#include <memory>
#include <stop_token>
#include <string>
#include <tuple>
#include <utility>

#include "lights/maths/spectrum.h"
#include "lights/pictures/image.h"
#include "lights/pictures/intensity_map.h"
#include "server/description/load_meter.h"
#include "server/description/remark_groups.h"
#include "server/description/scene_description.h"
#include "server/files/asset_reader.h"
#include "server/files/image_reader.h"
#include "server/files/photometric_file.h"
#include "server/pbrt/file_position.h"

namespace lucerna::pbrt {

struct Parameter;

struct LoadState {
  LoadState(AssetReader& assets, SceneDescription& scene, std::stop_token stop,
            std::string scene_file, const LoadLimits& limits)
      : assets(assets),
        scene(scene),
        stop(std::move(stop)),
        scene_file(std::move(scene_file)),
        meter(scene, limits),
        tables_(limits.budget) {}

  AssetReader& assets;
  SceneDescription& scene;
  std::stop_token stop;
  std::string scene_file;  ///< the first file of the load
  LoadMeter meter;
  /// Pictures read so far, by file name and encoding.
  std::map<std::pair<std::string, Encoding>, std::shared_ptr<const Image>> images;
  /// Pictures of surfaces read so far, in the same way.
  std::map<std::pair<std::string, Encoding>, std::shared_ptr<const Texels>> texels;
  /// Why pictures cannot be decoded, in the same way.
  std::map<std::pair<std::string, Encoding>, absl::Status> unreadable;
  /// Spectra of lights, shared by lights with the same spectrum (spectra.cpp).
  std::map<std::string, std::shared_ptr<const Spectrum>> spectra;
  /// Luminaires read so far, by file name.
  std::map<std::string, PhotometricFile> photometric_files;
  /// Pictures of goniometric lights, by file name and the way they are read.
  std::map<std::tuple<std::string, SphereMapping, ImageFilter>, std::shared_ptr<const IntensityMap>>
      intensity_maps;

  /// Adds a remark that `what` at `place` is not modelled, and what happens instead.
  void remark(const FilePosition& place, std::string what, std::string instead);
  /// Moves the remarks to the scene, in groups.
  void finish_remarks();

  /// The unpacked content of the file `name`.  Looks in the directory of the scene file first, as
  /// pbrt-v4 does, then in that of the file that names it.  Fails at `place`.
  AssetContent read(const FilePosition& place, const std::string& name);
  /// The file that the first string of `parameter` names.  Errors name the parameter too.
  AssetContent read(const Parameter& parameter);

  ImageOptions image_options(Encoding encoding) const {
    return {meter.limits().max_texels, encoding, stop, meter.budget()};
  }

  /// Fails with CANCELLED if the caller has stopped the load, and with RESOURCE_EXHAUSTED if the
  /// lists of the scene exceed the budget.
  void poll();
  /// Counts bytes that the loader needs until the load ends, for what grows with the number of
  /// directives.  A short directive can need far more memory than its text.
  void count(std::uint64_t bytes) { require(tables_.grow(bytes)); }
  /// Fails if `status` is an error.
  static void require(const absl::Status& status) {
    if (!status.ok()) throw StatusError(status);
  }

 private:
  absl::StatusOr<AssetContent> find(const FilePosition& place, const std::string& name);

  RemarkGroups remarks_;
  LoadBudget::Share tables_;
};

}  // namespace lucerna::pbrt
