// The list of all lights.  This is the one place that names them.
#pragma once

#include <cstddef>
#include <optional>
#include <type_traits>
#include <utility>
#include <variant>

#include "lights/models/area_light.h"
#include "lights/models/beam_light.h"
#include "lights/models/distant_light.h"
#include "lights/models/goniometric_light.h"
#include "lights/models/image_infinite_light.h"
#include "lights/models/infinite_light.h"
#include "lights/models/light.h"
#include "lights/models/point_light.h"
#include "lights/models/portal_light.h"
#include "lights/models/projection_light.h"
#include "lights/models/spot_light.h"
#include "lights/models/sun_light.h"

namespace lucerna {

/// A list of types.
template <typename... Lights>
struct LightList {
  static constexpr std::size_t kSize = sizeof...(Lights);
};

/// The lights without a surface.  Each has:
/// - `Params`, with the `level` that dims it and with how it moves (`apply`).
/// - `create(params, origin_m)`, which checks them.  Positions are kept about `origin_m`.  What
///   comes after `create` cannot fail.
/// - `place(params)`: its LightPlace.
/// - `params()`: those it was made from.
using FreeLights =
    LightList<PointLight, SpotLight, DistantLight, SunLight, UniformInfiniteLight,
              ImageInfiniteLight, GoniometricLight, ProjectionLight, BeamLight, PortalLight>;

namespace internal {
template <typename... Lights>
std::variant<typename Lights::Params...> params_of(LightList<Lights...>);
using AnyParams = decltype(params_of(FreeLights()));
}  // namespace internal

/// The parameters of any of them.
struct LightParams : internal::AnyParams {
  using internal::AnyParams::variant;
};

namespace internal {
template <typename Params, typename... Lights>
struct LightOf;
template <typename Params, typename L, typename... Rest>
struct LightOf<Params, LightList<L, Rest...>>
    : std::conditional_t<std::is_same_v<typename L::Params, Params>, std::type_identity<L>,
                         LightOf<Params, LightList<Rest...>>> {};
template <typename Params>
struct LightOf<Params, LightList<>> {};
}  // namespace internal

/// The light that is made from `Params`.
template <typename Params>
using LightOf = typename internal::LightOf<Params, FreeLights>::type;

template <typename Profile>
std::optional<LightParams> IntensityLight<Profile>::made_from() const {
  return params();
}

}  // namespace lucerna
