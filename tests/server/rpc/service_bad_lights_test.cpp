// Scenes with an invalid light.  The error has its place, nothing of the scene is loaded, and
// earlier scenes stay.  The scene loads once the light is fixed.

#include "service_fixture.h"
#include "tests/server/pbrt/pbrt_fixture.h"

namespace lucerna::testing {
namespace {

constexpr char kIes[] =
    "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 2 1 1 2 0 0 0\n1 1 10\n0 90\n0\n100 100\n";

std::string pfm(float value, const std::string& size = "2 2") {
  std::string bytes = "PF\n" + size + "\n-1.0\n";
  for (int i = 0; i < 12; ++i) bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  return bytes;
}

/// An invalid light and its correction.
struct BadLight {
  const char* name;
  std::string line, mended;  ///< the third line of the scene
  const char* file;          ///< the broken file, or null
  std::string bytes, mended_bytes;
  int column;  ///< of the error
  const char* what;
  grpc::StatusCode code = grpc::StatusCode::INVALID_ARGUMENT;
};

std::vector<BadLight> bad_lights() {
  const std::string infinite = "LightSource \"infinite\" \"string filename\" \"sky.pfm\"";
  const std::string luminaire = "LightSource \"goniometric\" \"string filename\" \"lamp.ies\"";
  const std::string panel =
      "AreaLightSource \"diffuse\" \"string profile\" \"lamp.ies\" Shape \"disk\"";
  const std::string screen =
      "AreaLightSource \"diffuse\" \"string filename\" \"sky.pfm\" Shape \"disk\"";
  const std::string ies = kIes;
  const std::string negative = ies.substr(0, ies.size() - 4) + "-99\n";
  const std::string point = "LightSource \"point\" ";
  return {
      {"no picture", "LightSource \"infinite\" \"string filename\" \"none.pfm\"", infinite, nullptr,
       "", "", 24, "file \"none.pfm\" does not exist", grpc::StatusCode::NOT_FOUND},
      {"a huge picture", screen, screen, "sky.pfm", pfm(1, "64000 64000"), pfm(1), 27,
       "sky.pfm: 64000 x 64000 texels", grpc::StatusCode::RESOURCE_EXHAUSTED},
      {"photometry cut off", luminaire, luminaire, "lamp.ies", ies.substr(0, 50), ies, 27,
       "lamp.ies:4: the file ends before "},
      {"negative candela", panel, panel, "lamp.ies", negative, ies, 27,
       "lamp.ies:7: candela value 2 = -99, allowed: finite, not negative"},
      {"no photometry", luminaire, luminaire, "lamp.ies", "", ies, 27,
       "lamp.ies:0: no line \"TILT=\""},
      {"unequal scale", "Scale 1 1 2 LightSource \"distant\" \"float angulardiameter\" 1",
       "Scale 2 2 2 LightSource \"distant\" \"float angulardiameter\" 1", nullptr, "", "", 35,
       "\"float angulardiameter\" under a transform of unequal scales 1, 1 and 2, allowed: equal "
       "scale on all axes"},
      {"a profile on a sphere",
       "AreaLightSource \"diffuse\" \"string profile\" \"lamp.ies\" Shape \"sphere\"", panel,
       nullptr, "", "", 55, "a light with \"profile\" on a sphere, allowed: flat shapes"},
      {"a spectrum in disorder", point + "\"spectrum I\" [500 1 400 1]",
       point + "\"spectrum I\" [400 1 500 1]", nullptr, "", "", 21,
       "wavelength 400 nm follows 500 nm"},
      {"a black body of ice", point + "\"blackbody I\" 3", point + "\"blackbody I\" 3000", nullptr,
       "", "", 21, "black body of 3 K, allowed: [100, 1e7] K"},
      {"an intensity beyond a float", point + "\"float scale\" 1e39", point + "\"float scale\" 1e3",
       nullptr, "", "", 21, "allowed: each channel finite"},
      {"an area light too bright",
       "AreaLightSource \"diffuse\" \"string filename\" \"sky.pfm\" \"float scale\" 1e30 "
       "Shape \"disk\"",
       screen, "sky.pfm", pfm(1e30F), pfm(1), 55,
       "the brightest texel of sky.pfm times the light's level = (1e+60"},
      {"a portal that is no rectangle",
       "LightSource \"infinite\" \"point3 portal\" [0 0 1 1 0 1 1 1 2 0 1 1]",
       "LightSource \"infinite\" \"point3 portal\" [0 0 1 1 0 1 1 1 1 0 1 1]", nullptr, "", "", 24,
       "\"point3 portal\": infinite.portal = "},
      {"motion that grows", "ActiveTransform EndTime Scale 2 2 2 " + point,
       "ActiveTransform EndTime Translate 2 2 2 " + point, nullptr, "", "", 37,
       "motion that scales or shears"},
      // Found only when the scene is built.
      {"motion beyond all rays", "ActiveTransform EndTime Translate 1e31 0 0 " + point,
       "ActiveTransform EndTime Translate 1 0 0 " + point, nullptr, "", "", 44,
       "motion reaching to 1"},
  };
}

class BadLightsTest : public ::testing::Test {
 protected:
  BadLightsTest() {
    files_.write("sky.pfm", pfm(1));
    files_.write("lamp.ies", kIes);
  }

