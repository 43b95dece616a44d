// What tests of edits share.
#pragma once

#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "proto/common/sha256.h"
#include "service_fixture.h"
#include "tests/paths.h"
#include "tests/temp_directory.h"

namespace lucerna::testing {

/// All answers about a scene, with what does not depend on the scene's content removed.
class Answers {
 public:
  Answers(Service& service, const std::string& scene) : service_(service), scene_(scene) {
    lights_ = service_.answer(about<v1::ListLightsRequest>(scene));
    for (v1::Light& light : *lights_.mutable_lights()) light.clear_source();
    add("lights", lights_);
    arriving();
    leaving();
    pictures();
  }

  const v1::ListLightsResponse& lights() const { return lights_; }
  bool operator==(const Answers& other) const { return bytes_ == other.bytes_; }
  /// The calls whose answers differ.
  std::string differences(const Answers& other) const {
    std::string names;
    for (const auto& [name, bytes] : bytes_)
      if (other.bytes_.at(name) != bytes) names += name + " ";
    return names;
  }

 private:
  static constexpr int kPoints = 40;

  template <typename Response>
  void add(const std::string& name, Response response) {
    if constexpr (requires { response.clear_cost(); }) response.clear_cost();
    if constexpr (requires { response.clear_item_costs(); }) response.clear_item_costs();
    // Places in files, of which the two scenes have their own.
    if constexpr (requires { response.clear_missed_surfaces(); }) response.clear_missed_surfaces();
    bytes_[name] = response.SerializeAsString();
  }
  template <typename Request>
  ResponseTo<Request> call(const std::string& name, const Request& request) {
    SCOPED_TRACE(name);
    const auto response = service_.answer(request);
    add(name, response);
    return response;
  }

  void arriving() {
    auto li = about<v1::SampleLiRequest>(scene_);
    for (int i = 0; i < kPoints; ++i) {
      const float x = 0.37F * static_cast<float>(i % 7) - 1;
      const float y = 0.41F * static_cast<float>(i % 5) - 1;
      for (const float v : {x, y, 0.01F}) li.mutable_receivers()->add_offsets_m(v);
      for (const float v : {0.F, 0.F, 1.F}) li.add_normals(v);
    }
    li.set_test_visibility(true);
    auto lux = about<v1::EstimateIrradianceRequest>(scene_);
    auto pdf = about<v1::PdfLiRequest>(scene_);
    *lux.mutable_receivers() = *pdf.mutable_receivers() = li.receivers();
    *lux.mutable_normals() = *pdf.mutable_normals() = li.normals();
    call("SampleLi", li);
    for (const v1::Light& light : lights_.lights()) {
      const std::string of = " of light " + std::to_string(light.id());
      li.set_light_id(light.id());
      pdf.set_light_id(light.id());
      const auto samples = call("SampleLi" + of, li);
      *pdf.mutable_wi() = samples.wi();
      call("PdfLi" + of, pdf);
    }
    lux.mutable_accuracy()->set_samples(64);
    std::vector<v1::Visibility> methods{v1::VISIBILITY_RAYS};
    // Maps of many lights take seconds to make.
    if (lights_.lights_size() < 10) methods.push_back(v1::VISIBILITY_SHADOW_MAPS);
    for (const auto visibility : methods)
      for (const std::uint32_t bounces : {0U, 2U}) {
        lux.set_bounces(bounces);
        lux.mutable_accuracy()->set_visibility(visibility);
        call("EstimateIrradiance " + std::to_string(visibility) + " " + std::to_string(bounces),
             lux);
      }
    lux.mutable_accuracy()->clear_samples();
    lux.mutable_accuracy()->mutable_target_error()->set_relative(0.05);
    lux.set_per_light(true);
    lux.set_bounces(0);
    call("EstimateIrradiance by a target", lux);
    auto seen = about<v1::TestVisibilityRequest>(scene_);
    *seen.mutable_segments()->mutable_from() = li.receivers();
    for (int i = 0; i < kPoints; ++i)
      for (const float v : {0.1F * static_cast<float>(i), 1.F, 2.5F})
        seen.mutable_segments()->mutable_to()->add_offsets_m(v);
    call("TestVisibility", seen);
  }

  void leaving() {
    auto rays = about<v1::SampleLeRequest>(scene_);
    auto pdf = about<v1::PdfLeRequest>(scene_);
    auto value = about<v1::LeRequest>(scene_);
    rays.set_count(64);
    call("SampleLe", rays);
    for (const v1::Light& light : lights_.lights()) {
      const std::string of = " of light " + std::to_string(light.id());
      rays.set_light_id(light.id());
      pdf.set_light_id(light.id());
      value.set_light_id(light.id());
      const auto leaving = call("SampleLe" + of, rays);
      *pdf.mutable_points() = *value.mutable_points() = leaving.points();
      *pdf.mutable_directions() = *value.mutable_directions() = leaving.directions();
      call("PdfLe" + of, pdf);
      call("Le" + of, value);
    }
    call("EstimatePower", about<v1::EstimatePowerRequest>(scene_));
  }

  void pictures() {
    auto tile = about<v1::RenderTileRequest>(scene_);
    set_rect(&tile, 16, 12);
    tile.mutable_accuracy()->set_samples(8);
    tile.set_bounces(2);
    call("RenderTile", tile);
  }

