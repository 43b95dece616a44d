#include "server/gltf/gltf_mesh.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>

#include "lights/maths/stop_poll.h"
#include "server/description/raw_mesh.h"
#include "server/gltf/accessor.h"
#include "server/gltf/draco_mesh.h"

namespace lucerna::gltf {
namespace {

/// Whether vertices get another value where that of the file is not finite.
bool is_mended(std::string_view attribute) {
  return attribute == "NORMAL" || attribute == "TANGENT" || attribute.starts_with("TEXCOORD_");
}

/// The attributes of one primitive, from accessors or from compressed data.
class Attributes {
 public:
  /// `place` is the primitive in the JSON text.
  Attributes(const Document& document, const tinygltf::Primitive& primitive, const View& place)
      : document_(document), primitive_(primitive), pointer_(place.pointer()) {
    const auto packed = place.extension("KHR_draco_mesh_compression");
    if (!packed) return;
    const std::size_t view =
        packed->at("bufferView").index(document.model().bufferViews.size(), "bufferView");
    draco_ = unpack_draco(*packed, document.view_bytes(view, packed->pointer()));
  }

  const std::optional<DracoMesh>& draco() const { return draco_; }

  bool has(const std::string& name) const {
    return (draco_ && draco_->attributes.contains(name)) || primitive_.attributes.contains(name);
  }

  /// Numbers of an attribute, `components` for each of `count` vertices.
  std::vector<double> numbers(const std::string& name, std::size_t components,
                              std::optional<std::size_t> count) const {
    const std::string at = fmt::format("{}/attributes/{}", pointer_, printable(name));
    std::vector<double> values;
    if (draco_ && draco_->attributes.contains(name)) {
      const DracoMesh::Attribute& packed = draco_->attributes.at(name);
      if (packed.components != components)
        document_.context().fail(
            at, fmt::format("found {} components, allowed: {}", packed.components, components));
      values = packed.values;
      StopPoll poll;
      for (const double value : values) {
        poll();
        if (!std::isfinite(value) && !is_mended(name))
          document_.context().fail(at, "a compressed value is not finite");
      }
    } else {
      values = read_numbers(document_, static_cast<std::size_t>(primitive_.attributes.at(name)),
                            components, is_mended(name));
    }
    if (count && values.size() != *count * components)
      document_.context().fail(at, fmt::format("found {} elements, but there are {} vertices",
                                               values.size() / components, *count));
    return values;
  }

  /// The number of components of an attribute in an accessor.
  std::size_t components(const std::string& name) const {
    if (draco_ && draco_->attributes.contains(name)) return draco_->attributes.at(name).components;
    return components_of(document_, static_cast<std::size_t>(primitive_.attributes.at(name)));
  }

