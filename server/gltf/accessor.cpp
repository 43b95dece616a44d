#include "server/gltf/accessor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "lights/maths/stop_poll.h"

namespace lucerna::gltf {
namespace {

/// Accessors without bytes are zeros.  Nothing else limits their count.
constexpr std::size_t kMostZeros = std::size_t{1} << 24;

std::size_t size_of(int type) {
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return 1;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return 2;
    default:
      return 4;
  }
}

template <typename T>
double value_as(const char* from) {
  T value;
  std::memcpy(&value, from, sizeof value);
  return static_cast<double>(value);
}

/// The number at `from`; normalised integers as fractions.  [glTF2, 3.6.2.2]
double number_at(const char* from, int type, bool normalized) {
  const auto fraction = [&](double value, double most) {
    return normalized ? std::max(value / most, -1.0) : value;
  };
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return fraction(value_as<std::int8_t>(from), 127);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return fraction(value_as<std::uint8_t>(from), 255);
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return fraction(value_as<std::int16_t>(from), 32767);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return fraction(value_as<std::uint16_t>(from), 65535);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      return fraction(value_as<std::uint32_t>(from), 4294967295.0);
    default:
      return value_as<float>(from);
  }
}

/// Elements of equal distance in a range of bytes.
struct Elements {
  const char* first = nullptr;
  std::size_t stride = 0;
};

/// The elements that begin at `offset` of a buffer view.
Elements elements(const Document& document, const std::string& pointer, std::size_t view,
                  std::size_t offset, std::size_t count, std::size_t size, bool strided) {
  const std::string_view bytes = document.view_bytes(view, pointer);
  std::size_t stride = size;
  if (strided && document.model().bufferViews[view].byteStride > 0)
    stride = document.model().bufferViews[view].byteStride;
  if (stride < size)
    document.context().fail(
        pointer, fmt::format("elements of {} bytes, but /bufferViews/{}/byteStride is {}", size,
                             view, stride));
  if (offset > bytes.size() || size > bytes.size() - offset ||
      count - 1 > (bytes.size() - offset - size) / stride)
    document.context().fail(
        pointer, fmt::format("{} elements of {} bytes from byte {} on, but /bufferViews/{} has {} "
                             "bytes",
                             count, stride, offset, view, bytes.size()));
  return {bytes.data() + offset, stride};
}

void check_finite(const Document& document, const std::string& pointer,
                  const std::vector<double>& values, std::size_t components) {
  StopPoll poll;
  for (std::size_t i = 0; i < values.size(); ++i, poll())
    if (!std::isfinite(values[i]))
      document.context().fail(pointer, fmt::format("element {} has the value {}, allowed: finite",
                                                   i / components, values[i]));
}

void apply_sparse(const Document& document, const std::string& pointer,
                  const tinygltf::Accessor& accessor, std::size_t components,
                  std::vector<double>& values) {
  const auto& sparse = accessor.sparse;
  const auto count = static_cast<std::size_t>(sparse.count);
  const std::string at = pointer + "/sparse";
  const std::size_t size = size_of(accessor.componentType);
  const Elements places =
      elements(document, at + "/indices", static_cast<std::size_t>(sparse.indices.bufferView),
               static_cast<std::size_t>(sparse.indices.byteOffset), count,
               size_of(sparse.indices.componentType), false);
  const Elements changed =
      elements(document, at + "/values", static_cast<std::size_t>(sparse.values.bufferView),
               static_cast<std::size_t>(sparse.values.byteOffset), count, components * size, false);
  StopPoll poll;
  for (std::size_t i = 0; i < count; ++i, poll()) {
    const auto place = static_cast<std::size_t>(
        number_at(places.first + i * places.stride, sparse.indices.componentType, false));
    if (place >= accessor.count)
      document.context().fail(at + "/indices", fmt::format("index {} is {}, allowed: 0 to {}", i,
                                                           place, accessor.count - 1));
    for (std::size_t k = 0; k < components; ++k)
      values[place * components + k] = number_at(changed.first + i * changed.stride + k * size,
                                                 accessor.componentType, accessor.normalized);
  }
}

std::string accessor_pointer(std::size_t index) { return fmt::format("/accessors/{}", index); }

}  // namespace

std::size_t components_of(const Document& document, std::size_t index) {
  return static_cast<std::size_t>(tinygltf::GetNumComponentsInType(
      static_cast<std::uint32_t>(document.model().accessors[index].type)));
}

std::vector<double> read_numbers(const Document& document, std::size_t index,
                                 std::size_t components, bool is_mended) {
  LoadState& context = document.context();
  const tinygltf::Accessor& accessor = document.model().accessors[index];
  const std::string pointer = accessor_pointer(index);
  if (components_of(document, index) != components)
    context.fail(pointer + "/type", fmt::format("found {} components, allowed here: {}",
                                                components_of(document, index), components));
  // Columns of other matrices are padded.
  if (components == 9 && size_of(accessor.componentType) != 4)
    context.fail(pointer + "/componentType", "a matrix of small integers, allowed: floats");
  context.poll();
  const std::size_t size = size_of(accessor.componentType);
  std::vector<double> values;
  if (accessor.bufferView >= 0) {
    const Elements from = elements(document, pointer, static_cast<std::size_t>(accessor.bufferView),
                                   accessor.byteOffset, accessor.count, components * size, true);
    context.claim(pointer, accessor.count, components * sizeof(double));
    values.reserve(accessor.count * components);
    StopPoll poll;
    for (std::size_t i = 0; i < accessor.count; ++i, poll())
      for (std::size_t k = 0; k < components; ++k)
        values.push_back(number_at(from.first + i * from.stride + k * size, accessor.componentType,
                                   accessor.normalized));
  } else {
    if (accessor.count > kMostZeros)
      context.fail(pointer + "/count", fmt::format("found {} elements without bytes, allowed: {}",
                                                   accessor.count, kMostZeros));
    context.claim(pointer, accessor.count, components * sizeof(double));
    values.assign(accessor.count * components, 0.0);
  }
  if (accessor.sparse.isSparse) apply_sparse(document, pointer, accessor, components, values);
  if (accessor.componentType == TINYGLTF_COMPONENT_TYPE_FLOAT && !is_mended)
    check_finite(document, pointer, values, components);
  return values;
}

std::vector<std::uint32_t> read_indices(const Document& document, std::size_t index) {
  const int type = document.model().accessors[index].componentType;
  if (type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE &&
      type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT &&
      type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT)
    document.context().fail(accessor_pointer(index) + "/componentType",
                            fmt::format("found {}, allowed for indices: 5121, 5123, 5125", type));
  if (document.model().accessors[index].normalized)
    document.context().fail(accessor_pointer(index) + "/normalized",
                            "found true, allowed for indices: false");
  const std::vector<double> values = read_numbers(document, index, 1);
  std::vector<std::uint32_t> result;
  result.reserve(values.size());
  StopPoll poll;
  for (const double value : values) poll(), result.push_back(static_cast<std::uint32_t>(value));
  return result;
}

}  // namespace lucerna::gltf
