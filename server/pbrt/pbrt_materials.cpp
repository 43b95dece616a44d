#include "server/pbrt/pbrt_materials.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "server/pbrt/metals.h"
#include "server/pbrt/older_pbrt.h"
#include "server/pbrt/pbrt_images.h"
#include "server/pbrt/pbrt_spectra.h"

namespace lucerna::pbrt {
namespace {

bool is_interface(std::string_view type) { return is_one_of(type, {"interface", "none", ""}); }

/// `type` as a string of static lifetime.  Fails if it is not a known type.
std::string_view known_type(const std::string& type, const FilePosition& place) {
  static constexpr std::array<std::string_view, 13> kTypes{"diffuse",
                                                           "coateddiffuse",
                                                           "diffusetransmission",
                                                           "conductor",
                                                           "coatedconductor",
                                                           "dielectric",
                                                           "thindielectric",
                                                           "hair",
                                                           "measured",
                                                           "subsurface",
                                                           "mix",
                                                           "interface",
                                                           "none"};
  if (type.empty()) return {};
  const auto found = std::ranges::find(kTypes, type);
  if (found == kTypes.end())
    fail(place, fmt::format("unknown material \"{}\", expected one of diffuse coateddiffuse "
                            "diffusetransmission conductor coatedconductor dielectric "
                            "thindielectric hair measured subsurface mix interface{}",
                            printable(type), hint_of_older_pbrt("Material", type)));
  return *found;
}

/// Reads the parameters of one material.
class Reader {
 public:
  Reader(LoadState& context, const TextureTable& textures, const ParameterSet& params)
      : context_(context), textures_(textures), params_(params) {}

  ColourValue reflectance(const char* name, double otherwise) const {
    return textures_.reflectance(context_, params_, name, {Rgb(otherwise)});
  }

  /// A number that is at least `least`.
  NumberValue number(const std::string& name, double otherwise, double least) const {
    const NumberValue value = textures_.number(params_, name, otherwise);
    if (value.is_constant() && !(value.constant >= least))
      fail(params_.place_of({name}),
           fmt::format("\"float {}\" = {}, allowed: at least {}", name, value.constant, least));
    return value;
  }

  Roughness roughness(const std::string& prefix) const {
    const auto one = [&](const char* name, const NumberValue& otherwise) {
      const std::string whole = prefix + name;
      return params_.find(whole, {"float", "texture"}) == nullptr ? otherwise : number(whole, 0, 0);
    };
    const NumberValue both = one("roughness", {0});
    return {one("uroughness", both), one("vroughness", both),
            params_.boolean("remaproughness", true)};
  }

  /// The index of a dielectric: a number, a texture, or a spectrum at one wavelength.
  NumberValue index(const std::string& name) const {
    const Parameter* p = params_.find(name, {"float", "texture", "spectrum"});
    if (p == nullptr) return {1.5};
    NumberValue value{1.5};
    if (p->type == "spectrum") {
      value.constant = index_at_sodium(context_, *p);
    } else {
      value = textures_.number(params_, name, 1.5);
    }
    constexpr double kLeast = 1e-3, kMost = 1e3;
    if (value.is_constant() && !(value.constant >= kLeast && value.constant <= kMost))
      fail(p->place, fmt::format("\"{} {}\" = {}, allowed: {} to {}", p->type, name, value.constant,
                                 kLeast, kMost));
    return value;
  }

  MetalParams metal(const std::string& prefix) const {
    MetalParams m;
    m.roughness = roughness(prefix);
    const Parameter* eta = params_.find(prefix + "eta", {"spectrum", "rgb", "texture"});
    const Parameter* k = params_.find(prefix + "k", {"spectrum", "rgb", "texture"});
    if (params_.find("reflectance", {"rgb", "spectrum", "texture", "float"}) != nullptr) {
      if (eta != nullptr || k != nullptr)
        fail((eta != nullptr ? eta : k)->place,
             fmt::format("\"{}{}\" and \"reflectance\" are both given, allowed: one of them",
                         prefix, eta != nullptr ? "eta" : "k"));
      m.reflectance = reflectance("reflectance", 0.5);
      return m;
    }
    if (const auto of_spectra = metal_index(context_, eta, k)) {
      m.eta.constant = of_spectra->eta;
      m.k.constant = of_spectra->k;
      return m;
    }
    m.eta = index_part(eta, *metal_index(context_, nullptr, nullptr), true);
    m.k = index_part(k, *metal_index(context_, nullptr, nullptr), false);
    return m;
  }

