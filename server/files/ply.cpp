#include "server/files/ply.h"

#include <absl/status/status.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string>

#include "lights/maths/stop_poll.h"
#include "proto/common/status_macros.h"
#include "server/files/ply_header.h"
#include "server/files/ply_numbers.h"

namespace lucerna::ply {
namespace {

/// The use of a property's numbers.
enum Role : std::uint8_t { kX, kY, kZ, kNx, kNy, kNz, kU, kV, kCorners, kSkip };

class Reader {
 public:
  Reader(const Header& header, std::stop_token stop, LoadBudget* budget)
      : header_(header), numbers_(header.data, header.encoding), stop_(std::move(stop)) {
    mesh_.share = LoadBudget::Share(budget);
  }

  absl::StatusOr<PlyMesh> read() {
    bool has_vertices = false;
    bool has_faces = false;
    for (const Element& element : header_.elements) {
      bool& seen = element.name == "vertex" ? has_vertices : has_faces;
      const bool known = element.name == "vertex" || element.name == "face";
      if (known && seen) return error(fmt::format("element \"{}\" twice", element.name));
      LUCERNA_RETURN_IF_ERROR(read_element(element));
      if (known) seen = true;
      has_vertices_ = has_vertices;
    }
    if (!has_vertices) return error("no element \"vertex\"");
    if (!has_faces) return error("no element \"face\"");
    // Faces may precede the vertices that they use, so check again.
    StopPoll poll;
    for (const std::uint32_t index : mesh_.indices) {
      poll();
      if (index >= mesh_.positions.size())
        return error(fmt::format("a face uses vertex {}, but there are {} vertices", index,
                                 mesh_.positions.size()));
    }
    LUCERNA_RETURN_IF_ERROR(mend_places());
    return std::move(mesh_);
  }

 private:
  absl::StatusOr<std::vector<Role>> roles(const Element& element) {
    constexpr std::array<std::string_view, 6> kNames{"x", "y", "z", "nx", "ny", "nz"};
    // The names that pbrt-v4 accepts, in its order; the first pair found counts.
    constexpr std::array<std::array<std::string_view, 2>, 4> kUvNames{
        {{"u", "v"}, {"s", "t"}, {"texture_u", "texture_v"}, {"texture_s", "texture_t"}}};
    const auto has = [&](std::string_view name) {
      return std::ranges::any_of(
          element.properties, [&](const Property& p) { return !p.count_type && p.name == name; });
    };
    const auto uv_names = std::ranges::find_if(
        kUvNames, [&](const auto& pair) { return has(pair[0]) && has(pair[1]); });
    std::vector<Role> result(element.properties.size(), kSkip);
    std::array<bool, kSkip> found{};
    for (std::size_t i = 0; i < result.size(); ++i) {
      const Property& property = element.properties[i];
      if (element.name == "face" && property.count_type &&
          (property.name == "vertex_indices" || property.name == "vertex_index"))
        result[i] = kCorners;
      for (std::uint8_t role = kX; element.name == "vertex" && role <= kNz; ++role)
        if (!property.count_type && property.name == kNames[role]) result[i] = Role(role);
      if (element.name == "vertex" && uv_names != kUvNames.end() && !property.count_type)
        for (std::size_t k = 0; k < 2; ++k)
          if (property.name == (*uv_names)[k]) result[i] = k == 0 ? kU : kV;
      if (result[i] == kSkip) continue;
      if (found[result[i]]) return error(fmt::format("property \"{}\" twice", property.name));
      found[result[i]] = true;
    }
    if (element.name == "vertex" && !(found[kX] && found[kY] && found[kZ]))
      return error("element \"vertex\" needs x, y and z");
    if (element.name == "face" && !found[kCorners])
      return error("element \"face\" needs the list \"vertex_indices\"");
    has_normals_ = element.name == "vertex" ? found[kNx] && found[kNy] && found[kNz] : has_normals_;
    if (element.name == "vertex") has_uv_ = uv_names != kUvNames.end();
    return result;
  }

