#include "server/pbrt/syntax/images.h"

#include <fmt/format.h>

namespace lucerna::pbrt {

namespace {

std::shared_ptr<const Image> decoded(Context& context, const Parameter& filename,
                                     const AssetContent& content, Encoding encoding) {
  context.poll();
  auto picture = decode_image(content, kMaxImageTexels, encoding);
  if (!picture.ok())
    fail(filename.place, absl::Status(picture.status().code(),
                                      fmt::format("\"string {}\": {}", filename.name,
                                                  std::string(picture.status().message()))));
  for (const ImageRemark& r : picture->remarks) context.remark(filename.place, r.what, r.instead);
  return picture->image;
}

AssetContent content_of(Context& context, const Parameter& filename) {
  if (filename.strings.size() != 1)
    fail(filename.place, fmt::format("\"string {}\" takes one name", filename.name));
  return context.read(filename);
}

}  // namespace

NamedImage read_image(Context& context, const Parameter& filename, Encoding encoding) {
  const AssetContent content = content_of(context, filename);
  std::shared_ptr<const Image>& image = context.images[{content.name, encoding}];
  if (image == nullptr) image = decoded(context, filename, content, encoding);
  return {content.name, image};
}

std::shared_ptr<const Texels> read_texels(Context& context, const Parameter& filename,
                                          Encoding encoding) {
  const AssetContent content = content_of(context, filename);
  std::shared_ptr<const Texels>& texels = context.texels[{content.name, encoding}];
  if (texels == nullptr)
    texels = context.scene.textures.picture(content.name,
                                            *decoded(context, filename, content, encoding));
  return texels;
}

ImageFilter image_filter(const ParameterSet& params, const char* otherwise) {
  const std::string name = params.string("filter", otherwise);
  if (name == "nearest") return ImageFilter::kNearest;
  if (name == "bilinear") return ImageFilter::kBilinear;
  fail(params.find("filter", {"string"})->place,
       fmt::format("\"string filter\" = \"{}\", allowed: nearest, bilinear", printable(name)));
}

}  // namespace lucerna::pbrt
