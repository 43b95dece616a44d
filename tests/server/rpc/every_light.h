// The services, and a scene with one light of each kind.
#pragma once

#include <cmath>
#include <functional>
#include <numbers>

#include "service_fixture.h"
#include "tests/paths.h"

namespace lucerna::testing {

/// Infinite lights whose rays enter through a rectangle.
inline bool has_portal(const v1::Light& light) {
  return light.image_infinite().portal_m_size() > 0;
}

inline double luminance_of(double r, double g, double b) {
  return 0.212639 * r + 0.715169 * g + 0.072192 * b;  // [ITU-R BT.709]
}

inline rpc::ServerOptions all_data() { return scenes_in(test_data()); }

class EveryLightTest : public ::testing::Test {
 protected:
  EveryLightTest() {
    auto list = about<v1::ListLightsRequest>(scene_);
    lights_ = service_.answer(list);
    const auto scene = service_.answer(about<v1::GetSceneRequest>(scene_));
    summary_ = scene.summary();
  }

  v1::SampleLeRequest rays(std::uint32_t count, std::uint64_t seed = 1) const {
    auto q = about<v1::SampleLeRequest>(scene_);
    q.set_count(count);
    q.mutable_seed()->set_seed(seed);
    return q;
  }
  v1::SampleLeRequest rays_of(const v1::Light& light, std::uint32_t count,
                              std::uint64_t seed = 1) const {
    v1::SampleLeRequest q = rays(count, seed);
    q.set_light_id(light.id());
    return q;
  }
  v1::PdfLeRequest density_of(const v1::Light& light) const {
    auto q = about<v1::PdfLeRequest>(scene_);
    q.set_light_id(light.id());
    return q;
  }

  /// The first light for which `is_so` is true.
  const v1::Light& first(const std::function<bool(const v1::Light&)>& is_so) const {
    for (const v1::Light& light : lights_.lights()) {
      if (is_so(light)) return light;
    }
    throw std::runtime_error("no such light in every_light.pbrt");
  }
  const v1::Light& first(v1::Light::KindCase kind) const {
    return first([&](const v1::Light& l) { return l.kind_case() == kind; });
  }
  const v1::Light& first(v1::AreaShape shape) const {
    return first([&](const v1::Light& l) { return l.diffuse_area().shape() == shape; });
  }

  Service service_{all_data()};
  std::string scene_ = service_.load("lights/every_light.pbrt");
  v1::ListLightsResponse lights_;
  v1::SceneSummary summary_;
};

/// Calls EstimatePower for the lights.
class PowerTest : public EveryLightTest {
 protected:
  v1::EstimatePowerRequest request(v1::EstimatePowerRequest::Method method) const {
    auto q = about<v1::EstimatePowerRequest>(scene_);
    q.set_method(method);
    return q;
  }
  v1::EstimatePowerResponse answer(const v1::EstimatePowerRequest& q) { return service_.answer(q); }
};

}  // namespace lucerna::testing
