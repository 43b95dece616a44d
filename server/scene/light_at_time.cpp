#include "server/scene/light_at_time.h"

#include <algorithm>

namespace lucerna {
namespace {

template <typename L>
const L& as(const void* light) {
  return *static_cast<const L*>(light);
}

template <typename L>
concept TakesSlack = requires(const L& l, const Vec3& v, const SceneSphere& scene) {
  l.pdf_le(v, v, scene, 0.0);
};

template <typename L>
concept LeavesWithSlack = requires(const L& l, const Vec3& v) {
  l.le_leaving(v, v, 0.0);
};

template <typename L>
constexpr LightTraits kTraits{L::kDelta, SeenOnSurface<L>, SeenBeyond<L>, LeavesFreely<L>,
                              HasIrradiance<L>};

template <typename L>
constexpr LightCalls kCalls{
    .sample_li = [](const void* light, const Receiver& receiver,
                    Vec2 u) { return as<L>(light).sample_li(receiver, u); },
    .pdf_li = [](const void* light, const Receiver& receiver,
                 const Vec3& wi) { return as<L>(light).pdf_li(receiver, wi); },
    .pdf_li_point = [](const void* light, const Receiver& receiver,
                       const SurfacePoint& point) -> SolidAnglePdf {
      if constexpr (SeenOnSurface<L>)
        return as<L>(light).pdf_li(receiver, point);
      else
        return {};
    },
    .irradiance = [](const void* light, const Receiver& receiver) -> std::optional<Rgb> {
      if constexpr (HasIrradiance<L>)
        return as<L>(light).irradiance(receiver);
      else
        return std::nullopt;
    },
    .hides_itself =
        [](const void* light) {
          if constexpr (HasIrradiance<L>)
            return as<L>(light).hides_itself();
          else
            return false;
        },
    .most_irradiance = [](const void* light, const Receiver& receiver) -> MostIrradiance {
      if constexpr (requires { as<L>(light).most_irradiance(receiver); }) {
        return as<L>(light).most_irradiance(receiver);
      } else {
        const LightSample s = as<L>(light).sample_li(receiver, {0.5, 0.5});
        const bool all_around = receiver.normal == Vec3{};
        const double lx =
            luminance(s.value) * (all_around ? 1 : std::max(0.0, dot(receiver.normal, s.wi)));
        return {lx, lx};
      }
    },
    .le = [](const void* light, const SurfacePoint& point, const Vec3& w) -> Rgb {
      if constexpr (SeenOnSurface<L>)
        return as<L>(light).le(point, w);
      else
        return {};
    },
    .le_escaped = [](const void* light, const Vec3& origin, const Vec3& w) -> Rgb {
      if constexpr (SeenBeyond<L>)
        return as<L>(light).le_escaped(origin, w);
      else
        return {};
    },
    .le_leaving = [](const void* light, const Vec3& origin, const Vec3& w, double slack_m) -> Rgb {
      if constexpr (LeavesWithSlack<L>)
        return as<L>(light).le_leaving(origin, w, slack_m);
      else if constexpr (LeavesFreely<L>)
        return as<L>(light).le_leaving(origin, w);
      else
        return {};
    },
    .sample_le =
        [](const void* light, Vec2 u_position, Vec2 u_direction, const SceneSphere& scene) {
          return as<L>(light).sample_le(u_position, u_direction, scene);
        },
    .ray_from = [](const void* light, const SurfacePoint& point, const Vec3& w,
                   double slack_m) -> EmissionSample {
      if constexpr (requires { as<L>(light).ray_from(point, w, slack_m); })
        return as<L>(light).ray_from(point, w, slack_m);
      else if constexpr (SeenOnSurface<L>)
        return as<L>(light).ray_from(point, w);
      else
        return {};
    },
    .pdf_le =
        [](const void* light, const Vec3& position, const Vec3& w, const SceneSphere& scene,
           double slack_m) {
          if constexpr (TakesSlack<L>)
            return as<L>(light).pdf_le(position, w, scene, slack_m);
          else
            return as<L>(light).pdf_le(position, w, scene);
        },
    .power = [](const void* light, const SceneSphere& scene) { return as<L>(light).power(scene); },
    .power_approximate =
        [](const void* light, const SceneSphere& scene) {
          return as<L>(light).power_approximate(scene);
        },
    .bounds = [](const void* light) { return as<L>(light).bounds(); },
};

}  // namespace

bool is_delta(const SceneLight& light) {
  return visit([](const auto& model) { return model.kDelta; }, light.light);
}

LightAtTime::LightAtTime(const SceneLight& light, double time_s) : is_unseen_(light.is_unseen) {
  bool takes_slack = false;
  visit(
      [&]<typename L>(const L& model) {
        static_assert(TakesSlack<L> || !LeavesWithSlack<L>);  // Posed treats both in the same way
        traits_ = &kTraits<L>;
        calls_ = &kCalls<L>;
        light_ = &model;
        takes_slack = TakesSlack<L>;
      },
      light.light);
  if (light.moving == nullptr) [[likely]]
    return;
  const Pose pose = light.moving->at(time_s);
  if (takes_slack)
    move<true>(pose);
  else
    move<false>(pose);
}

template <bool kSlack>
void LightAtTime::move(const Pose& pose) {
  const auto& moved = moved_.emplace<Moved<kSlack>>(*calls_, light_, pose);
  calls_ = &kCalls<Posed<AnyModel<kSlack>>>;
  light_ = &moved.posed;
}

}  // namespace lucerna
