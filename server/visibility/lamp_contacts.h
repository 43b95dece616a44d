// Lamps without a size that lie on a surface, such as a luminaire at the height of its ceiling.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>

#include "server/rays/accelerator.h"
#include "server/scene/scene.h"

namespace lucerna {

/// Rays are rounded, so they cannot tell on which side of a near surface a lamp is.  For a lamp
/// that may touch a surface, its exact position decides.  A surface that it lies on, up to the
/// rounding of coordinates, does not hide it: both sides get the light that it sends there.
///
/// Each lamp is tested at its first use.  All members may be called from any thread.
class LampContacts : public AttachedPart {
 public:
  /// `scene` must outlive it.
  explicit LampContacts(const Scene& scene);

  /// Whether a surface is so near to this light that rays cannot resolve it.  False for lights with
  /// a size or without a place.
  bool touches(std::uint32_t light) const {
    const Contact known = contacts_[light].load(std::memory_order_relaxed);
    return (known == Contact::kUnknown ? find(light) : known) == Contact::kSome;
  }

  /// Whether a surface is between a receiver and a light that touches one.  `ray`: from the
  /// receiver to the light; its t is 1 there.  `error_m`: of the receiver's position, if that may
  /// lie on a surface of unknown normal.
  bool is_hidden(std::uint32_t light, const Vec3& receiver, Ray ray, RayFilter blocking,
                 float error_m = 0) const;
  /// The share of light that panes between the receiver and such a light pass.
  double through_panes(std::uint32_t light, const Vec3& receiver, Ray ray, float error_m = 0) const;

  std::uint64_t bytes() const override { return scene_.lights().size() * sizeof contacts_[0]; }
  std::optional<ScenePart> report() const override;

 private:
  enum class Contact : std::uint8_t { kUnknown, kNone, kSome };
  Contact find(std::uint32_t light) const;
  /// The first surface that separates both.  `ray`: may start behind surfaces found before.
  std::optional<SurfaceHit> between(std::uint32_t light, const Vec3& receiver, Ray ray,
                                    RayFilter filter, float error_m) const;

  const Scene& scene_;
  std::unique_ptr<std::atomic<Contact>[]> contacts_;  // of each light
};

inline const LampContacts& lamp_contacts(const Scene& scene) {
  return scene.attached<LampContacts>();
}

}  // namespace lucerna
