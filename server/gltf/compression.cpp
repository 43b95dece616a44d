#include "server/gltf/compression.h"

#include <fmt/format.h>
#include <meshoptimizer.h>

namespace lucerna::gltf {
namespace {

void filter_meshopt(const View& packed, const std::string& filter, std::string& bytes,
                    std::size_t count, std::size_t stride) {
  if (filter == "OCTAHEDRAL") {
    if (stride != 4 && stride != 8)
      packed.at("byteStride").fail(fmt::format("found {}, allowed: 4 or 8", stride));
    meshopt_decodeFilterOct(bytes.data(), count, stride);
  } else if (filter == "QUATERNION") {
    if (stride != 8) packed.at("byteStride").fail(fmt::format("found {}, allowed: 8", stride));
    meshopt_decodeFilterQuat(bytes.data(), count, stride);
  } else if (filter == "EXPONENTIAL") {
    if (stride % 4 != 0)
      packed.at("byteStride").fail(fmt::format("found {}, allowed: multiples of 4", stride));
    meshopt_decodeFilterExp(bytes.data(), count, stride);
  } else if (filter != "NONE") {
    packed.at("filter").fail(fmt::format(
        "found \"{}\", allowed: NONE, OCTAHEDRAL, QUATERNION, EXPONENTIAL", printable(filter)));
  }
}

}  // namespace

std::string unpack_meshopt(const View& packed, std::string_view bytes) {
  const std::size_t count = packed.at("count").integer(1, 0xffff'ffff);
  const std::size_t stride = packed.at("byteStride").integer(1, 256);
  const std::string& mode = packed.at("mode").text();
  const std::string filter = packed.text("filter", "NONE");
  const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
  packed.context().claim_for_good(packed.pointer(), count, stride);
  std::string result;
  int error = 0;
  if (mode == "ATTRIBUTES") {
    if (stride % 4 != 0)
      packed.at("byteStride").fail(fmt::format("found {}, allowed: multiples of 4", stride));
    result.resize(count * stride);
    error = meshopt_decodeVertexBuffer(result.data(), count, stride, data, bytes.size());
  } else if (mode == "TRIANGLES" || mode == "INDICES") {
    if (stride != 2 && stride != 4)
      packed.at("byteStride").fail(fmt::format("found {}, allowed: 2 or 4", stride));
    if (mode == "TRIANGLES" && count % 3 != 0)
      packed.at("count").fail(fmt::format("found {}, allowed: multiples of 3", count));
    if (filter != "NONE") packed.at("filter").fail("found a filter of indices, allowed: NONE");
    result.resize(count * stride);
    error = mode == "TRIANGLES"
                ? meshopt_decodeIndexBuffer(result.data(), count, stride, data, bytes.size())
                : meshopt_decodeIndexSequence(result.data(), count, stride, data, bytes.size());
  } else {
    packed.at("mode").fail(
        fmt::format("found \"{}\", allowed: ATTRIBUTES, TRIANGLES, INDICES", printable(mode)));
  }
  if (error != 0)
    packed.fail(fmt::format("the {} bytes are not {} compressed elements", bytes.size(), count));
  filter_meshopt(packed, filter, result, count, stride);
  return result;
}

}  // namespace lucerna::gltf
