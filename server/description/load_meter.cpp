#include "server/description/load_meter.h"

#include <fmt/format.h>

#include "proto/common/status_macros.h"
#include "server/description/scene_contents.h"

namespace lucerna {
namespace {

template <typename T>
std::uint64_t bytes_of(const std::vector<T>& values) {
  return values.capacity() * sizeof(T);
}

/// Memory of a deque: each element, and a pointer to its block.
template <typename List>
std::uint64_t bytes_of(const List& values) {
  return values.size() * (sizeof(typename List::value_type) + sizeof(void*));
}

}  // namespace

std::uint64_t array_bytes(const ShapeDescription& shape) {
  return std::visit(
      []<typename Geometry>(const Geometry& g) -> std::uint64_t {
        std::uint64_t sum = 0;
        if constexpr (requires { g.positions; })
          sum += bytes_of(g.positions) + bytes_of(g.normals) + bytes_of(g.indices) +
                 bytes_of(g.corner_uv);
        if constexpr (requires { g.colours; }) sum += bytes_of(g.colours) + bytes_of(g.tangents);
        if constexpr (requires { g.points; }) sum += bytes_of(g.points) + bytes_of(g.normals);
        return sum;
      },
      shape.geometry);
}

std::uint64_t listed_bytes(const ShapeDescription& shape) {
  return array_bytes(shape) + sizeof shape + sizeof(ShapeDescription*) +
         (shape.emission ? sizeof *shape.emission + shape.emission->name.size() : 0);
}

absl::Status LoadMeter::add(const ShapeDescription& shape) {
  primitives_ += primitives_of(shape);
  if (primitives_ > limits_.max_primitives)
    return absl::ResourceExhaustedError(fmt::format(
        "the scene has {} triangles and other primitives up to here, allowed: at most {}",
        primitives_, limits_.max_primitives));
  return hold(listed_bytes(shape));
}

absl::Status LoadMeter::hold(std::uint64_t bytes) {
  LUCERNA_RETURN_IF_ERROR(keep(bytes));
  if (budget() != nullptr) scene_.held_bytes += bytes;
  return absl::OkStatus();
}

absl::Status LoadMeter::keep(std::uint64_t bytes) {
  return budget() == nullptr ? absl::OkStatus() : budget()->claim(bytes);
}

absl::Status LoadMeter::count_lists() {
  if (budget() == nullptr) return absl::OkStatus();
  const std::uint64_t lists = bytes_of(scene_.instances) + bytes_of(scene_.lights) +
                              bytes_of(scene_.materials) + bytes_of(scene_.media) +
                              bytes_of(scene_.objects);
  // Lists only grow.
  if (lists > lists_) LUCERNA_RETURN_IF_ERROR(hold(lists - lists_));
  lists_ = lists;
  const std::uint64_t textures = scene_.textures.bytes();
  if (textures > textures_) LUCERNA_RETURN_IF_ERROR(keep(textures - textures_));
  if (textures < textures_) budget()->release(textures_ - textures);
  textures_ = textures;
  return absl::OkStatus();
}

}  // namespace lucerna
