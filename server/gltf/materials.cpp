#include "server/gltf/materials.h"

#include <fmt/format.h>

#include <cmath>

#include "lights/spectra/level_validation.h"

namespace lucerna::gltf {
namespace {

/// Wrapping of a sampler.
MaterialEmission::Wrap wrap_of(const View& sampler, std::string_view key) {
  const std::uint64_t code = sampler.integer(key, 10497, 0, 1 << 16);
  if (code == 10497) return MaterialEmission::Wrap::kRepeat;
  if (code == 33071) return MaterialEmission::Wrap::kClamp;
  if (code == 33648) return MaterialEmission::Wrap::kMirror;
  sampler.at(key).fail(fmt::format("found {}, allowed: 33071, 33648, 10497", code));
}

/// Puts KHR_texture_transform before the flip of v: translation * rotation * scale.
void apply_transform(const View& transform, MaterialEmission& emission) {
  const std::vector<double> offset = transform.numbers("offset", {0, 0});
  const std::vector<double> scale = transform.numbers("scale", {1, 1});
  const double angle = transform.number("rotation", 0);
  const double c = std::cos(angle), s = std::sin(angle);
  emission.uv[0][0] = c * scale[0];
  emission.uv[0][1] = s * scale[1];
  emission.uv[0][2] = offset[0];
  emission.uv[1][0] = s * scale[0];
  emission.uv[1][1] = -c * scale[1];
  emission.uv[1][2] = 1 - offset[1];
  emission.uv_set = static_cast<int>(
      transform.integer("texCoord", static_cast<std::uint64_t>(emission.uv_set), 0, 1000));
}

/// Checks a reference to a texture.
void check_texture(const Document& document, const View& info) {
  info.at("index").index(document.count("textures"), "texture");
  info.integer("texCoord", 0, 0, 1000);
  info.number("scale", 1);
  info.number("strength", 1, kUnit);
  if (const auto transform = info.extension("KHR_texture_transform")) {
    transform->numbers("offset", {0, 0});
    transform->numbers("scale", {1, 1});
    transform->number("rotation", 0);
  }
}

}  // namespace

bool is_material_extension(std::string_view name) {
  return name == "KHR_materials_emissive_strength" || name == "KHR_texture_transform";
}

void Materials::read_pictures() {
  for (std::size_t i = 0; i < document_.count("materials"); ++i)
    emission(document_.root().at("materials")[i].require_object());
}

/// Sets the picture of `emission`; false if the picture was not uploaded yet.
bool Materials::apply_texture(const View& info, MaterialEmission& emission) {
  const View root = document_.root();
  const View texture =
      root.at("textures")[info.at("index").index(document_.count("textures"), "texture")];
  emission.uv_set = static_cast<int>(info.integer("texCoord", 0, 0, 1000));
  if (const auto transform = info.extension("KHR_texture_transform"))
    apply_transform(*transform, emission);
  emission.wrap_u = emission.wrap_v = MaterialEmission::Wrap::kRepeat;
  Picture picture;
  if (const auto index = texture.index("sampler", document_.count("samplers"), "sampler")) {
    const View sampler = root.at("samplers")[*index];
    emission.wrap_u = wrap_of(sampler, "wrapS");
    emission.wrap_v = wrap_of(sampler, "wrapT");
    constexpr std::uint64_t kNearest = 9728;
    if (sampler.integer("magFilter", 9729, 9728, 9729) == kNearest)
      picture.filter = ImageFilter::kNearest;
  }
  const auto source = texture.index("source", document_.count("images"), "image");
  if (!source) {
    texture.context().remark(texture.pointer(), "a texture without a picture in \"source\"",
                             "white");
    return true;
  }
  picture.image = document_.image(*source);
  if (picture.image == nullptr) return false;
  const View image = root.at("images")[*source];
  picture.name = image.text("uri", "");
  if (picture.name.empty() || picture.name.starts_with("data:"))
    picture.name = image.context().location(image.pointer()).file;
  emission.picture = std::move(picture);
  return true;
}

std::shared_ptr<const MaterialEmission> Materials::emission(const View& material) {
  const std::vector<double> factor = material.numbers("emissiveFactor", {0, 0, 0}, kUnit);
  double strength = 1;
  if (const auto given = material.extension("KHR_materials_emissive_strength"))
    strength = given->number("emissiveStrength", 1, kNotNegative);
  MaterialEmission emission;
  emission.radiance_cd_m2 = Rgb<double>(factor[0], factor[1], factor[2]) * strength;
  if (emission.radiance_cd_m2.is_black()) return nullptr;
  if (const auto status = check_light_value<float>("emission", emission.radiance_cd_m2, "cd/m2");
      !status.ok())
    material.fail(status);
  if (const auto texture = material.find("emissiveTexture");
      texture && !apply_texture(*texture, emission))
    return nullptr;
  return std::make_shared<const MaterialEmission>(std::move(emission));
}

Materials::Use Materials::make(const View& material) {
  Use use;
  Rgb<double> reflectance(1.0);
  std::vector<std::string> left_out;
  const auto note = [&](const View& parent, std::string_view key) {
    const auto texture = parent.find(key);
    if (!texture) return;
    check_texture(document_, *texture);
    left_out.emplace_back(key);
  };
  if (const auto pbr = material.find("pbrMetallicRoughness")) {
    const std::vector<double> base =
        pbr->require_object().numbers("baseColorFactor", {1, 1, 1, 1}, kUnit);
    reflectance = {base[0], base[1], base[2]};
    if (pbr->number("metallicFactor", 1, kUnit) > 0) left_out.emplace_back("metallicFactor");
    pbr->number("roughnessFactor", 1, kUnit);
    note(*pbr, "baseColorTexture");
    note(*pbr, "metallicRoughnessTexture");
  }
  note(material, "normalTexture");
  note(material, "occlusionTexture");
  const std::string alpha = material.text("alphaMode", "OPAQUE");
  if (alpha != "OPAQUE" && alpha != "MASK" && alpha != "BLEND")
    material.at("alphaMode")
        .fail(fmt::format("found \"{}\", allowed: OPAQUE, MASK, BLEND", printable(alpha)));
  if (alpha != "OPAQUE") left_out.emplace_back("alphaMode");
  if (!left_out.empty())
    material.context().remark(
        material.pointer(), fmt::format("not modelled: {}", fmt::join(left_out, ", ")),
        fmt::format("an opaque diffuse surface, reflectance ({:.3g}, {:.3g}, {:.3g})",
                    reflectance.r, reflectance.g, reflectance.b));
  use.double_sided = material.boolean("doubleSided", false);
  use.emission = emission(material);
  auto& all = material.context().scene.materials;
  use.material = static_cast<std::uint32_t>(all.size());
  all.push_back(diffuse_material(reflectance));
  return use;
}

const Materials::Use& Materials::use(std::optional<std::size_t> index) {
  uses_.resize(document_.count("materials"));
  std::optional<Use>& known = index ? uses_[*index] : default_;
  if (!known) {
    static const Json kEmpty = Json::object();
    known = make(index ? document_.root().at("materials")[*index]
                       : View(document_.context(), kEmpty, ""));
  }
  return *known;
}

}  // namespace lucerna::gltf