  absl::Status read_element(const Element& element) {
    LUCERNA_ASSIGN_OR_RETURN(auto role, roles(element));
    if (element.properties.empty() && element.count > 0)
      return error(fmt::format("element \"{}\" has no properties", element.name));
    std::uint64_t least = 0;
    for (const Property& property : element.properties)
      least += numbers_.least_bytes(property.count_type.value_or(property.type));
    if (element.count > 0 && element.count > numbers_.bytes_left() / least)
      return error(fmt::format("{} elements \"{}\" announced, but the data are too short",
                               element.count, element.name));
    if (element.name == "vertex") {
      LUCERNA_RETURN_IF_ERROR(
          mesh_.share.grow(element.count * (sizeof(Vec3) + (has_normals_ ? sizeof(Vec3f) : 0) +
                                            (has_uv_ ? sizeof(Vec2f) : 0))));
      mesh_.positions.reserve(element.count);
      if (has_normals_) mesh_.normals.reserve(element.count);
      if (has_uv_) mesh_.uv.reserve(element.count);
    } else if (element.name == "face") {
      LUCERNA_RETURN_IF_ERROR(make_room_for_quads(element, role));
      const std::uint64_t triangles = element.count + mesh_.quads.capacity();
      LUCERNA_RETURN_IF_ERROR(mesh_.share.grow(3 * triangles * sizeof(std::uint32_t)));
      mesh_.indices.reserve(3 * triangles);
    }
    if (numbers_.encoding() != Encoding::kAscii) {
      if (element.name == "vertex" && has_no_list(element)) return read_vertices(element, role);
      if (is_plain_face(element)) return read_plain_faces(element);
    }
    for (std::uint64_t i = 0; i < element.count; ++i) {
      if ((i & 0xffff) == 0 && stop_.stop_requested())
        return absl::CancelledError("loading was cancelled");
      LUCERNA_RETURN_IF_ERROR(read_one(element, role, i));
    }
    return absl::OkStatus();
  }

  // Binary data of the usual form are read in bulk.
  static constexpr std::uint64_t kRowsAtOnce = 1 << 14;  // so that they stay in the cache

  static bool has_no_list(const Element& element) {
    return std::ranges::none_of(element.properties,
                                [](const Property& p) { return p.count_type.has_value(); });
  }

  /// Reads vertices, one property after the other.  The data are long enough.
  absl::Status read_vertices(const Element& element, const std::vector<Role>& role) {
    const bool swapped = numbers_.encoding() == Encoding::kBigEndian;
    std::size_t stride = 0;
    for (const Property& property : element.properties) stride += size_of(property.type);
    for (std::uint64_t first = 0; first < element.count; first += kRowsAtOnce) {
      if (stop_.stop_requested()) return absl::CancelledError("loading was cancelled");
      const std::uint64_t rows = std::min(kRowsAtOnce, element.count - first);
      const char* block = numbers_.take(rows * stride);
      mesh_.positions.resize(first + rows);
      if (has_normals_) mesh_.normals.resize(first + rows);
      if (has_uv_) mesh_.uv.resize(first + rows);
      for (std::size_t p = 0; p < role.size(); block += size_of(element.properties[p++].type)) {
        const auto into = [&]<typename V, typename C>(std::vector<V>& values, C V::*component) {
          with_type(element.properties[p].type, [&]<typename T>() {
            const char* at = block;
            for (std::uint64_t i = first; i < first + rows; ++i, at += stride)
              values[i].*component = static_cast<C>(load<T>(at, swapped));
          });
        };
        constexpr std::array kOfPosition{&Vec3::x, &Vec3::y, &Vec3::z};
        constexpr std::array kOfNormal{&Vec3f::x, &Vec3f::y, &Vec3f::z};
        if (role[p] <= kZ)
          into(mesh_.positions, kOfPosition[role[p] - kX]);
        else if (role[p] <= kNz && has_normals_)
          into(mesh_.normals, kOfNormal[role[p] - kNx]);
        else if (role[p] == kU || role[p] == kV)
          into(mesh_.uv, role[p] == kU ? &Vec2f::x : &Vec2f::y);
      }
      for (std::uint64_t i = first; i < first + rows; ++i) check_vertex(i);
    }
    return absl::OkStatus();
  }

