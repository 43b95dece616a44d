// EditLights, and the edits of LoadScene.  A revision gives the same bits as a scene whose file
// says so.
#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <numbers>
#include <regex>
#include <sstream>

#include "service_fixture.h"
#include "tests/temp_directory.h"

namespace lucerna::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

/// All answers about a scene, with what does not depend on the scene's content removed.
class Answers {
 public:
  Answers(Service& service, const std::string& scene) : service_(service), scene_(scene) {
    v1::ListLightsRequest list;
    list.set_scene_id(scene);
    const grpc::Status listed =
        status_of([&](auto* c) { return service_.scenes.ListLights(c, list, &lights_); });
    EXPECT_TRUE(listed.ok()) << listed.error_message();
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

  template <typename Request>
  Request request() const {
    Request q;
    q.set_scene_id(scene_);
    return q;
  }
  template <typename Response>
  void add(const std::string& name, Response response) {
    if constexpr (requires { response.clear_cost(); }) response.clear_cost();
    if constexpr (requires { response.clear_item_costs(); }) response.clear_item_costs();
    bytes_[name] = response.SerializeAsString();
  }
  template <typename Response, typename Call>
  Response call(const std::string& name, const Call& ask) {
    Response response;
    const grpc::Status s = status_of([&](auto* c) { return ask(c, &response); });
    EXPECT_TRUE(s.ok()) << name << ": " << s.error_message();
    add(name, response);
    return response;
  }

  void arriving() {
    auto li = request<v1::SampleLiRequest>();
    for (int i = 0; i < kPoints; ++i) {
      const float x = 0.37F * static_cast<float>(i % 7) - 1;
      const float y = 0.41F * static_cast<float>(i % 5) - 1;
      for (const float v : {x, y, 0.01F}) li.mutable_receivers()->add_offsets_m(v);
      for (const float v : {0.F, 0.F, 1.F}) li.add_normals(v);
    }
    li.set_test_visibility(true);
    auto lux = request<v1::EstimateIrradianceRequest>();
    auto pdf = request<v1::PdfLiRequest>();
    *lux.mutable_receivers() = *pdf.mutable_receivers() = li.receivers();
    *lux.mutable_normals() = *pdf.mutable_normals() = li.normals();
    call<v1::SampleLiResponse>(
        "SampleLi", [&](auto* c, auto* r) { return service_.lighting.SampleLi(c, li, r); });
    for (const v1::Light& light : lights_.lights()) {
      const std::string of = " of light " + std::to_string(light.id());
      li.set_light_id(light.id());
      pdf.set_light_id(light.id());
      const auto samples = call<v1::SampleLiResponse>(
          "SampleLi" + of, [&](auto* c, auto* r) { return service_.lighting.SampleLi(c, li, r); });
      *pdf.mutable_wi() = samples.wi();
      call<v1::PdfLiResponse>("PdfLi" + of,
                              [&](auto* c, auto* r) { return service_.lighting.PdfLi(c, pdf, r); });
    }
    lux.mutable_accuracy()->set_samples(64);
    std::vector<v1::Visibility> methods{v1::VISIBILITY_RAYS};
    // Maps of many lights take seconds to make.
    if (lights_.lights_size() < 10) methods.push_back(v1::VISIBILITY_SHADOW_MAPS);
    for (const auto visibility : methods)
      for (const std::uint32_t bounces : {0U, 2U}) {
        lux.set_bounces(bounces);
        lux.mutable_accuracy()->set_visibility(visibility);
        call<v1::EstimateIrradianceResponse>(
            "EstimateIrradiance " + std::to_string(visibility) + " " + std::to_string(bounces),
            [&](auto* c, auto* r) { return service_.lighting.EstimateIrradiance(c, lux, r); });
      }
    lux.mutable_accuracy()->clear_samples();
    lux.mutable_accuracy()->mutable_target_error()->set_relative(0.05);
    lux.set_per_light(true);
    lux.set_bounces(0);
    call<v1::EstimateIrradianceResponse>("EstimateIrradiance by a target", [&](auto* c, auto* r) {
      return service_.lighting.EstimateIrradiance(c, lux, r);
    });
    auto seen = request<v1::TestVisibilityRequest>();
    *seen.mutable_segments()->mutable_from() = li.receivers();
    for (int i = 0; i < kPoints; ++i)
      for (const float v : {0.1F * static_cast<float>(i), 1.F, 2.5F})
        seen.mutable_segments()->mutable_to()->add_offsets_m(v);
    call<v1::TestVisibilityResponse>("TestVisibility", [&](auto* c, auto* r) {
      return service_.lighting.TestVisibility(c, seen, r);
    });
  }

  void leaving() {
    auto rays = request<v1::SampleLeRequest>();
    auto pdf = request<v1::PdfLeRequest>();
    auto value = request<v1::LeRequest>();
    rays.set_count(64);
    call<v1::SampleLeResponse>(
        "SampleLe", [&](auto* c, auto* r) { return service_.lighting.SampleLe(c, rays, r); });
    for (const v1::Light& light : lights_.lights()) {
      const std::string of = " of light " + std::to_string(light.id());
      rays.set_light_id(light.id());
      pdf.set_light_id(light.id());
      value.set_light_id(light.id());
      const auto leaving = call<v1::SampleLeResponse>("SampleLe" + of, [&](auto* c, auto* r) {
        return service_.lighting.SampleLe(c, rays, r);
      });
      *pdf.mutable_points() = *value.mutable_points() = leaving.points();
      *pdf.mutable_directions() = *value.mutable_directions() = leaving.directions();
      call<v1::PdfLeResponse>("PdfLe" + of,
                              [&](auto* c, auto* r) { return service_.lighting.PdfLe(c, pdf, r); });
      call<v1::LeResponse>("Le" + of,
                           [&](auto* c, auto* r) { return service_.lighting.Le(c, value, r); });
    }
    call<v1::EstimatePowerResponse>("EstimatePower", [&](auto* c, auto* r) {
      return service_.lighting.EstimatePower(c, request<v1::EstimatePowerRequest>(), r);
    });
  }

  void pictures() {
    auto tile = request<v1::RenderTileRequest>();
    tile.mutable_rect()->set_x1(16);
    tile.mutable_rect()->set_y1(12);
    tile.mutable_accuracy()->set_samples(8);
    tile.set_bounces(2);
    call<v1::RenderTileResponse>(
        "RenderTile", [&](auto* c, auto* r) { return service_.render.RenderTile(c, tile, r); });
  }

  Service& service_;
  std::string scene_;
  v1::ListLightsResponse lights_;
  std::map<std::string, std::string> bytes_;
};

class Edit : public ::testing::Test {
 protected:
  Edit() {
    const fs::path data = LUCERNA_TEST_DATA;
    fs::copy(data / "lights", root_.path() / "lights");
    fs::create_directory(root_.path() / "reference");
    for (const char* file : {"sky.exr", "slide.exr", "screen.exr"})
      fs::copy_file(data / "reference" / file, root_.path() / "reference" / file);
    rpc::ServerOptions options = service_options();
    options.scenes.root = root_.path().string();
    service_ = std::make_unique<Service>(options);
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
  grpc::Status edit(const v1::EditLightsRequest& request, v1::EditLightsResponse* response) {
    return status_of([&](auto* c) { return service_->scenes.EditLights(c, request, response); });
  }
  /// The id of the revision.
  std::string edited(const v1::EditLightsRequest& request) {
    v1::EditLightsResponse response;
    const grpc::Status s = edit(request, &response);
    EXPECT_TRUE(s.ok()) << s.error_message();
    new_ids_.assign(response.light_ids().begin(), response.light_ids().end());
    return response.scene_id();
  }
  v1::ListLightsResponse list(const std::string& scene) {
    v1::ListLightsRequest request;
    request.set_scene_id(scene);
    v1::ListLightsResponse response;
    const grpc::Status s =
        status_of([&](auto* c) { return service_->scenes.ListLights(c, request, &response); });
    EXPECT_TRUE(s.ok()) << s.error_message();
    return response;
  }
  static v1::LightChange* change(v1::EditLightsRequest& request, std::uint64_t light) {
    v1::LightChange* const change = request.add_edits()->mutable_change();
    change->set_light_id(light);
    return change;
  }
  static v1::EditLightsRequest request_for(const std::string& scene) {
    v1::EditLightsRequest request;
    request.set_scene_id(scene);
    return request;
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

/// Multiplies the level of every light of a .pbrt file.
std::string dimmed(const std::string& text, double factor) {
  static const std::regex kLight(R"re((Area)?LightSource "[a-z]+")re");
  static const std::regex kScale(R"re("float scale" \[([0-9.]+)\])re");
  std::string out;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line); out += line + "\n") {
    std::smatch light, scale;
    if (!std::regex_search(line, light, kLight)) continue;
    const std::string level = std::regex_search(line, scale, kScale) ? scale[1].str() : "1";
    const std::string kind = light[0].str();  // `light` refers to `line`
    line = std::regex_replace(line, kScale, "");
    line.replace(line.find(kind), kind.size(),
                 kind + " \"float scale\" [" + std::to_string(std::stod(level) * factor) + "]");
  }
  return out;
}

TEST_F(Edit, DimmedLightsOfEveryKindHaveTheBitsOfAFileThatDimsThem) {
  const std::string scene = service_->load("lights/every_light.pbrt");
  v1::EditLightsRequest request = request_for(scene);
  const Answers before(*service_, scene);
  for (const v1::Light& light : before.lights().lights())
    change(request, light.id())->set_scale(0.5);
  const std::string revision = edited(request);
  expect_same(revision, load("lights/dimmed.pbrt", dimmed(every_light(), 0.5)));
  const Answers dim(*service_, revision);
  EXPECT_FALSE(dim == before);
  // The scene itself is as before.
  const Answers after(*service_, scene);
  EXPECT_TRUE(after == before) << after.differences(before);
}

/// A scene near zero, whose coordinates are sums of few powers of two.  `%` stands before each
/// light that has a place.
constexpr char kPlaced[] = R"(Film "rgb" "integer xresolution" [16] "integer yresolution" [12]
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

std::string placed(const std::string& where) {
  std::string text = kPlaced;
  for (std::size_t at; (at = text.find('%')) != std::string::npos;) text.replace(at, 1, where);
  return text;
}

TEST_F(Edit, ShiftedLightsHaveTheBitsOfAFileThatShiftsThem) {
  const std::string scene = load("placed.pbrt", placed(""));
  v1::EditLightsRequest request = request_for(scene);
  for (const std::uint64_t light : {1, 2, 3, 4, 5, 6, 8}) {
    v1::Vector3* shift = change(request, light)->mutable_placement()->mutable_shift_m();
    shift->set_x(0.25), shift->set_y(0.5), shift->set_z(-0.125);
  }
  expect_same(edited(request), load("shifted.pbrt", placed("Translate 0.25 0.5 -0.125")));
}

TEST_F(Edit, TurnedLightsPointElsewhere) {
  const std::string scene = load("placed.pbrt", placed(""));
  v1::EditLightsRequest request = request_for(scene);
  for (const std::uint64_t light : {2, 7}) {
    v1::LightPlacement* place = change(request, light)->mutable_placement();
    place->mutable_turn_axis()->set_z(2);
    place->set_turn_rad(std::numbers::pi / 2);
  }
  const Answers turned(*service_, edited(request));
  const v1::Light& spot = turned.lights().lights(1);
  EXPECT_NEAR(spot.spot().position_m().x(), 2, 1e-12);
  EXPECT_NEAR(spot.spot().axis().x() / spot.spot().axis().z(), 2.5 / 3.5, 1e-12);
  EXPECT_NEAR(spot.spot().axis().y() / spot.spot().axis().z(), 2 / 3.5, 1e-12);
  const v1::Vector3& to_light = turned.lights().lights(6).distant().to_light();
  EXPECT_NEAR(to_light.x() / to_light.z(), 2.0 / 3, 1e-12);
  EXPECT_NEAR(to_light.y() / to_light.z(), 1.0 / 3, 1e-12);
}

TEST_F(Edit, ShiftedSurfacesOfEveryKindHaveTheBitsOfAFileThatShiftsThem) {
  const auto text = [](const std::string& where) {
    std::string all =
        "WorldBegin\nShape \"bilinearmesh\" \"point3 P\" [-4 -4 0  4 -4 0  -4 4 0  4 4 0]\n";
    for (const char* shape :
         {"\"sphere\" \"float radius\" [0.25]", "\"disk\" \"float radius\" [0.5]",
          "\"cylinder\" \"float radius\" [0.25]",
          "\"bilinearmesh\" \"point3 P\" [0 0 0  1 0 0  0 1 0  1 1 1]",
          "\"trianglemesh\" \"point3 P\" [0 0 0  1 0 0  0 1 0] \"normal N\" [0 0 1  0 0 1  0 0 1] "
          "\"integer indices\" [0 1 2]"})
      all += "AttributeBegin AreaLightSource \"diffuse\" \"bool twosided\" true\n" + where +
             "Translate -1 1 2\nShape " + shape + " AttributeEnd\n";
    return all;
  };
  const std::string scene = load("surfaces.pbrt", text(""));
  v1::EditLightsRequest request = request_for(scene);
  for (std::uint64_t light = 1; light <= 5; ++light) {
    v1::Vector3* shift = change(request, light)->mutable_placement()->mutable_shift_m();
    shift->set_x(0.25), shift->set_y(-0.5), shift->set_z(0.125);
  }
  const std::string moved = edited(request);
  expect_same(moved, load("moved.pbrt", text("Translate 0.25 -0.5 0.125\n")));
  // Another edit of the revision keeps the places, and shares the geometry.
  const std::uint64_t builds = service_->server->scenes().builds();
  request = request_for(moved);
  change(request, 1)->set_scale(0.5);
  EXPECT_NE(edited(request), moved);
  EXPECT_EQ(service_->server->scenes().builds(), builds);
  // Back at their places the surfaces are those of the file.
  request = request_for(moved);
  for (std::uint64_t light = 1; light <= 5; ++light) change(request, light)->mutable_placement();
  EXPECT_EQ(edited(request), scene);
  // A surface moves without the file.  If the scene gets another origin, all of it is built again,
  // which needs the file.
  write("surfaces.pbrt", text("Scale 2 2 2\n"));
  request = request_for(scene);
  change(request, 1)->mutable_placement()->mutable_shift_m()->set_x(3);
  EXPECT_NE(edited(request), scene);
  request = request_for(scene);
  change(request, 1)->mutable_placement()->mutable_shift_m()->set_x(1e6);
  v1::EditLightsResponse response;
  EXPECT_EQ(edit(request, &response).error_code(), grpc::StatusCode::FAILED_PRECONDITION);
}

TEST_F(Edit, TurnedSurfacesTurnAboutTheirMiddle) {
  const std::string scene =
      load("pane.pbrt",
           "WorldBegin\nAreaLightSource \"diffuse\" \"rgb L\" [1 1 1]\n"
           "Shape \"bilinearmesh\" \"point3 P\" [1 1 2  3 1 2  1 3 2  3 3 2]\n");
  v1::EditLightsRequest request = request_for(scene);
  v1::LightPlacement* place = change(request, 1)->mutable_placement();
  place->mutable_turn_axis()->set_x(1);
  place->set_turn_rad(std::numbers::pi / 2);
  const Answers turned(*service_, edited(request));
  const v1::Bounds& bounds = turned.lights().lights(0).bounds();
  EXPECT_NEAR(bounds.lower_m().x(), 1, 1e-12);
  EXPECT_NEAR(bounds.upper_m().x(), 3, 1e-12);
  EXPECT_NEAR(bounds.lower_m().y(), 2, 1e-12);
  EXPECT_NEAR(bounds.lower_m().z(), 1, 1e-12);
  EXPECT_NEAR(bounds.upper_m().z(), 3, 1e-12);
}

TEST_F(Edit, TintedLightsHaveTheBitsOfAFileThatTintsThem) {
  const std::string light = "LightSource \"point\" \"point3 from\" [0 0 2] ";
  const std::string scene =
      load("white.pbrt", "WorldBegin\nShape \"sphere\"\n" + light + "\"rgb I\" [8 8 8]\n");
  v1::EditLightsRequest request = request_for(scene);
  v1::Rgb* tint = change(request, 1)->mutable_tint();
  tint->set_r(1), tint->set_g(0.5), tint->set_b(0.25);
  expect_same(edited(request), load("tinted.pbrt", "WorldBegin\nShape \"sphere\"\n" + light +
                                                       "\"rgb I\" [8 4 2]\n"));
}

TEST_F(Edit, LightsThatAreOffAreBlackUntilTheyAreOn) {
  const std::string scene = load("placed.pbrt", placed(""));
  v1::EditLightsRequest request = request_for(scene);
  for (std::uint64_t light = 1; light <= 8; ++light) change(request, light)->set_on(false);
  const std::string dark = edited(request);
  const Answers answers(*service_, dark);
  for (const v1::Light& light : answers.lights().lights()) EXPECT_EQ(light.power_lm(), 0);
  request = request_for(dark);
  for (std::uint64_t light = 1; light <= 8; ++light) change(request, light)->set_on(true);
  EXPECT_EQ(edited(request), scene);
}

TEST_F(Edit, RemovedLightsLeaveDarkSurfacesAndKeepTheIdsOfOthers) {
  const std::string scene = load("placed.pbrt", placed(""));
  v1::EditLightsRequest request = request_for(scene);
  request.add_edits()->set_remove(8);
  std::string without = placed("");
  const std::size_t begin = without.find("AreaLightSource");
  without.erase(begin, without.find('\n', begin) - begin);
  const std::string last = edited(request);
  expect_same(last, load("without.pbrt", without));
  request = request_for(last);
  request.add_edits()->set_remove(2);
  const Answers answers(*service_, edited(request));
  std::vector<std::uint64_t> ids;
  for (const v1::Light& light : answers.lights().lights()) ids.push_back(light.id());
  EXPECT_THAT(ids, ElementsAre(1, 3, 4, 5, 6, 7));
}

v1::Light point_light(double z) {
  v1::Light light;
  light.mutable_point()->mutable_position_m()->set_z(z);
  for (auto set : {&v1::Rgb::set_r, &v1::Rgb::set_g, &v1::Rgb::set_b})
    (light.mutable_point()->mutable_intensity_cd()->*set)(100);
  return light;
}

TEST_F(Edit, NewLightsShineAsThoseOfAFile) {
  const std::string start =
      "WorldBegin\nShape \"bilinearmesh\" \"point3 P\" [-4 -4 0  4 -4 0  -4 4 "
      "0  4 4 0]\nLightSource \"point\" \"point3 from\" [1 0 2]\n";
  const std::string scene = load("one.pbrt", start);
  write("lamp.pbrt",
        "WorldBegin\nLightSource \"point\" \"rgb I\" [100 100 100] \"point3 from\" [0 0 3]\n");
  v1::EditLightsRequest by_message = request_for(scene), by_file = by_message;
  *by_message.add_edits()->mutable_put() = point_light(3);
  by_file.add_edits()->mutable_add()->set_path("lamp.pbrt");
  const std::string fresh =
      load("two.pbrt",
           start + "LightSource \"point\" \"rgb I\" [100 100 100] \"point3 from\" [0 0 3]\n");
  const auto lux = [&](const std::string& of) {
    v1::EstimateIrradianceRequest q;
    q.set_scene_id(of);
    for (const float v : {0.5F, 0.25F, 0.F}) q.mutable_receivers()->add_offsets_m(v);
    for (const float v : {0.F, 0.F, 1.F}) q.add_normals(v);
    v1::EstimateIrradianceResponse r;
    EXPECT_TRUE(
        status_of([&](auto* c) { return service_->lighting.EstimateIrradiance(c, q, &r); }).ok());
    return r.irradiance_lx(0);
  };
  EXPECT_EQ(lux(edited(by_message)), lux(fresh));
  ASSERT_EQ(new_ids_.size(), 1U);
  EXPECT_GE(new_ids_[0], std::uint64_t{1} << 32);
  const std::string from_file = edited(by_file);
  EXPECT_EQ(lux(from_file), lux(fresh));
  EXPECT_EQ(list(from_file).lights(1).source(), "lamp.pbrt:2:1");
  EXPECT_EQ(list(edited(by_message)).lights(1).source(), "(added)");
  EXPECT_NE(lux(scene), lux(fresh));
}

TEST_F(Edit, TheIdFollowsFromTheLightsAndNotFromTheWayToThem) {
  const std::string scene = load("placed.pbrt", placed(""));
  v1::EditLightsRequest both = request_for(scene);
  change(both, 1)->set_scale(0.5);
  *both.add_edits()->mutable_put() = point_light(2);
  const std::string at_once = edited(both);
  const std::uint64_t lamp = new_ids_.at(0);

  v1::EditLightsRequest first = request_for(scene);
  *first.add_edits()->mutable_put() = point_light(2);
  change(first, 1)->set_scale(7);
  change(first, 3)->set_on(false);
  v1::EditLightsRequest second = request_for(edited(first));
  EXPECT_EQ(new_ids_.at(0), lamp);
  change(second, 3)->set_on(true);
  change(second, 1)->set_scale(0.5);
  EXPECT_EQ(edited(second), at_once);

  v1::EditLightsRequest back = request_for(at_once);
  back.add_edits()->set_remove(lamp);
  change(back, 1)->set_scale(1);
  EXPECT_EQ(edited(back), scene);

  // In one call with the load, also on a server that never saw the scene.
  v1::LoadSceneRequest load;
  load.set_path("placed.pbrt");
  *load.mutable_edits() = both.edits();
  rpc::ServerOptions options = service_options();
  options.scenes.root = root_.path().string();
  Service other(options);
  for (Service* service : {service_.get(), &other}) {
    v1::LoadSceneResponse loaded;
    const grpc::Status s =
        status_of([&](auto* c) { return service->scenes.LoadScene(c, load, &loaded); });
    EXPECT_TRUE(s.ok()) << s.error_message();
    EXPECT_EQ(loaded.scene_id(), at_once);
  }
}

TEST_F(Edit, RevisionsShareMemoryAndOutliveTheirScene) {
  const std::string scene = load("placed.pbrt", placed(""));
  const std::uint64_t alone = service_->server->scenes().bytes();
  v1::EditLightsRequest request = request_for(scene);
  request.set_lease_s(60);
  change(request, 1)->set_scale(0.5);
  const std::string revision = edited(request);
  v1::GetSceneRequest get;
  get.set_scene_id(revision);
  v1::GetSceneResponse of;
  ASSERT_TRUE(status_of([&](auto* c) { return service_->scenes.GetScene(c, get, &of); }).ok());
  EXPECT_EQ(of.summary().loaded_scene_id(), scene);
  EXPECT_EQ(of.summary().edited_lights(), 1U);
  EXPECT_GT(of.summary().leased_s(), 0);
  EXPECT_LT(of.summary().own_bytes(), of.summary().bytes());
  EXPECT_EQ(service_->server->scenes().bytes(), alone + of.summary().own_bytes());
  v1::ReleaseSceneRequest release;
  release.set_scene_id(scene);
  v1::ReleaseSceneResponse gone;
  ASSERT_TRUE(
      status_of([&](auto* c) { return service_->scenes.ReleaseScene(c, release, &gone); }).ok());
  // The shared part is still in use.
  EXPECT_EQ(service_->server->scenes().bytes(), alone + of.summary().own_bytes());
  EXPECT_NE(Answers(*service_, revision).lights().lights_size(), 0);
  release.set_scene_id(revision);
  release.set_lease_id("");
  EXPECT_EQ(status_of([&](auto* c) {
              return service_->scenes.ReleaseScene(c, release, &gone);
            }).error_code(),
            grpc::StatusCode::FAILED_PRECONDITION);
}

TEST_F(Edit, WrongEditsNameTheirFieldAndMakeNothing) {
  const std::string scene = load("placed.pbrt", placed(""));
  const auto fails = [&](const std::function<void(v1::EditLightsRequest&)>& set) {
    v1::EditLightsRequest request = request_for(scene);
    change(request, 1)->set_scale(0.5);  // a good edit before the bad one
    set(request);
    v1::EditLightsResponse response;
    return edit(request, &response);
  };
  expect_bad_field(fails([](auto& r) { r.add_edits(); }), "edits[1].edit");
  for (const double scale : {-1.0, 2e9, std::nan("")})
    expect_bad_field(fails([&](auto& r) { change(r, 2)->set_scale(scale); }),
                     "edits[1].change.scale");
  expect_bad_field(fails([](auto& r) { change(r, 2)->mutable_tint()->set_g(-1); }),
                   "edits[1].change.tint.g");
  expect_bad_field(
      fails([](auto& r) { change(r, 2)->mutable_placement()->mutable_shift_m()->set_x(INFINITY); }),
      "edits[1].change.placement.shift_m.x");
  expect_bad_field(fails([](auto& r) { change(r, 2)->mutable_placement()->set_turn_rad(1); }),
                   "edits[1].change.placement.turn_axis");
  expect_bad_field(fails([](auto& r) { r.add_edits()->mutable_put()->mutable_beam(); }),
                   "edits[1].put.kind");
  expect_bad_field(fails([](auto& r) { r.add_edits()->mutable_add(); }), "edits[1].add.path");
  for (const std::uint64_t light : {0, 9, 1000}) {
    EXPECT_EQ(fails([&](auto& r) { change(r, light)->set_scale(1); }).error_code(),
              grpc::StatusCode::NOT_FOUND);
    EXPECT_EQ(fails([&](auto& r) { r.add_edits()->set_remove(light); }).error_code(),
              grpc::StatusCode::NOT_FOUND);
  }
  const grpc::Status twice = fails([](auto& r) {
    r.add_edits()->set_remove(2);
    change(r, 2)->set_scale(1);
  });
  EXPECT_EQ(twice.error_code(), grpc::StatusCode::NOT_FOUND);
  const grpc::Status sun =
      fails([](auto& r) { change(r, 7)->mutable_placement()->mutable_shift_m()->set_x(1); });
  EXPECT_EQ(sun.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_THAT(sun.error_message(), HasSubstr("light 7: the light is at infinity, allowed: turns"));
  const grpc::Status negative = fails([](auto& r) {
    *r.add_edits()->mutable_put() = point_light(2);
    r.mutable_edits(1)->mutable_put()->mutable_point()->mutable_intensity_cd()->set_r(-1);
  });
  EXPECT_EQ(negative.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_THAT(negative.error_message(), HasSubstr("edits[1].put"));
  write("shapes.pbrt", "WorldBegin\nShape \"sphere\"\n");
  const grpc::Status shapes =
      fails([](auto& r) { r.add_edits()->mutable_add()->set_path("shapes.pbrt"); });
  EXPECT_EQ(shapes.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_THAT(shapes.error_message(), HasSubstr("shapes.pbrt:2:1: a shape in a file"));
  EXPECT_EQ(
      fails([](auto& r) { r.add_edits()->mutable_add()->set_path("none.pbrt"); }).error_code(),
      grpc::StatusCode::NOT_FOUND);
  v1::EditLightsRequest request = request_for(std::string(64, '0'));
  v1::EditLightsResponse response;
  EXPECT_EQ(edit(request, &response).error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(service_->server->scenes().size(), 1U);
}

}  // namespace
}  // namespace lucerna::testing
