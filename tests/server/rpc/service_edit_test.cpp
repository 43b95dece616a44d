// EditLights, and the edits of LoadScene.  A revision gives the same bits as a scene whose file
// says so.
#include <regex>
#include <sstream>

#include "edit_fixture.h"

namespace lucerna::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::Gt;
using ::testing::HasSubstr;

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
  auto request = about<v1::EditLightsRequest>(scene);
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

TEST_F(Edit, TintedLightsHaveTheBitsOfAFileThatTintsThem) {
  const std::string light = "LightSource \"point\" \"point3 from\" [0 0 2] ";
  const std::string scene =
      load("white.pbrt", "WorldBegin\nShape \"sphere\"\n" + light + "\"rgb I\" [8 8 8]\n");
  auto request = about<v1::EditLightsRequest>(scene);
  v1::Rgb* tint = change(request, 1)->mutable_tint();
  tint->set_r(1), tint->set_g(0.5), tint->set_b(0.25);
  expect_same(edited(request), load("tinted.pbrt", "WorldBegin\nShape \"sphere\"\n" + light +
                                                       "\"rgb I\" [8 4 2]\n"));
}

TEST_F(Edit, LightsThatAreOffAreBlackUntilTheyAreOn) {
  const std::string scene = load("placed.pbrt", placed(""));
  auto request = about<v1::EditLightsRequest>(scene);
  for (std::uint64_t light = 1; light <= 8; ++light) change(request, light)->set_on(false);
  const std::string dark = edited(request);
  const Answers answers(*service_, dark);
  for (const v1::Light& light : answers.lights().lights()) EXPECT_EQ(light.power_lm(), 0);
  request = about<v1::EditLightsRequest>(dark);
  for (std::uint64_t light = 1; light <= 8; ++light) change(request, light)->set_on(true);
  EXPECT_EQ(edited(request), scene);
}

TEST_F(Edit, RemovedLightsLeaveDarkSurfacesAndKeepTheIdsOfOthers) {
  const std::string scene = load("placed.pbrt", placed(""));
  auto request = about<v1::EditLightsRequest>(scene);
  request.add_edits()->set_remove(8);
  std::string without = placed("");
  const std::size_t begin = without.find("AreaLightSource");
  without.erase(begin, without.find('\n', begin) - begin);
  const std::string last = edited(request);
  expect_same(last, load("without.pbrt", without));
  request = about<v1::EditLightsRequest>(last);
  request.add_edits()->set_remove(2);
  const Answers answers(*service_, edited(request));
  std::vector<std::uint64_t> ids;
  for (const v1::Light& light : answers.lights().lights()) ids.push_back(light.id());
  EXPECT_THAT(ids, ElementsAre(1, 3, 4, 5, 6, 7));
}

