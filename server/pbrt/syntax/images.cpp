#include "server/pbrt/syntax/images.h"

#include <fmt/format.h>

namespace lucerna::pbrt {

NamedImage read_image(Context& context, const Parameter& filename, Encoding encoding) {
  if (filename.strings.size() != 1)
    fail(filename.place, fmt::format("\"string {}\" takes one name", filename.name));
  const AssetContent content = context.read(filename);
  std::shared_ptr<const Image>& image = context.images[{content.name, encoding}];
  if (image == nullptr) {
    context.poll();
    auto decoded = decode_image(content, kMaxImageTexels, encoding);
    if (!decoded.ok())
      fail(filename.place, absl::Status(decoded.status().code(),
                                        fmt::format("\"string {}\": {}", filename.name,
                                                    std::string(decoded.status().message()))));
    for (const ImageRemark& r : decoded->remarks) context.remark(filename.place, r.what, r.instead);
    image = decoded->image;
  }
  return {content.name, image};
}

ImageFilter image_filter(const ParameterSet& params, const char* otherwise) {
  const std::string name = params.string("filter", otherwise);
  if (name == "nearest") return ImageFilter::kNearest;
  if (name == "bilinear") return ImageFilter::kBilinear;
  fail(params.find("filter", {"string"})->place,
       fmt::format("\"string filter\" = \"{}\", allowed: nearest, bilinear", printable(name)));
}

}  // namespace lucerna::pbrt
