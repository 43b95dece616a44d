// Lights and scenes as messages.
#pragma once

#include "lucerna/v1/light.pb.h"
#include "lucerna/v1/scene.pb.h"
#include "server/scene_store.h"

namespace lucerna::rpc {

/// Requires an index below the number of lights.
void set_light(const Scene& scene, std::uint32_t light, v1::Light* out);
void set_summary(const StoredScene& stored, v1::SceneSummary* out);
void add_remarks(const Scene& scene, google::protobuf::RepeatedPtrField<v1::Remark>* out);
void set_parts(const Scene& scene, v1::GetSceneResponse* out);

}  // namespace lucerna::rpc
