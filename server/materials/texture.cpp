#include "server/materials/texture.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "lights/sampling/hash_number.h"
#include "server/materials/image_lookup.h"

namespace lucerna {
namespace {

/// How the coordinates of a mapping grow over the footprint of `p`.
CoordinateSteps steps_of(const TextureMapping& mapping, const TexturePoint& p, const Vec2& st) {
  const Footprint& f = *p.footprint;
  const auto step = [&](const Vec2& uv, const Vec3& position) {
    TexturePoint next = p;
    next.uv = {p.uv.x + uv.x, p.uv.y + uv.y};
    next.position += position;
    const Vec2 to = mapping(next);
    Vec2 d{to.x - st.x, to.y - st.y};
    // Past the seam of a turn.
    if (mapping.kind == TextureMapping::Kind::kSpherical) d.y -= std::round(d.y);
    if (mapping.kind == TextureMapping::Kind::kCylindrical) d.x -= std::round(d.x);
    return d;
  };
  return {step(f.uv_x, f.position_x), step(f.uv_y, f.position_y)};
}

/// Whether a sum of rounded coordinates is odd.
bool is_odd(double sum) { return std::fmod(sum, 2) != 0; }

class Evaluation {
 public:
  Evaluation(const Textures& textures, const TexturePoint& p) : textures_(textures), p_(p) {}

  Rgb operator()(const ImageTexture& t) const {
    const Vec2 st = t.mapping(p_);
    std::optional<CoordinateSteps> steps;
    if (uses_levels(t.filter) && p_.footprint != nullptr) steps = steps_of(t.mapping, p_, st);
    const Rgb value = look_up(t, st, steps ? &*steps : nullptr) * t.scale;
    if (!t.invert) return value;
    const auto inverse = [](double x) { return std::max(0.0, 1 - x); };
    return {inverse(value.r), inverse(value.g), inverse(value.b)};
  }
  Rgb operator()(const CheckerboardTexture& t) const {
    if (t.dimension == 3) {
      const Vec3 q = t.mapping.texture_from_world.point(p_.position);
      return textures_(t.parts[is_odd(std::floor(q.x) + std::floor(q.y) + std::floor(q.z))], p_);
    }
    const Vec2 st = t.mapping(p_);
    return textures_(t.parts[is_odd(std::floor(st.x) + std::floor(st.y))], p_);
  }
  Rgb operator()(const ScaleTexture& t) const {
    return textures_(t.part, p_) * textures_(t.factor, p_);
  }
  Rgb operator()(const CutOffTexture& t) const {
    return Rgb(textures_(t.part, p_).r >= t.least ? 1.0 : 0.0);
  }
  Rgb operator()(const MixTexture& t) const {
    const double amount = textures_(t.amount, p_);
    return textures_(t.parts[0], p_) * (1 - amount) + textures_(t.parts[1], p_) * amount;
  }
  Rgb operator()(const DirectionMixTexture& t) const {
    const double along = std::fabs(dot(p_.normal, t.direction));
    return textures_(t.parts[0], p_) * along + textures_(t.parts[1], p_) * (1 - along);
  }
  Rgb operator()(const BilerpTexture& t) const {
    const Vec2 st = t.mapping(p_);
    return (t.corners[0] * (1 - st.y) + t.corners[1] * st.y) * (1 - st.x) +
           (t.corners[2] * (1 - st.y) + t.corners[3] * st.y) * st.x;
  }
  Rgb operator()(const VertexColourTexture&) const { return p_.colour; }
  Rgb operator()(const DotsTexture& t) const {
    const Vec2 st = t.mapping(p_);
    const double s = std::floor(st.x + 0.5), v = std::floor(st.y + 0.5);
    if (hash_number({s, v, 0}) < 0.5) return textures_(t.outside, p_);
    constexpr double kRadius = 0.35, kMostShift = 0.5 - kRadius;
    const double x = st.x - s - kMostShift * (2 * hash_number({s, v, 1}) - 1),
                 y = st.y - v - kMostShift * (2 * hash_number({s, v, 2}) - 1);
    return textures_(x * x + y * y < kRadius * kRadius ? t.inside : t.outside, p_);
  }

