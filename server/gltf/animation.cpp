#include "server/gltf/animation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "server/gltf/accessor.h"

namespace lucerna::gltf {
namespace {

using Value = std::array<double, 4>;

/// From a to b at `part`, by the shorter way and at constant speed.  [Shoemake85]
Value slerp(const Value& a, const Value& b, double part) {
  double cosine = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
  const double sign = cosine < 0 ? -1 : 1;
  cosine = std::min(std::abs(cosine), 1.0);
  const double angle = std::acos(cosine);
  double of_a = 1 - part, of_b = part;
  if (angle > 1e-6) {
    of_a = std::sin(of_a * angle) / std::sin(angle);
    of_b = std::sin(of_b * angle) / std::sin(angle);
  }
  Value result;
  for (std::size_t k = 0; k < 4; ++k) result[k] = of_a * a[k] + sign * of_b * b[k];
  return result;
}

void normalize(Value& q) {
  const double size = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  if (!(size > 0)) {
    q = {0, 0, 0, 1};
    return;
  }
  for (double& x : q) x /= size;
}

Vec3 vec(const std::vector<double>& v, const Vec3& otherwise) {
  return v.size() == 3 ? Vec3{v[0], v[1], v[2]} : otherwise;
}

}  // namespace

std::array<double, 4> Track::at(double time_s) const {
  const auto load = [&](const double* from) {
    Value value{};
    std::copy(from, from + components_, value.begin());
    if (components_ == 4) normalize(value);
    return value;
  };
  const auto after = std::upper_bound(times_s_.begin(), times_s_.end(), time_s);
  if (after == times_s_.begin()) return load(key(0));
  const auto i = static_cast<std::size_t>(after - times_s_.begin()) - 1;
  if (kind_ == Kind::kStep || after == times_s_.end()) return load(key(i));
  const double span = times_s_[i + 1] - times_s_[i];
  const double t = (time_s - times_s_[i]) / span;
  if (kind_ == Kind::kLinear) {
    const Value a = load(key(i)), b = load(key(i + 1));
    if (components_ == 4) return slerp(a, b, t);
    Value result{};
    for (std::size_t k = 0; k < 3; ++k) result[k] = a[k] * (1 - t) + b[k] * t;
    return result;
  }
  // Each key frame has an incoming tangent, a value and an outgoing tangent.
  const double* from = key(i);
  const double* to = key(i + 1);
  Value result{};
  for (std::size_t k = 0; k < components_; ++k) {
    const double out = span * from[components_ + k];
    const double in = span * (to - components_)[k];
    const double t2 = t * t, t3 = t2 * t;
    result[k] = (2 * t3 - 3 * t2 + 1) * from[k] + (t3 - 2 * t2 + t) * out +
                (3 * t2 - 2 * t3) * to[k] + (t3 - t2) * in;
  }
  if (components_ == 4) normalize(result);
  return result;
}

Animations::Animations(const Document& document) : document_(document) {
  const auto& animations = document.model().animations;
  for (std::size_t a = 0; a < animations.size(); ++a) {
    const View place = document.root().at("animations")[a];
    for (std::size_t c = 0; c < animations[a].channels.size(); ++c)
      add(place.at("channels")[c], animations[a], animations[a].channels[c], place);
  }
}

void Animations::add(const View& channel, const tinygltf::Animation& animation,
                     const tinygltf::AnimationChannel& source, const View& animation_place) {
  LoadState& context = document_.context();
  context.poll();
  const std::string& path = source.target_path;
  if (source.target_node < 0) return;  // the target of an extension
  if (path != "translation" && path != "rotation") {
    context.remark(channel.pointer(),
                   fmt::format("animation of \"{}\" is not modelled", printable(path)), "at rest");
    return;
  }
  const auto node = static_cast<std::size_t>(source.target_node);
  Tracks& tracks = nodes_[node];
  Track& track = path == "rotation" ? tracks.rotation : tracks.translation;
  if (!document_.model().nodes[node].matrix.empty())
    channel.fail(
        fmt::format("animates node {}, which has a matrix, allowed: translation, rotation "
                    "and scale",
                    node));
  if (!track.empty()) {
    context.remark(
        channel.pointer(),
        fmt::format("a second animation of the {} of node {} is not modelled", path, node),
        "the first");
    return;
  }
  const auto& sampler = animation.samplers[static_cast<std::size_t>(source.sampler)];
  const std::string at =
      animation_place.at("samplers")[static_cast<std::size_t>(source.sampler)].pointer();
  std::vector<double> times = read_numbers(document_, static_cast<std::size_t>(sampler.input), 1);
  for (std::size_t i = 0; i < times.size(); ++i)
    if (times[i] < 0 || (i > 0 && !(times[i] > times[i - 1])))
      context.fail(at + "/input",
                   fmt::format("time {} is {} s, allowed: from 0 on, ascending", i, times[i]));
  const auto kind = sampler.interpolation == "STEP"          ? Track::Kind::kStep
                    : sampler.interpolation == "CUBICSPLINE" ? Track::Kind::kSpline
                                                             : Track::Kind::kLinear;
  const std::size_t components = path == "rotation" ? 4 : 3;
  std::vector<double> values =
      read_numbers(document_, static_cast<std::size_t>(sampler.output), components);
  const std::size_t expected = times.size() * components * (kind == Track::Kind::kSpline ? 3 : 1);
  if (values.size() != expected)
    context.fail(at + "/output",
                 fmt::format("found {} values, expected {} for {} times",
                             values.size() / components, expected / components, times.size()));
  track = Track(std::move(times), std::move(values), components, kind);
}

Matrix Animations::local(std::size_t node, std::optional<double> time_s) const {
  const tinygltf::Node& n = document_.model().nodes[node];
  if (!n.matrix.empty()) return from_columns(n.matrix.data());
  Vec3 translation = vec(n.translation, {0, 0, 0});
  Quaternion rotation{0, 0, 0, 1};
  if (n.rotation.size() == 4) std::copy(n.rotation.begin(), n.rotation.end(), rotation.begin());
  const auto found = nodes_.find(node);
  if (time_s && found != nodes_.end()) {
    const Tracks& tracks = found->second;
    if (!tracks.translation.empty()) {
      const Value t = tracks.translation.at(*time_s);
      translation = {t[0], t[1], t[2]};
    }
    if (!tracks.rotation.empty()) rotation = tracks.rotation.at(*time_s);
  }
  return from_parts(translation, rotation, vec(n.scale, {1, 1, 1}));
}

std::vector<double> Animations::times_s(std::size_t node, bool in_chain) const {
  std::vector<double> result;
  const auto found = nodes_.find(node);
  if (found == nodes_.end()) return result;
  for (const Track* track : {&found->second.translation, &found->second.rotation}) {
    const std::vector<double>& times = track->times_s();
    // Curves between two times become straight pieces.
    const bool is_curved = track->kind() == Track::Kind::kSpline ||
                           (in_chain && track->kind() == Track::Kind::kLinear);
    constexpr int kPieces = 16;
    for (std::size_t i = 0; i < times.size(); ++i) {
      if (i > 0 && is_curved)
        for (int piece = 1; piece < kPieces; ++piece)
          result.push_back(times[i - 1] + (times[i] - times[i - 1]) * piece / kPieces);
      // A step is a motion within the shortest time.
      if (i > 0 && track->kind() == Track::Kind::kStep)
        result.push_back(std::nextafter(times[i], -std::numeric_limits<double>::infinity()));
      result.push_back(times[i]);
    }
  }
  std::sort(result.begin(), result.end());
  result.erase(std::unique(result.begin(), result.end()), result.end());
  return result;
}

}  // namespace lucerna::gltf