 private:
  const Document& document_;
  const tinygltf::Primitive& primitive_;
  std::string pointer_;
  std::optional<DracoMesh> draco_;
};

std::vector<Vec3> vectors(const std::vector<double>& numbers) {
  std::vector<Vec3> result;
  result.reserve(numbers.size() / 3);
  StopPoll poll;
  for (std::size_t i = 0; i + 3 <= numbers.size(); i += 3, poll())
    result.emplace_back(numbers[i], numbers[i + 1], numbers[i + 2]);
  return result;
}

/// Three indices for each triangle of strips and fans.  [glTF2, 3.7.2.1]
std::vector<std::uint32_t> triangles(int mode, const std::vector<std::uint32_t>& corners) {
  std::vector<std::uint32_t> result;
  if (mode == TINYGLTF_MODE_TRIANGLES) {
    result.assign(corners.begin(), corners.end() - static_cast<std::ptrdiff_t>(corners.size() % 3));
    return result;
  }
  if (corners.size() < 3) return result;
  result.reserve(3 * (corners.size() - 2));
  StopPoll poll;
  for (std::size_t i = 0; i + 2 < corners.size(); ++i, poll()) {
    const bool is_fan = mode == TINYGLTF_MODE_TRIANGLE_FAN;
    const std::size_t turned = is_fan ? 0 : i % 2;
    const std::uint32_t a = is_fan ? corners[i + 1] : corners[i];
    const std::uint32_t b = is_fan ? corners[i + 2] : corners[i + 1 + turned];
    const std::uint32_t c = is_fan ? corners[0] : corners[i + 2 - turned];
    result.insert(result.end(), {a, b, c});
  }
  return result;
}

/// Adds the weighted differences of morph targets.  [glTF2, 3.7.2.2]
void morph(const Document& document, const tinygltf::Primitive& primitive,
           const std::string& pointer, const std::vector<double>& weights,
           const std::string& attribute, std::vector<Vec3>& values) {
  StopPoll poll;
  for (std::size_t t = 0; t < primitive.targets.size() && t < weights.size(); ++t) {
    const auto found = primitive.targets[t].find(attribute);
    if (weights[t] == 0 || found == primitive.targets[t].end()) continue;
    const auto change = vectors(
        read_numbers(document, static_cast<std::size_t>(found->second), 3, is_mended(attribute)));
    if (change.size() != values.size())
      document.context().fail(fmt::format("{}/targets/{}/{}", pointer, t, attribute),
                              fmt::format("found {} elements, but there are {} vertices",
                                          change.size(), values.size()));
    for (std::size_t i = 0; i < values.size(); ++i, poll()) values[i] += weights[t] * change[i];
  }
}

/// The matrix of each vertex: the weighted mean of those of its joints.
std::vector<Matrix> skinned(const Document& document, const Attributes& attributes,
                            const std::string& pointer, const std::vector<Matrix>& joints,
                            std::size_t count) {
  LoadState& context = document.context();
  context.claim(pointer, count, sizeof(Matrix));
  std::vector<Matrix> result(count, Matrix{});
  std::vector<double> total(count, 0.0);
  StopPoll poll;
  for (std::size_t set = 0; attributes.has(fmt::format("JOINTS_{}", set)); ++set) {
    const std::string name = fmt::format("JOINTS_{}", set);
    if (!attributes.has(fmt::format("WEIGHTS_{}", set)))
      context.fail(pointer + "/attributes", fmt::format("{} without WEIGHTS_{}", name, set));
    const std::vector<double> of = attributes.numbers(name, 4, count);
    const std::vector<double> by = attributes.numbers(fmt::format("WEIGHTS_{}", set), 4, count);
    for (std::size_t i = 0; i < of.size(); ++i, poll()) {
      if (by[i] == 0) continue;
      if (!(of[i] >= 0 && of[i] < static_cast<double>(joints.size())))
        context.fail(fmt::format("{}/attributes/{}", pointer, name),
                     fmt::format("vertex {} names joint {}, allowed: 0 to {}", i / 4, of[i],
                                 joints.size() - 1));
      const Matrix& joint = joints[static_cast<std::size_t>(of[i])];
      for (std::size_t r = 0; r < 3; ++r)
        for (std::size_t c = 0; c < 4; ++c) result[i / 4][r][c] += by[i] * joint[r][c];
      total[i / 4] += by[i];
    }
  }
  for (std::size_t i = 0; i < count; ++i, poll()) {
    if (!(total[i] > 0)) {
      result[i] = joints[0];  // a vertex without weights
      continue;
    }
    // Weights of small integers add up to 1 only nearly.
    for (auto& row : result[i])
      for (double& x : row) x /= total[i];
  }
  return result;
}

/// Sets the unit normals.  Mends those without a direction, with a remark.
void set_normals(LoadState& context, const std::vector<Vec3>& normals, Part& part) {
  part.mesh.normals.reserve(normals.size());
  StopPoll poll;
  for (const Vec3& normal : normals) {
    poll();
    const Vec3 n = normalized(normal);
    part.mesh.normals.emplace_back(is_finite(n) ? n : Vec3{});
  }
  const std::size_t mended = mend_normals<3>(
      part.mesh, false, [](const auto& p) { return cross(p[1] - p[0], p[2] - p[0]); });
  if (mended > 0)
    context.remark(part.pointer + "/attributes/NORMAL",
                   fmt::format("{} of {} normals have no direction", mended, normals.size()),
                   mended == normals.size() ? "the mesh has no vertex normals"
                                            : "the mean of the faces around each");
}

/// The (u, v) of the corners in the picture.  Triangles within one repetition of the picture are
/// moved to it.
std::vector<Vec2f> corner_uv(LoadState& context, const std::string& pointer,
                             const MaterialEmission& emission, const std::vector<double>& uv,
                             const std::vector<std::uint32_t>& indices) {
  std::vector<Vec2f> result;
  result.reserve(indices.size());
  StopPoll poll;
  for (std::size_t i = 0; i + 3 <= indices.size(); i += 3, poll()) {
    double at[2][3];
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t axis = 0; axis < 2; ++axis)
        at[axis][k] = emission.uv[axis][0] * uv[2 * indices[i + k]] +
                      emission.uv[axis][1] * uv[2 * indices[i + k] + 1] + emission.uv[axis][2];
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const TextureWrap wrap = axis == 0 ? emission.wrap_u : emission.wrap_v;
      double* x = at[axis];
      const double tile =
          std::floor((std::min({x[0], x[1], x[2]}) + std::max({x[0], x[1], x[2]})) / 2);
      for (std::size_t k = 0; k < 3; ++k) {
        if (wrap == TextureWrap::kClamp) continue;
        x[k] -= tile;
        if (wrap == TextureWrap::kMirror && std::fmod(tile, 2) != 0) x[k] = 1 - x[k];
        constexpr double kRounding = 1e-5;
        if (x[k] < -kRounding || x[k] > 1 + kRounding)
          context.remark(pointer,
                         "an emissive picture that repeats within a triangle is not modelled",
                         "its border texels continue");
      }
    }
    for (std::size_t k = 0; k < 3; ++k)
      result.push_back({static_cast<float>(at[0][k]), static_cast<float>(at[1][k])});
  }
  return result;
}

