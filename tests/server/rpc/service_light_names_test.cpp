// Lights by their names: ListLights shows them, and every request that takes an id takes a name.
#include <gmock/gmock.h>

#include "every_query.h"
#include "tests/server/pbrt/pbrt_fixture.h"

namespace lucerna::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr char kScene[] =
    "WorldBegin\n"
    "LightSource \"point\" \"rgb I\" [1 1 1] \"point3 from\" [0 0 3]\n"
    "LightSource \"point\" \"rgb I\" [2 2 2] \"point3 from\" [0 0 2] \"string name\" \"desk\"\n"
    "AttributeBegin\n"
    "AreaLightSource \"diffuse\" \"rgb L\" [3 3 3] \"string name\" \"Fenster \xc3\xbc"
    "ber 2\"\n"
    "Translate 0 0 4 Shape \"disk\"\nAttributeEnd\n"
    "LightSource \"point\" \"rgb I\" [4 4 4] \"string name\" \"twin\"\n"
    "LightSource \"point\" \"rgb I\" [5 5 5] \"string name\" \"twin\"\n";

class LightNamesService : public ::testing::Test {
 protected:
  LightNamesService() : service_(options(files_)) { id_ = service_.load("scene.pbrt"); }

  static rpc::ServerOptions options(const SceneFiles& files) {
    files.write("scene.pbrt", kScene);
    return scenes_in(files.path());
  }

  v1::PdfLiRequest named(const std::string& name) const {
    auto request = about<v1::PdfLiRequest>(id_);
    request.set_light_name(name);
    return request;
  }

  SceneFiles files_;
  Service service_;
  std::string id_;
};

TEST_F(LightNamesService, ListLightsShowsThem) {
  const auto response = service_.answer(about<v1::ListLightsRequest>(id_));
  std::vector<std::string> names;
  for (const v1::Light& light : response.lights()) names.push_back(light.name());
  EXPECT_THAT(names, ElementsAre("", "desk", "twin", "twin",
                                 "Fenster \xc3\xbc"
                                 "ber 2"));
}

TEST_F(LightNamesService, EveryQueryAnswersForANameAsForTheId) {
  int queries = 0;
  for_each_query(id_, 3, [&](auto by_name) {
    if constexpr (requires { by_name.set_light_name("desk"); }) {
      ++queries;
      auto by_id = by_name;
      by_name.clear_light_id();
      by_name.set_light_name("desk");
      by_id.set_light_id(2);
      EXPECT_EQ(without_cost(service_.answer(by_name)), without_cost(service_.answer(by_id)))
          << by_id.GetTypeName();
    }
  });
  EXPECT_EQ(queries, 5);
}

TEST_F(LightNamesService, PowerTakesIdsAndNames) {
  auto request = about<v1::EstimatePowerRequest>(id_);
  request.add_light_names("desk");
  request.add_light_ids(1);
  auto response = service_.answer(request);
  ASSERT_EQ(response.lights_size(), 2);
  EXPECT_EQ(response.lights(0).light_id(), 1U);
  EXPECT_EQ(response.lights(1).light_id(), 2U);
  // 4 pi (1 + 2) lm.
  EXPECT_NEAR(response.total().power_lm(), 12 * kPi, 1e-9);

  request.add_light_names("dsk");
  expect_error(service_.call(request, &response), grpc::StatusCode::NOT_FOUND,
               "light_names[1] = \"dsk\", which the scene does not");
}

TEST_F(LightNamesService, AnUnknownNameIsNotFoundAndTheSimilarOnesAreListed) {
  const grpc::Status status = service_.status(named("Desk"));
  EXPECT_EQ(status.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(status.error_message(),
            "light_name = \"Desk\", which the scene does not have; similar names: \"desk\", "
            "\"twin\", \"Fenster \xc3\xbc"
            "ber 2\"");
  EXPECT_EQ(detail<google::rpc::ErrorInfo>(status).reason(), "NO_SUCH_LIGHT");
}

TEST_F(LightNamesService, ANameOfSeveralLightsIsRefusedWithTheirIds) {
  const grpc::Status status = service_.status(named("twin"));
  expect_bad_field(status, "light_name");
  EXPECT_THAT(status.error_message(),
              HasSubstr("the name of one light; 2 lights have this name: use an id, 3, 4"));
}

TEST_F(LightNamesService, AnIdBesideANameIsRefused) {
  v1::PdfLiRequest request = named("desk");
  request.set_light_id(2);
  expect_bad_field(service_.status(request), "light_name");
  auto le = about<v1::LeRequest>(id_);
  le.set_light_name("desk");
  le.set_light_id(0);
  expect_bad_field(service_.status(le), "light_name");
}

TEST_F(LightNamesService, ARequiredLightMustBeNamed) {
  expect_bad_field(service_.status(named("")), "light_id");
}

TEST_F(LightNamesService, ANamedLightNeedsNoValueThatChoosesIt) {
  auto request = about<v1::SampleLiRequest>(id_);
  request.set_light_name("desk");
  set(request.mutable_receivers()->mutable_offsets_m(), 0, 0, 0);
  request.mutable_u()->mutable_u()->Add(0);
  request.mutable_u()->mutable_u()->Add(0);
  request.mutable_u()->add_u_light(0.5);
  expect_bad_field(service_.status(request), "u.u_light");
}

TEST_F(LightNamesService, ASceneWithoutNamesSaysSo) {
  files_.write("plain.pbrt", "WorldBegin LightSource \"point\"\n");
  v1::PdfLiRequest request = named("desk");
  request.set_scene_id(service_.load("plain.pbrt"));
  expect_error(service_.status(request), grpc::StatusCode::NOT_FOUND,
               "none of its lights has a name");
}

}  // namespace
}  // namespace lucerna::testing
