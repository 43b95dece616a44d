// The lights of a scene, with all that an edit makes anew: names, spectra and the choice of one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "server/description/scene_description.h"
#include "server/runtime/shared_blocks.h"
#include "server/scene/light_names.h"
#include "server/scene/light_selector.h"
#include "server/scene/scene_frame.h"
#include "server/scene/scene_light.h"
#include "server/scene/scene_part.h"

namespace lucerna {

/// What the lights of a scene consist of.
struct LightsData {
  SceneFrame frame;
  SharedBlocks<SceneLight> all;
  std::vector<std::string> files;  ///< of the lights' source locations
  // Both are empty if no light has a spectrum.
  std::vector<std::shared_ptr<const Spectrum>> spectra;
  std::vector<std::int32_t> light_spectra;  ///< of each light, into `spectra`; -1: RGB
  LightNames names;
  /// For each Surface::light the index of its light, -1 if that was removed.  Empty if all are the
  /// same.
  std::vector<std::int32_t> of_surfaces;
  // Set from the others.
  std::vector<std::uint32_t> infinite;
  bool has_visible = false, moves = false;
  std::vector<ScenePart> parts;
  std::vector<ScenePart> pictures;  ///< pictures and webs, which revisions of a scene share
};

/// Immutable.  All members may be called from any thread.
class SceneLights {
 public:
  /// Sets what follows from the lights themselves.
  explicit SceneLights(LightsData data);

  std::size_t size() const { return data_.all.size(); }
  bool empty() const { return data_.all.empty(); }
  const SceneLight& operator[](std::size_t i) const { return data_.all[i]; }
  auto begin() const { return data_.all.begin(); }
  auto end() const { return data_.all.end(); }
  /// What a revision is made from.
  const LightsData& data() const { return data_; }

  const SceneFrame& frame() const { return data_.frame; }
  SourceLocation source_of(const SceneLight& light) const {
    return {data_.files[light.file], light.line, light.column};
  }
  /// World position of the zero of the light's coordinates.
  const Vec3& origin_of(const SceneLight& light) const {
    return light.moving != nullptr ? light.moving->origin_m : data_.frame.origin;
  }
  /// The index of the light with this id.
  std::optional<std::uint32_t> find(std::uint64_t id) const;
  /// The index of the light of surfaces with this Surface::light; -1 if it does not emit.
  std::int32_t of_surface(std::int32_t number) const {
    return data_.of_surfaces.empty() || number < 0
               ? number
               : data_.of_surfaces[static_cast<std::size_t>(number)];
  }
  const LightNames& names() const { return data_.names; }
  std::span<const std::shared_ptr<const Spectrum>> spectra() const { return data_.spectra; }
  /// The number of a light's spectrum among those of the scene.  Equal spectra are stored once.
  std::optional<std::uint32_t> spectrum_number(std::uint32_t light) const {
    if (data_.light_spectra.empty() || data_.light_spectra[light] < 0) return std::nullopt;
    return static_cast<std::uint32_t>(data_.light_spectra[light]);
  }
  /// Null for a light with RGB values.
  const Spectrum* spectrum(std::uint32_t light) const {
    const auto number = spectrum_number(light);
    return number ? data_.spectra[*number].get() : nullptr;
  }
  /// Indices of the lights that rays meet when they leave the scene.
  std::span<const std::uint32_t> infinite() const { return data_.infinite; }
  /// Whether rays may find a light: one that is no delta light and is not unseen.
  bool has_visible() const { return data_.has_visible; }
  /// Whether a light moves.
  bool moves() const { return data_.moves; }

  /// The selector of all lights.  Requires two lights or more.  That of a revision is made at its
  /// first use.
  const LightSelector& selector() const {
    if (const LightSelector* made = selector_.made()) [[likely]]
      return *made;
    return make_selector();
  }
  /// The selector of all lights except delta lights.  Made at its first use.
  const LightSelector& area_selector() const;
  /// Chooses a light for a receiver (LightSelector).  The probability is not part of any density.
  /// `u` in [0, 1).  Nothing if none of the lights that remain for `u` reaches the receiver.
  /// Requires at least one light.
  std::optional<LightChoice> choose(LightSelection how, const Receiver& receiver, double u) const;
  /// The probability with which `choose` chooses this light.
  double probability(LightSelection how, const Receiver& receiver, std::uint32_t light) const;
  /// Chooses a light by flux, for a ray that leaves it.
  LightChoice choose_emitter(double u) const;

  /// The parts that are built.
  std::vector<ScenePart> parts() const;
  std::uint64_t bytes() const;

 private:
  const LightSelector& make_selector() const;
  /// All lights, or all except delta lights, as items of a selector.
  std::vector<LightSelector::Item> selector_items(bool areas_alone) const;

  LightsData data_;
  LazyPart<LightSelector> selector_{"light choice"}, area_selector_{"area light choice"};
};

}  // namespace lucerna
