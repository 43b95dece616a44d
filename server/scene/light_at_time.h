// A light at one moment, with one interface for all models.
//
// Code that visits a light with a generic lambda is compiled for each model, and again for each
// model that moves.  Code that calls a LightAtTime is compiled once.  A call goes through a table
// of functions and takes about a nanosecond more than a direct call.
#pragma once

#include <optional>
#include <utility>
#include <variant>

#include "lights/models/irradiance.h"
#include "lights/models/light_bounds.h"
#include "lights/models/point_light.h"
#include "lights/models/posed_light.h"
#include "lights/sampling/light_sample.h"
#include "lights/shapes/shape.h"
#include "server/scene/scene.h"

namespace lucerna {

/// Properties of a model that are known at compile time, from the concepts of
/// lights/models/light.h.
struct LightTraits {
  bool is_delta;        ///< `kDelta`
  bool has_surface;     ///< SeenOnSurface
  bool is_seen_beyond;  ///< SeenBeyond
  bool leaves_freely;   ///< LeavesFreely
  bool has_irradiance;  ///< HasIrradiance
};

/// The members of one model, each with a pointer to the light before its arguments.  A member that
/// the model lacks returns black, a density of 0 or nothing.  `slack_m` has no effect on a model
/// without that argument.
struct LightCalls {
  LightSample (*sample_li)(const void*, const Receiver&, Vec2 u);
  SolidAnglePdf (*pdf_li)(const void*, const Receiver&, const Vec3& wi);
  SolidAnglePdf (*pdf_li_point)(const void*, const Receiver&, const SurfacePoint&);
  std::optional<Rgb> (*irradiance)(const void*, const Receiver&);
  bool (*hides_itself)(const void*);
  MostIrradiance (*most_irradiance)(const void*, const Receiver&);
  Rgb (*le)(const void*, const SurfacePoint&, const Vec3& w);
  Rgb (*le_escaped)(const void*, const Vec3& origin, const Vec3& w);
  Rgb (*le_leaving)(const void*, const Vec3& origin, const Vec3& w, double slack_m);
  EmissionSample (*sample_le)(const void*, Vec2 u_position, Vec2 u_direction, const SceneSphere&);
  EmissionSample (*ray_from)(const void*, const SurfacePoint&, const Vec3& w, double slack_m);
  EmissionPdf (*pdf_le)(const void*, const Vec3& position, const Vec3& w, const SceneSphere&,
                        double slack_m);
  Power (*power)(const void*, const SceneSphere&);
  Power (*power_approximate)(const void*, const SceneSphere&);
  std::optional<LightBounds> (*bounds)(const void*);
};

/// A light of any model, with the members that Posed calls, so that one Posed serves all
/// models. `kSlack`: whether pdf_le and le_leaving of the model take `slack_m`.  Posed treats
/// such models differently.
template <bool kSlack>
class AnyModel {
 public:
  // Posed requires the constant.  LightTraits has the value of the model.
  static constexpr bool kDelta = false;

  AnyModel(const LightCalls& calls, const void* light) : calls_(calls), light_(light) {}

  LightSample sample_li(const Receiver& receiver, Vec2 u) const {
    return calls_.sample_li(light_, receiver, u);
  }
  SolidAnglePdf pdf_li(const Receiver& receiver, const Vec3& wi) const {
    return calls_.pdf_li(light_, receiver, wi);
  }
  SolidAnglePdf pdf_li(const Receiver& receiver, const SurfacePoint& point) const {
    return calls_.pdf_li_point(light_, receiver, point);
  }
  std::optional<Rgb> irradiance(const Receiver& receiver) const {
    return calls_.irradiance(light_, receiver);
  }
  bool hides_itself() const { return calls_.hides_itself(light_); }
  MostIrradiance most_irradiance(const Receiver& receiver) const {
    return calls_.most_irradiance(light_, receiver);
  }
  Rgb le(const SurfacePoint& point, const Vec3& w) const { return calls_.le(light_, point, w); }
  Rgb le_escaped(const Vec3& origin, const Vec3& w) const {
    return calls_.le_escaped(light_, origin, w);
  }
  Rgb le_leaving(const Vec3& origin, const Vec3& w) const {
    return calls_.le_leaving(light_, origin, w, 0);
  }
  Rgb le_leaving(const Vec3& origin, const Vec3& w, double slack_m) const requires(kSlack) {
    return calls_.le_leaving(light_, origin, w, slack_m);
  }
  EmissionSample sample_le(Vec2 u_position, Vec2 u_direction, const SceneSphere& scene) const {
    return calls_.sample_le(light_, u_position, u_direction, scene);
  }
  EmissionSample ray_from(const SurfacePoint& point, const Vec3& w) const {
    return calls_.ray_from(light_, point, w, 0);
  }
  EmissionSample ray_from(const SurfacePoint& point, const Vec3& w, double slack_m) const
      requires(kSlack) {
    return calls_.ray_from(light_, point, w, slack_m);
  }
  EmissionPdf pdf_le(const Vec3& position, const Vec3& w, const SceneSphere& scene) const {
    return calls_.pdf_le(light_, position, w, scene, 0);
  }
  EmissionPdf pdf_le(const Vec3& position, const Vec3& w, const SceneSphere& scene,
                     double slack_m) const requires(kSlack) {
    return calls_.pdf_le(light_, position, w, scene, slack_m);
  }
  Power power(const SceneSphere& scene) const { return calls_.power(light_, scene); }
  Power power_approximate(const SceneSphere& scene) const {
    return calls_.power_approximate(light_, scene);
  }
  std::optional<LightBounds> bounds() const { return calls_.bounds(light_); }

