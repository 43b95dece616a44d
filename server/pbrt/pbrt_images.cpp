#include "server/pbrt/pbrt_images.h"

#include <fmt/format.h>

#include <utility>

namespace lucerna::pbrt {

namespace {

/// The picture that `decode` makes of the content, with its remarks.  Nothing, with a remark, if
/// the content is no picture that the server reads.  Limits of the server and a file that is
/// missing are still errors.
template <typename Picture>
std::optional<Picture> decoded(LoadState& context, const Parameter& filename,
                               const AssetContent& content, Encoding encoding, const char* instead,
                               absl::StatusOr<Picture> (*decode)(const AssetContent&,
                                                                 const ImageOptions&)) {
  const auto key = std::pair(content.name, encoding);
  absl::StatusOr<Picture> picture = absl::InvalidArgumentError("");
  if (const auto known = context.unreadable.find(key); known != context.unreadable.end()) {
    picture = known->second;
  } else {
    context.poll();
    picture = decode(content, context.image_options(encoding));
  }
  const absl::Status& status = picture.status();
  if (absl::IsCancelled(status)) throw StatusError(status);
  const std::string what =
      fmt::format("\"string {}\": {}", filename.name, std::string(status.message()));
  if (absl::IsInvalidArgument(status)) {
    context.unreadable.try_emplace(key, status);
    context.remark(filename.place, what, instead);
    return std::nullopt;
  }
  if (!status.ok()) fail(filename.place, absl::Status(status.code(), what));
  for (const ImageRemark& r : picture->remarks) context.remark(filename.place, r.what, r.instead);
  return *std::move(picture);
}

AssetContent content_of(LoadState& context, const Parameter& filename) {
  if (filename.strings().size() != 1)
    fail(filename.place, fmt::format("\"string {}\" takes one name", filename.name));
  return context.read(filename);
}

Texels texels_of(CodedImage codes) {
  return Texels(codes.width, codes.height, codes.is_grey, std::move(codes.codes),
                std::move(codes.values));
}

}  // namespace

NamedImage read_image(LoadState& context, const Parameter& filename, Encoding encoding) {
  const AssetContent content = content_of(context, filename);
  std::shared_ptr<const Image>& image = context.images[{content.name, encoding}];
  if (image == nullptr) {
    const auto picture =
        decoded(context, filename, content, encoding, "the light is left out", &decode_image);
    if (!picture) throw LightLeftOut();
    image = picture->image;
    // The tables from which lights draw points take up to as much as the picture.
    LoadState::require(context.meter.keep(2 * image->bytes()));
  }
  return {content.name, image};
}

std::shared_ptr<const Texels> read_texels(LoadState& context, const Parameter& filename,
                                          Encoding encoding, const char* instead) {
  const AssetContent content = content_of(context, filename);
  std::shared_ptr<const Texels>& texels = context.texels[{content.name, encoding}];
  if (texels != nullptr) return texels;
  auto given = decoded(context, filename, content, encoding, instead, &decode_surface);
  if (!given) return nullptr;
  DecodedSurface picture = *std::move(given);
  Textures& textures = context.scene.textures;
  if (picture.codes) {
    texels = textures.picture(content.name, texels_of(*std::move(picture.codes)), context.stop);
  } else {
    // Texels have at most the bytes of the picture.
    LoadState::require(picture.share.grow(picture.image->bytes()));
    texels = textures.picture(content.name, Texels(*picture.image), context.stop);
  }
  picture.share.reset();
  context.poll();
  return texels;
}

ImageFilter image_filter(const ParameterSet& params, const char* otherwise) {
  return params.choice<ImageFilter>(
      "filter", otherwise,
      {{"nearest", ImageFilter::kNearest}, {"bilinear", ImageFilter::kBilinear}});
}

}  // namespace lucerna::pbrt
