// Lights by their names: ListLights shows them, and every request that takes an id takes a name.
#include <gmock/gmock.h>

#include "service_fixture.h"
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
    rpc::ServerOptions options = service_options();
    options.scenes.root = files.path().string();
    return options;
  }

  /// The answers to two requests, without their costs, which differ from call to call.
  template <typename Response, typename Request, typename Call>
  void expect_equal(const Request& by_name, const Request& by_id, const Call& call) {
    Response of_name, of_id;
    const grpc::Status s =
        status_of([&](auto* c) { return (service_.lighting.*call)(c, by_name, &of_name); });
    ASSERT_TRUE(s.ok()) << s.error_message();
    const grpc::Status t =
        status_of([&](auto* c) { return (service_.lighting.*call)(c, by_id, &of_id); });
    ASSERT_TRUE(t.ok()) << t.error_message();
    of_name.clear_cost();
    of_id.clear_cost();
    EXPECT_EQ(of_name.DebugString(), of_id.DebugString());
    EXPECT_GT(of_name.ByteSizeLong(), 0U);
  }

  /// Both forms of a request: with a name, and with the id of the same light.
  template <typename Request>
  std::pair<Request, Request> requests(const Request& base) const {
    std::pair<Request, Request> both{base, base};
    both.first.set_scene_id(id_);
    both.second.set_scene_id(id_);
    both.first.set_light_name("desk");
    both.second.set_light_id(2);
    return both;
  }

  grpc::Status pdf(const v1::PdfLiRequest& request) {
    v1::PdfLiResponse response;
    return status_of([&](auto* c) { return service_.lighting.PdfLi(c, request, &response); });
  }
  v1::PdfLiRequest named(const std::string& name) const {
    v1::PdfLiRequest request;
    request.set_scene_id(id_);
    request.set_light_name(name);
    return request;
  }

  SceneFiles files_;
  Service service_;
  std::string id_;
};

using Stub = v1::LightingService::Stub;

TEST_F(LightNamesService, ListLightsShowsThem) {
  v1::ListLightsRequest request;
  request.set_scene_id(id_);
  v1::ListLightsResponse response;
  ASSERT_TRUE(
      status_of([&](auto* c) { return service_.scenes.ListLights(c, request, &response); }).ok());
  std::vector<std::string> names;
  for (const v1::Light& light : response.lights()) names.push_back(light.name());
  EXPECT_THAT(names, ElementsAre("", "desk", "twin", "twin",
                                 "Fenster \xc3\xbc"
                                 "ber 2"));
}

TEST_F(LightNamesService, EveryQueryAnswersForANameAsForTheId) {
  v1::SampleLiRequest sample;
  set(sample.mutable_receivers()->mutable_offsets_m(), 0, 0, 0, 1, 0, 0);
  sample.mutable_u()->mutable_u()->Add(0.25F);
  sample.mutable_u()->mutable_u()->Add(0.5F);
  sample.mutable_u()->mutable_u()->Add(0.25F);
  sample.mutable_u()->mutable_u()->Add(0.5F);
  const auto [li, li_id] = requests(sample);
  expect_equal<v1::SampleLiResponse>(
      li, li_id,
      static_cast<grpc::Status (Stub::*)(grpc::ClientContext*, const v1::SampleLiRequest&,
                                         v1::SampleLiResponse*)>(&Stub::SampleLi));
  v1::PdfLiRequest pdf;
  set(pdf.mutable_receivers()->mutable_offsets_m(), 0, 0, 0);
  set(pdf.mutable_wi(), 0, 0, 1);
  const auto [density, density_id] = requests(pdf);
  expect_equal<v1::PdfLiResponse>(density, density_id, &Stub::PdfLi);
  v1::SampleLeRequest emit;
  emit.set_count(3);
  const auto [le, le_id] = requests(emit);
  expect_equal<v1::SampleLeResponse>(le, le_id, &Stub::SampleLe);
  v1::PdfLeRequest emitted;
  set(emitted.mutable_points()->mutable_offsets_m(), 0, 0, 2);
  set(emitted.mutable_directions(), 0, 0, 1);
  const auto [ray, ray_id] = requests(emitted);
  expect_equal<v1::PdfLeResponse>(ray, ray_id, &Stub::PdfLe);
  v1::LeRequest seen;
  set(seen.mutable_points()->mutable_offsets_m(), 0, 0, 0);
  set(seen.mutable_directions(), 0, 0, 1);
  const auto [look, look_id] = requests(seen);
  expect_equal<v1::LeResponse>(look, look_id, &Stub::Le);
}

