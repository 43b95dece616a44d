#include "server/files/image_reader.h"

#include <dlfcn.h>

#include "proto/common/status_macros.h"
#include "server/files/picture_decoder.h"

namespace lucerna {
namespace {

/// The decoder, or why the dynamic linker cannot load it.
struct LoadedDecoder {
  const PictureDecoder* decoder = nullptr;
  std::string error;
};

/// Stays loaded to the end: pictures hold code of the library.
LoadedDecoder load_decoder() {
  // The dynamic linker finds it by the run path of the program.
  void* library = ::dlopen(LUCERNA_PICTURE_LIBRARY, RTLD_NOW | RTLD_LOCAL);
  const void* symbol = library == nullptr ? nullptr : ::dlsym(library, kPictureDecoder);
  if (symbol != nullptr) return {static_cast<const PictureDecoder*>(symbol), ""};
  const char* error = ::dlerror();
  return {nullptr, error == nullptr ? LUCERNA_PICTURE_LIBRARY : error};
}

absl::StatusOr<const PictureDecoder*> decoder_for(const AssetContent& content) {
  static const LoadedDecoder kLoaded = load_decoder();
  if (kLoaded.decoder != nullptr) return kLoaded.decoder;
  return absl::FailedPreconditionError(content.name +
                                       ": this server cannot decode pictures: " + kLoaded.error);
}

}  // namespace

absl::StatusOr<DecodedImage> decode_image(const AssetContent& content,
                                          const ImageOptions& options) {
  LUCERNA_ASSIGN_OR_RETURN(const PictureDecoder* decoder, decoder_for(content));
  return decoder->image(content, options);
}

absl::StatusOr<DecodedSurface> decode_surface(const AssetContent& content,
                                              const ImageOptions& options) {
  LUCERNA_ASSIGN_OR_RETURN(const PictureDecoder* decoder, decoder_for(content));
  return decoder->surface(content, options);
}

absl::StatusOr<DecodedAlpha> decode_alpha(const AssetContent& content,
                                          const ImageOptions& options) {
  LUCERNA_ASSIGN_OR_RETURN(const PictureDecoder* decoder, decoder_for(content));
  return decoder->alpha(content, options);
}

}  // namespace lucerna
