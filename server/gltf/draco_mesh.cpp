#include "server/gltf/draco_mesh.h"

#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>
#include <draco/core/decoder_buffer.h>
#include <draco/core/varint_decoding.h>
#include <draco/mesh/mesh.h>
#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <memory>
#include <utility>

#include "lights/maths/stop_poll.h"

namespace lucerna::gltf {
namespace {

/// What the decoder may allocate.  It outlives the decoder, which knows no errors of ours.
class Allowance {
 public:
  explicit Allowance(const LoadState& context)
      : most_faces_(context.meter.limits().max_primitives), share_(context.meter.budget()) {}

  bool allows_faces(std::uint64_t faces) {
    if (faces > most_faces_)
      error_ = absl::ResourceExhaustedError(
          fmt::format("a compressed mesh of {} triangles, allowed: {}", faces, most_faces_));
    return error_.ok();
  }
  bool allows(std::uint64_t count, std::uint64_t bytes_each) {
    const std::uint64_t bytes = count * bytes_each;  // below 2^32 and below 2^20
    if (share_.bytes() + bytes > kMostUnpackedBytes) {
      error_ = absl::ResourceExhaustedError(
          fmt::format("a compressed mesh needs {} bytes to unpack, allowed: {}",
                      share_.bytes() + bytes, kMostUnpackedBytes));
    } else if (absl::Status status = share_.grow(bytes); !status.ok()) {
      error_ = std::move(status);
    }
    return error_.ok();
  }
  const absl::Status& error() const { return error_; }

 private:
  std::uint64_t most_faces_;
  LoadBudget::Share share_;
  absl::Status error_;
};

// The decoder's memory in bytes, as measured with Draco 1.5.5 and rounded up.
constexpr std::uint64_t kBytesOfFace = 24;             // indices, twice
constexpr std::uint64_t kBytesOfEdgebreakerFace = 64;  // and the table of corners
constexpr std::uint64_t kBytesOfEdgebreakerVertex = 32;
constexpr std::uint64_t kBytesOfSeamFace = 16;  // for each attribute with seams of its own
constexpr std::uint64_t kBytesOfSeamVertex = 32;

/// One number of the header of the connectivity.  [Draco, "Bitstream Specification"]
bool read_number(draco::DecoderBuffer& buffer, bool is_varint, std::uint32_t& number) {
  return is_varint ? draco::DecodeVarint(&number, &buffer) : buffer.Decode(&number);
}

class SequentialCounts {
 public:
  using Decoder = draco::MeshSequentialDecoder;
  static bool allows(draco::DecoderBuffer header, std::uint16_t version, Allowance& allowance) {
    const bool is_varint = version >= DRACO_BITSTREAM_VERSION(2, 2);
    std::uint32_t faces = 0, points = 0;
    // Draco reports bytes that end too early.
    if (!read_number(header, is_varint, faces) || !read_number(header, is_varint, points))
      return true;
    return allowance.allows_faces(faces) && allowance.allows(faces, kBytesOfFace);
  }
};

class EdgebreakerCounts {
 public:
  using Decoder = draco::MeshEdgebreakerDecoder;
  static bool allows(draco::DecoderBuffer header, std::uint16_t version, Allowance& allowance) {
    const bool is_varint = version >= DRACO_BITSTREAM_VERSION(2, 0);
    std::uint32_t new_vertices = 0, vertices = 0, faces = 0;
    std::uint8_t attributes = 0;
    if (version < DRACO_BITSTREAM_VERSION(2, 2) && !read_number(header, is_varint, new_vertices))
      return true;
    if (!read_number(header, is_varint, vertices) || !read_number(header, is_varint, faces) ||
        !header.Decode(&attributes))
      return true;
    return allowance.allows_faces(faces) &&
           allowance.allows(faces, kBytesOfEdgebreakerFace + attributes * kBytesOfSeamFace) &&
           allowance.allows(std::uint64_t{vertices} + new_vertices,
                            kBytesOfEdgebreakerVertex + attributes * kBytesOfSeamVertex);
  }
};

/// Draco's decoder of one kind.  It asks before it allocates.
template <typename Counts>
class BoundedDecoder final : public Counts::Decoder {
 public:
  explicit BoundedDecoder(Allowance& allowance) : allowance_(allowance) {}

 protected:
  bool DecodeConnectivity() override {
    // A copy of the buffer: Draco reads the numbers again.
    return Counts::allows(*this->buffer(), this->bitstream_version(), allowance_) &&
           Counts::Decoder::DecodeConnectivity();
  }
  bool DecodeAllAttributes() override {
    // The attributes are known, and their values are not allocated yet.
    const draco::PointCloud& cloud = *this->point_cloud();
    for (int i = 0; i < cloud.num_attributes(); ++i) {
      const draco::PointAttribute& attribute = *cloud.attribute(i);
      // The values, their whole numbers, and the index of the value.
      const std::uint64_t bytes = static_cast<std::uint64_t>(attribute.byte_stride()) +
                                  4 * static_cast<std::uint64_t>(attribute.num_components()) + 4;
      if (!allowance_.allows(cloud.num_points(), bytes)) return false;
    }
    return Counts::Decoder::DecodeAllAttributes();
  }

 private:
  Allowance& allowance_;
};

template <typename Counts>
draco::Status decode(draco::DecoderBuffer& buffer, Allowance& allowance, draco::Mesh& mesh) {
  const draco::DecoderOptions options;
  return BoundedDecoder<Counts>(allowance).Decode(options, &buffer, &mesh);
}

std::unique_ptr<draco::Mesh> decoded(const View& place, std::string_view bytes) {
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  draco::DecoderBuffer begin = buffer;
  draco::DracoHeader header;
  draco::Status status = draco::PointCloudDecoder::DecodeHeader(&begin, &header);
  auto mesh = std::make_unique<draco::Mesh>();
  Allowance allowance(place.context());
  if (status.ok() && header.encoder_type != draco::TRIANGULAR_MESH)
    place.fail("Draco: the bytes hold a cloud of points, allowed: a mesh");
  if (status.ok()) {
    status = header.encoder_method == draco::MESH_SEQUENTIAL_ENCODING
                 ? decode<SequentialCounts>(buffer, allowance, *mesh)
             : header.encoder_method == draco::MESH_EDGEBREAKER_ENCODING
                 ? decode<EdgebreakerCounts>(buffer, allowance, *mesh)
                 : draco::Status(draco::Status::DRACO_ERROR, "Unknown encoding method.");
  }
  if (!allowance.error().ok()) place.fail(allowance.error());
  if (!status.ok()) place.fail(fmt::format("Draco: {}", printable(status.error_msg_string())));
  return mesh;
}

}  // namespace

DracoMesh unpack_draco(const View& packed, std::string_view bytes) {
  const std::unique_ptr<draco::Mesh> mesh = decoded(packed, bytes);
  DracoMesh result;
  const std::size_t points = mesh->num_points();
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
    packed.context().claim(place.pointer(), points, components * sizeof(double));
    DracoMesh::Attribute& to = result.attributes[name];
    to.components = components;
    to.values.resize(points * components);
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