TEST_F(LightNamesService, PowerTakesIdsAndNames) {
  v1::EstimatePowerRequest request;
  request.set_scene_id(id_);
  request.add_light_names("desk");
  request.add_light_ids(1);
  v1::EstimatePowerResponse response;
  const grpc::Status s =
      status_of([&](auto* c) { return service_.lighting.EstimatePower(c, request, &response); });
  ASSERT_TRUE(s.ok()) << s.error_message();
  ASSERT_EQ(response.lights_size(), 2);
  EXPECT_EQ(response.lights(0).light_id(), 1U);
  EXPECT_EQ(response.lights(1).light_id(), 2U);
  // 4 pi (1 + 2) lm.
  EXPECT_NEAR(response.total().power_lm(), 12 * kPi, 1e-9);

  request.add_light_names("dsk");
  const grpc::Status t =
      status_of([&](auto* c) { return service_.lighting.EstimatePower(c, request, &response); });
  EXPECT_EQ(t.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_THAT(t.error_message(), HasSubstr("light_names[1] = \"dsk\", which the scene does not"));
}

TEST_F(LightNamesService, AnUnknownNameIsNotFoundAndTheSimilarOnesAreListed) {
  const grpc::Status status = pdf(named("Desk"));
  EXPECT_EQ(status.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(status.error_message(),
            "light_name = \"Desk\", which the scene does not have; similar names: \"desk\", "
            "\"twin\", \"Fenster \xc3\xbc"
            "ber 2\"");
  EXPECT_EQ(detail<google::rpc::ErrorInfo>(status).reason(), "NO_SUCH_LIGHT");
}

TEST_F(LightNamesService, ANameOfSeveralLightsIsRefusedWithTheirIds) {
  const grpc::Status status = pdf(named("twin"));
  expect_bad_field(status, "light_name");
  EXPECT_THAT(status.error_message(),
              HasSubstr("the name of one light; 2 lights have this name: use an id, 3, 4"));
}

TEST_F(LightNamesService, AnIdBesideANameIsRefused) {
  v1::PdfLiRequest request = named("desk");
  request.set_light_id(2);
  expect_bad_field(pdf(request), "light_name");
  v1::LeRequest le;
  le.set_scene_id(id_);
  le.set_light_name("desk");
  le.set_light_id(0);
  v1::LeResponse response;
  expect_bad_field(status_of([&](auto* c) { return service_.lighting.Le(c, le, &response); }),
                   "light_name");
}

TEST_F(LightNamesService, ARequiredLightMustBeNamed) {
  expect_bad_field(pdf(named("")), "light_id");
}

TEST_F(LightNamesService, ANamedLightNeedsNoValueThatChoosesIt) {
  v1::SampleLiRequest request;
  request.set_scene_id(id_);
  request.set_light_name("desk");
  set(request.mutable_receivers()->mutable_offsets_m(), 0, 0, 0);
  request.mutable_u()->mutable_u()->Add(0);
  request.mutable_u()->mutable_u()->Add(0);
  request.mutable_u()->add_u_light(0.5);
  v1::SampleLiResponse response;
  expect_bad_field(
      status_of([&](auto* c) { return service_.lighting.SampleLi(c, request, &response); }),
      "u.u_light");
}

TEST_F(LightNamesService, ASceneWithoutNamesSaysSo) {
  files_.write("plain.pbrt", "WorldBegin LightSource \"point\"\n");
  v1::PdfLiRequest request = named("desk");
  request.set_scene_id(service_.load("plain.pbrt"));
  const grpc::Status status = pdf(request);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_THAT(status.error_message(), HasSubstr("none of its lights has a name"));
}

}  // namespace
}  // namespace lucerna::testing