/// The (u, v) of the corners for textures, v upwards.
std::vector<Vec2f> texture_uv(const std::vector<double>& uv,
                              const std::vector<std::uint32_t>& indices) {
  std::vector<Vec2f> result;
  result.reserve(indices.size());
  StopPoll poll;
  for (const std::uint32_t i : indices)
    poll(),
        result.push_back({static_cast<float>(uv[2 * i]), static_cast<float>(1 - uv[2 * i + 1])});
  return result;
}

/// Sets the (u, v) that the material of a part needs.
void set_uv(LoadState& context, const Attributes& attributes, std::size_t count, Part& part) {
  const auto* emission =
      part.use.emission && part.use.emission->picture ? part.use.emission.get() : nullptr;
  if (emission == nullptr && !part.use.uv_set) return;
  const std::string set =
      fmt::format("TEXCOORD_{}", emission != nullptr ? emission->uv_set : *part.use.uv_set);
  // Without coordinates every point shows (0, 0).
  std::vector<double> uv(2 * count, 0.0);
  if (attributes.has(set)) {
    uv = attributes.numbers(set, 2, count);
    std::size_t mended = 0;
    StopPoll poll;
    for (std::size_t i = 0; i < uv.size(); i += 2, poll()) {
      if (std::isfinite(uv[i]) && std::isfinite(uv[i + 1])) continue;
      uv[i] = uv[i + 1] = 0;
      ++mended;
    }
    if (mended > 0)
      context.remark(fmt::format("{}/attributes/{}", part.pointer, set),
                     fmt::format("the (u, v) of {} vertices are not finite", mended),
                     "(u, v) 0, 0");
  } else {
    context.remark(part.pointer + "/attributes",
                   fmt::format("{}, which a texture of the material needs, is missing", set),
                   "every point has the (u, v) 0, 0");
  }
  context.claim(part.pointer, part.mesh.indices.size(), sizeof(Vec2f));
  part.mesh.corner_uv = emission != nullptr
                            ? corner_uv(context, part.pointer, *emission, uv, part.mesh.indices)
                            : texture_uv(uv, part.mesh.indices);
}

/// Sets the colours of the vertices, linear as in the file.  [glTF2, 3.7.2.1]
void set_colours(LoadState& context, const Attributes& attributes, std::size_t count, Part& part) {
  const std::string at = part.pointer + "/attributes/COLOR_0";
  const std::size_t components = attributes.components("COLOR_0");
  if (components != 3 && components != 4)
    context.fail(at, fmt::format("found {} components, allowed: 3 or 4", components));
  const std::vector<double> values = attributes.numbers("COLOR_0", components, count);
  context.claim(part.pointer, count, sizeof(Rgbf));
  part.mesh.colours.reserve(count);
  bool is_opaque = true;
  StopPoll poll;
  for (std::size_t i = 0; i < values.size(); i += components, poll()) {
    for (std::size_t k = 0; k < components; ++k)
      if (!(values[i + k] >= 0 && values[i + k] <= 1))
        context.fail(at, fmt::format("element {} has the value {}, allowed: 0 to 1", i / components,
                                     values[i + k]));
    part.mesh.colours.push_back(Rgbf(Rgb(values[i], values[i + 1], values[i + 2])));
    is_opaque = is_opaque && (components == 3 || values[i + 3] == 1);
  }
  const NumberValue& alpha = part.use.alpha;
  if (!is_opaque && !(alpha.is_constant() && alpha.constant == 1))
    context.remark(at, "the alpha of vertex colours is not modelled", "that of the material");
}