 private:
  const Textures& textures_;
  const TexturePoint& p_;
};

}  // namespace

Vec2 TextureMapping::operator()(const TexturePoint& p) const {
  if (kind == Kind::kUv) return {scale.x * p.uv.x + shift.x, scale.y * p.uv.y + shift.y};
  if (kind == Kind::kAffine) {
    const Vec3 uv{p.uv.x, p.uv.y, 1};
    return {dot(uv, axis_s), dot(uv, axis_t)};
  }
  const Vec3 q = texture_from_world.point(p.position);
  constexpr double kTurn = 2 * std::numbers::pi;
  const auto around = [&] {
    const double angle = std::atan2(q.y, q.x);
    return (angle < 0 ? angle + kTurn : angle) / kTurn;
  };
  switch (kind) {
    case Kind::kSpherical:
      return {std::atan2(std::hypot(q.x, q.y), q.z) / std::numbers::pi, around()};
    case Kind::kCylindrical:
      // The seam is at -x.
      return {0.5 + std::atan2(q.y, q.x) / kTurn, q.z};
    default:
      return {dot(q, axis_s) + shift.x, dot(q, axis_t) + shift.y};
  }
}

std::int32_t Textures::add(TextureNode node, const std::stop_token& stop) {
  if (const auto* image = std::get_if<ImageTexture>(&node); image && uses_levels(image->filter)) {
    uses_footprints_ = true;
    const auto found = std::ranges::find(pictures_, image->image, &Picture::texels);
    if (found != pictures_.end()) {
      found->texels->make_levels(stop);
      fit(stop);
    }
  }
  nodes_.push_back(std::move(node));
  return static_cast<std::int32_t>(nodes_.size() - 1);
}

Rgb Textures::at(std::int32_t texture, const TexturePoint& p) const {
  return std::visit(Evaluation(*this, p), nodes_[static_cast<std::size_t>(texture)]);
}

bool Textures::needs_only_uv(std::int32_t texture) const {
  const auto of = [this](const auto& value) {
    return value.is_constant() || needs_only_uv(value.texture);
  };
  return std::visit(
      [&](const auto& t) {
        bool result = true;
        using Kind = TextureMapping::Kind;
        if constexpr (requires { t.mapping; })
          result = t.mapping.kind == Kind::kUv || t.mapping.kind == Kind::kAffine;
        if constexpr (requires { t.dimension; }) result = result && t.dimension == 2;
        using Node = std::decay_t<decltype(t)>;
        if constexpr (std::is_same_v<Node, VertexColourTexture> ||
                      std::is_same_v<Node, DirectionMixTexture>)
          result = false;
        if constexpr (requires { t.parts; }) result = result && of(t.parts[0]) && of(t.parts[1]);
        if constexpr (requires { t.part; }) result = result && of(t.part);
        if constexpr (requires { t.factor; }) result = result && of(t.factor);
        if constexpr (requires { t.amount; }) result = result && of(t.amount);
        if constexpr (requires { t.inside; }) result = result && of(t.inside) && of(t.outside);
        return result;
      },
      nodes_[static_cast<std::size_t>(texture)]);
}

std::shared_ptr<const Texels> Textures::picture(const std::string& name, Texels texels,
                                                const std::stop_token& stop) {
  const auto kept = std::make_shared<Texels>(std::move(texels));
  pictures_.push_back({name, kept->width(), kept->height(), kept});
  fit(stop);
  return kept;
}

/// Halves the largest pictures until all fit.
void Textures::fit(const std::stop_token& stop) {
  const auto sum = [&] {
    std::size_t bytes = 0;
    for (const Picture& p : pictures_) bytes += p.texels->bytes();
    return bytes;
  };
  while (sum() > limit_bytes_ && !stop.stop_requested()) {
    const auto largest =
        std::ranges::max_element(pictures_, {}, [](const Picture& p) { return p.texels->bytes(); });
    if (largest->texels->width() * largest->texels->height() == 1) break;
    largest->texels->halve(stop);
  }
}

std::vector<HalvedPicture> Textures::halved() const {
  std::vector<HalvedPicture> all;
  for (const Picture& p : pictures_)
    if (p.texels->width() != p.width || p.texels->height() != p.height)
      all.push_back({p.name, p.width, p.height, p.texels->width(), p.texels->height()});
  return all;
}

std::size_t Textures::bytes() const {
  std::size_t sum =
      nodes_.capacity() * sizeof(TextureNode) + pictures_.capacity() * sizeof(Picture);
  for (const Picture& p : pictures_) sum += p.texels->bytes();
  return sum;
}

}  // namespace lucerna