  void check_vertex(std::uint64_t i) {
    all_finite_ &= is_finite(mesh_.positions[i]);
    if (has_uv_ && !(std::isfinite(mesh_.uv[i].x) && std::isfinite(mesh_.uv[i].y))) {
      mesh_.uv[i] = {0, 0};
      ++mesh_.mended_uv;
    }
  }

  /// Moves vertices that are not finite to another one.  Fails if a face uses one.
  absl::Status mend_places() {
    if (all_finite_) return absl::OkStatus();
    StopPoll poll;
    for (const std::uint32_t index : mesh_.indices) {
      poll();
      if (!is_finite(mesh_.positions[index]))
        return error(fmt::format("vertex {} is not finite", index));
    }
    const Vec3 place = mesh_.indices.empty() ? Vec3{} : mesh_.positions[mesh_.indices[0]];
    for (Vec3& p : mesh_.positions) {
      poll();
      if (!is_finite(p)) p = place;
    }
    return absl::OkStatus();
  }

  /// Whether each face is only its corners: a count of one byte, then indices of four.
  bool is_plain_face(const Element& element) const {
    if (element.name != "face" || element.properties.size() != 1 ||
        numbers_.encoding() != Encoding::kLittleEndian)
      return false;
    const Property& p = element.properties[0];
    return (p.type == Type::kInt32 || p.type == Type::kUint32) &&
           (p.count_type == Type::kUint8 || p.count_type == Type::kInt8);
  }

  absl::Status read_plain_faces(const Element& element) {
    const Property& property = element.properties[0];
    // A negative index is a large one here.
    const std::uint64_t most = property.type == Type::kInt32 ? 0x7fffffff : 0xffffffff;
    const std::uint64_t vertices = has_vertices_ ? mesh_.positions.size() : most + 1;
    for (std::uint64_t face = 0; face < element.count; ++face) {
      if (face % kRowsAtOnce == 0 && stop_.stop_requested())
        return absl::CancelledError("loading was cancelled");
      const std::string_view rest = numbers_.rest();
      constexpr std::size_t kTriangleBytes = 13;
      std::array<std::uint32_t, 3> corner;
      if (rest.size() >= kTriangleBytes && rest[0] == 3) {
        std::memcpy(corner.data(), rest.data() + 1, sizeof corner);
        if (std::max({corner[0], corner[1], corner[2]}) < vertices) {
          mesh_.indices.insert(mesh_.indices.end(), corner.begin(), corner.end());
          numbers_.take(kTriangleBytes);
          continue;
        }
      }
      LUCERNA_RETURN_IF_ERROR(read_face(property, face));
    }
    return absl::OkStatus();
  }

  absl::Status read_one(const Element& element, const std::vector<Role>& role, std::uint64_t i) {
    std::array<double, kCorners> value{};
    for (std::size_t p = 0; p < role.size(); ++p) {
      const Property& property = element.properties[p];
      if (role[p] == kCorners) {
        LUCERNA_RETURN_IF_ERROR(read_face(property, i));
        continue;
      }
      double n = 0;
      if (!next(property, n)) return cut_off(element.name, i);
      if (role[p] < kCorners) value[role[p]] = n;
    }
    if (element.name != "vertex") return absl::OkStatus();
    const Vec3 position{value[kX], value[kY], value[kZ]};
    mesh_.positions.push_back(position);
    if (has_uv_) mesh_.uv.push_back({static_cast<float>(value[kU]), static_cast<float>(value[kV])});
    if (has_normals_) mesh_.normals.emplace_back(Vec3{value[kNx], value[kNy], value[kNz]});
    check_vertex(i);
    return absl::OkStatus();
  }

