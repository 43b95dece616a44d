#include "server/visibility/lamp_contacts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "server/rays/error_bounds.h"
#include "server/visibility/end_tolerance.h"

namespace lucerna {
namespace {

/// Surfaces so near to a lamp touch it, for each metre of coordinate.  Eight times the error of
/// rays across the scene.
constexpr double kNear = 8 * kTraversalBound;

/// The place of a light without a size, in its own coordinates.
std::optional<Vec3> place_of(const SceneLight& light) {
  if (!light.light->is_delta()) return std::nullopt;
  const auto bounds = light.light->bounds();
  if (!bounds || bounds->lower != bounds->upper) return std::nullopt;
  return bounds->lower;
}

}  // namespace

LampContacts::LampContacts(const Scene& scene)
    : scene_(scene), contacts_(std::make_unique<std::atomic<Contact>[]>(scene.lights().size())) {}

LampContacts::Contact LampContacts::find(std::uint32_t light) const {
  const SceneLight& of = scene_.lights()[light];
  bool touches = false;
  if (const auto place = place_of(of)) {
    Bounds places;
    if (of.moving == nullptr) {
      places.add(*place);
    } else {
      const auto [lower, upper] = of.moving->motion.bounds(*place, *place);
      places.add(lower), places.add(upper);
    }
    const Vec3 middle = places.lower * 0.5 + places.upper * 0.5;
    const double reach = max_abs(middle) + 2 * largest_coordinate(scene_);
    touches = scene_.geometry().accelerator().may_touch(
        middle, length(places.upper - middle) + kNear * reach + double{kLeastError});
  }
  const Contact contact = touches ? Contact::kSome : Contact::kNone;
  contacts_[light].store(contact, std::memory_order_relaxed);
  return contact;
}

bool LampContacts::is_hidden(std::uint32_t light, const Vec3& receiver, Ray ray, RayFilter blocking,
                             float error_m) const {
  return between(light, receiver, ray, blocking, error_m).has_value();
}

double LampContacts::through_panes(std::uint32_t light, const Vec3& receiver, Ray ray,
                                   float error_m) const {
  double share = 1;
  if (!scene_.geometry().has_panes()) return share;
  while (const auto hit = between(light, receiver, ray, RayFilter::kPanes, error_m)) {
    share *= scene_.geometry().through_pane(*hit, ray.direction);
    // Past the other triangle, if the ray meets an edge.
    const float error_t = max_abs(hit->position_error) / length(ray.direction);
    ray.t_min = std::nextafter(hit->t + error_t, INFINITY);
  }
  return share;
}

std::optional<SurfaceHit> LampContacts::between(std::uint32_t light, const Vec3& receiver, Ray ray,
                                                RayFilter filter, float error_m) const {
  const SceneLight& of = scene_.lights()[light];
  Vec3 lamp = *place_of(of);
  if (of.moving != nullptr) lamp = of.moving->at(ray.time_s).point(lamp);
  // The rounded ray may end before a surface that it should meet.
  constexpr float kBeyond = 1 + 0x1p-12F;
  ray.t_max = kBeyond;
  if (!(ray.t_min < ray.t_max)) return std::nullopt;
  const auto rounding_m = static_cast<float>(kFloatRoundoff * max_abs(receiver)) + kLeastError;
  const EndTolerances ends{
      {receiver, std::max(error_m, rounding_m)}, {lamp, 0}, /*are_exact=*/true};
  return first_other_surface(scene_, ray, ends, filter);
}

std::optional<ScenePart> LampContacts::report() const {
  std::size_t touching = 0;
  for (std::size_t l = 0; l < scene_.lights().size(); ++l)
    touching += contacts_[l].load(std::memory_order_relaxed) == Contact::kSome ? 1 : 0;
  return ScenePart{"lamp contacts", bytes(), 0,
                   fmt::format("a query tested shadows: {} lamps touch a surface", touching)};
}

}  // namespace lucerna