/// The tangents of the vertices.  Without them the frame follows (u, v).  [glTF2, 3.7.2.1]
std::vector<VertexTangent> tangents(LoadState& context, const std::string& pointer,
                                    const std::vector<Vec3>& along,
                                    const std::vector<double>& given) {
  std::vector<VertexTangent> result;
  context.claim(pointer, along.size(), sizeof(VertexTangent));
  result.reserve(along.size());
  std::size_t without = 0;
  StopPoll poll;
  for (std::size_t i = 0; i < along.size(); ++i, poll()) {
    const Vec3 t = normalized(along[i]);
    without += !is_finite(t);
    result.push_back({is_finite(t) ? Vec3f(t) : Vec3f{}, given[4 * i + 3] < 0 ? -1.0F : 1.0F});
  }
  if (without > 0)
    context.remark(pointer + "/attributes/TANGENT",
                   fmt::format("{} of {} tangents have no direction", without, along.size()),
                   "the frame follows the other tangents, or (u, v)");
  return result;
}

/// What a deformation moves, for each vertex.
struct Vertices {
  std::vector<Vec3> positions, normals, along_u;  ///< the last two may be missing
  std::vector<double> tangents;                   ///< of the file, four for each of `along_u`
};

Vertices read_vertices(const Attributes& attributes, bool needs_tangents) {
  Vertices v;
  v.positions = vectors(attributes.numbers("POSITION", 3, std::nullopt));
  const std::size_t count = v.positions.size();
  if (attributes.has("NORMAL")) v.normals = vectors(attributes.numbers("NORMAL", 3, count));
  // Tangents count only with normals.  [glTF2, 3.7.2.1]
  if (!needs_tangents || !attributes.has("TANGENT") || v.normals.empty()) return v;
  v.tangents = attributes.numbers("TANGENT", 4, count);
  StopPoll poll;
  for (std::size_t i = 0; i < v.tangents.size(); i += 4, poll())
    v.along_u.emplace_back(v.tangents[i], v.tangents[i + 1], v.tangents[i + 2]);
  return v;
}

/// Three indices for each triangle of a primitive of `count` vertices.
std::vector<std::uint32_t> read_triangles(const Document& document,
                                          const tinygltf::Primitive& primitive, int mode,
                                          const std::string& pointer, const Attributes& attributes,
                                          std::size_t count) {
  LoadState& context = document.context();
  std::vector<std::uint32_t> corners;
  StopPoll poll;
  if (attributes.draco()) {
    corners = attributes.draco()->indices;
    mode = TINYGLTF_MODE_TRIANGLES;
  } else if (primitive.indices >= 0) {
    corners = read_indices(document, static_cast<std::size_t>(primitive.indices));
  } else {
    context.claim(pointer, count, sizeof(std::uint32_t));
    corners.resize(count);
    for (std::size_t i = 0; i < count; ++i, poll()) corners[i] = static_cast<std::uint32_t>(i);
  }
  for (std::size_t i = 0; i < corners.size(); ++i, poll())
    if (corners[i] >= count)
      context.fail(
          pointer + "/indices",
          fmt::format("index {} names vertex {}, but there are {} vertices", i, corners[i], count));
  context.claim(pointer, corners.size(), 3 * sizeof(std::uint32_t));
  return triangles(mode, corners);
}

/// Moves the vertices as morph targets and joints say.
void deform(const Document& document, const tinygltf::Primitive& primitive,
            const std::string& pointer, const Attributes& attributes,
            const std::vector<double>& weights, const std::vector<Matrix>& joints, Vertices& v) {
  morph(document, primitive, pointer, weights, "POSITION", v.positions);
  if (!v.normals.empty()) morph(document, primitive, pointer, weights, "NORMAL", v.normals);
  if (!v.along_u.empty()) morph(document, primitive, pointer, weights, "TANGENT", v.along_u);
  StopPoll poll;
  if (!joints.empty()) {
    const std::vector<Matrix> moved =
        skinned(document, attributes, pointer, joints, v.positions.size());
    for (std::size_t i = 0; i < moved.size(); ++i, poll()) {
      v.positions[i] = point(moved[i], v.positions[i]);
      if (!v.along_u.empty()) v.along_u[i] = vector(moved[i], v.along_u[i]);
      if (v.normals.empty()) continue;
      const auto transform = Transform::from_matrix(moved[i]);
      v.normals[i] = transform ? transform->normal(v.normals[i]) : vector(moved[i], v.normals[i]);
    }
  }
  for (std::size_t i = 0; i < v.positions.size(); ++i, poll())
    if (!is_finite(v.positions[i]))
      document.context().fail(pointer, fmt::format("vertex {} is not finite", i));
}