  CoatParams coat(const std::string& prefix) const {
    CoatParams c;
    c.eta = index(prefix + "eta");
    c.thickness = number("thickness", 0.01, 0);
    c.roughness = roughness(prefix);
    if (const Parameter* albedo = params_.find("albedo", {"float", "rgb", "spectrum", "texture"}))
      context_.remark(albedo->place, "scattering within a coat (\"albedo\") is not modelled",
                      "a coat that absorbs");
    params_.ignore({"g", "maxdepth", "nsamples"});
    return c;
  }

 private:
  /// Half of an index, of which one part is an rgb or a texture.
  ColourValue index_part(const Parameter* p, const MetalIndex& otherwise, bool is_eta) const {
    if (p == nullptr) return {is_eta ? otherwise.eta : otherwise.k};
    if (p->type == "texture") return textures_.texture(*p);
    if (p->type == "spectrum") {
      const auto both = metal_index(context_, is_eta ? p : nullptr, is_eta ? nullptr : p);
      return {is_eta ? both->eta : both->k};
    }
    return {not_negative_rgb(context_, *p, RgbConversion::White::kAdapted)};
  }

  LoadState& context_;
  const TextureTable& textures_;
  const ParameterSet& params_;
};

}  // namespace

Materials::Materials() { add(ParameterSet("diffuse", {}, {}, {})); }

void Materials::define(const std::string& type, ParameterSet params, Entry& entry) {
  entry.type = known_type(type, params.place());
  entry.params = std::move(params);
  entry.defined = true;
}

std::uint32_t Materials::add(ParameterSet params) {
  Entry entry;
  const std::string type = params.type();
  define(type, std::move(params), entry);
  materials_.push_back(std::move(entry));
  return static_cast<std::uint32_t>(materials_.size() - 1);
}

std::uint32_t Materials::named(const std::string& name, const FilePosition& place) {
  const auto [it, added] = names_.try_emplace(name, static_cast<std::uint32_t>(materials_.size()));
  if (added) {
    Entry entry;
    entry.name = &it->first;
    entry.params = ParameterSet({}, {}, {}, place);
    materials_.push_back(std::move(entry));
  }
  return it->second;
}

void Materials::make_named(const std::string& name, ParameterSet params) {
  const FilePosition place = params.place();
  Entry& entry = materials_[named(name, place)];
  if (entry.defined)
    fail(place, fmt::format("material \"{}\" is already defined, at {}", printable(name),
                            to_string(entry.params.place())));
  const std::string type = params.string("type", "");
  if (type.empty())
    fail(place, fmt::format("material \"{}\" lacks \"string type\"", printable(name)));
  define(type, std::move(params), entry);
}

bool Materials::may_need_uv(std::uint32_t reference) const {
  const Entry& entry = materials_[reference];
  if (!entry.defined || entry.type == "mix") return true;
  return entry.params.has_textures() || entry.params.find("normalmap", {"string"}) != nullptr ||
         entry.params.find("uroughness", {"float", "texture"}) != nullptr ||
         entry.params.find("conductor.uroughness", {"float", "texture"}) != nullptr ||
         entry.params.find("interface.uroughness", {"float", "texture"}) != nullptr;
}

MixParams Materials::mix_of(LoadState& context, const Entry& entry) {
  const Parameter* parts = entry.params.find("materials", {"string"});
  if (parts == nullptr)
    fail(entry.params.place(),
         fmt::format("material \"mix\" lacks \"string materials\"{}",
                     entry.params.find("namedmaterial1", {"string"}) != nullptr ? kIsOfPbrt3 : ""));
  if (parts->strings().size() != 2)
    fail(parts->place,
         fmt::format("\"string materials\" has {} names, allowed: 2", parts->strings().size()));
  MixParams mix;
  for (std::size_t i = 0; i < 2; ++i) {
    const auto part = names_.find(parts->strings()[i]);
    if (part == names_.end())
      fail(parts->place,
           fmt::format("material \"{}\" is not defined", printable(parts->strings()[i])));
    const auto index = resolve(context, part->second);
    if (!index)
      fail(parts->place, fmt::format("material \"{}\" is an interface, which cannot be mixed",
                                     printable(parts->strings()[i])));
    mix.materials.at(i) = *index;
  }
  mix.amount = textures_.number(entry.params, "amount", 0.5);
  return mix;
}

Material Materials::material_of(LoadState& context, const Entry& entry) {
  const Reader read(context, textures_, entry.params);
  const std::string owner = entry.name == nullptr
                                ? fmt::format("material \"{}\"", entry.type)
                                : fmt::format("material \"{}\"", printable(*entry.name));
  Material m;
  if (entry.type == "diffuse") {
    m.params = DiffuseParams{read.reflectance("reflectance", 0.5)};
  } else if (entry.type == "diffusetransmission") {
    m.params = DiffuseTransmissionParams{read.reflectance("reflectance", 0.25),
                                         read.reflectance("transmittance", 0.25),
                                         read.number("scale", 1, 0).constant};
  } else if (entry.type == "conductor") {
    m.params = read.metal("");
  } else if (entry.type == "dielectric") {
    m.params = DielectricParams{read.index("eta"), read.roughness("")};
  } else if (entry.type == "thindielectric") {
    m.params = ThinDielectricParams{read.index("eta")};
  } else if (entry.type == "coateddiffuse") {
    m.params = CoatedDiffuseParams{read.reflectance("reflectance", 0.5), read.coat("")};
  } else if (entry.type == "coatedconductor") {
    m.params = CoatedMetalParams{read.metal("conductor."), read.coat("interface.")};
  } else if (entry.type == "mix") {
    m.params = mix_of(context, entry);
  } else {
    const ColourValue value = read.reflectance("reflectance", 0.5);
    context.remark(entry.params.place(), fmt::format("material \"{}\" is not modelled", entry.type),
                   "diffuse, with its reflectance or 0.5");
    m.params = DiffuseParams{value};
    return m;
  }
  if (const Parameter* map = entry.params.find("normalmap", {"string"}))
    if (auto texels = read_texels(context, *map, kData, "no normal map"))
      m.normal_map = context.scene.textures.add(ImageTexture{.image = std::move(texels)});
  if (const Parameter* map = entry.params.find("displacement", {"texture", "float"})) {
    const NumberValue height = textures_.number(entry.params, "displacement", 0);
    if (m.normal_map >= 0)
      context.remark(map->place, fmt::format("{} has a \"normalmap\" too", owner),
                     "the \"displacement\" is not used, as in pbrt-v4");
    else if (!height.is_constant())
      m.bumps = height.texture;
  }
  entry.params.ignore({"type"});
  entry.params.remark_unused(context, owner);
  return m;
}

std::optional<std::uint32_t> Materials::resolve(LoadState& context, std::uint32_t reference) {
  Entry& entry = materials_[reference];
  const FilePosition place = entry.params.place();
  if (!entry.defined)
    fail(place,
         fmt::format("material \"{}\" is not defined in this scene", printable(*entry.name)));
  if (entry.resolved) return entry.index;
  constexpr int kMaxNesting = 64;
  if (nesting_ == kMaxNesting)
    fail(place, fmt::format("material \"{}\" is a mix of itself, or of mixes more than {} deep",
                            printable(*entry.name), kMaxNesting));
  if (is_interface(entry.type)) return std::nullopt;
  ++nesting_;
  Material made = material_of(context, entry);
  --nesting_;
  context.scene.materials.push_back(std::move(made));
  entry.index = static_cast<std::uint32_t>(context.scene.materials.size() - 1);
  entry.params = ParameterSet({}, {}, {}, place);
  constexpr std::size_t kMaterialsPerPoll = 256;
  if (context.scene.materials.size() % kMaterialsPerPoll == 0) context.poll();
  entry.resolved = true;
  return entry.index;
}

}  // namespace lucerna::pbrt
