#include "server/pictures/colour_layer.h"

#include <algorithm>

namespace lucerna {
namespace {

/// The channel `prefix` and `letter`, in upper or lower case; -1 if there is none.
int channel_of(const OIIO::ImageSpec& spec, const std::string& prefix, char letter) {
  const auto& names = spec.channelnames;
  for (const char l : {letter, static_cast<char>(letter - 'A' + 'a')})
    if (const auto found = std::ranges::find(names, prefix + l); found != names.end())
      return static_cast<int>(found - names.begin());
  return -1;
}

}  // namespace

std::optional<ColourLayer> colour_layer(const OIIO::ImageSpec& spec) {
  if (spec.nchannels <= 2) return ColourLayer{"", {0, 0, 0}, channel_of(spec, "", 'A'), 0};
  std::optional<ColourLayer> layer;
  const auto try_prefix = [&](const std::string& prefix) {
    const std::array channels{channel_of(spec, prefix, 'R'), channel_of(spec, prefix, 'G'),
                              channel_of(spec, prefix, 'B')};
    if (std::ranges::min(channels) < 0) return;
    if (layer) {
      ++layer->others;
      return;
    }
    layer = ColourLayer{prefix.substr(0, prefix.empty() ? 0 : prefix.size() - 1), channels,
                        channel_of(spec, prefix, 'A'), 0};
  };
  try_prefix("");
  for (const std::string& name : spec.channelnames) {
    const std::size_t dot = name.rfind('.');
    // Each layer is found once, by its red channel.
    if (dot != std::string::npos && (name.substr(dot) == ".R" || name.substr(dot) == ".r"))
      try_prefix(name.substr(0, dot + 1));
  }
  return layer;
}

}  // namespace lucerna
