#include "server/scene/scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "lights/maths/stop_poll.h"
#include "proto/common/sha256.h"
#include "proto/common/status_macros.h"
#include "server/runtime/denormals.h"
#include "server/scene/scene_builder.h"
#include "server/scene/create_light.h"

namespace lucerna {

std::string scene_id(const std::vector<Asset>& assets, const std::vector<HalvedPicture>& halved,
                     const LevelFactors& factors) {
  std::string text;
  for (const Asset& a : assets) {
    // Lengths come first, so that different lists of assets give different bytes.
    text += fmt::format("{}:{}{}:", a.name.size(), a.name, a.sha256.size());
    text += a.sha256;
  }
  for (const HalvedPicture& h : halved)
    text += fmt::format("halved:{}:{}{}x{}:", h.name.size(), h.name, h.kept_width, h.kept_height);
  // Shortest decimal numbers: different factors give different texts.
  if (factors != LevelFactors())
    text += fmt::format("levels:{}:{}:{}:", factors.lamps, factors.suns, factors.emission);
  return hexadecimal(sha256(text));
}

absl::StatusOr<std::shared_ptr<const Scene>> Scene::Builder::build(const std::string& isa) {
  const DenormalsAreZero denormals;
  LUCERNA_RETURN_IF_ERROR(check_references());
  report_halved_pictures();
  simplify_media();
  scene_->contents_ = contents_of(in_);
  LUCERNA_RETURN_IF_ERROR(place());
  LUCERNA_RETURN_IF_ERROR(report_portals());
  LUCERNA_RETURN_IF_ERROR(count_lights());
  LUCERNA_RETURN_IF_ERROR(build_lights());
  LUCERNA_RETURN_IF_ERROR(build_geometry(isa));
  LUCERNA_RETURN_IF_ERROR(prepare_choice());
  scene_->id_ = scene_id(in_.assets, halved_, in_.level_factors);
  scene_->camera_ = Camera(in_.camera, in_.film, scene_->origin_);
  scene_->camera_description_ = in_.camera;
  scene_->film_ = in_.film;
  scene_->hints_ = in_.hints;
  scene_->level_factors_ = in_.level_factors;
  scene_->remarks_ = std::move(in_.remarks);
  scene_->assets_ = std::move(in_.assets);
  return scene_;
}

void Scene::Builder::report_halved_pictures() {
  halved_ = in_.textures.halved();
  for (const HalvedPicture& h : halved_) {
    Remark& remark = in_.remarks.emplace_back();
    remark.where.file = h.name;
    remark.what = fmt::format("a picture of {} x {} texels exceeds the memory of textures", h.width,
                              h.height);
    remark.instead =
        fmt::format("{} x {}, each the mean of several texels", h.kept_width, h.kept_height);
  }
}

absl::Status Scene::Builder::check_references() const {
  const auto check = [&](const ShapeDescription& s) -> absl::Status {
    const auto is_medium = [&](std::int32_t medium) {
      return medium >= -1 && medium < static_cast<std::int32_t>(in_.media.size());
    };
    if (s.media && !(is_medium(s.media->inside) && is_medium(s.media->outside)))
      return located(absl::InvalidArgumentError(
                         fmt::format("media number {} and {}, allowed: -1 for none, less than {}",
                                     s.media->inside, s.media->outside, in_.media.size())),
                     s.where);
    if (s.is_interface || s.material < in_.materials.size()) return absl::OkStatus();
    return located(
        absl::InvalidArgumentError(fmt::format("material number {}, allowed: less than {}",
                                               s.material, in_.materials.size())),
        s.where);
  };
  StopPoll poll;
  for (const auto& s : in_.shapes) {
    poll();
    LUCERNA_RETURN_IF_ERROR(check(s));
  }
  for (const auto& o : in_.objects)
    for (const auto& s : o.shapes) {
      poll();
      LUCERNA_RETURN_IF_ERROR(check(s));
    }
  for (const auto& i : in_.instances) {
    poll();
    if (i.object >= in_.objects.size())
      return absl::InvalidArgumentError(
          fmt::format("object number {}, allowed: less than {}", i.object, in_.objects.size()));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::shared_ptr<const Scene>> Scene::build(SceneDescription description,
                                                          const std::string& isa,
                                                          std::stop_token stop,
                                                          LoadBudget* budget) {
  return Builder(description, std::move(stop), budget).build(isa);
}

absl::StatusOr<std::shared_ptr<const Scene>> Scene::build_moved(SceneDescription description,
                                                                const MovedSurfaces& moved,
                                                                const std::string& isa,
                                                                std::stop_token stop,
                                                                LoadBudget* budget) {
  LUCERNA_RETURN_IF_ERROR(move_surfaces(moved, description));
  Builder builder(description, std::move(stop), budget);
  builder.note_moved(moved);
  return builder.build(isa);
}

std::optional<std::uint32_t> Scene::find_light(std::uint64_t id) const {
  // Ids ascend; without edits there are no gaps.
  const auto found = std::ranges::lower_bound(lights_, id, {}, &SceneLight::id);
  if (found == lights_.end() || found->id != id) return std::nullopt;
  return static_cast<std::uint32_t>(found - lights_.begin());
}

std::int32_t Scene::surface_number(const SceneLight& light) const {
  if (light.id <= base_->lights_.size()) return static_cast<std::int32_t>(light.id - 1);
  const auto added = placed_->lights.find(light.id);
  return added != placed_->lights.end() ? added->second.number : kNoSurface;
}

std::uint64_t Scene::shape_count() const {
  std::uint64_t sum = placed_->surfaces.surfaces.size();
  for (const SurfaceTable& o : base_->object_surfaces_) sum += o.surfaces.size();
  return sum;
}

std::uint64_t Scene::primitive_count() const {
  std::uint64_t sum = placed_->accelerator->scene().primitives();
  for (std::uint32_t i = 0; i < base_->object_surfaces_.size(); ++i)
    sum += placed_->accelerator->object(i).primitives();
  return sum;
}

std::vector<ScenePart> PlacedSurfaces::reports() const {
  std::vector<ScenePart> all = parts;
  attached_parts.for_each([&](const AttachedPart& attached) {
    if (auto part = attached.report()) all.push_back(*std::move(part));
  });
  return all;
}

std::uint64_t PlacedSurfaces::bytes() const {
  std::uint64_t sum = 0;
  for (const ScenePart& part : parts) sum += part.bytes;
  attached_parts.for_each([&](const AttachedPart& attached) { sum += attached.bytes(); });
  return sum;
}

std::vector<ScenePart> Scene::parts() const {
  std::vector<ScenePart> all = shared_parts();
  all.insert(all.end(), parts_.begin(), parts_.end());
  if (light_selector_)
    if (auto tree = light_selector_->tree_part().report()) all.push_back(*std::move(tree));
  if (auto choice = revised_selector_.report()) all.push_back(*std::move(choice));
  if (auto areas = area_selector_.report()) all.push_back(*std::move(areas));
  const auto attached_from = static_cast<std::ptrdiff_t>(all.size());
  attached_.for_each([&](const AttachedPart& attached) {
    if (auto part = attached.report()) all.push_back(*std::move(part));
  });
  if (has_own_surfaces())
    for (ScenePart& part : placed_->reports()) all.push_back(std::move(part));
  // Sorted by name, so that the order does not depend on the order of first uses.
  std::sort(all.begin() + attached_from, all.end(),
            [](const ScenePart& a, const ScenePart& b) { return a.name > b.name; });
  return all;
}

std::vector<ScenePart> Scene::shared_parts() const {
  std::vector<ScenePart> shared;
  if (loaded_ == nullptr) return shared;
  for (const ScenePart& part : loaded_->parts_)
    if (!part.is_of_lights) shared.push_back(part);
  return shared;
}

std::uint64_t Scene::bytes() const {
  std::uint64_t sum = own_bytes();
  for (const ScenePart& part : shared_parts()) sum += part.bytes;
  return sum;
}

std::uint64_t Scene::own_bytes() const {
  std::uint64_t sum = area_selector_.bytes() + revised_selector_.bytes();
  if (light_selector_) sum += light_selector_->tree_part().bytes();
  attached_.for_each([&](const AttachedPart& attached) { sum += attached.bytes(); });
  for (const ScenePart& part : parts_) sum += part.bytes;
  return has_own_surfaces() ? sum + placed_->bytes() : sum;
}

const LightSelector& Scene::revised_selector() const {
  return revised_selector_.get(
      [this] {
        auto made = std::make_unique<LightSelector>(selector_items(*this, false));
        made->build_tree_if_used();
        return std::unique_ptr<const LightSelector>(std::move(made));
      },
      [this](const LightSelector&) {
        return fmt::format("{} lights to choose from", lights_.size());
      });
}

const LightSelector& Scene::area_selector() const {
  return area_selector_.get(
      [this] {
        auto made = std::make_unique<LightSelector>(selector_items(*this, true));
        made->build_tree_if_used();
        return std::unique_ptr<const LightSelector>(std::move(made));
      },
      [](const LightSelector&) { return "a query sampled lights other than delta lights"; });
}

std::string Scene::isa() const { return placed_->accelerator->isa(); }

namespace {

// kAll visits each light once, so each is equally likely.
LightSelection selection_of_one(LightSelection how) {
  return how == LightSelection::kAll ? LightSelection::kUniform : how;
}

}  // namespace

std::optional<LightChoice> choose_light(const Scene& scene, LightSelection how,
                                        const Receiver& receiver, double u) {
  if (scene.lights().size() == 1) return LightChoice{0, 1};
  return scene.light_selector().choose(selection_of_one(how), receiver, u);
}

double choice_probability(const Scene& scene, LightSelection how, const Receiver& receiver,
                          std::uint32_t light) {
  if (scene.lights().size() == 1) return 1;
  return scene.light_selector().probability(selection_of_one(how), receiver, light);
}

LightChoice choose_emitter(const Scene& scene, double u) {
  if (scene.lights().size() == 1) return {0, 1};
  return scene.light_selector().by_flux().choose(u);
}

}  // namespace lucerna
