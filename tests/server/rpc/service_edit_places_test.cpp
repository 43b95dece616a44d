// Edits that move lights, and that move and add their surfaces.  A revision gives the same bits as
// a scene whose file says so.
#include "edit_fixture.h"

namespace lucerna::testing {
namespace {

using ::testing::HasSubstr;

/// A shape of every kind that emits.
constexpr const char* kLampShapes[] = {
    "\"sphere\" \"float radius\" [0.25]", "\"disk\" \"float radius\" [0.5]",
    "\"cylinder\" \"float radius\" [0.25]",
    "\"bilinearmesh\" \"point3 P\" [0 0 0  1 0 0  0 1 0  1 1 1]",
    "\"trianglemesh\" \"point3 P\" [0 0 0  1 0 0  0 1 0] \"normal N\" [0 0 1  0 0 1  0 0 1] "
    "\"integer indices\" [0 1 2]"};

TEST_F(Edit, ShiftedLightsHaveTheBitsOfAFileThatShiftsThem) {
  const std::string scene = load("placed.pbrt", placed(""));
  auto request = about<v1::EditLightsRequest>(scene);
  for (const std::uint64_t light : {1, 2, 3, 4, 5, 6, 8}) {
    v1::Vector3* shift = change(request, light)->mutable_placement()->mutable_shift_m();
    shift->set_x(0.25), shift->set_y(0.5), shift->set_z(-0.125);
  }
  expect_same(edited(request), load("shifted.pbrt", placed("Translate 0.25 0.5 -0.125")));
}

TEST_F(Edit, TurnedLightsPointElsewhere) {
  const std::string scene = load("placed.pbrt", placed(""));
  auto request = about<v1::EditLightsRequest>(scene);
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

TEST_F(Edit, AShiftAndATurnKeepEachOther) {
  const std::string scene = load("placed.pbrt", placed(""));
  auto both = about<v1::EditLightsRequest>(scene), shift = both;
  const auto turn = [this](v1::EditLightsRequest& r) {
    v1::LightPlacement* place = change(r, 2)->mutable_placement();
    place->mutable_turn_axis()->set_z(1);
    place->set_turn_rad(0.5);
    return place;
  };
  turn(both)->mutable_shift_m()->set_x(0.25);
  const std::string at_once = edited(both);
  change(shift, 2)->mutable_placement()->mutable_shift_m()->set_x(0.25);
  auto after = about<v1::EditLightsRequest>(edited(shift));
  turn(after);
  EXPECT_EQ(edited(after), at_once);
  after = about<v1::EditLightsRequest>(at_once);
  change(after, 2)->mutable_placement()->mutable_shift_m();  // a shift by 0
  auto turned = about<v1::EditLightsRequest>(scene);
  turn(turned);
  EXPECT_EQ(edited(after), edited(turned));
  change(after, 2)->mutable_placement();
  EXPECT_EQ(edited(after), scene);
}

TEST_F(Edit, ShiftedSurfacesOfEveryKindHaveTheBitsOfAFileThatShiftsThem) {
  const auto text = [](const std::string& where) {
    std::string all =
        "WorldBegin\nShape \"bilinearmesh\" \"point3 P\" [-4 -4 0  4 -4 0  -4 4 0  4 4 0]\n";
    for (const char* shape : kLampShapes)
      all += "AttributeBegin AreaLightSource \"diffuse\" \"bool twosided\" true\n" + where +
             "Translate -1 1 2\nShape " + shape + " AttributeEnd\n";
    return all;
  };
  const std::string scene = load("surfaces.pbrt", text(""));
  auto request = about<v1::EditLightsRequest>(scene);
  for (std::uint64_t light = 1; light <= 5; ++light) {
    v1::Vector3* shift = change(request, light)->mutable_placement()->mutable_shift_m();
    shift->set_x(0.25), shift->set_y(-0.5), shift->set_z(0.125);
  }
  const std::string moved = edited(request);
  expect_same(moved, load("moved.pbrt", text("Translate 0.25 -0.5 0.125\n")));
  // Another edit of the revision keeps the places, and shares the geometry.
  const std::uint64_t builds = service_->server->scenes().builds();
  request = about<v1::EditLightsRequest>(moved);
  change(request, 1)->set_scale(0.5);
  EXPECT_NE(edited(request), moved);
  EXPECT_EQ(service_->server->scenes().builds(), builds);
  // Back at their places the surfaces are those of the file.
  request = about<v1::EditLightsRequest>(moved);
  for (std::uint64_t light = 1; light <= 5; ++light) change(request, light)->mutable_placement();
  EXPECT_EQ(edited(request), scene);
  // A surface moves without the file.  If the scene gets another origin, all of it is built again,
  // which needs the file.
  write("surfaces.pbrt", text("Scale 2 2 2\n"));
  request = about<v1::EditLightsRequest>(scene);
  change(request, 1)->mutable_placement()->mutable_shift_m()->set_x(3);
  EXPECT_NE(edited(request), scene);
  request = about<v1::EditLightsRequest>(scene);
  change(request, 1)->mutable_placement()->mutable_shift_m()->set_x(1e6);
  EXPECT_EQ(service_->status(request).error_code(), grpc::StatusCode::FAILED_PRECONDITION);
}

TEST_F(Edit, TurnedSurfacesTurnAboutTheirMiddle) {
  const std::string scene =
      load("pane.pbrt",
           "WorldBegin\nAreaLightSource \"diffuse\" \"rgb L\" [1 1 1]\n"
           "Shape \"bilinearmesh\" \"point3 P\" [1 1 2  3 1 2  1 3 2  3 3 2]\n");
  auto request = about<v1::EditLightsRequest>(scene);
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

TEST_F(Edit, NewLightsShineAsThoseOfAFile) {
  const std::string start =
      "WorldBegin\nShape \"bilinearmesh\" \"point3 P\" [-4 -4 0  4 -4 0  -4 4 "
      "0  4 4 0]\nLightSource \"point\" \"point3 from\" [1 0 2]\n";
  const std::string scene = load("one.pbrt", start);
  write("lamp.pbrt",
        "WorldBegin\nLightSource \"point\" \"rgb I\" [100 100 100] \"point3 from\" [0 0 3]\n");
  auto by_message = about<v1::EditLightsRequest>(scene), by_file = by_message;
  *by_message.add_edits()->mutable_put() = point_light(3);
  by_file.add_edits()->mutable_add()->set_path("lamp.pbrt");
  const std::string fresh =
      load("two.pbrt",
           start + "LightSource \"point\" \"rgb I\" [100 100 100] \"point3 from\" [0 0 3]\n");
  const auto lux = [&](const std::string& of) {
    auto q = about<v1::EstimateIrradianceRequest>(of);
    for (const float v : {0.5F, 0.25F, 0.F}) q.mutable_receivers()->add_offsets_m(v);
    for (const float v : {0.F, 0.F, 1.F}) q.add_normals(v);
    const auto r = service_->answer(q);
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

/// One lamp of every shape, after these directives.
std::vector<std::string> lamps(const std::string& where, const std::string& level) {
  std::vector<std::string> all;
  for (const char* shape : kLampShapes)
    all.push_back(
        "AttributeBegin Material \"diffuse\" \"rgb reflectance\" [0.25 0.75 0.5]\n"
        "AreaLightSource \"diffuse\" \"rgb L\" " +
        level + " \"bool twosided\" true\n" + where + " Translate " +
        std::to_string(static_cast<int>(all.size()) - 2) + " 1 2\nShape " + shape +
        " AttributeEnd\n");
  return all;
}

/// The texts in the order of these ids.
std::string in_order(const std::vector<std::uint64_t>& ids, const std::vector<std::string>& texts) {
  std::map<std::uint64_t, std::string> by_id;
  for (std::size_t i = 0; i < ids.size(); ++i) by_id[ids[i]] = texts[i];
  std::string all;
  for (const auto& [id, text] : by_id) all += text;
  return all;
}

TEST_F(Edit, NewSurfacesOfEveryKindShineAsThoseOfAFile) {
  const std::string start =
      "Film \"rgb\" \"integer xresolution\" [16] \"integer yresolution\" [12]\n"
      "LookAt 0 -6 2.5   0 0 1   0 0 1\nCamera \"perspective\" \"float fov\" [40]\nWorldBegin\n"
      "Material \"diffuse\" \"rgb reflectance\" [0.6 0.5 0.4]\n"
      "Shape \"bilinearmesh\" \"point3 P\" [-4 -4 0  4 -4 0  -4 4 0  4 4 0]\n"
      "Shape \"sphere\" \"float radius\" [0.75]\n";
  std::string added = "WorldBegin\n";
  for (const std::string& lamp : lamps("", "[3 2 1]")) added += lamp;
  write("lamps.pbrt", added);
  // With glass, all materials are kept, and not only reflectances.
  for (const std::string glass :
       {"", "Material \"dielectric\"\nShape \"disk\" \"float radius\" [3]\n"}) {
    const std::string scene = load("room.pbrt", start + glass);
    auto request = about<v1::EditLightsRequest>(scene);
    request.add_edits()->mutable_add()->set_path("lamps.pbrt");
    const std::string lit = edited(request);
    ASSERT_EQ(new_ids_.size(), 5U);
    const std::vector<std::uint64_t> ids = new_ids_;
    const std::string fresh = load("lit.pbrt", start + glass + in_order(ids, lamps("", "[3 2 1]")));
    EXPECT_EQ(picture(lit), picture(fresh));
    EXPECT_EQ(total_lux(lit), total_lux(fresh));
    EXPECT_NE(picture(lit), picture(scene));
    // The light of a new surface can change, move and go as any other.
    request = about<v1::EditLightsRequest>(lit);
    for (const std::uint64_t id : ids) {
      change(request, id)->set_scale(0.5);
      v1::Vector3* shift = change(request, id)->mutable_placement()->mutable_shift_m();
      shift->set_x(0.25), shift->set_z(0.5);
    }
    const std::string moved = edited(request);
    const std::string elsewhere = load(
        "moved.pbrt", start + glass + in_order(ids, lamps("Translate 0.25 0 0.5", "[1.5 1 0.5]")));
    EXPECT_EQ(picture(moved), picture(elsewhere));
    EXPECT_EQ(total_lux(moved), total_lux(elsewhere));
    request = about<v1::EditLightsRequest>(moved);
    for (const std::uint64_t id : ids) request.add_edits()->set_remove(id);
    EXPECT_EQ(edited(request), scene);
  }
}

TEST_F(Edit, NewSurfacesThatCannotBeAddedAreRefused) {
  const std::string scene =
      load("room.pbrt", "WorldBegin\nShape \"sphere\"\nLightSource \"point\"\n");
  const std::string light = "AreaLightSource \"diffuse\"\n";
  const auto refusal = [&](const std::string& text) {
    write("lamp.pbrt", "WorldBegin\n" + text);
    auto request = about<v1::EditLightsRequest>(scene);
    request.add_edits()->mutable_add()->set_path("lamp.pbrt");
    const grpc::Status s = service_->status(request);
    EXPECT_EQ(s.error_code(), grpc::StatusCode::INVALID_ARGUMENT) << text;
    return s.error_message();
  };
  EXPECT_THAT(refusal("Shape \"sphere\"\n"),
              HasSubstr("lamp.pbrt:2:1: a shape that does not emit"));
  EXPECT_THAT(refusal(light + "Material \"conductor\"\nShape \"sphere\"\n"),
              HasSubstr("lamp.pbrt:4:1: a shape of another material"));
  EXPECT_THAT(refusal(light + "Shape \"sphere\" \"float alpha\" [0.5]\n"),
              HasSubstr("lamp.pbrt:3:1: a cut-out shape"));
  EXPECT_THAT(refusal(light + "Translate 1e6 0 0 Shape \"sphere\"\n"),
              HasSubstr("allowed: surfaces within the scene"));
  EXPECT_EQ(service_->server->scenes().size(), 1U);
}

}  // namespace
}  // namespace lucerna::testing
