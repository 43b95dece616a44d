#include "server/gltf/gltf_materials.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "lights/maths/level_validation.h"

namespace lucerna::gltf {
namespace {

/// Puts KHR_texture_transform before the flip of v: translation * rotation * scale.
void apply_transform(const View& transform, MaterialEmission& emission) {
  const std::vector<double> offset = transform.numbers("offset", {0, 0});
  const std::vector<double> scale = transform.numbers("scale", {1, 1});
  const double angle = transform.number("rotation", 0);
  const double c = std::cos(angle), s = std::sin(angle);
  emission.is_transformed = true;
  emission.uv[0][0] = c * scale[0];
  emission.uv[0][1] = s * scale[1];
  emission.uv[0][2] = offset[0];
  emission.uv[1][0] = s * scale[0];
  emission.uv[1][1] = -c * scale[1];
  emission.uv[1][2] = 1 - offset[1];
  emission.uv_set = static_cast<int>(
      transform.integer("texCoord", static_cast<std::uint64_t>(emission.uv_set), 0, 1000));
}

/// A texture of a material that is applied: in pbrMetallicRoughness, in the material, or in an
/// extension.
struct Slot {
  std::string_view parent, key;
};
constexpr std::string_view kPbr = "pbrMetallicRoughness",
                           kTransmission = "KHR_materials_transmission",
                           kCoat = "KHR_materials_clearcoat", kSpecular = "KHR_materials_specular",
                           kAnisotropy = "KHR_materials_anisotropy", kIor = "KHR_materials_ior",
                           kUnlit = "KHR_materials_unlit",
                           kStrength = "KHR_materials_emissive_strength",
                           kGlossiness = "KHR_materials_pbrSpecularGlossiness";
constexpr Slot kApplied[] = {{kPbr, "baseColorTexture"},     {kPbr, "metallicRoughnessTexture"},
                             {"", "normalTexture"},          {kTransmission, "transmissionTexture"},
                             {kCoat, "clearcoatTexture"},    {kCoat, "clearcoatRoughnessTexture"},
                             {kSpecular, "specularTexture"}, {kSpecular, "specularColorTexture"},
                             {kGlossiness, "diffuseTexture"}};
constexpr Slot kLeftOut[] = {{"", "occlusionTexture"},
                             {kCoat, "clearcoatNormalTexture"},
                             {kAnisotropy, "anisotropyTexture"},
                             {kGlossiness, "specularGlossinessTexture"}};

/// Where a material has its base colour: in pbrMetallicRoughness, or in specular-glossiness if it
/// has that alone.
struct BaseColour {
  std::optional<View> parent;
  bool is_glossiness = false;

