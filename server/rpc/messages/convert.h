// Lights and scenes as messages.
#pragma once

#include <string>

#include "lights/maths/rgb.h"
#include "lights/maths/vec.h"
#include "lucerna/v1/light.pb.h"
#include "lucerna/v1/scene.pb.h"
#include "server/store/scene_store.h"

namespace lucerna::rpc {

inline void set(const Vec3& v, v1::Vector3* out) {
  out->set_x(v.x);
  out->set_y(v.y);
  out->set_z(v.z);
}

inline void set(const Rgb& c, v1::Rgb* out) {
  out->set_r(c.r);
  out->set_g(c.g);
  out->set_b(c.b);
}

/// `motion` has positions about `origin_m`.
void set_motion(const Motion& motion, const Vec3& origin_m, v1::Motion* out);
/// `light`: an index below the number of lights.
void set_light(const Scene& scene, std::uint32_t light, v1::Light* out);
/// Unit of the light's flux where fields are in lm; empty: lm.
std::string power_unit(const Scene& scene, std::uint32_t light);
/// Of LoadScene or EditLights.
template <typename Response>
void set_loaded(const LoadedScene& loaded, Response* out) {
  for (const MissingAsset& asset : loaded.missing) {
    v1::NamedAsset* missing = out->add_missing();
    missing->set_name(asset.name);
    missing->set_sha256(asset.digest);
  }
  if (loaded.stored.scene == nullptr) return;
  out->set_scene_id(loaded.stored.scene->id());
  out->set_already_loaded(loaded.already_loaded);
  out->set_lease_id(loaded.lease.id);
  out->set_lease_s(loaded.lease.seconds);
}
void set_summary(const StoredScene& stored, v1::SceneSummary* out);
void add_remarks(const Scene& scene, google::protobuf::RepeatedPtrField<v1::Remark>* out);
void set_parts(const Scene& scene, v1::GetSceneResponse* out);
void set_contents(const Scene& scene, v1::SceneContents* out);

}  // namespace lucerna::rpc
