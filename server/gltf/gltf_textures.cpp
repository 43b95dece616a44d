#include "server/gltf/gltf_textures.h"

#include <fmt/format.h>

#include <cmath>

namespace lucerna::gltf {
namespace {

/// translation * rotation * scale, for (u, v) with v upwards.  [glTF2, KHR_texture_transform]
TextureMapping mapping_of(const View& transform) {
  const std::vector<double> offset = transform.numbers("offset", {0, 0});
  const std::vector<double> scale = transform.numbers("scale", {1, 1});
  const double angle = transform.number("rotation", 0);
  const double c = std::cos(angle), s = std::sin(angle);
  TextureMapping m;
  m.kind = TextureMapping::Kind::kAffine;
  m.axis_s = {c * scale[0], -s * scale[1], offset[0] + s * scale[1]};
  m.axis_t = {s * scale[0], c * scale[1], 1 - offset[1] - c * scale[1]};
  return m;
}

/// Wrapping along "wrapS" or "wrapT".
TextureWrap wrap_of(const View& sampler, std::string_view key) {
  const std::uint64_t code = sampler.integer(key, 10497, 0, 1 << 16);
  if (code == 10497) return TextureWrap::kRepeat;
  if (code == 33071) return TextureWrap::kClamp;
  if (code == 33648) return TextureWrap::kMirror;
  sampler.at(key).fail(fmt::format("found {}, allowed: 33071, 33648, 10497", code));
}

}  // namespace

Sampling sampling_of(const Document& document, const View& texture) {
  Sampling s;
  const auto index = texture.index("sampler", document.count("samplers"), "sampler");
  if (!index) return s;
  const View sampler = document.root().at("samplers")[*index];
  s.wrap_s = wrap_of(sampler, "wrapS");
  s.wrap_t = wrap_of(sampler, "wrapT");
  constexpr std::uint64_t kNearest = 9728;
  if (sampler.integer("magFilter", 9729, 9728, 9729) == kNearest) s.filter = ImageFilter::kNearest;
  return s;
}

void check_texture(const Document& document, const View& info) {
  info.at("index").index(document.count("textures"), "texture");
  info.integer("texCoord", 0, 0, 1000);
  info.number("scale", 1);
  info.number("strength", 1, kUnit);
  if (const auto transform = info.extension("KHR_texture_transform")) {
    transform->numbers("offset", {0, 0});
    transform->numbers("scale", {1, 1});
    transform->number("rotation", 0);
    transform->integer("texCoord", 0, 0, 1000);
  }
}

bool TextureSet::fits(const View& info, const ImageTexture& texture, int set) {
  if (uv_set_ && *uv_set_ != set) {
    info.context().remark(
        info.pointer(),
        fmt::format("a texture of TEXCOORD_{} beside those of TEXCOORD_{}", set, *uv_set_),
        "only its factor is applied");
    return false;
  }
  const bool is_plain = texture.mapping.kind == TextureMapping::Kind::kUv &&
                        texture.wrap_s == TextureWrap::kRepeat &&
                        texture.wrap_t == TextureWrap::kRepeat;
  if (!has_picture_ || (allowed_ && is_plain)) return true;
  info.context().remark(info.pointer(),
                        "a texture with a transform or without repetition, or beside an emissive "
                        "picture with one",
                        "only its factor is applied");
  return false;
}

std::int32_t TextureSet::image(const View& info, PictureKind kind) {
  check_texture(document_, info);
  const View texture = document_.texture_of(info);
  const auto source = document_.picture_of(texture);
  if (!source) {
    texture.context().remark(texture.pointer(), "a texture without a picture in \"source\"",
                             "white");
    return -1;
  }
  ImageTexture t;
  std::uint64_t set = info.integer("texCoord", 0, 0, 1000);
  if (const auto transform = info.extension("KHR_texture_transform")) {
    t.mapping = mapping_of(*transform);
    set = transform->integer("texCoord", set, 0, 1000);
  }
  const Sampling sampling = sampling_of(document_, texture);
  t.wrap_s = sampling.wrap_s;
  t.wrap_t = sampling.wrap_t;
  t.filter =
      sampling.filter == ImageFilter::kNearest ? TextureFilter::kNearest : TextureFilter::kBilinear;
  if (!fits(info, t, static_cast<int>(set))) return -1;
  t.image = document_.texels(*source, kind);
  if (t.image == nullptr)
    return -1;  // not uploaded yet, so the load ends after this; or unreadable
  uv_set_ = static_cast<int>(set);
  any_ = true;
  return document_.context().scene.textures.add(std::move(t));
}

ColourValue TextureSet::colour(const std::optional<View>& parent, std::string_view key,
                               PictureKind kind, const Rgb& factor) {
  const auto info = parent ? parent->find(key) : std::nullopt;
  const std::int32_t node = info ? image(*info, kind) : -1;
  if (node < 0) return {factor};
  if (factor == Rgb(1)) return {{}, node};
  return {{}, document_.context().scene.textures.add(ScaleTexture{{{}, node}, {factor}})};
}

NumberValue TextureSet::number(const std::optional<View>& parent, std::string_view key,
                               PictureKind kind, double factor) {
  const ColourValue value = colour(parent, key, kind, Rgb(factor));
  return {factor, value.texture};
}

}  // namespace lucerna::gltf
