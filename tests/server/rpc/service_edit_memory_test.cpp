// The memory of edits: all that a revision keeps counts against the budget.
#include "edit_fixture.h"

namespace lucerna::testing {
namespace {

using ::testing::Gt;
using ::testing::HasSubstr;

constexpr int kManyLights = 2000;
constexpr std::size_t kNameBytes = 200;

TEST_F(Edit, UnknownFieldsOfALightAreDropped) {
  const std::string scene = load("placed.pbrt", placed(""));
  auto request = about<v1::EditLightsRequest>(scene);
  *request.add_edits()->mutable_put() = point_light(3);
  const std::string revision = edited(request);
  v1::Light* const light = request.mutable_edits(0)->mutable_put();
  for (google::protobuf::Message* message :
       std::initializer_list<google::protobuf::Message*>{light, light->mutable_point()}) {
    message->GetReflection()->MutableUnknownFields(message)->AddLengthDelimited(
        9999, std::string(1 << 20, 'x'));
    EXPECT_EQ(edited(request), revision);
  }
}

// Each revision has a list of its own, so revisions of many lights would fill the memory.
TEST_F(Edit, ListsOfEditsCountAgainstTheBudget) {
  const std::string scene = load("placed.pbrt", placed(""));
  auto request = about<v1::EditLightsRequest>(scene);
  for (int i = 0; i < kManyLights; ++i) {
    v1::Light* const light = request.add_edits()->mutable_put();
    *light = point_light(1 + i);
    light->set_name(std::string(kNameBytes, 'n') + std::to_string(i));
  }
  request.set_lease_s(60);
  request.set_scene_id(edited(request));
  const std::uint64_t before = service_->server->scenes().bytes();
  request.clear_edits();
  change(request, 1)->set_scale(0.5);
  edited(request);
  // The name twice in the list, in the description and in the content, and once in the scene.
  EXPECT_THAT(service_->server->scenes().bytes() - before, Gt(3 * kManyLights * kNameBytes));
}

TEST_F(Edit, AddedFilesThatDoNotFitAreRefusedWhileTheyAreRead) {
  constexpr int kSide = 200;
  std::string points, indices;
  for (int i = 0; i < kSide * kSide; ++i)
    points += std::to_string(0.01 * (i % kSide)) + " " + std::to_string(0.01 * (i / kSide)) + " 2 ";
  for (int i = 0; i + kSide < kSide * kSide; ++i)
    indices +=
        std::to_string(i) + " " + std::to_string(i + 1) + " " + std::to_string(i + kSide) + " ";
  write("mesh.pbrt",
        "WorldBegin\nAreaLightSource \"diffuse\"\nShape \"trianglemesh\" \"point3 P\" [" + points +
            "] \"integer indices\" [" + indices + "]\n");
  rpc::ServerOptions options = scenes_in(root_.path());
  options.scenes.memory_budget_bytes = 32 << 20;
  service_ = std::make_unique<Service>(options);
  auto request = about<v1::EditLightsRequest>(load("placed.pbrt", placed("")));
  for (int i = 0; i < 200; ++i) request.add_edits()->mutable_add()->set_path("mesh.pbrt");
  const grpc::Status status = service_->status(request);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED) << status.error_message();
  // A mesh takes about 1.4 MB.
  EXPECT_THAT(status.error_message(), ::testing::MatchesRegex("edits\\[[0-9]{1,2}\\].add: .*"));
  EXPECT_THAT(service_->server->scenes().bytes(), ::testing::Lt(4U << 20));
}

}  // namespace
}  // namespace lucerna::testing