std::optional<Part> make_part(const Document& document, Materials& materials,
                              const tinygltf::Mesh& mesh, const tinygltf::Primitive& primitive,
                              const View& place, const Deformation& deformation) {
  LoadState& context = document.context();
  const std::string& pointer = place.pointer();
  context.poll();
  const int mode = primitive.mode < 0 ? TINYGLTF_MODE_TRIANGLES : primitive.mode;
  if (mode < TINYGLTF_MODE_TRIANGLES) {
    context.remark(
        pointer + "/mode",
        mode == TINYGLTF_MODE_POINTS ? "points are not modelled" : "lines are not modelled",
        "left out");
    return std::nullopt;
  }
  const Attributes attributes(document, primitive, place);
  if (!attributes.has("POSITION")) {
    context.remark(pointer + "/attributes", "a primitive without POSITION", "left out");
    return std::nullopt;
  }
  Part part;
  part.pointer = pointer;
  part.use = materials.use(primitive.material < 0
                               ? std::nullopt
                               : std::optional(static_cast<std::size_t>(primitive.material)),
                           attributes.has("COLOR_0"));
  Vertices vertices = read_vertices(attributes, part.use.needs_tangents);
  const std::size_t count = vertices.positions.size();
  part.mesh.indices = read_triangles(document, primitive, mode, pointer, attributes, count);
  if (part.mesh.indices.empty()) {
    context.remark(pointer, "a primitive without a triangle", "left out");
    return std::nullopt;
  }
  deform(document, primitive, pointer, attributes,
         deformation.weights.empty() ? mesh.weights : deformation.weights, deformation.joints,
         vertices);
  part.mesh.positions = std::move(vertices.positions);
  set_normals(context, vertices.normals, part);
  part.mesh.tangents = tangents(context, pointer, vertices.along_u, vertices.tangents);
  if (attributes.has("COLOR_0")) set_colours(context, attributes, count, part);
  set_uv(context, attributes, count, part);
  return part;
}

}  // namespace

std::vector<Part> make_parts(const Document& document, Materials& materials, std::size_t index,
                             const Deformation& deformation) {
  const tinygltf::Mesh& mesh = document.model().meshes[index];
  const View primitives = document.root().at("meshes")[index].at("primitives");
  std::vector<Part> parts;
  for (std::size_t p = 0; p < mesh.primitives.size(); ++p) {
    auto part =
        make_part(document, materials, mesh, mesh.primitives[p], primitives[p], deformation);
    if (part) parts.push_back(*std::move(part));
  }
  return parts;
}

TriangleMeshData transformed(const LoadState& context, const std::string& pointer,
                             TriangleMeshData mesh, const Transform& transform) {
  StopPoll poll;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i, poll()) {
    mesh.positions[i] = transform.point(mesh.positions[i]);
    if (!is_finite(mesh.positions[i]))
      context.fail(pointer, fmt::format("vertex {} is not finite after its transform", i));
  }
  for (Vec3f& n : mesh.normals) poll(), n = Vec3f(normalized(transform.normal(Vec3(n))));
  for (VertexTangent& t : mesh.tangents) {
    poll();
    t.along_u = Vec3f(normalized(transform.vector(Vec3(t.along_u))));
    if (transform.swaps_handedness()) t.turn = -t.turn;
  }
  if (transform.swaps_handedness()) {
    for (std::size_t i = 0; i + 3 <= mesh.indices.size(); i += 3, poll()) {
      std::swap(mesh.indices[i + 1], mesh.indices[i + 2]);
      if (!mesh.corner_uv.empty()) std::swap(mesh.corner_uv[i + 1], mesh.corner_uv[i + 2]);
    }
  }
  return mesh;
}

}  // namespace lucerna::gltf
