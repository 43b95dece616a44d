// Calls with large input that are cancelled while they compute.  Their work ends: nothing of it
// runs or waits afterwards.
#include <future>
#include <random>
#include <thread>

#include "edit_fixture.h"

namespace lucerna::testing {
namespace {

class Stopped : public Edit {
 protected:
  using Call = std::function<grpc::Status(grpc::ClientContext*)>;

  /// Cancels the call at ten moments, and expects each time that its work ends.
  void expect_stops(const Call& call) {
    std::mt19937 random(1);
    for (int i = 0; i < 10; ++i) {
      grpc::ClientContext context;
      auto answer = std::async(std::launch::async, [&] { return call(&context); });
      std::this_thread::sleep_for(std::chrono::milliseconds(random() % 100));
      context.TryCancel();
      const grpc::Status status = answer.get();
      ASSERT_TRUE(status.ok() || status.error_code() == grpc::StatusCode::CANCELLED)
          << status.error_message();
      ASSERT_TRUE(is_idle()) << "moment " << i;
    }
  }

 private:
  /// Waits for the lanes.  Work that nobody stops would take minutes.
  bool is_idle() {
    const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (std::chrono::steady_clock::now() < limit) {
      const Lanes& lanes = service_->server->lanes();
      if (lanes.pending(Lane::kInteractive) + lanes.pending(Lane::kBulk) == 0) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return false;
  }
};

TEST_F(Stopped, EditsOfManyLights) {
  v1::EditLightsRequest request = request_for(load("placed.pbrt", placed("")));
  for (int i = 0; i < 65536; ++i) *request.add_edits()->mutable_put() = point_light(2);
  expect_stops([&](grpc::ClientContext* c) {
    v1::EditLightsResponse response;
    return service_->scenes.EditLights(c, request, &response);
  });
}

TEST_F(Stopped, EditsThatMoveManySurfaces) {
  constexpr int kLamps = 20000;
  std::string text = "WorldBegin\nAreaLightSource \"diffuse\"\n";
  for (int i = 0; i < kLamps; ++i)
    text += "Shape \"trianglemesh\" \"point3 P\" [" + std::to_string(i + 2) +
            " 0 0  1 0 0  0 1 0] \"integer indices\" [0 1 2]\n";
  v1::EditLightsRequest request = request_for(load("lamps.pbrt", text));
  for (int i = 1; i <= kLamps; ++i)
    change(request, i)->mutable_placement()->mutable_shift_m()->set_y(0.25);
  expect_stops([&](grpc::ClientContext* c) {
    v1::EditLightsResponse response;
    return service_->scenes.EditLights(c, request, &response);
  });
}

// A remark of each portal counts the shapes outdoors.
TEST_F(Stopped, LoadsOfManyPortals) {
  std::string text = "WorldBegin\nObjectBegin \"a\"\n";
  for (int i = 0; i < 1000; ++i) text += "Shape \"sphere\"\n";
  text += "ObjectEnd\n";
  for (int i = 0; i < 1000; ++i) text += "ObjectInstance \"a\"\n";
  for (int i = 0; i < 1000; ++i)
    text += "LightSource \"infinite\" \"point3 portal\" [-1 -1 0  1 -1 0  1 1 0  -1 1 0]\n";
  v1::LoadSceneRequest request;
  request.set_path(write("portals.pbrt", text));
  expect_stops([&](grpc::ClientContext* c) {
    v1::LoadSceneResponse response;
    return service_->scenes.LoadScene(c, request, &response);
  });
}

TEST_F(Stopped, LoadsOfManyShapes) {
  std::string text = "WorldBegin\n";
  for (int i = 0; i < 200000; ++i) text += "Shape \"sphere\"\n";
  v1::LoadSceneRequest request;
  request.set_path(write("shapes.pbrt", text));
  expect_stops([&](grpc::ClientContext* c) {
    v1::LoadSceneResponse response;
    return service_->scenes.LoadScene(c, request, &response);
  });
}

}  // namespace
}  // namespace lucerna::testing
