#include "server/pbrt/materials.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "server/pbrt/spectra.h"

namespace lucerna::pbrt {
namespace {

bool is_one_of(std::string_view word, std::initializer_list<std::string_view> words) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

bool is_interface(std::string_view type) { return is_one_of(type, {"interface", "none", ""}); }

bool is_material(std::string_view type) {
  return is_interface(type) ||
         is_one_of(type, {"diffuse", "coateddiffuse", "diffusetransmission", "conductor",
                          "coatedconductor", "dielectric", "thindielectric", "hair", "measured",
                          "subsurface", "mix"});
}

void check_type(const std::string& type, const Place& place) {
  if (!is_material(type))
    fail(place, fmt::format("unknown material \"{}\", expected one of diffuse coateddiffuse "
                            "diffusetransmission conductor coatedconductor dielectric "
                            "thindielectric hair measured subsurface mix interface",
                            printable(type)));
}

/// The colour for a message; one number for greys.
std::string short_text(const Rgb<double>& c) {
  return c.r == c.g && c.g == c.b ? fmt::format("{:.4g}", c.r) : text(c);
}

}  // namespace

Materials::Materials() { add("diffuse", {}, {}); }

std::uint32_t Materials::add(const std::string& type, ParameterSet params, const Place& place) {
  check_type(type, place);
  Material material;
  material.type = type;
  material.params = std::move(params);
  material.place = place;
  material.defined = true;
  materials_.push_back(std::move(material));
  return static_cast<std::uint32_t>(materials_.size() - 1);
}

std::uint32_t Materials::named(const std::string& name, const Place& place) {
  const auto [it, added] = names_.try_emplace(name, static_cast<std::uint32_t>(materials_.size()));
  if (added) {
    Material material;
    material.name = name;
    material.place = place;
    materials_.push_back(std::move(material));
  }
  return it->second;
}

void Materials::make_named(const std::string& name, ParameterSet params, const Place& place) {
  Material& material = materials_[named(name, place)];
  if (material.defined)
    fail(place, fmt::format("material \"{}\" is already defined, at {}", printable(name),
                            to_string(material.place)));
  material.type = params.string("type", "");
  if (material.type.empty())
    fail(place, fmt::format("material \"{}\" lacks \"string type\"", printable(name)));
  check_type(material.type, place);
  material.params = std::move(params);
  material.place = place;
  material.defined = true;
}

void Materials::make_texture(Context& context, const std::string& name, const std::string& kind,
                             const std::string& type, const ParameterSet& params,
                             const Place& place) {
  if (kind != "float" && kind != "spectrum")
    fail(place, fmt::format("texture \"{}\" has type \"{}\", expected \"float\" or \"spectrum\"",
                            printable(name), printable(kind)));
  const auto [it, added] = textures_.try_emplace(kind + " " + name, Rgb<double>(0.5));
  if (!added)
    fail(place, fmt::format("{} texture \"{}\" is already defined", kind, printable(name)));
  if (!is_one_of(type, {"constant", "scale", "mix", "directionmix", "bilerp", "imagemap",
                        "checkerboard", "dots", "fbm", "wrinkled", "windy", "marble", "ptex"}))
    fail(place, fmt::format("unknown texture class \"{}\"", printable(type)));
  const auto amount = [&](const char* parameter, double otherwise) {
    const Parameter* given = params.find(parameter, {"float", "texture"});
    if (given == nullptr) return otherwise;
    if (given->type == "float") return given->numbers.front();
    const auto found = textures_.find("float " + given->strings.front());
    if (found == textures_.end())
      fail(given->place, fmt::format("float texture \"{}\" is not defined before this place",
                                     printable(given->strings.front())));
    return found->second.r;
  };
  Rgb<double> value(0.5);
  // Float textures are not reflectances and may exceed 1.
  const auto part = [&](const char* parameter, double otherwise) {
    return kind == "float" ? Rgb<double>(amount(parameter, otherwise))
                           : texture_or_value(context, params, parameter, Rgb<double>(otherwise));
  };
  if (type == "constant") {
    value = part("value", 1);
  } else if (type == "scale") {
    value = part("tex", 1) * amount("scale", 1);
  } else if (type == "mix") {
    const double t = amount("amount", 0.5);
    value = part("tex1", 0) * (1 - t) + part("tex2", 1) * t;
  } else {
    context.remark(place, fmt::format("texture \"{}\" ({}) is not modelled", printable(name), type),
                   "constant 0.5");
    textures_[kind + " " + name] = value;
    return;
  }
  params.remark_unused(context, fmt::format("texture \"{}\"", printable(name)));
  textures_[kind + " " + name] = value;
}

Rgb<double> Materials::texture_or_value(Context& context, const ParameterSet& params,
                                        const std::string& name,
                                        const Rgb<double>& otherwise) const {
  const Parameter* parameter = params.find(name, {"rgb", "spectrum", "texture", "float"});
  if (parameter == nullptr) return otherwise;
  if (parameter->type != "texture") return reflectance(context, *parameter);
  for (const char* kind : {"spectrum ", "float "}) {
    const auto found = textures_.find(kind + parameter->strings.front());
    if (found != textures_.end()) return found->second;
  }
  fail(parameter->place, fmt::format("texture \"{}\" is not defined in this scene",
                                     printable(parameter->strings.front())));
}

Rgb<double> Materials::diffuse_of(Context& context, const Material& material) {
  const auto reflectance_of = [&](double otherwise) {
    const Rgb<double> value =
        texture_or_value(context, material.params, "reflectance", Rgb<double>(otherwise));
    const Rgb<double> clamped{std::clamp(value.r, 0.0, 1.0), std::clamp(value.g, 0.0, 1.0),
                              std::clamp(value.b, 0.0, 1.0)};
    if (clamped != value)
      context.remark(material.place,
                     fmt::format("{} is not a valid reflectance", short_text(value)),
                     fmt::format("clamped to {}", short_text(clamped)));
    return clamped;
  };
  const std::string owner = material.name.empty()
                                ? fmt::format("material \"{}\"", material.type)
                                : fmt::format("material \"{}\"", printable(material.name));
  for (const char* name : {"displacement", "normalmap"})
    if (const Parameter* map = material.params.find(name, {"texture", "string", "float"}))
      context.remark(map->place, fmt::format("\"{}\" of {} is not modelled", name, owner),
                     "the surface without it");
  if (material.type == "diffuse") {
    const Rgb<double> value = reflectance_of(0.5);
    material.params.ignore({"type"});
    material.params.remark_unused(context, owner);
    return value;
  }
  if (material.type == "mix") {
    const Parameter* parts = material.params.find("materials", {"string"});
    if (parts == nullptr) fail(material.place, "material \"mix\" lacks \"string materials\"");
    const auto part = names_.find(parts->strings.front());
    if (part == names_.end())
      fail(parts->place,
           fmt::format("material \"{}\" is not defined", printable(parts->strings.front())));
    const auto index = resolve(context, part->second);
    const Rgb<double> value =
        index ? context.scene.materials[*index].reflectance : Rgb<double>(0.5);
    context.remark(material.place, "material \"mix\" is not modelled",
                   fmt::format("its first part, diffuse, reflectance {}", short_text(value)));
    return value;
  }
  // Default reflectances of pbrt-v4; 0.5 for materials without one.
  const Rgb<double> value = reflectance_of(material.type == "diffusetransmission" ? 0.25 : 0.5);
  context.remark(material.place, fmt::format("material \"{}\" is not modelled", material.type),
                 fmt::format("diffuse, reflectance {}", short_text(value)));
  return value;
}

std::optional<std::uint32_t> Materials::resolve(Context& context, std::uint32_t reference) {
  Material& material = materials_[reference];
  if (!material.defined)
    fail(material.place,
         fmt::format("material \"{}\" is not defined in this scene", printable(material.name)));
  if (material.resolved) return material.index;
  constexpr int kMaxNesting = 64;
  if (nesting_ == kMaxNesting)
    fail(material.place, fmt::format("material \"{}\" is a mix of itself, or of mixes more than {} "
                                     "deep",
                                     printable(material.name), kMaxNesting));
  if (!is_interface(material.type)) {
    ++nesting_;
    const Rgb<double> value = diffuse_of(context, material);
    --nesting_;
    context.scene.materials.push_back({value});
    material.index = static_cast<std::uint32_t>(context.scene.materials.size() - 1);
  }
  material.resolved = true;
  return material.index;
}

}  // namespace lucerna::pbrt