 private:
  const LightCalls& calls_;
  const void* light_;
};

/// A light of a scene at one moment, about the scene's origin.  The members are those of the models
/// and return the same bits.  LightCalls states what they return for models without them.  Refers
/// to the light, which must outlive it.  May be called from any thread.
class LightAtTime {
 public:
  LightAtTime(const SceneLight& light, double time_s);
  LightAtTime(const LightAtTime&) = delete;
  LightAtTime& operator=(const LightAtTime&) = delete;

  bool is_delta() const { return traits_->is_delta; }
  bool is_unseen() const { return is_unseen_; }
  bool has_surface() const { return traits_->has_surface; }
  bool is_seen_beyond() const { return traits_->is_seen_beyond; }
  bool leaves_freely() const { return traits_->leaves_freely; }
  bool has_irradiance() const { return traits_->has_irradiance; }

  LightSample sample_li(const Receiver& receiver, Vec2 u) const {
    return calls_->sample_li(light_, receiver, u);
  }
  SolidAnglePdf pdf_li(const Receiver& receiver, const Vec3& wi) const {
    return calls_->pdf_li(light_, receiver, wi);
  }
  SolidAnglePdf pdf_li(const Receiver& receiver, const SurfacePoint& point) const {
    return calls_->pdf_li_point(light_, receiver, point);
  }
  std::optional<Rgb> irradiance(const Receiver& receiver) const {
    return calls_->irradiance(light_, receiver);
  }
  bool hides_itself() const { return calls_->hides_itself(light_); }
  MostIrradiance most_irradiance(const Receiver& receiver) const {
    return calls_->most_irradiance(light_, receiver);
  }
  Rgb le(const SurfacePoint& point, const Vec3& w) const { return calls_->le(light_, point, w); }
  Rgb le_escaped(const Vec3& origin, const Vec3& w) const {
    return calls_->le_escaped(light_, origin, w);
  }
  Rgb le_leaving(const Vec3& origin, const Vec3& w) const {
    return calls_->le_leaving(light_, origin, w, 0);
  }
  EmissionSample sample_le(Vec2 u_position, Vec2 u_direction, const SceneSphere& scene) const {
    return calls_->sample_le(light_, u_position, u_direction, scene);
  }
  EmissionSample ray_from(const SurfacePoint& point, const Vec3& w) const {
    return calls_->ray_from(light_, point, w, 0);
  }
  EmissionPdf pdf_le(const Vec3& position, const Vec3& w, const SceneSphere& scene) const {
    return calls_->pdf_le(light_, position, w, scene, 0);
  }
  Power power(const SceneSphere& scene) const { return calls_->power(light_, scene); }
  Power power_approximate(const SceneSphere& scene) const {
    return calls_->power_approximate(light_, scene);
  }
  std::optional<LightBounds> bounds() const { return calls_->bounds(light_); }

 private:
  template <bool kSlack>
  struct Moved {
    Moved(const LightCalls& calls, const void* light, const Pose& pose)
        : model(calls, light), posed(model, pose) {}
    AnyModel<kSlack> model;
    Posed<AnyModel<kSlack>> posed;
  };
  template <bool kSlack>
  void move(const Pose& pose);

  const LightTraits* traits_;
  const LightCalls* calls_;
  const void* light_;
  bool is_unseen_;
  // The light that `light_` points to, if it moves.
  std::variant<std::monostate, Moved<false>, Moved<true>> moved_{};
};

/// Whether the light is a delta light.
bool is_delta(const SceneLight& light);

/// Calls `f` with the light at `time_s`.  The argument is the model itself if a sample takes less
/// time than a call (HasPlainSamples), else a LightAtTime.
template <typename F>
void with_fast_light(const SceneLight& light, double time_s, F&& f) {
  if (light.moving == nullptr)
    if (const auto* point = light.light.template get_if<PointLight>()) return f(*point);
  f(LightAtTime(light, time_s));
}

}  // namespace lucerna
