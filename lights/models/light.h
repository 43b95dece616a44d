// The closed set of light models.  This is the one place that names all of them.  Code that depends
// on the kind of light visits a Light, so code that forgets a kind does not compile.
#pragma once

#include <concepts>
#include <cstdint>
#include <memory>
#include <type_traits>
#include <utility>
#include <variant>

#include "lights/models/area_light.h"
#include "lights/models/beam_light.h"
#include "lights/models/distant_light.h"
#include "lights/models/goniometric_light.h"
#include "lights/models/image_infinite_light.h"
#include "lights/models/infinite_light.h"
#include "lights/models/light_model.h"
#include "lights/models/point_light.h"
#include "lights/models/portal_light.h"
#include "lights/models/projection_light.h"
#include "lights/models/spot_light.h"
#include "lights/models/sun_light.h"

namespace lucerna {

// One type for each shape of LUCERNA_AREA_SHAPES: plain, with a picture, and as a panel.
#define LUCERNA_LIGHT(Shape) , Shape##Light
#define LUCERNA_PAINTED_LIGHT(Shape) , Painted##Shape##Light
#define LUCERNA_PANEL_LIGHT(Shape) , Panel##Shape##Light
/// The list of all of them.
using LightModels =
    std::variant<PointLight, SpotLight, DistantLight, SunLight, UniformInfiniteLight,
                 ImageInfiniteLight  //
                     LUCERNA_AREA_SHAPES(LUCERNA_LIGHT) LUCERNA_AREA_SHAPES(LUCERNA_PAINTED_LIGHT)
                         LUCERNA_FLAT_SHAPES(LUCERNA_PANEL_LIGHT),
                 GoniometricLight, ProjectionLight, BeamLight, PortalLight>;
#undef LUCERNA_LIGHT
#undef LUCERNA_PAINTED_LIGHT
#undef LUCERNA_PANEL_LIGHT

// A light that lacks a member does not compile here.  The message names the light and the member.
template <LightModel... Models>
constexpr bool are_light_models(const std::variant<Models...>*) {
  return true;
}
template <HasMembersOfItsKind... Models>
constexpr bool have_members_of_their_kinds(const std::variant<Models...>*) {
  return true;
}
static_assert(are_light_models(static_cast<const LightModels*>(nullptr)) &&
              have_members_of_their_kinds(static_cast<const LightModels*>(nullptr)));
// Without plain samples, point lights would still work but be slower.
static_assert(HasPlainSamples<PointLight>);

namespace internal {
template <typename Found, typename Models>
struct ParamsOf;
template <typename... Found>
struct ParamsOf<std::variant<Found...>, std::variant<>> {
  using type = std::variant<Found...>;
};
template <typename... Found, typename L, typename... Rest>
struct ParamsOf<std::variant<Found...>, std::variant<L, Rest...>>
    : ParamsOf<std::variant<Found...>, std::variant<Rest...>> {};
template <typename... Found, typename L, typename... Rest>
requires requires { typename L::Params; }
struct ParamsOf<std::variant<Found...>, std::variant<L, Rest...>>
    : ParamsOf<std::variant<Found..., typename L::Params>, std::variant<Rest...>> {};
}  // namespace internal

/// The parameters of each light without a surface, in the order of LightModels.
using LightParams = internal::ParamsOf<std::variant<>, LightModels>::type;

template <typename T, typename Types>
inline constexpr bool kIsOneOf = false;
template <typename T, typename... Types>
inline constexpr bool kIsOneOf<T, std::variant<Types...>> = (std::is_same_v<T, Types> || ...);

/// A light of one of the models, immutable.  Models larger than a point light are stored outside of
/// it, and copies share them.  So entries in a table of lights have the size of a point light.  The
/// largest model is ten times larger.
class Light {
 public:
  template <typename Model>
  requires kIsOneOf<Model, LightModels>
  // NOLINTNEXTLINE(google-explicit-constructor): a model is a light.
  Light(Model model) : stored_(stored(std::move(model))) {}

  /// The result of `f` called with the model.
  template <typename F>
  friend decltype(auto) visit(F&& f, const Light& light) {
    return std::visit([&](const auto& stored) -> decltype(auto) { return f(model_in(stored)); },
                      light.stored_);
  }

  /// Null if the light is of another model.
  template <typename Model>
  const Model* get_if() const {
    const auto* stored = std::get_if<Stored<Model>>(&stored_);
    return stored != nullptr ? &model_in(*stored) : nullptr;
  }

  /// Memory of the model that is stored outside of the Light [bytes].
  std::uint64_t bytes_beside() const {
    return std::visit(
        []<typename S>(const S& stored) -> std::uint64_t {
          using Model = std::decay_t<decltype(model_in(stored))>;
          return std::is_same_v<S, Model> ? 0 : sizeof(Model);
        },
        stored_);
  }

 private:
  template <typename Model>
  using Stored =
      std::conditional_t<sizeof(Model) <= sizeof(PointLight), Model, std::shared_ptr<const Model>>;
  template <typename Models>
  struct Storage;
  template <typename... Models>
  struct Storage<std::variant<Models...>> {
    using type = std::variant<Stored<Models>...>;
  };

  template <typename Model>
  static Stored<Model> stored(Model model) {
    if constexpr (std::is_same_v<Stored<Model>, Model>)
      return model;
    else
      return std::make_shared<const Model>(std::move(model));
  }
  template <typename Model>
  static const Model& model_in(const Model& model) {
    return model;
  }
  template <typename Model>
  static const Model& model_in(const std::shared_ptr<const Model>& model) {
    return *model;
  }

  typename Storage<LightModels>::type stored_;
};

}  // namespace lucerna
