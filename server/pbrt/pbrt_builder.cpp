#include "server/pbrt/pbrt_builder.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <utility>

#include "lights/maths/stop_poll.h"
#include "server/pbrt/pbrt_images.h"

namespace lucerna::pbrt {
namespace {

// Each open block takes half a kilobyte, and a copy of the lists of attributes.
constexpr std::size_t kMostOpenBlocks = 256;
constexpr std::size_t kMostAttributes = 64;  // of one target

// About the memory of a node in a map, and of a parameter with one short value.
constexpr std::size_t kNodeBytes = 96;
constexpr std::size_t kParameterBytes = sizeof(Parameter) + 128;

/// Products of large transforms can have entries that are infinite or not a number.
bool is_in_range(const Transform& t) {
  if (!(t == t)) return false;  // not a number, in the matrix or its inverse
  for (const auto& row : t.matrix())
    for (const double entry : row)
      if (!std::isfinite(entry)) return false;
  return true;
}

}  // namespace

void Builder::require_world(const char* directive, const FilePosition& place) const {
  if (!in_world_) fail(place, fmt::format("{} is not allowed before WorldBegin", directive));
}

void Builder::require_before_world(const std::string& directive, const FilePosition& place) const {
  if (in_world_) fail(place, fmt::format("{} is not allowed after WorldBegin", directive));
}

void Builder::set_transform(const Transform& transform) {
  state_.world_from_object.change(state_.start_active, state_.end_active,
                                  [&](const Transform&) { return transform; });
}

void Builder::concatenate(const Transform& transform) {
  state_.world_from_object.change(state_.start_active, state_.end_active,
                                  [&](const Transform& t) { return t * transform; });
}

void Builder::coordinate_system(const std::string& name) {
  const bool is_new = coordinate_systems_.insert_or_assign(name, state_.world_from_object).second;
  // Its transforms can be such that nothing else holds.
  const std::size_t transforms = state_.world_from_object.moves() ? 2 : 1;
  if (is_new) context_.count(transforms * sizeof(Transform) + kNodeBytes + name.size());
}

void Builder::coord_sys_transform(const std::string& name, const FilePosition& place) {
  const auto found = coordinate_systems_.find(name);
  if (found == coordinate_systems_.end()) {
    context_.remark(place, fmt::format("coordinate system \"{}\" is not defined", printable(name)),
                    "the transform stays unchanged");
    return;
  }
  state_.world_from_object = found->second;
}

void Builder::active_transform(bool start, bool end) {
  state_.start_active = start;
  state_.end_active = end;
}

const Transform& Builder::still_transform(const char* directive, const FilePosition& place) {
  const MovingTransform& moving = state_.world_from_object;
  if (moving.moves())
    context_.remark(place, fmt::format("motion of {} is not modelled", directive),
                    "its position at the start");
  return moving.start();
}

std::shared_ptr<const Motion> Builder::motion(const char* directive, const MovingTransform& moving,
                                              const FilePosition& place) {
  if (!is_in_range(moving.start()) || !is_in_range(moving.end()))
    fail(place,
         fmt::format("{}: the product of the transforms exceeds the range of a double", directive));
  if (!moving.moves()) return nullptr;
  // Many shapes may have the same motion.
  if (last_motion_ && moving.is_same_object_as(last_moving_)) return last_motion_;
  const std::array<KeyTransform, 2> frames{{{start_s_, moving.start()}, {end_s_, moving.end()}}};
  absl::StatusOr<Motion> motion = Motion::create(frames);
  if (!motion.ok())
    fail(place, fmt::format("{}: {}", directive, std::string(motion.status().message())));
  context_.count(sizeof(Motion) + motion->bytes());
  last_moving_ = moving;
  last_motion_ = std::make_shared<const Motion>(*std::move(motion));
  return last_motion_;
}

void Builder::setting(const std::string& directive, const std::string& type, Parameters params,
                      const FilePosition& place) {
  require_before_world(directive, place);
  ParameterSet setting(type, std::move(params), {}, place);
  if (directive == "Camera") {
    // The current transform maps world to camera.  The motion is that of the camera in the world.
    MovingTransform world_from_camera = state_.world_from_object;
    world_from_camera.change(true, true, [](const Transform& t) { return t.inverse(); });
    settings_.camera_from_world = state_.world_from_object.start();
    settings_.camera_motion = motion("Camera", world_from_camera, place);
    coordinate_systems_["camera"] = world_from_camera;
    settings_.camera = std::move(setting);
    context_.scene.surrounding_medium = state_.media.outside;
  } else if (directive == "Film") {
    settings_.film = std::move(setting);
  } else if (directive == "Integrator") {
    settings_.integrator = std::move(setting);
  } else if (directive == "Sampler") {
    settings_.sampler = std::move(setting);
  } else if (directive == "PixelFilter") {
    settings_.filter = std::move(setting);
  }  // Accelerator: no effect on the result.
}

void Builder::world_begin(const FilePosition& place) {
  require_before_world("WorldBegin", place);
  in_world_ = true;
  state_.world_from_object = {};
  active_transform(true, true);
  coordinate_systems_["world"] = {};
  apply(context_, settings_);
}

void Builder::transform_times(double start_s, double end_s, const FilePosition& place) {
  require_before_world("TransformTimes", place);
  start_s_ = start_s;
  end_s_ = end_s;
}

void Builder::attribute_begin(const FilePosition& place) {
  require_world("AttributeBegin", place);
  open("AttributeBegin", place);
}

void Builder::open(std::string_view opener, const FilePosition& place) {
  if (opened_.size() == kMostOpenBlocks)
    fail(place, fmt::format("blocks are open {} deep, allowed: at most {}", opened_.size() + 1,
                            kMostOpenBlocks));
  opened_.push_back({opener, place, state_});
}

void Builder::count_materials(std::size_t before, std::size_t parameters) {
  const std::size_t added = materials_.size() - before;
  context_.count(added * (Materials::bytes_of_one() + kNodeBytes) + parameters * kParameterBytes);
}

void Builder::close(std::string_view opener, const char* directive, const FilePosition& place) {
  if (opened_.empty() || opened_.back().opener == "Import")
    fail(place, fmt::format("{} has nothing to close{}", directive,
                            opened_.empty() ? "" : " in this imported file"));
  if (opened_.back().opener != opener)
    fail(place, fmt::format("{} does not match the {} of {}", directive, opened_.back().opener,
                            to_string(opened_.back().place)));
  state_ = std::move(opened_.back().saved);
  opened_.pop_back();
}

void Builder::attribute_end(const FilePosition& place) {
  require_world("AttributeEnd", place);
  close("AttributeBegin", "AttributeEnd", place);
}

void Builder::attribute(const std::string& target, Parameters params, const FilePosition& place) {
  Parameters* attributes = nullptr;
  if (target == "shape") attributes = &state_.shape_attributes;
  if (target == "light") attributes = &state_.light_attributes;
  if (target == "material") attributes = &state_.material_attributes;
  if (target == "texture") attributes = &state_.texture_attributes;
  if (target == "medium") attributes = &state_.medium_attributes;
  if (attributes == nullptr)
    fail(place, fmt::format("unknown attribute target \"{}\", expected one of shape light material "
                            "medium texture",
                            printable(target)));
  for (auto& parameter : params) {
    // A later parameter overrides an earlier one of the same name and type.
    std::erase_if(*attributes, [&](const auto& earlier) {
      return earlier->name == parameter->name && earlier->type == parameter->type;
    });
    if (attributes->size() == kMostAttributes)
      fail(parameter->place, fmt::format("more than {} attributes of \"{}\", allowed: at most {}",
                                         kMostAttributes, target, kMostAttributes));
    attributes->push_back(std::move(parameter));
  }
}

void Builder::reverse_orientation(const FilePosition& place) {
  require_world("ReverseOrientation", place);
  state_.reverse_orientation = !state_.reverse_orientation;
}

void Builder::material(const std::string& type, Parameters params, const FilePosition& place) {
  require_world("Material", place);
  const std::size_t before = materials_.size(), parameters = params.size();
  state_.material =
      materials_.add(ParameterSet(type, std::move(params), state_.material_attributes, place));
  count_materials(before, parameters);
}

void Builder::make_named_material(const std::string& name, Parameters params,
                                  const FilePosition& place) {
  require_world("MakeNamedMaterial", place);
  const std::size_t before = materials_.size(), parameters = params.size();
  materials_.make_named(name,
                        ParameterSet("", std::move(params), state_.material_attributes, place));
  count_materials(before, parameters);
}

void Builder::named_material(const std::string& name, const FilePosition& place) {
  require_world("NamedMaterial", place);
  const std::size_t before = materials_.size();
  state_.material = materials_.named(name, place);
  count_materials(before, 0);
}

void Builder::make_named_medium(const std::string& name, Parameters params,
                                const FilePosition& place) {
  media_.make(context_, name, ParameterSet("", std::move(params), state_.medium_attributes, place));
}

void Builder::medium_interface(const std::string& inside, const std::string& outside,
                               const FilePosition& place) {
  state_.media = {media_.named(context_, inside, place), media_.named(context_, outside, place)};
}

void Builder::texture(const std::string& name, const std::string& kind, const std::string& type,
                      Parameters params, const FilePosition& place) {
  require_world("Texture", place);
  materials_.textures().make(
      context_, name, kind, ParameterSet(type, std::move(params), state_.texture_attributes, place),
      still_transform("a texture", place));
}

void Builder::shape(const std::string& type, Parameters params, const FilePosition& place) {
  require_world("Shape", place);
  ParameterSet set(type, std::move(params), state_.shape_attributes, place);
  // A moving shape in an object would need one motion for each instance.
  const Transform& world_from_object =
      open_object_ ? still_transform("a shape within an object definition", place)
                   : state_.world_from_object.start();
  const NumberValue alpha = materials_.textures().alpha(set);
  const bool with_uv = (state_.area_light && !open_object_ && needs_uv(*state_.area_light)) ||
                       materials_.may_need_uv(state_.material) || !alpha.is_constant();
  auto geometry =
      make_geometry(context_, {set, world_from_object, state_.reverse_orientation, with_uv});
  if (!geometry) return;
  ShapeDescription shape;
  if (!open_object_) shape.motion = motion("Shape", place);
  shape.material = state_.material;
  shape.has_uv = materials_.may_need_uv(state_.material) || !alpha.is_constant();
  shape.where = location(place);
  if (state_.media.inside != state_.media.outside) shape.media = state_.media;
  if (state_.area_light && open_object_) {
    context_.remark(place, "an area light within an object definition", "the shape emits nothing");
  } else if (state_.area_light) {
    shape.emission = make_emission(context_, *state_.area_light, *geometry, place,
                                   state_.world_from_object.start().swaps_handedness());
  }
  shape.alpha = alpha;
  if (shape.emission && materials_.textures().hides_only(set)) {
    shape.emission->is_unseen = true;
    shape.alpha = {1};
  }
  shape.geometry = *std::move(geometry);
  if (absl::Status status = context_.meter.add(shape); !status.ok()) fail(place, status);
  auto& shapes =
      open_object_ ? context_.scene.objects[*open_object_].shapes : context_.scene.shapes;
  shapes.push_back(std::move(shape));
}

void Builder::light_source(const std::string& type, Parameters params, const FilePosition& place) {
  require_world("LightSource", place);
  const ParameterSet set(type, std::move(params), state_.light_attributes, place);
  LightDescription light;
  try {
    light = make_light(context_, set, state_.world_from_object.start());
  } catch (const LightLeftOut&) {
    return;
  }
  light.motion = motion("LightSource", place);
  if (light.motion && std::holds_alternative<PortalLightParams>(light.params))
    context_.remark(place, "a moving light with a portal, which pbrt-v4 keeps in place",
                    "the portal moves with the light");
  context_.scene.lights.push_back(std::move(light));
}

void Builder::area_light_source(const std::string& type, Parameters params,
                                const FilePosition& place) {
  require_world("AreaLightSource", place);
  state_.area_light =
      std::make_shared<const ParameterSet>(type, std::move(params), state_.light_attributes, place);
}

void Builder::object_begin(const std::string& name, const FilePosition& place) {
  require_world("ObjectBegin", place);
  if (open_object_) fail(place, "ObjectBegin within an object definition");
  auto& objects = context_.scene.objects;
  if (!objects_.try_emplace(name, static_cast<std::uint32_t>(objects.size())).second)
    fail(place, fmt::format("object \"{}\" was defined before", printable(name)));
  open("ObjectBegin", place);
  open_object_ = objects.size();
  objects.push_back({printable(name), {}});
}

void Builder::object_end(const FilePosition& place) {
  require_world("ObjectEnd", place);
  close("ObjectBegin", "ObjectEnd", place);
  open_object_.reset();
}

void Builder::object_instance(const std::string& name, const FilePosition& place) {
  require_world("ObjectInstance", place);
  if (open_object_) fail(place, "ObjectInstance within an object definition");
  context_.scene.instances.push_back(
      {0, state_.world_from_object.start(), motion("ObjectInstance", place), location(place)});
  if (const auto found = objects_.find(name); found != objects_.end()) {
    context_.scene.instances.back().object = found->second;
    return;
  }
  undefined_objects_.push_back({context_.scene.instances.size() - 1, name, place});
  context_.count(sizeof(Use) + name.size());
}

void Builder::import_begin(const FilePosition& place) {
  require_world("Import", place);
  open("Import", place);
}

void Builder::import_end() {
  if (opened_.back().opener != "Import")
    fail(opened_.back().place,
         fmt::format("{} is not closed in this imported file", opened_.back().opener));
  state_ = std::move(opened_.back().saved);
  opened_.pop_back();
}

void Builder::resolve_materials(ShapeList& shapes) {
  // Within the list, since a second list would double its memory.
  auto end = shapes.begin();
  const auto keep = [&](ShapeDescription& shape) {
    if (&shape != &*end) *end = std::move(shape);
    ++end;
  };
  StopPoll poll;
  for (ShapeDescription& shape : shapes) {
    poll();
    const FilePosition place{&shape.where.file, shape.where.line, shape.where.column};
    if (const auto index = materials_.resolve(context_, shape.material)) {
      shape.material = *index;
      keep(shape);
      continue;
    }
    if (shape.emission)
      context_.remark(place, "a light whose shape has the material \"interface\"",
                      "emits nothing, as in pbrt-v4");
    shape.emission.reset();
    shape.is_interface = true;
    if (shape.media)
      keep(shape);
    else
      context_.remark(place, "a shape with the material \"interface\" that bounds no medium",
                      "left out");
  }
  shapes.erase(end, shapes.end());
}

void Builder::finish(const FilePosition& end) {
  if (!in_world_) fail(end, "expected WorldBegin, found the end of the file");
  if (!opened_.empty())
    fail(opened_.back().place, fmt::format("{} is not closed", opened_.back().opener));
  StopPoll poll;
  for (const Use& use : undefined_objects_) {
    poll();
    const auto found = objects_.find(use.name);
    if (found == objects_.end())
      fail(use.place,
           fmt::format("no object \"{}\" is defined in this scene", printable(use.name)));
    context_.scene.instances[use.instance].object = found->second;
  }
  media_.finish();
  resolve_materials(context_.scene.shapes);
  for (ObjectDefinition& object : context_.scene.objects) resolve_materials(object.shapes);
}

}  // namespace lucerna::pbrt
