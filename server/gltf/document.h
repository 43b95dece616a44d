// One glTF file: its JSON text, its model and its bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "lights/pictures/image.h"
#include "server/gltf/model.h"
#include "server/gltf/view.h"

namespace lucerna::gltf {

/// What is read of a picture.
enum class PictureKind : std::uint8_t {
  kColour,  ///< sRGB-coded colours
  kData,    ///< linear values
  kNormal,  ///< the same; without the picture, there is no texture
  kAlpha,   ///< alpha in all channels; 1 if the picture has none
};

class Document {
 public:
  /// Reads and checks the file `context.file`, a .gltf or a .glb file, and all its buffers.
  explicit Document(LoadState& context);

  LoadState& context() const { return context_; }
  /// The JSON text.  Types and indices are checked (structure.h), those of extensions are not.
  View root() const { return {context_, json_, ""}; }
  const tinygltf::Model& model() const { return model_; }
  /// The number of elements of an array of the root.
  std::size_t count(std::string_view key) const;
  /// The texture to which `info` refers.
  View texture_of(const View& info) const;
  /// The light of an extension of the root to which `use` refers.
  View light_of(const char* extension, const View& use) const;

  /// The bytes of a buffer view, unpacked.  Fails at `pointer` if the buffer is too short.
  std::string_view view_bytes(std::size_t view, const std::string& pointer) const;

  /// The bytes of a thing with "uri" or "bufferView".  If the file was not uploaded yet, the load
  /// goes on without it (null) until require_all_files.
  const AssetContent* read(const View& thing) const;
  /// The index of the picture of a texture: that of EXT_texture_webp if it has one.
  std::optional<std::size_t> picture_of(const View& texture) const;
  /// The URI of the picture images/`index`, or its place if the file holds it.
  std::string picture_name(std::size_t index) const;
  /// The colours of the picture images/`index` for a light; null as above.  Null too, after a
  /// remark, if it cannot be decoded: the scene does without the light.
  std::shared_ptr<const Image> image(std::size_t index) const;
  /// The picture for the textures of the scene, whose memory has a limit; null as above.  If it
  /// cannot be decoded: grey 0.5 for colours, after a remark, and null for other kinds.
  std::shared_ptr<const Texels> texels(std::size_t index, PictureKind kind) const;
  /// Fails if a file was not uploaded yet.
  void require_all_files() const;

 private:
  std::string_view split_container(std::string_view bytes);
  void parse(std::string_view text, std::size_t start);
  void read_buffers();
  const AssetContent* read_uri(const View& uri) const;
  void remark_on(const View& place, const std::vector<ImageRemark>& remarks) const;
  /// False after a remark if `status` says that the picture cannot be decoded.  Fails on all other
  /// errors.
  bool is_decoded(const View& place, const absl::Status& status, const char* instead) const;
  /// Nothing if it cannot be decoded.
  std::optional<Texels> read_texels(const AssetContent& content, const View& place,
                                    PictureKind kind, LoadBudget::Share& share) const;

  LoadState& context_;
  Json json_;
  tinygltf::Model model_;
  std::string embedded_;  ///< the binary chunk of a .glb file
  bool has_embedded_ = false;
  std::vector<AssetContent> buffers_;
  mutable std::map<std::size_t, std::string> unpacked_;  ///< of compressed buffer views
  mutable std::map<std::string, AssetContent> files_;    ///< by JSON pointer
  mutable std::map<std::size_t, std::shared_ptr<const Image>> images_;
  mutable std::map<std::pair<std::size_t, PictureKind>, std::shared_ptr<const Texels>> texels_;
  mutable std::set<std::pair<std::size_t, PictureKind>> unreadable_;
  mutable absl::Status missing_;
};

}  // namespace lucerna::gltf
