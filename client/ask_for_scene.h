// What a job has to know of the scene before it can say what its pieces are.  Not installed.
#pragma once

#include <memory>
#include <utility>

#include "lucerna/client/job.h"

namespace lucerna::client {

/// One piece: what a server says of the scene.
class AskForScene final : public Work {
 public:
  std::size_t size() const override { return 1; }
  void start(std::size_t, const Client& client, const std::string& scene_id,
             const CallOptions& options, Done done) override {
    v1::GetSceneRequest request;
    request.set_scene_id(scene_id);
    client.get_scene(request, options, answer_as<v1::GetSceneResponse>(std::move(done)));
  }
  absl::Status accept(std::size_t, Result result) override {
    summary = static_cast<v1::GetSceneResponse&>(*result).summary();
    return absl::OkStatus();
  }

  v1::SceneSummary summary;
};

}  // namespace lucerna::client