  absl::Status read_face(const Property& property, std::uint64_t face) {
    double count = 0;
    if (!numbers_.next(*property.count_type, count)) return cut_off("face", face);
    if (count != 3 && count != 4) {
      if (!skip(property.type, count)) return cut_off("face", face);
      ++(count < 3 ? mesh_.short_faces : mesh_.long_faces);
      return absl::OkStatus();
    }
    std::array<std::uint32_t, 4> corner{};
    for (int k = 0; k < static_cast<int>(count); ++k) {
      double index = 0;
      if (!numbers_.next(property.type, index)) return cut_off("face", face);
      if (!(index >= 0 && index <= 4294967295.0) || index != std::floor(index))
        return error(fmt::format("face {} uses vertex {}", face, index));
      corner[k] = static_cast<std::uint32_t>(index);
      if (has_vertices_ && corner[k] >= mesh_.positions.size())
        return error(fmt::format("face {} uses vertex {}, but there are {} vertices", face,
                                 corner[k], mesh_.positions.size()));
    }
    mesh_.indices.insert(mesh_.indices.end(), {corner[0], corner[1], corner[2]});
    if (count == 4) {
      LUCERNA_RETURN_IF_ERROR(make_room_for_quad());
      mesh_.indices.insert(mesh_.indices.end(), {corner[0], corner[2], corner[3]});
      mesh_.quads.push_back(static_cast<std::uint32_t>(mesh_.indices.size() / 3 - 2));
    }
    return absl::OkStatus();
  }

  /// Counts the quadrilaterals of binary faces with indices of one byte, so that lists get their
  /// size at once.  Such faces are short, and lists that grow would need too much memory for them.
  absl::Status make_room_for_quads(const Element& element, const std::vector<Role>& role) {
    const auto corners = static_cast<std::size_t>(std::ranges::find(role, kCorners) - role.begin());
    if (numbers_.encoding() == Encoding::kAscii || size_of(element.properties[corners].type) > 1)
      return absl::OkStatus();
    const Numbers begin = numbers_;
    std::uint64_t quads = 0;
    for (std::uint64_t i = 0; i < element.count; ++i) {
      if ((i & 0xffff) == 0 && stop_.stop_requested())
        return absl::CancelledError("loading was cancelled");
      for (std::size_t p = 0; p < role.size(); ++p) {
        const Property& property = element.properties[p];
        double n = 0;
        if (!next(property, n)) return cut_off(element.name, i);
        if (p == corners && n == 4) ++quads;
      }
    }
    numbers_ = begin;
    LUCERNA_RETURN_IF_ERROR(mesh_.share.grow(quads * sizeof(std::uint32_t)));
    mesh_.quads.reserve(quads);
    return absl::OkStatus();
  }

  /// Quadrilaterals need more room than read_element() made.
  absl::Status make_room_for_quad() {
    const auto make_room = [&](std::vector<std::uint32_t>& list, std::size_t count) {
      if (list.size() + count <= list.capacity()) return absl::OkStatus();
      const std::size_t more = std::max<std::size_t>(list.capacity(), 1024);
      LUCERNA_RETURN_IF_ERROR(mesh_.share.grow(more * sizeof(std::uint32_t)));
      list.reserve(list.capacity() + more);
      return absl::OkStatus();
    };
    LUCERNA_RETURN_IF_ERROR(make_room(mesh_.quads, 1));
    return make_room(mesh_.indices, 3);
  }

  /// Reads a number, or the length of a list whose numbers it skips.
  bool next(const Property& property, double& value) {
    if (!property.count_type) return numbers_.next(property.type, value);
    return numbers_.next(*property.count_type, value) && skip(property.type, value);
  }

  bool skip(Type type, double count) {
    const auto least = static_cast<double>(numbers_.least_bytes(type));
    if (!(count >= 0) || count != std::floor(count) ||
        count * least > static_cast<double>(numbers_.bytes_left()))
      return false;
    double ignored = 0;
    for (auto left = static_cast<std::uint64_t>(count); left > 0; --left)
      if (!numbers_.next(type, ignored)) return false;
    return true;
  }

  static absl::Status cut_off(const std::string& element, std::uint64_t i) {
    return error(fmt::format("{} {}: the data end or do not contain a number", element, i));
  }

  const Header& header_;
  Numbers numbers_;
  std::stop_token stop_;
  PlyMesh mesh_;
  bool has_vertices_ = false, all_finite_ = true;
  bool has_normals_ = false, has_uv_ = false;
};

}  // namespace
}  // namespace lucerna::ply

namespace lucerna {

absl::StatusOr<PlyMesh> parse_ply(std::string_view bytes, std::stop_token stop,
                                  LoadBudget* budget) {
  LUCERNA_ASSIGN_OR_RETURN(const auto header, ply::parse_header(bytes));
  return ply::Reader(header, std::move(stop), budget).read();
}

}  // namespace lucerna
