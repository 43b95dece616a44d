// Writes glTF files and loads them.
#pragma once

#include <absl/strings/escaping.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string>
#include <variant>
#include <vector>

#include "server/gltf/load_gltf.h"
#include "tests/temp_directory.h"
#include "tests/value_of.h"

namespace lucerna::testing {

using Json = nlohmann::json;

inline std::string message_of(const absl::Status& status) {
  return std::string(status.message().data(), status.message().size());
}

template <typename T>
std::string bytes_of(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

/// A PNG file of 8-bit RGBA texels, rows from the top.
inline std::string png(std::uint32_t width, std::uint32_t height,
                       const std::vector<std::uint8_t>& rgba) {
  const auto big = [](std::uint32_t n) {
    return std::string{static_cast<char>(n >> 24), static_cast<char>(n >> 16),
                       static_cast<char>(n >> 8), static_cast<char>(n)};
  };
  const auto chunk = [&](const std::string& kind, const std::string& data) {
    const std::string body = kind + data;
    const auto* bytes = reinterpret_cast<const Bytef*>(body.data());
    return big(static_cast<std::uint32_t>(data.size())) + body +
           big(static_cast<std::uint32_t>(crc32(0, bytes, static_cast<uInt>(body.size()))));
  };
  std::string rows;
  for (std::uint32_t y = 0; y < height; ++y) {
    rows += '\0';  // no filter
    rows.append(reinterpret_cast<const char*>(&rgba[4 * width * y]), 4 * width);
  }
  uLongf size = compressBound(rows.size());
  std::string packed(size, '\0');
  compress(reinterpret_cast<Bytef*>(packed.data()), &size,
           reinterpret_cast<const Bytef*>(rows.data()), rows.size());
  packed.resize(size);
  return "\x89PNG\r\n\x1a\n" +
         chunk("IHDR", big(width) + big(height) + std::string("\x8\x6\0\0\0", 5)) +
         chunk("IDAT", packed) + chunk("IEND", "");
}

/// A temporary directory of scene files.
class GltfFiles {
 public:
  const std::filesystem::path& path() const { return directory_.path(); }

  void write(const std::string& name, const std::string& bytes) const {
    std::filesystem::create_directories((path() / name).parent_path());
    std::ofstream(path() / name, std::ios::binary) << bytes;
  }

  absl::StatusOr<SceneDescription> load(const std::string& name,
                                        const LevelFactors& factors = {}) const {
    auto reader = AssetReader::open(path().string());
    if (!reader.ok()) return reader.status();
    return load_gltf(*reader, name, {}, {}, factors);
  }

 private:
  TempDirectory directory_;
};

/// A glTF file in the making.
class GltfFile {
 public:
  Json json = {{"asset", {{"version", "2.0"}}}};

  /// The index of a new accessor.
  template <typename T>
  int add(const std::vector<T>& values, const std::string& type, int component_type,
          bool normalized = false) {
    const std::size_t components = type == "SCALAR" ? 1
                                   : type == "MAT4" ? 16
                                                    : static_cast<std::size_t>(type[3] - '0');
    const int view = add_view(bytes_of(values));
    json["accessors"].push_back({{"bufferView", view},
                                 {"componentType", component_type},
                                 {"count", values.size() / components},
                                 {"type", type}});
    if (normalized) json["accessors"].back()["normalized"] = true;
    return static_cast<int>(json["accessors"].size()) - 1;
  }
  int add_floats(const std::vector<float>& values, const std::string& type) {
    return add(values, type, 5126);
  }
  int add_view(const std::string& bytes) {
    json["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", bytes.size()}});
    bytes_ += bytes;
    bytes_.resize((bytes_.size() + 3) / 4 * 4);
    return static_cast<int>(json["bufferViews"].size()) - 1;
  }
  /// The index of a new mesh of one primitive.
  int add_mesh(Json primitive) {
    json["meshes"].push_back({{"primitives", Json::array({std::move(primitive)})}});
    return static_cast<int>(json["meshes"].size()) - 1;
  }
  /// A node of the scene.
  int add_node(Json node) {
    json["nodes"].push_back(std::move(node));
    const int index = static_cast<int>(json["nodes"].size()) - 1;
    if (!json.contains("scenes")) json["scenes"] = Json::array({{{"nodes", Json::array()}}});
    json["scenes"][0]["nodes"].push_back(index);
    return index;
  }
  int add_light(const Json& light) {
    json["extensions"]["KHR_lights_punctual"]["lights"].push_back(light);
    const int index =
        static_cast<int>(json["extensions"]["KHR_lights_punctual"]["lights"].size()) - 1;
    return index;
  }
  static Json light_node(int light) {
    return {{"extensions", {{"KHR_lights_punctual", {{"light", light}}}}}};
  }
  /// A triangle (0,0,0), (1,0,0), (0,1,0), facing +z, as a primitive.
  Json triangle() {
    return {{"attributes", {{"POSITION", add_floats({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3")}}}};
  }

  const std::string& bytes() const { return bytes_; }

  /// With the buffer as a data URI.
  std::string text() const {
    return with_buffer("data:application/octet-stream;base64," + coded());
  }
  /// With the buffer in another file.
  std::string text(const std::string& uri) const { return with_buffer(uri); }
  /// A .glb file.
  std::string binary() const {
    std::string text = with_buffer("");
    text.resize((text.size() + 3) / 4 * 4, ' ');
    const auto number = [](std::size_t n) {
      return bytes_of(std::vector<std::uint32_t>{static_cast<std::uint32_t>(n)});
    };
    std::string chunks = number(text.size()) + "JSON" + text;
    if (!bytes_.empty()) chunks += number(bytes_.size()) + std::string("BIN\0", 4) + bytes_;
    return "glTF" + number(2) + number(12 + chunks.size()) + chunks;
  }

  absl::StatusOr<SceneDescription> load() const {
    const GltfFiles files;
    files.write("scene.gltf", text());
    return files.load("scene.gltf");
  }
  /// The scene; a failure of the test if it does not load.
  SceneDescription scene() const {
    auto loaded = load();
    EXPECT_TRUE(loaded.ok()) << loaded.status();
    return loaded.ok() ? *std::move(loaded) : SceneDescription();
  }
  std::string error() const { return message_of(load().status()); }

 private:
  std::string coded() const {
    return absl::Base64Escape(absl::string_view(bytes_.data(), bytes_.size()));
  }
  std::string with_buffer(const std::string& uri) const {
    Json whole = json;
    if (!bytes_.empty() && !whole.contains("buffers")) {
      Json buffer = {{"byteLength", bytes_.size()}};
      if (!uri.empty()) buffer["uri"] = uri;
      whole["buffers"] = Json::array({buffer});
    }
    return whole.dump();
  }
  std::string bytes_;
};

/// "pointer: what -> instead" for each remark, one per line.
inline std::string gltf_remarks(const SceneDescription& scene) {
  std::string result;
  for (const Remark& remark : scene.remarks)
    result += remark.where.file.str() + ": " + remark.what + " -> " + remark.instead + "\n";
  return result;
}

inline const TriangleMeshData& mesh_of(const ShapeDescription& shape) {
  return std::get<TriangleMeshData>(shape.geometry);
}

}  // namespace lucerna::testing
