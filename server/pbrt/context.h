// What every part of the reader works on.
#pragma once

#include <absl/status/statusor.h>

#include <cstddef>
#include <map>
#include <memory>
#include <set>
#include <stop_token>
#include <string>
#include <tuple>
#include <utility>

#include "lights/pictures/image.h"
#include "lights/pictures/intensity_map.h"
#include "lights/spectra/spectrum.h"
#include "server/assets/asset_reader.h"
#include "server/description/scene_description.h"
#include "server/formats/photometric_file.h"
#include "server/pbrt/place.h"

namespace lucerna::pbrt {

struct Parameter;

struct Context {
  Context(AssetReader& assets, SceneDescription& scene, std::stop_token stop,
          std::string scene_file)
      : assets(assets), scene(scene), stop(std::move(stop)), scene_file(std::move(scene_file)) {}

  AssetReader& assets;
  SceneDescription& scene;
  std::stop_token stop;
  std::string scene_file;  ///< the file that loading began with
  /// The pictures read so far, by the name of the file.
  std::map<std::string, std::shared_ptr<const Image>> images;
  /// Of lights, shared between those that say the same (spectra.cpp).
  std::map<std::string, std::shared_ptr<const Spectrum>> spectra;
  /// The luminaires read so far, by the name of the file.
  std::map<std::string, PhotometricFile> photometric_files;
  /// Of goniometric lights, by the name of the picture and how it is read.
  std::map<std::tuple<std::string, SphereMapping, ImageFilter>, std::shared_ptr<const IntensityMap>>
      intensity_maps;

  /// Says that `what` at `place` is not modelled, and what happens instead.  After 1000 remarks
  /// they are only counted.  Says the same only once (an area light is met anew with each of its
  /// shapes).
  void remark(const Place& place, std::string what, std::string instead);
  /// Says how many remarks were only counted, if any.
  void finish_remarks();

  /// The file that `place` names: beneath the directory of the scene file, as pbrt-v4 looks for it,
  /// or of the file that names it.  Unpacked.  Fails at `place`.
  AssetContent read(const Place& place, const std::string& name);
  /// The file that the first string of `parameter` names.  Errors name the parameter too.
  AssetContent read(const Parameter& parameter);

  /// Fails with CANCELLED once the caller gave up.
  void poll() const;

 private:
  absl::StatusOr<AssetContent> find(const Place& place, const std::string& name);

  std::set<std::string> said_;
  std::size_t uncounted_ = 0;
};

}  // namespace lucerna::pbrt
