#include "tests/reliability/long_calls.h"

#include <fmt/core.h>

#include <fstream>
#include <memory>

#include "lucerna/v1/lighting.pb.h"
#include "lucerna/v1/render.pb.h"
#include "lucerna/v1/scene.pb.h"

namespace lucerna::reliability {
namespace {

/// A direction for each item, downwards in general.
void add_directions(google::protobuf::RepeatedField<float>* to) {
  to->Reserve(3 * kManyItems);
  for (int i = 0; i < kManyItems; ++i) {
    to->Add(0.001F * static_cast<float>(i % 701) - 0.35F);
    to->Add(0.001F * static_cast<float>(i % 577) - 0.29F);
    to->Add(-1);
  }
}

Message made(const std::string& method, const google::protobuf::MessageLite& request) {
  return make_message(method, request);
}

/// Writes a file of the scene root.
void write_file(const SceneFiles& files, const std::string& name, const std::string& text) {
  std::ofstream(files.folder() + "/" + name, std::ios::binary) << text;
}

/// A light of 2 `edge`^2 triangles, and one with a power that differs.
std::string mesh_light(int edge, std::uint64_t number) {
  std::string positions, indices;
  for (int i = 0; i <= edge; ++i)
    for (int k = 0; k <= edge; ++k) {
      positions += fmt::format("{} {} 0 ", i, k);
      if (i == edge || k == edge) continue;
      const int a = i * (edge + 1) + k, b = a + edge + 1;
      indices += fmt::format("{} {} {} {} {} {} ", a, b, a + 1, a + 1, b, b + 1);
    }
  return fmt::format(
      "WorldBegin\nLightSource \"point\" \"float scale\" {}\n"
      "AreaLightSource \"diffuse\"\n"
      "Shape \"trianglemesh\" \"point3 P\" [{}] \"integer indices\" [{}]\n",
      number, positions, indices);
}

/// One triangle at many places.
std::string gltf_nodes(int count, std::uint64_t number) {
  std::string nodes, numbers;
  for (int i = 0; i < count; ++i) {
    const char* comma = i == 0 ? "" : ",";
    nodes += fmt::format("{}{{\"mesh\":0,\"translation\":[{},0,{}]}}", comma, i, number);
    numbers += fmt::format("{}{}", comma, i);
  }
  return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[)" + numbers +
         R"(]}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],)"
         R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3",)"
         R"("min":[0,0,0],"max":[1,1,0]}],"bufferViews":[{"buffer":0,"byteLength":36}],)"
         R"("buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,)"
         R"(AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],"nodes":[)" +
         nodes + "]}";
}

/// A subdivision of `levels` steps that emits.
std::string subdivision(int levels, std::uint64_t number) {
  return fmt::format(
      "WorldBegin\nLightSource \"point\" \"float scale\" {}\nAreaLightSource \"diffuse\"\n"
      "Shape \"loopsubdiv\" \"integer levels\" {} \"point3 P\" [0 0 0 1 0 0 0 1 0 0 0 1]"
      " \"integer indices\" [0 2 1 0 1 3 1 2 3 0 3 2]\n",
      number, levels);
}

template <typename Request>
Request about(const Subject& subject) {
  Request request;
  request.set_scene_id(subject.scene());
  return request;
}

}  // namespace

