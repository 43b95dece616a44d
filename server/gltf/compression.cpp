#include "server/gltf/compression.h"

#include <fmt/format.h>
#include <meshoptimizer.h>

#include <array>
#include <cmath>

#include "lights/maths/stop_poll.h"
#include "server/gltf/draco_mesh.h"

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

DracoMesh unpack_draco(const View& packed, std::string_view bytes) {
  const std::unique_ptr<draco::Mesh> mesh = decode_draco(packed, bytes);
  DracoMesh result;
  result.points = mesh->num_points();
  const std::size_t faces = mesh->num_faces();
  packed.context().claim(packed.pointer(), faces, 3 * sizeof(std::uint32_t));
  result.indices.reserve(3 * faces);
  StopPoll poll;
  for (draco::FaceIndex f(0); f < mesh->num_faces(); ++f, poll())
    for (int k = 0; k < 3; ++k) result.indices.push_back(mesh->face(f)[k].value());

  const View attributes = packed.at("attributes");
  for (const auto& [name, id] : attributes.require_object().json().items()) {
    const View place = attributes.at(name);
    const draco::PointAttribute* from =
        mesh->GetAttributeByUniqueId(static_cast<std::uint32_t>(place.integer(0, 0xffff'ffff)));
    if (from == nullptr)
      place.fail(fmt::format("found {}, which is no attribute of the compressed mesh",
                             place.integer(0, 0xffff'ffff)));
    const std::size_t components = static_cast<std::size_t>(from->num_components());
    if (components < 1 || components > 4)
      place.fail(fmt::format("the attribute has {} components, allowed: 1 to 4", components));
    packed.context().claim(place.pointer(), result.points, components * sizeof(double));
    DracoMesh::Attribute& to = result.attributes[name];
    to.components = components;
    to.values.resize(result.points * components);
    std::array<float, 4> values{};
    for (draco::PointIndex p(0); p < mesh->num_points(); ++p, poll()) {
      // Normalised integers become their fractions.
      if (!from->ConvertValue<float>(from->mapped_index(p), static_cast<std::int8_t>(components),
                                     values.data()))
        place.fail("the attribute has values that cannot be read");
      for (std::size_t k = 0; k < components; ++k)
        to.values[p.value() * components + k] = values[k];
    }
  }
  return result;
}

}  // namespace lucerna::gltf
