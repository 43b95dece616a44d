#include "server/gltf/tree.h"

#include <fmt/format.h>

#include <algorithm>

#include "lights/maths/stop_poll.h"

namespace lucerna::gltf {
namespace {

void check_matrix(const Document& document, std::size_t node) {
  const std::vector<double>& m = document.model().nodes[node].matrix;
  if (m.empty()) return;
  if (m[3] != 0 || m[7] != 0 || m[11] != 0 || m[15] != 1)
    document.context().fail(fmt::format("/nodes/{}/matrix", node),
                            fmt::format("the last row is ({}, {}, {}, {}), allowed: (0, 0, 0, 1)",
                                        m[3], m[7], m[11], m[15]));
}

}  // namespace

bool Tree::is_animated(std::size_t node) const {
  StopPoll poll;
  for (auto n = static_cast<std::ptrdiff_t>(node); n >= 0;
       n = parent_[static_cast<std::size_t>(n)], poll())
    if (animations_.animates(static_cast<std::size_t>(n))) return true;
  return false;
}

Tree::Tree(const Document& document)
    : document_(document),
      animations_(document),
      parent_(document.model().nodes.size(), -1),
      is_followed_(document.model().nodes.size(), false) {
  const auto& nodes = document.model().nodes;
  StopPoll poll;
  for (std::size_t i = 0; i < nodes.size(); ++i, poll()) {
    check_matrix(document, i);
    for (const int child : nodes[i].children)
      parent_[static_cast<std::size_t>(child)] = static_cast<std::ptrdiff_t>(i);
  }
  find_followed();
  // A list of open nodes instead of recursion, since trees may be deep.
  const std::vector<std::size_t> first = roots();
  std::vector<PlacedNode> open;
  for (auto i = first.rbegin(); i != first.rend(); ++i, poll())
    open.push_back({*i, kIdentity, nullptr});
  while (!open.empty()) {
    document.context().poll();
    PlacedNode node = std::move(open.back());
    open.pop_back();
    if (animations_.animates(node.index) && is_followed_[node.index]) {
      Moved moved = move(node.index);
      node.world_from_node = moved.world_from_node;
      node.motion = std::move(moved.motion);
    } else {
      node.world_from_node =
          multiply(node.world_from_node, animations_.local(node.index, std::nullopt));
    }
    const std::vector<int>& children = nodes[node.index].children;
    for (auto i = children.rbegin(); i != children.rend(); ++i)
      open.push_back({static_cast<std::size_t>(*i), node.world_from_node, node.motion});
    nodes_.push_back(std::move(node));
  }
}

void Tree::find_followed() {
  const auto& nodes = document_.model().nodes;
  const auto places = document_.root().find("nodes");
  StopPoll poll;
  for (std::size_t i = 0; i < nodes.size(); ++i, poll()) {
    const View place = (*places)[i];
    if (nodes[i].camera < 0 && (nodes[i].mesh < 0 || nodes[i].skin >= 0) &&
        !place.extension("KHR_lights_punctual") && !place.extension("EXT_lights_ies"))
      continue;
    // An animated node computes its motion from all nodes above it.
    for (auto n = static_cast<std::ptrdiff_t>(i);
         n >= 0 && !is_followed_[static_cast<std::size_t>(n)];
         n = parent_[static_cast<std::size_t>(n)], poll()) {
      is_followed_[static_cast<std::size_t>(n)] = true;
      if (animations_.animates(static_cast<std::size_t>(n))) break;
    }
  }
}

std::optional<View> Tree::scene() const {
  const auto scenes = document_.root().find("scenes");
  if (!scenes || scenes->size() == 0) return std::nullopt;
  return (*scenes)[static_cast<std::size_t>(std::max(document_.model().defaultScene, 0))];
}

std::vector<std::size_t> Tree::roots() const {
  std::vector<std::size_t> result;
  const auto& model = document_.model();
  if (model.scenes.empty()) {
    StopPoll poll;
    for (std::size_t i = 0; i < parent_.size(); ++i, poll())
      if (parent_[i] < 0) result.push_back(i);
    document_.context().remark("", "the file has no scene", "all its nodes");
    return result;
  }
  const auto index = static_cast<std::size_t>(std::max(model.defaultScene, 0));
  StopPoll poll;
  for (const int root : model.scenes[index].nodes)
    poll(), result.push_back(static_cast<std::size_t>(root));
  if (model.scenes.size() > 1)
    document_.context().remark("/scenes", fmt::format("{} scenes", model.scenes.size()),
                               fmt::format("only scene {} is loaded", index));
  return result;
}

Matrix Tree::world(std::size_t node, std::optional<double> time_s) const {
  Matrix m = animations_.local(node, time_s);
  for (std::ptrdiff_t p = parent_[node]; p >= 0; p = parent_[static_cast<std::size_t>(p)])
    m = multiply(animations_.local(static_cast<std::size_t>(p), time_s), m);
  return m;
}

/// The motion of a node with an animation, with that of the nodes above it.
Tree::Moved Tree::move(std::size_t node) const {
  LoadState& context = document_.context();
  const std::string pointer = fmt::format("/nodes/{}", node);
  std::vector<std::size_t> moving;
  std::uint64_t depth = 0;
  for (auto n = static_cast<std::ptrdiff_t>(node); n >= 0;
       n = parent_[static_cast<std::size_t>(n)]) {
    ++depth;
    if (animations_.animates(static_cast<std::size_t>(n)))
      moving.push_back(static_cast<std::size_t>(n));
  }
  std::vector<double> times;
  for (const std::size_t n : moving) {
    context.poll();
    const std::vector<double> more = animations_.times_s(n, moving.size() > 1);
    times.insert(times.end(), more.begin(), more.end());
  }
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  if (times.empty()) return {world(node, std::nullopt), nullptr};
  // Deep trees of moving nodes would take hours.  This takes a few seconds.
  constexpr std::uint64_t kMostEvaluations = 50'000'000;
  evaluations_ += times.size() * depth;
  if (evaluations_ > kMostEvaluations)
    context.fail(pointer, absl::ResourceExhaustedError(fmt::format(
                              "{} key frames of {} nodes above each other bring the transforms to "
                              "{}, allowed: {}",
                              times.size(), depth, evaluations_, kMostEvaluations)));
  context.claim(pointer, times.size(), sizeof(KeyTransform) + sizeof(Motion::KeyFrame));
  Moved moved{world(node, times[0]), nullptr};
  std::vector<KeyTransform> frames;
  frames.reserve(times.size());
  bool moves = false;
  for (const double time_s : times) {
    context.poll();
    const Matrix m = world(node, time_s);
    moves = moves || m != moved.world_from_node;
    const auto transform = Transform::from_matrix(m);
    if (!transform) return moved;  // a scale of 0: nothing of it is visible
    frames.push_back({time_s, *transform});
  }
  if (!moves) return moved;
  absl::StatusOr<Motion> motion = Motion::create(frames);
  if (!motion.ok()) {
    context.remark(pointer, std::string(motion.status().message()), "at its first key frame");
    return moved;
  }
  moved.motion = std::make_shared<const Motion>(*std::move(motion));
  return moved;
}

}  // namespace lucerna::gltf