  static rpc::ServerOptions options(const SceneFiles& files) { return scenes_in(files.path()); }
  /// Writes the line with a valid light before it, and a surface and a valid light after it.
  void write(const std::string& line) const {
    files_.write("scene.pbrt", "WorldBegin\nLightSource \"point\"\nAttributeBegin\n" + line +
                                   "\nAttributeEnd\nShape \"sphere\" LightSource \"distant\"\n");
  }
  grpc::Status load(v1::LoadSceneResponse* response) {
    v1::LoadSceneRequest request;
    request.set_path("scene.pbrt");
    return service_.call(request, response);
  }
  /// Ids and paths of the loaded scenes.
  std::vector<std::pair<std::string, std::string>> loaded() {
    const auto list = service_.answer(v1::ListScenesRequest());
    std::vector<std::pair<std::string, std::string>> all;
    for (const auto& scene : list.scenes()) all.emplace_back(scene.scene_id(), scene.path());
    return all;
  }
  int lights_of(const std::string& id) {
    const auto lights = service_.answer(about<v1::ListLightsRequest>(id));
    return lights.lights_size();
  }
  void expect_error(const BadLight& bad, const grpc::Status& status) {
    EXPECT_EQ(status.error_code(), bad.code) << status.error_message();
    EXPECT_EQ(status.error_message().find("scene.pbrt:4:" + std::to_string(bad.column) + ": "), 0U)
        << status.error_message();
    EXPECT_NE(status.error_message().find(bad.what), std::string::npos) << status.error_message();
    EXPECT_EQ(detail<google::rpc::ErrorInfo>(status).domain(), "lucerna");
  }

  const SceneFiles files_;
  Service service_{options(files_)};
};

TEST_F(BadLightsTest, LeaveNothingOfTheirSceneAndLoadWhenFixed) {
  for (const BadLight& bad : bad_lights()) {
    SCOPED_TRACE(bad.name);
    write(bad.line);
    if (bad.file != nullptr) files_.write(bad.file, bad.bytes);
    const std::uint64_t builds = service_.server->scenes().builds();
    v1::LoadSceneResponse response;
    expect_error(bad, load(&response));
    EXPECT_EQ(response.scene_id(), "");
    EXPECT_EQ(response.remarks_size(), 0);
    EXPECT_TRUE(loaded().empty());
    EXPECT_EQ(service_.server->scenes().size(), 0U);
    EXPECT_EQ(service_.server->scenes().builds(), builds);

    write(bad.mended);
    if (bad.file != nullptr) files_.write(bad.file, bad.mended_bytes);
    ASSERT_TRUE(load(&response).ok());
    EXPECT_FALSE(response.already_loaded());
    EXPECT_EQ(lights_of(response.scene_id()), 3);
    ASSERT_EQ(loaded().size(), 1U);
    EXPECT_EQ(loaded()[0].second, "scene.pbrt");
    EXPECT_TRUE(service_.status(about<v1::ReleaseSceneRequest>(response.scene_id())).ok());
  }
}

TEST_F(BadLightsTest, LeaveTheSceneThatWasLoadedFromTheSamePath) {
  write("LightSource \"spot\"");
  v1::LoadSceneResponse good;
  ASSERT_TRUE(load(&good).ok());
  const auto before = loaded();
  ASSERT_EQ(before.size(), 1U);
  for (const BadLight& bad : bad_lights()) {
    SCOPED_TRACE(bad.name);
    write(bad.line);
    if (bad.file != nullptr) files_.write(bad.file, bad.bytes);
    v1::LoadSceneResponse response;
    expect_error(bad, load(&response));
    EXPECT_EQ(loaded(), before);
    EXPECT_EQ(lights_of(good.scene_id()), 3);
    if (bad.file != nullptr) files_.write(bad.file, bad.mended_bytes);
  }
  // The original file again is the same scene.
  write("LightSource \"spot\"");
  v1::LoadSceneResponse again;
  ASSERT_TRUE(load(&again).ok());
  EXPECT_EQ(again.scene_id(), good.scene_id());
  EXPECT_TRUE(again.already_loaded());
}

}  // namespace
}  // namespace lucerna::testing
