// The nodes of the scene in the world.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "server/gltf/animation.h"
#include "server/gltf/document.h"
#include "server/gltf/matrix.h"

namespace lucerna::gltf {

/// A node of the scene.
struct PlacedNode {
  std::size_t index = 0;
  /// At the first key frame if it moves.  It may have no inverse.
  Matrix world_from_node = kIdentity;
  std::shared_ptr<const Motion> motion;  ///< null if it does not move
};

class Tree {
 public:
  /// The nodes of the default scene, parents before their children.
  explicit Tree(const Document& document);

  const std::vector<PlacedNode>& nodes() const { return nodes_; }
  /// The scene in the JSON text; nothing if the file has none.
  std::optional<View> scene() const;
  /// World from node, without animation.
  Matrix at_rest(std::size_t node) const { return world(node, std::nullopt); }
  /// Whether an animation moves the node or one above it.
  bool is_animated(std::size_t node) const;

 private:
  struct Moved {
    Matrix world_from_node;
    std::shared_ptr<const Motion> motion;
  };
  std::vector<std::size_t> roots() const;
  void find_followed();
  Matrix world(std::size_t node, std::optional<double> time_s) const;
  Moved move(std::size_t node) const;

  const Document& document_;
  Animations animations_;
  std::vector<std::ptrdiff_t> parent_;  ///< -1: none
  /// Whether something moves with a node: its own content, or content below it with no animated
  /// node between.  Joints have no content.
  std::vector<bool> is_followed_;
  mutable std::uint64_t evaluations_ = 0;  ///< of transforms at times
  std::vector<PlacedNode> nodes_;
};

}  // namespace lucerna::gltf
