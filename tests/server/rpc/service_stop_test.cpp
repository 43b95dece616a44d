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

  void expect_loads_stop(const v1::LoadSceneRequest& request) {
    expect_stops([&](grpc::ClientContext* c) {
      v1::LoadSceneResponse response;
      return service_->scenes.LoadScene(c, request, &response);
    });
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
  auto request = about<v1::EditLightsRequest>(load("placed.pbrt", placed("")));
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
  auto request = about<v1::EditLightsRequest>(load("lamps.pbrt", text));
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
  expect_loads_stop(request);
}

TEST_F(Stopped, LoadsOfManyShapes) {
  std::string text = "WorldBegin\n";
  for (int i = 0; i < 200000; ++i) text += "Shape \"sphere\"\n";
  v1::LoadSceneRequest request;
  request.set_path(write("shapes.pbrt", text));
  expect_loads_stop(request);
}

// Each of these is one long loop after another.
TEST_F(Stopped, LoadsOfOneLargeLight) {
  constexpr int kSide = 300;
  std::string positions, indices;
  for (int i = 0; i <= kSide; ++i)
    for (int k = 0; k <= kSide; ++k) {
      positions += std::to_string(i) + " " + std::to_string(k) + " 0 ";
      if (i == kSide || k == kSide) continue;
      const int at = i * (kSide + 1) + k;
      for (const int corner : {at, at + 1, at + kSide + 1}) indices += std::to_string(corner) + " ";
    }
  v1::LoadSceneRequest request;
  request.set_path(
      write("light.pbrt",
            "WorldBegin\nAreaLightSource \"diffuse\"\nShape \"trianglemesh\" \"point3 P\" [" +
                positions + "] \"integer indices\" [" + indices + "]\n"));
  expect_loads_stop(request);
}

TEST_F(Stopped, LoadsOfASubdivision) {
  v1::LoadSceneRequest request;
  request.set_path(write(
      "loop.pbrt",
      "WorldBegin\nAreaLightSource \"diffuse\"\nShape \"loopsubdiv\" \"integer levels\" 8"
      " \"point3 P\" [0 0 0 1 0 0 0 1 0 0 0 1] \"integer indices\" [0 2 1 0 1 3 1 2 3 0 3 2]\n"));
  expect_loads_stop(request);
}

TEST_F(Stopped, LoadsOfManyNodes) {
  constexpr int kNodes = 50000;
  std::string nodes, numbers;
  for (int i = 0; i < kNodes; ++i) {
    nodes += (i == 0 ? "" : ",") + std::string("{\"mesh\":0,\"translation\":[") +
             std::to_string(i) + ",0,0]}";
    numbers += (i == 0 ? "" : ",") + std::to_string(i);
  }
  v1::LoadSceneRequest request;
  request.set_path(
      write("nodes.gltf",
            R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[)" + numbers +
                R"(]}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],)"
                R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3",)"
                R"("min":[0,0,0],"max":[1,1,0]}],"bufferViews":[{"buffer":0,"byteLength":36}],)"
                R"("buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,)"
                R"(AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],"nodes":[)" +
                nodes + "]}"));
  expect_loads_stop(request);
}

TEST_F(Stopped, LoadsOfALongSpectrum) {
  std::string samples;
  for (int i = 0; i < 100000; ++i) samples += std::to_string(360 + 400.0 * i / 100000) + " 1 ";
  v1::LoadSceneRequest request;
  request.set_path(write("spectrum.pbrt",
                         "WorldBegin\nLightSource \"point\" \"spectrum I\" [" + samples + "]\n"));
  expect_loads_stop(request);
}

TEST_F(Stopped, Queries) {
  const std::string scene = load("placed.pbrt", placed(""));
  constexpr int kPoints = 60000;
  v1::Points points;
  for (int i = 0; i < 3 * kPoints; ++i) points.add_offsets_m(0.001F * static_cast<float>(i % 701));
  auto irradiance = about<v1::EstimateIrradianceRequest>(scene);
  *irradiance.mutable_receivers() = points;
  for (int i = 0; i < kPoints; ++i)
    for (const float n : {0.0F, 0.0F, 1.0F}) irradiance.add_normals(n);
  irradiance.mutable_accuracy()->set_samples(4096);
  irradiance.mutable_accuracy()->set_closed_forms(v1::CLOSED_FORMS_OFF);
  expect_stops([&](grpc::ClientContext* c) {
    v1::EstimateIrradianceResponse response;
    return service_->lighting.EstimateIrradiance(c, irradiance, &response);
  });
  auto power = about<v1::EstimatePowerRequest>(scene);
  power.set_method(v1::EstimatePowerRequest::METHOD_SAMPLED);
  power.mutable_accuracy()->set_samples(1 << 20);
  expect_stops([&](grpc::ClientContext* c) {
    v1::EstimatePowerResponse response;
    return service_->lighting.EstimatePower(c, power, &response);
  });
}

}  // namespace
}  // namespace lucerna::testing