  Service& service_;
  std::string scene_;
  v1::ListLightsResponse lights_;
  std::map<std::string, std::string> bytes_;
};

class Edit : public ::testing::Test {
 protected:
  Edit() {
    const std::filesystem::path data = test_data();
    std::filesystem::copy(data / "lights", root_.path() / "lights");
    std::filesystem::create_directory(root_.path() / "reference");
    for (const char* file : {"sky.exr", "slide.exr", "screen.exr"})
      std::filesystem::copy_file(data / "reference" / file, root_.path() / "reference" / file);
    service_ = std::make_unique<Service>(scenes_in(root_.path()));
  }

  std::string write(const std::string& name, const std::string& text) {
    std::ofstream(root_.path() / name) << text;
    return name;
  }
  std::string load(const std::string& name, const std::string& text) {
    return service_->load(write(name, text));
  }
  std::string every_light() const {
    std::ifstream file(root_.path() / "lights/every_light.pbrt");
    return {std::istreambuf_iterator<char>(file), {}};
  }
  /// The id of the revision.
  std::string edited(const v1::EditLightsRequest& request) {
    const auto response = service_->answer(request);
    new_ids_.assign(response.light_ids().begin(), response.light_ids().end());
    return response.scene_id();
  }
  v1::ListLightsResponse list(const std::string& scene) {
    return service_->answer(about<v1::ListLightsRequest>(scene));
  }
  static v1::LightChange* change(v1::EditLightsRequest& request, std::uint64_t light) {
    v1::LightChange* const change = request.add_edits()->mutable_change();
    change->set_light_id(light);
    return change;
  }
  /// A digest of the bits of a whole picture.
  std::string picture(const std::string& scene) {
    auto q = about<v1::RenderTileRequest>(scene);
    set_rect(&q, 16, 12);
    q.mutable_accuracy()->set_samples(16);
    q.set_bounces(3);
    auto r = service_->answer(q);
    r.clear_cost();
    return hexadecimal(sha256(r.SerializeAsString()));
  }
  /// The illuminance of a few points, exact to the bit.
  std::vector<double> total_lux(const std::string& scene) {
    auto q = about<v1::EstimateIrradianceRequest>(scene);
    for (float x = -3; x <= 3; ++x) {
      for (const float v : {x, 0.25F, 0.F}) q.mutable_receivers()->add_offsets_m(v);
      for (const float v : {0.F, 0.F, 1.F}) q.add_normals(v);
    }
    const auto r = service_->answer(q);
    return {r.irradiance_lx().begin(), r.irradiance_lx().end()};
  }
  void expect_same(const std::string& revision, const std::string& fresh) {
    ASSERT_NE(revision, "");
    ASSERT_NE(fresh, "");
    const Answers a(*service_, revision), b(*service_, fresh);
    EXPECT_TRUE(a == b) << a.differences(b);
  }

  TempDirectory root_;
  std::unique_ptr<Service> service_;
  std::vector<std::uint64_t> new_ids_;
};

/// A scene near zero, whose coordinates are sums of few powers of two.  `%` stands before each
/// light that has a place.
inline constexpr char kPlaced[] =
    R"(Film "rgb" "integer xresolution" [16] "integer yresolution" [12]
LookAt 0 -6 2.5   0 0 1   0 0 1
Camera "perspective" "float fov" [40]
WorldBegin
Shape "bilinearmesh" "point3 P" [-4 -4 0  4 -4 0  -4 4 0  4 4 0]
AttributeBegin % LightSource "point" "rgb I" [12 6 3] "point3 from" [1.25 -1.5 3.25]
AttributeEnd
AttributeBegin %
LightSource "spot" "rgb I" [40 40 40] "point3 from" [2 -2.5 3.5] "point3 to" [0 0 0]
AttributeEnd
AttributeBegin % Rotate 180 1 0 0
LightSource "goniometric" "string filename" "lights/downlight.ies" AttributeEnd
AttributeBegin % LightSource "goniometric" "string filename" "reference/sky.exr"
AttributeEnd
AttributeBegin % Translate -1 1 3 Rotate 180 1 0 0
LightSource "projection" "string filename" "reference/slide.exr" "float fov" [30] "float scale" [50]
LightSource "projection" "string filename" "reference/slide.exr" "string projection" "orthographic"
AttributeEnd
LightSource "distant" "rgb L" [2 2 2] "point3 from" [1 -2 3] "point3 to" [0 0 0]
AreaLightSource "diffuse" "rgb L" [10 10 10]
AttributeBegin %
Shape "trianglemesh" "point3 P" [-2 -1 3  -1 -1 3  -2 -2 3] "integer indices" [0 1 2]
AttributeEnd
)";

inline std::string placed(const std::string& where) {
  std::string text = kPlaced;
  for (std::size_t at; (at = text.find('%')) != std::string::npos;) text.replace(at, 1, where);
  return text;
}

inline v1::Light point_light(double z) {
  v1::Light light;
  light.mutable_point()->mutable_position_m()->set_z(z);
  for (auto set : {&v1::Rgb::set_r, &v1::Rgb::set_g, &v1::Rgb::set_b})
    (light.mutable_point()->mutable_intensity_cd()->*set)(100);
  return light;
}

}  // namespace lucerna::testing