std::vector<LongCall> long_calls(const Subject& subject, const SceneFiles& files) {
  std::vector<LongCall> calls;
  const auto add = [&](const std::string& method, const google::protobuf::MessageLite& request) {
    calls.push_back({method, [message = made(method, request)] { return message; }});
  };
  const v1::Points points = points_above(kManyItems);
  // The disk, the only light with a surface, is the last.
  v1::ListLightsRequest lights;
  lights.set_scene_id(subject.scene());
  const auto listed = value_of(subject.client().list_lights(lights), "ListLights").lights();
  const std::uint64_t disk = listed.rbegin()->id();

  calls.push_back({"LightingService/EstimateIrradiance",
                   [message = subject.irradiance(60'000, 4096)] { return message; }});
  {
    auto request = about<v1::SampleLiRequest>(subject);
    *request.mutable_receivers() = points_above(4);
    request.set_test_visibility(true);
    request.mutable_seed()->set_seed(1);
    request.mutable_accuracy()->mutable_target_error()->set_relative(1e-9);
    request.mutable_accuracy()->mutable_target_error()->set_max_samples(65536);
    add("LightingService/SampleLi", request);
  }
  {
    auto request = about<v1::PdfLiRequest>(subject);
    *request.mutable_receivers() = points;
    request.set_light_id(disk);
    add_directions(request.mutable_wi());
    add("LightingService/PdfLi", request);
  }
  {
    auto request = about<v1::SampleLeRequest>(subject);
    request.set_count(kManyItems);
    add("LightingService/SampleLe", request);
  }
  {
    auto request = about<v1::PdfLeRequest>(subject);
    *request.mutable_points() = points;
    request.set_light_id(disk);
    add_directions(request.mutable_directions());
    add("LightingService/PdfLe", request);
  }
  {
    auto request = about<v1::LeRequest>(subject);
    *request.mutable_points() = points;
    add_directions(request.mutable_directions());
    add("LightingService/Le", request);
  }
  {
    auto request = about<v1::TestVisibilityRequest>(subject);
    *request.mutable_rays()->mutable_from() = points;
    add_directions(request.mutable_rays()->mutable_directions());
    add("LightingService/TestVisibility", request);
  }
  {
    auto request = about<v1::EstimatePowerRequest>(subject);
    request.set_method(v1::EstimatePowerRequest::METHOD_SAMPLED);
    request.mutable_accuracy()->set_samples(1 << 20);
    add("LightingService/EstimatePower", request);
  }
  calls.push_back(
      {"RenderService/RenderTile", [message = subject.tile(256, 1 << 14)] { return message; }});
  {
    auto request = about<v1::RenderImageRequest>(subject);
    request.mutable_accuracy()->set_samples(1 << 14);
    add("RenderService/RenderImage", request);
  }
  const auto next = std::make_shared<std::uint64_t>(1000);
  calls.push_back({"SceneService/LoadScene", [&files, next] {
                     v1::LoadSceneRequest request;
                     request.set_path(files.write(++*next));
                     return made("SceneService/LoadScene", request);
                   }});
  const auto add_load = [&](const std::string& what, const std::string& name, auto text) {
    calls.push_back({"SceneService/LoadScene, " + what, [&files, next, name, text] {
                       write_file(files, name, text(++*next));
                       v1::LoadSceneRequest request;
                       request.set_path(name);
                       return made("SceneService/LoadScene", request);
                     }});
  };
  add_load("a light of 500 000 triangles", "light.pbrt",
           [](std::uint64_t number) { return mesh_light(500, number); });
  add_load("a subdivision into 4 million triangles", "loop.pbrt",
           [](std::uint64_t number) { return subdivision(10, number); });
  add_load("100 000 nodes", "nodes.gltf",
           [](std::uint64_t number) { return gltf_nodes(100'000, number); });
  calls.push_back({"SceneService/EditLights", [id = subject.scene(), disk, next] {
                     v1::EditLightsRequest request;
                     request.set_scene_id(id);
                     // To move a light with a surface, the server builds its geometry again.
                     v1::LightChange& change = *request.add_edits()->mutable_change();
                     change.set_light_id(disk);
                     change.mutable_placement()->mutable_shift_m()->set_x(
                         1e-4 * static_cast<double>(++*next));
                     return made("SceneService/EditLights", request);
                   }});
  {
    v1::UploadAssetRequest header, chunk;
    header.mutable_header()->set_sha256(std::string(32, 'x'));
    header.mutable_header()->set_size_bytes(std::uint64_t{2} << 30);
    chunk.set_chunk(std::string(1 << 20, 'y'));
    calls.push_back({"SceneService/UploadAsset",
                     [message = made("SceneService/UploadAsset", header)] { return message; },
                     made("", chunk).bytes});
  }
  return calls;
}

}  // namespace lucerna::reliability
