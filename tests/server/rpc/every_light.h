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

inline rpc::ServerOptions all_data() {
  rpc::ServerOptions options = service_options();
  options.scenes.root = test_data();
  return options;
}

class EveryLightTest : public ::testing::Test {
 protected:
  EveryLightTest() {
    v1::ListLightsRequest list;
    list.set_scene_id(scene_);
    EXPECT_TRUE(
        status_of([&](auto* c) { return service_.scenes.ListLights(c, list, &lights_); }).ok());
    v1::GetSceneRequest get;
    get.set_scene_id(scene_);
    v1::GetSceneResponse scene;
    EXPECT_TRUE(status_of([&](auto* c) { return service_.scenes.GetScene(c, get, &scene); }).ok());
    summary_ = scene.summary();
  }

  grpc::Status sample(const v1::SampleLeRequest& q, v1::SampleLeResponse* r) {
    return status_of([&](auto* c) { return service_.lighting.SampleLe(c, q, r); });
  }
  grpc::Status pdf(const v1::PdfLeRequest& q, v1::PdfLeResponse* r) {
    return status_of([&](auto* c) { return service_.lighting.PdfLe(c, q, r); });
  }
  grpc::Status power(const v1::EstimatePowerRequest& q, v1::EstimatePowerResponse* r) {
    return status_of([&](auto* c) { return service_.lighting.EstimatePower(c, q, r); });
  }

  v1::SampleLeRequest rays(std::uint32_t count, std::uint64_t seed = 1) const {
    v1::SampleLeRequest q;
    q.set_scene_id(scene_);
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
    v1::PdfLeRequest q;
    q.set_scene_id(scene_);
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
    v1::EstimatePowerRequest q;
    q.set_scene_id(scene_);
    q.set_method(method);
    return q;
  }
  v1::EstimatePowerResponse answer(const v1::EstimatePowerRequest& q) {
    v1::EstimatePowerResponse r;
    const grpc::Status status = power(q, &r);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return r;
  }
};

}  // namespace lucerna::testing