TEST_F(Edit, ARemovedLampDoesNotShineAsTheNextLight) {
  const auto lamp = [](const char* place, const char* radiance) {
    return std::string("AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" ") + radiance +
           " Translate " + place + " Shape \"sphere\" \"float radius\" 0.5 AttributeEnd\n";
  };
  const std::string scene =
      load("lamps.pbrt", "WorldBegin\n" + lamp("-2 0 3", "[1 1 1]") + lamp("2 0 3", "[5 5 5]"));
  auto request = about<v1::EditLightsRequest>(scene);
  request.add_edits()->set_remove(1);
  auto rays = about<v1::LeRequest>(edited(request));
  for (const float x : {-2.0F, 2.0F}) {
    for (const float p : {x, 0.0F, 0.0F}) rays.mutable_points()->add_offsets_m(p);
    for (const float w : {0.0F, 0.0F, 1.0F}) rays.add_directions(w);
  }
  const auto answer = service_->answer(rays);
  EXPECT_THAT(answer.light_ids(), ElementsAre(0, 2));
  EXPECT_THAT(answer.radiance_cd_m2(), ElementsAre(0, 0, 0, Gt(0), Gt(0), Gt(0)));
}

TEST_F(Edit, TheIdFollowsFromTheLightsAndNotFromTheWayToThem) {
  const std::string scene = load("placed.pbrt", placed(""));
  auto both = about<v1::EditLightsRequest>(scene);
  change(both, 1)->set_scale(0.5);
  *both.add_edits()->mutable_put() = point_light(2);
  const std::string at_once = edited(both);
  const std::uint64_t lamp = new_ids_.at(0);

  auto first = about<v1::EditLightsRequest>(scene);
  *first.add_edits()->mutable_put() = point_light(2);
  change(first, 1)->set_scale(7);
  change(first, 3)->set_on(false);
  auto second = about<v1::EditLightsRequest>(edited(first));
  EXPECT_EQ(new_ids_.at(0), lamp);
  change(second, 3)->set_on(true);
  change(second, 1)->set_scale(0.5);
  EXPECT_EQ(edited(second), at_once);

  auto back = about<v1::EditLightsRequest>(at_once);
  back.add_edits()->set_remove(lamp);
  change(back, 1)->set_scale(1);
  EXPECT_EQ(edited(back), scene);

  // In one call with the load, also on a server that never saw the scene.
  v1::LoadSceneRequest load;
  load.set_path("placed.pbrt");
  *load.mutable_edits() = both.edits();
  Service other(scenes_in(root_.path()));
  for (Service* service : {service_.get(), &other}) {
    const auto loaded = service->answer(load);
    EXPECT_EQ(loaded.scene_id(), at_once);
  }
}

TEST_F(Edit, RevisionsShareMemoryAndOutliveTheirScene) {
  const std::string scene = load("placed.pbrt", placed(""));
  const std::uint64_t alone = service_->server->scenes().bytes();
  auto request = about<v1::EditLightsRequest>(scene);
  request.set_lease_s(60);
  change(request, 1)->set_scale(0.5);
  const std::string revision = edited(request);
  const auto of = service_->answer(about<v1::GetSceneRequest>(revision));
  EXPECT_EQ(of.summary().loaded_scene_id(), scene);
  EXPECT_EQ(of.summary().edited_lights(), 1U);
  EXPECT_GT(of.summary().leased_s(), 0);
  EXPECT_LT(of.summary().own_bytes(), of.summary().bytes());
  EXPECT_EQ(service_->server->scenes().bytes(), alone + of.summary().own_bytes());
  auto release = about<v1::ReleaseSceneRequest>(scene);
  auto gone = service_->answer(release);
  // The shared part is still in use.
  EXPECT_EQ(service_->server->scenes().bytes(), alone + of.summary().own_bytes());
  EXPECT_NE(Answers(*service_, revision).lights().lights_size(), 0);
  release.set_scene_id(revision);
  release.set_lease_id("");
  EXPECT_EQ(service_->call(release, &gone).error_code(), grpc::StatusCode::FAILED_PRECONDITION);
}

// Trying one id after another would take minutes.
TEST_F(Edit, AsManyEqualLightsAsARequestMayHaveGetIdsOneAfterAnother) {
  constexpr int kLights = 65536;
  auto request = about<v1::EditLightsRequest>(load("placed.pbrt", placed("")));
  for (int i = 0; i < kLights; ++i) *request.add_edits()->mutable_put() = point_light(2);
  v1::EditLightsResponse response;
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(60));
  const grpc::Status s = service_->call(&context, request, &response);
  ASSERT_TRUE(s.ok()) << s.error_message();
  ASSERT_EQ(response.light_ids_size(), kLights);
  for (int i = 1; i < kLights; ++i)
    ASSERT_EQ(response.light_ids(i) - response.light_ids(i - 1), 1U) << i;
}

TEST_F(Edit, WrongEditsNameTheirFieldAndMakeNothing) {
  const std::string scene = load("placed.pbrt", placed(""));
  const auto fails = [&](const std::function<void(v1::EditLightsRequest&)>& set) {
    auto request = about<v1::EditLightsRequest>(scene);
    change(request, 1)->set_scale(0.5);  // a good edit before the bad one
    set(request);
    return service_->status(request);
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
  // The limits of files and of other calls.
  for (const std::uint32_t samples : {1025U, 4294967295U})
    expect_bad_field(fails([&](auto& r) {
                       *r.add_edits()->mutable_put() = point_light(2);
                       r.mutable_edits(1)->mutable_put()->set_samples_per_light(samples);
                     }),
                     "edits[1].put.samples_per_light");
  expect_bad_field(fails([](auto& r) {
                     r.add_edits()->mutable_add()->set_path(std::string(std::size_t{1} << 20, 'a'));
                   }),
                   "edits[1].add.path");
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
  expect_error(
      fails([](auto& r) { change(r, 7)->mutable_placement()->mutable_shift_m()->set_x(1); }),
      grpc::StatusCode::INVALID_ARGUMENT, "light 7: the light is at infinity, allowed: turns");
  const grpc::Status negative = fails([](auto& r) {
    *r.add_edits()->mutable_put() = point_light(2);
    r.mutable_edits(1)->mutable_put()->mutable_point()->mutable_intensity_cd()->set_r(-1);
  });
  expect_error(negative, grpc::StatusCode::INVALID_ARGUMENT, "edits[1].put");
  write("shapes.pbrt", "WorldBegin\nShape \"sphere\"\n");
  expect_error(fails([](auto& r) { r.add_edits()->mutable_add()->set_path("shapes.pbrt"); }),
               grpc::StatusCode::INVALID_ARGUMENT, "shapes.pbrt:2:1: a shape that does not emit");
  EXPECT_EQ(
      fails([](auto& r) { r.add_edits()->mutable_add()->set_path("none.pbrt"); }).error_code(),
      grpc::StatusCode::NOT_FOUND);
  auto request = about<v1::EditLightsRequest>(std::string(64, '0'));
  EXPECT_EQ(service_->status(request).error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(service_->server->scenes().size(), 1U);
}

}  // namespace
}  // namespace lucerna::testing
