#include "server/rpc/messages/convert.h"

#include "server/queries/queries.h"
#include "server/visibility/smooth_remarks.h"

namespace lucerna::rpc {

void set_summary(const StoredScene& stored, v1::SceneSummary* out) {
  const Scene& scene = *stored.scene;
  out->set_scene_id(scene.id());
  out->set_path(stored.path);
  out->set_shapes(scene.geometry().shape_count());
  out->set_primitives(scene.geometry().primitive_count());
  out->set_lights(scene.lights().size());
  set(scene.origin(), out->mutable_origin_m());
  set(scene.origin() + scene.sphere().center_m, out->mutable_center_m());
  out->set_radius_m(scene.sphere().radius_m);
  out->set_image_width(static_cast<std::uint32_t>(scene.camera().width()));
  out->set_image_height(static_cast<std::uint32_t>(scene.camera().height()));
  const RenderHints& hints = scene.report().hints;
  if (hints.samples_per_pixel) {
    out->set_samples_per_pixel(static_cast<std::uint32_t>(*hints.samples_per_pixel));
  }
  if (const auto bounces = hinted_bounces(scene)) out->set_bounces(*bounces);
  out->set_shutter_open_s(hints.shutter_open_s);
  out->set_shutter_close_s(hints.shutter_close_s);
  if (const Motion* motion = scene.camera().motion()) {
    set_motion(*motion, scene.origin(), out->mutable_camera_motion());
  }
  out->set_film_scale(scene.camera().film_scale());
  if (const Camera& camera = scene.camera(); camera.is_cropped()) {
    v1::FilmCrop* const crop = out->mutable_film_crop();
    crop->set_x(static_cast<std::uint32_t>(camera.crop().x0));
    crop->set_y(static_cast<std::uint32_t>(camera.crop().y0));
    crop->set_film_width(static_cast<std::uint32_t>(camera.film_width()));
    crop->set_film_height(static_cast<std::uint32_t>(camera.film_height()));
  }
  if (const LevelFactors& factors = scene.report().level_factors; factors != LevelFactors()) {
    v1::LevelFactors* const levels = out->mutable_level_factors();
    levels->set_lamps(factors.lamps);
    levels->set_suns(factors.suns);
    levels->set_emission(factors.emission);
  }
  out->set_bytes(scene.bytes());
  if (scene.loaded() != nullptr) {
    out->set_loaded_scene_id(scene.loaded()->id());
    std::uint64_t edited = scene.edits().added.size();
    for (const auto& [id, change] : scene.edits().changes)
      edited += scene.edits().added.contains(id) ? 0 : 1;
    out->set_edited_lights(edited);
    out->set_own_bytes(scene.own_bytes());
  }
  out->set_leased_s(stored.leased_s);
}

void add_remarks(const Scene& scene, google::protobuf::RepeatedPtrField<v1::Remark>* out) {
  const auto add = [&](const Remark& remark) {
    v1::Remark* r = out->Add();
    r->set_file(remark.where.file);
    r->set_line(static_cast<std::uint32_t>(remark.where.line));
    r->set_column(static_cast<std::uint32_t>(remark.where.column));
    r->set_what(remark.what);
    r->set_instead(remark.instead);
    r->set_count(remark.count);
    for (const SourceLocation& place : remark.more) {
      v1::RemarkPlace* p = r->add_more_places();
      p->set_file(place.file);
      p->set_line(static_cast<std::uint32_t>(place.line));
      p->set_column(static_cast<std::uint32_t>(place.column));
    }
  };
  for (const Remark& remark : scene.report().remarks) add(remark);
  if (const auto remark = remark_on_smooth_surfaces(scene)) add(*remark);
}

void set_contents(const Scene& scene, v1::SceneContents* out) {
  const SceneContents& contents = scene.report().contents;
  const auto add = [](const std::vector<KindCount>& counts, auto* to) {
    for (const KindCount& kind : counts) {
      v1::KindCount* k = to->Add();
      k->set_kind(kind.kind);
      k->set_count(kind.count);
      k->set_primitives(kind.primitives);
      k->set_without_area(kind.without_area);
    }
  };
  add(contents.shapes, out->mutable_shapes());
  add(contents.materials, out->mutable_materials());
  add(contents.textures, out->mutable_textures());
  out->set_objects(contents.objects);
  out->set_instances(contents.instances);
  out->set_camera(contents.camera);
  for (const TexturePicture& picture : contents.pictures) {
    v1::TexturePicture* p = out->add_pictures();
    p->set_name(picture.name);
    p->set_width(static_cast<std::uint32_t>(picture.width));
    p->set_height(static_cast<std::uint32_t>(picture.height));
    p->set_bytes(picture.bytes);
  }
}

void set_parts(const Scene& scene, v1::GetSceneResponse* out) {
  for (const ScenePart& part : scene.parts()) {
    v1::ScenePart* p = out->add_parts();
    p->set_name(part.name);
    p->set_bytes(part.bytes);
    p->set_build_ms(part.build_ms);
    p->set_why(part.why);
  }
  for (const Asset& asset : scene.report().assets) {
    v1::NamedAsset* a = out->add_assets();
    a->set_name(asset.name);
    a->set_sha256(asset.sha256);
    a->set_size_bytes(asset.bytes);
  }
}

}  // namespace lucerna::rpc
