// Lights whose surfaces are cut out: they emit what their surface does not let through.
#include "server/scene/emitter_alpha.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "lights/maths/stop_poll.h"

namespace lucerna {
namespace {

/// Columns and rows of a picture of alpha, if the texture is no picture itself.
constexpr int kSide = 512;

/// Whether all (u, v) of the corners are within the picture.
bool is_within_picture(const ShapeDescription& shape) {
  constexpr float kRounded = 1e-5F;
  const auto is_within = [](const Vec2f& uv) {
    return std::min(uv.x, uv.y) >= -kRounded && std::max(uv.x, uv.y) <= 1 + kRounded;
  };
  return std::visit(
      [&](const auto& geometry) {
        if constexpr (requires { geometry.corner_uv; })
          return std::ranges::all_of(geometry.corner_uv, is_within);
        else
          return true;
      },
      shape.geometry);
}

/// The picture of a light, times alpha.
Picture times_alpha(const std::optional<Picture>& picture, const NumberValue& alpha,
                    const Textures& textures) {
  const auto* of_alpha = textures.picture(alpha.texture);
  int width = of_alpha != nullptr ? of_alpha->image->width() : kSide;
  int height = of_alpha != nullptr ? of_alpha->image->height() : kSide;
  if (picture) {
    width = std::max(width, picture->image->width());
    height = std::max(height, picture->image->height());
  }
  std::vector<Rgbf> texels;
  texels.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  StopPoll poll;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x, poll()) {
      const Vec2 uv{(x + 0.5) / width, 1 - (y + 0.5) / height};
      const double share = std::clamp(textures(alpha, {.uv = uv}), 0.0, 1.0);
      texels.emplace_back((picture ? picture->at(uv) : Rgb(1)) * share);
    }
  Picture result;
  result.image = *Image::create(width, height, std::move(texels));
  result.filter = of_alpha != nullptr && !picture && of_alpha->filter == TextureFilter::kNearest
                      ? ImageFilter::kNearest
                      : ImageFilter::kBilinear;
  if (picture) result.name = picture->name;
  return result;
}

/// A remark if the shape becomes opaque.
std::optional<std::string> apply_alpha(ShapeDescription& shape, const Textures& textures) {
  auto& emission = *shape.emission;
  if (shape.alpha.is_constant()) {
    emission.radiance_cd_m2 = emission.radiance_cd_m2 * std::clamp(shape.alpha.constant, 0.0, 1.0);
    return std::nullopt;
  }
  const auto opaque = [&](const char* why) {
    shape.alpha = {1};
    return fmt::format("\"alpha\" of a light {} is not modelled", why);
  };
  if (emission.panel) return opaque("with a photometric profile");
  if (!textures.needs_only_uv(shape.alpha.texture))
    return opaque("that follows the place in space");
  if (!is_within_picture(shape)) return opaque("whose (u, v) leave the square from 0 to 1");
  emission.picture = times_alpha(emission.picture, shape.alpha, textures);
  return std::nullopt;
}

}  // namespace

bool apply_alpha(SceneDescription& scene) {
  bool any = false;
  StopPoll poll;
  for (ShapeDescription& s : scene.shapes) {
    poll();
    if (!s.emission || (s.alpha.is_constant() && s.alpha.constant >= 1)) continue;
    if (auto what = apply_alpha(s, scene.textures))
      scene.remarks.push_back({s.where, *std::move(what), "opaque"});
    any = true;
  }
  return any;
}

}  // namespace lucerna