  std::string_view texture() const { return is_glossiness ? "diffuseTexture" : "baseColorTexture"; }
  /// RGBA.
  std::vector<double> factor() const {
    const std::vector<double> white{1, 1, 1, 1};
    return parent ? parent->require_object().numbers(
                        is_glossiness ? "diffuseFactor" : "baseColorFactor", white, kUnit)
                  : white;
  }
};

BaseColour base_colour(const View& material) {
  if (auto pbr = material.find(kPbr)) return {std::move(pbr)};
  auto glossiness = material.extension(kGlossiness);
  const bool is_given = glossiness.has_value();
  return {std::move(glossiness), is_given};
}

/// Reads the file of a texture, which may not be uploaded yet.
void read_picture(const Document& document, const View& info) {
  check_texture(document, info);
  if (const auto source = document.picture_of(document.texture_of(info)))
    document.read(document.root().at("images")[*source]);
}

std::optional<View> texture_at(const View& material, const Slot& slot) {
  if (slot.parent.empty()) return material.find(slot.key);
  const auto parent = slot.parent == kPbr ? material.find(kPbr) : material.extension(slot.parent);
  return parent ? parent->require_object().find(slot.key) : std::nullopt;
}

/// Whether this is a pane of clear glass.  Then direct light passes it, and both of its sides
/// reflect by Fresnel's equations.
bool is_pane(const GltfSurfaceParams& s) {
  const auto is = [](const auto& value, const auto& constant) {
    return value.is_constant() && value.constant == constant;
  };
  const Rgb white(1);
  return is(s.transmission, 1.0) && is(s.base, white) && s.surface.is_constant() &&
         s.surface.constant.g == 0 && s.surface.constant.b == 0 && is(s.specular, 1.0) &&
         is(s.specular_colour, white) && is(s.coat, 0.0) && s.ior >= 1;
}

/// Of the extensions of a material.
void set_layers(const View& material, TextureSet& textures, GltfSurfaceParams& s) {
  if (const auto ior = material.extension(kIor)) {
    s.ior = ior->number("ior", 1.5, kNotNegative);
    if (s.ior != 0 && s.ior < 1)
      ior->at("ior").fail(fmt::format("found {}, allowed: 0, or 1 or more", s.ior));
  }
  if (const auto specular = material.extension(kSpecular)) {
    s.specular = textures.number(specular, "specularTexture", PictureKind::kAlpha,
                                 specular->number("specularFactor", 1, kUnit));
    const auto c = specular->numbers("specularColorFactor", {1, 1, 1}, kNotNegative);
    s.specular_colour =
        textures.colour(specular, "specularColorTexture", PictureKind::kColour, {c[0], c[1], c[2]});
  }
  if (const auto transmission = material.extension(kTransmission))
    s.transmission = textures.number(transmission, "transmissionTexture", PictureKind::kData,
                                     transmission->number("transmissionFactor", 0, kUnit));
  if (const auto coat = material.extension(kCoat)) {
    s.coat = textures.number(coat, "clearcoatTexture", PictureKind::kData,
                             coat->number("clearcoatFactor", 0, kUnit));
    s.coat_roughness = textures.colour(coat, "clearcoatRoughnessTexture", PictureKind::kData,
                                       Rgb(coat->number("clearcoatRoughnessFactor", 0, kUnit)));
  }
  if (const auto anisotropy = material.extension(kAnisotropy)) {
    s.anisotropy = anisotropy->number("anisotropyStrength", 0, kUnit);
    s.anisotropy_turn_rad = anisotropy->number("anisotropyRotation", 0);
  }
}

/// [glTF2, 3.9, appendix B]
Material scattering(const View& material, TextureSet& textures, const Rgb& base, bool has_colours) {
  const auto pbr = material.find(kPbr);
  GltfSurfaceParams s;
  const BaseColour colour = base_colour(material);
  s.base = textures.colour(colour.parent, colour.texture(), PictureKind::kColour, base);
  if (has_colours) {
    Textures& all = material.context().scene.textures;
    const std::int32_t colours = all.add(VertexColourTexture{});
    s.base.texture = all.add(ScaleTexture{s.base, {{}, colours}});
  }
  double metallic = pbr ? pbr->number("metallicFactor", 1, kUnit) : 1;
  double roughness = pbr ? pbr->number("roughnessFactor", 1, kUnit) : 1;
  if (colour.is_glossiness) {
    metallic = 0;
    roughness = 1 - colour.parent->number("glossinessFactor", 1, kUnit);
    // Without an index of refraction, the reflectance along the normal is 0.04 of this colour.
    const auto f = colour.parent->numbers("specularFactor", {1, 1, 1}, kUnit);
    s.specular_colour = {Rgb(f[0], f[1], f[2]) / 0.04};
  }
  Material result{.params = DiffuseParams{s.base}, .second_axis = FrameAlong::kV};
  if (const auto normal = material.find("normalTexture")) {
    result.normal_map =
        textures.colour(material, "normalTexture", PictureKind::kNormal, Rgb(1)).texture;
    result.normal_scale = normal->number("scale", 1);
  }
  if (material.extension(kUnlit)) return result;
  s.surface = textures.colour(pbr, "metallicRoughnessTexture", PictureKind::kData,
                              Rgb(1, roughness, metallic));
  set_layers(material, textures, s);
  const auto is_zero = [](const NumberValue& v) { return v.is_constant() && v.constant == 0; };
  const bool is_diffuse = metallic == 0 && is_zero(s.specular) && !s.transmits() && is_zero(s.coat);
  if (is_pane(s) && result.normal_map < 0)
    result.params = ThinDielectricParams{{s.ior}};
  else if (!is_diffuse)
    result.params = std::move(s);
  return result;
}

NumberValue alpha_of(const View& material, TextureSet& textures) {
  const std::string mode = material.text("alphaMode", "OPAQUE");
  if (mode != "OPAQUE" && mode != "MASK" && mode != "BLEND")
    material.at("alphaMode")
        .fail(fmt::format("found \"{}\", allowed: OPAQUE, MASK, BLEND", printable(mode)));
  const double cut_off = material.number("alphaCutoff", 0.5, kNotNegative);
  if (mode == "OPAQUE") return {1};
  const BaseColour base = base_colour(material);
  NumberValue value =
      textures.number(base.parent, base.texture(), PictureKind::kAlpha, base.factor()[3]);
  if (mode == "BLEND") return value;
  if (value.is_constant()) return {value.constant >= cut_off ? 1.0 : 0.0};
  return {1, material.context().scene.textures.add(CutOffTexture{{{}, value.texture}, cut_off})};
}

}  // namespace

bool is_material_extension(std::string_view name) {
  for (const std::string_view known :
       {kTransmission, kCoat, kSpecular, kAnisotropy, kIor, kUnlit, kStrength})
    if (name == known) return true;
  return name == "KHR_texture_transform" || name == "EXT_texture_webp";
}

void Materials::read_pictures() {
  for (std::size_t i = 0; i < document_.count("materials"); ++i) {
    const View material = document_.root().at("materials")[i].require_object();
    emission(material);
    for (const Slot& slot : kApplied)
      if (const auto info = texture_at(material, slot)) read_picture(document_, *info);
  }
}

/// Sets the picture of `emission`; false if it was not uploaded yet, or cannot be decoded.
bool Materials::apply_texture(const View& info, MaterialEmission& emission) {
  const View texture = document_.texture_of(info);
  emission.uv_set = static_cast<int>(info.integer("texCoord", 0, 0, 1000));
  if (const auto transform = info.extension("KHR_texture_transform"))
    apply_transform(*transform, emission);
  const Sampling sampling = sampling_of(document_, texture);
  emission.wrap_u = sampling.wrap_s;
  emission.wrap_v = sampling.wrap_t;
  Picture picture;
  picture.filter = sampling.filter;
  const auto source = document_.picture_of(texture);
  if (!source) {
    texture.context().remark(texture.pointer(), "a texture without a picture in \"source\"",
                             "white");
    return true;
  }
  picture.image = document_.image(*source);
  if (picture.image == nullptr) return false;
  picture.name = document_.picture_name(*source);
  emission.picture = std::move(picture);
  return true;
}

std::shared_ptr<const MaterialEmission> Materials::emission(const View& material) {
  std::vector<double> factor(3, 0.0);
  const auto given_factor = material.find("emissiveFactor");
  if (given_factor && given_factor->json().is_array() && given_factor->size() == 4) {
    factor.resize(4);
    material.context().remark(given_factor->pointer(), "4 numbers, which glTF limits to 3",
                              "the first 3");
  }
  factor = material.numbers("emissiveFactor", factor, kNotNegative);
  factor.resize(3);
  if (*std::ranges::max_element(factor) > 1)
    material.context().remark(
        material.at("emissiveFactor").pointer(),
        fmt::format("an emissiveFactor of {}, {} and {}, which glTF limits to 1", factor[0],
                    factor[1], factor[2]),
        "used as given");
  double strength = 1;
  if (const auto given = material.extension(kStrength))
    strength = given->number("emissiveStrength", 1, kNotNegative);
  MaterialEmission emission;
  emission.radiance_cd_m2 = Rgb(factor[0], factor[1], factor[2]) * strength *
                            material.context().scene.level_factors.emission;
  if (emission.radiance_cd_m2.is_black()) return nullptr;
  if (const auto status =
          check_light_value("emission", emission.radiance_cd_m2, "cd/m2", kMostInAnswers);
      !status.ok())
    material.fail(status);
  if (const auto texture = material.find("emissiveTexture");
      texture && !apply_texture(*texture, emission))
    return nullptr;
  return std::make_shared<const MaterialEmission>(std::move(emission));
}

/// Checks and reports what is not applied.
void Materials::note_left_out(const View& material) {
  for (const Slot& slot : kLeftOut)
    if (const auto info = texture_at(material, slot)) {
      check_texture(document_, *info);
      material.context().remark(
          info->pointer(), fmt::format("{} is not applied", slot.key),
          slot.key == "occlusionTexture" ? "the light is computed" : "the surface without it");
    }
  if (const auto unlit = material.extension(kUnlit))
    material.context().remark(unlit->pointer(), "a surface that is not lit",
                              "diffuse, with its base colour");
}

Materials::Use Materials::make(const View& material, bool has_colours) {
  Use use;
  use.emission = emission(material);
  use.double_sided = material.boolean("doubleSided", false);
  const std::vector<double> base = base_colour(material).factor();
  const bool has_picture = use.emission && use.emission->picture;
  std::optional<int> set;
  if (has_picture) set = use.emission->uv_set;
  const bool is_plain = !has_picture || (!use.emission->is_transformed &&
                                         use.emission->wrap_u == TextureWrap::kRepeat &&
                                         use.emission->wrap_v == TextureWrap::kRepeat);
  TextureSet textures(document_, set, has_picture, is_plain);
  auto& all = material.context().scene.materials;
  use.material = static_cast<std::uint32_t>(all.size());
  const Material& made =
      all.emplace_back(scattering(material, textures, {base[0], base[1], base[2]}, has_colours));
  const auto* surface = std::get_if<GltfSurfaceParams>(&made.params);
  use.needs_tangents = made.normal_map >= 0 || (surface != nullptr && surface->anisotropy != 0);
  note_left_out(material);
  use.alpha = alpha_of(material, textures);
  use.uv_set = textures.uv_set();
  return use;
}

const Materials::Use& Materials::use(std::optional<std::size_t> index, bool has_colours) {
  std::vector<std::optional<Use>>& uses = uses_[has_colours ? 1 : 0];
  const std::size_t count = document_.count("materials");
  uses.resize(count + 1);
  std::optional<Use>& known = uses[index.value_or(count)];
  if (!known) {
    static const Json kEmpty = Json::object();
    known = make(
        index ? document_.root().at("materials")[*index] : View(document_.context(), kEmpty, ""),
        has_colours);
  }
  return *known;
}

}  // namespace lucerna::gltf
