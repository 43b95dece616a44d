#include "server/pictures/colour_layer.h"

#include <OpenImageIO/strutil.h>

#include <algorithm>
#include <string_view>

namespace lucerna {
namespace {

/// Whether a channel has this name or its first letter, in upper or lower case.
bool is_called(std::string_view channel, std::string_view word) {
  using OIIO::Strutil::iequals;
  return iequals(channel, word) || iequals(channel, word.substr(0, 1));
}

/// The name without its layer.
std::string_view last_part(std::string_view channel) {
  return channel.substr(channel.rfind('.') + 1);
}

bool is_depth(std::string_view channel) {
  const std::string_view part = last_part(channel);
  return part == "ZBack" || is_called(part, "z") || OIIO::Strutil::iequals(part, "depth");
}

/// The channel of this name in the layer; -1 if there is none.
int channel_of(const OIIO::ImageSpec& spec, std::string_view prefix, std::string_view word) {
  const auto found = std::ranges::find_if(spec.channelnames, [&](std::string_view name) {
    return name.starts_with(prefix) && is_called(name.substr(prefix.size()), word);
  });
  return found == spec.channelnames.end() ? -1
                                          : static_cast<int>(found - spec.channelnames.begin());
}

std::optional<ColourLayer> grey_layer(const OIIO::ImageSpec& spec) {
  ColourLayer layer;
  int grey = -1;
  for (int i = 0; i < spec.nchannels; ++i) {
    const std::string_view name = spec.channelnames[i];
    if (is_depth(name)) continue;
    if (spec.nchannels > 1 && is_called(last_part(name), "alpha")) {
      layer.alpha = i;
    } else if (grey >= 0) {
      return std::nullopt;
    } else {
      grey = i;
    }
  }
  if (grey < 0) return std::nullopt;
  layer.channels.fill(grey);
  return layer;
}

}  // namespace

std::optional<ColourLayer> colour_layer(const OIIO::ImageSpec& spec, bool are_named) {
  if (!are_named && spec.nchannels <= 2)
    return ColourLayer{.channels = {0, 0, 0}, .alpha = channel_of(spec, "", "alpha")};
  std::optional<ColourLayer> layer;
  const auto try_prefix = [&](std::string_view prefix) {
    const std::array channels{channel_of(spec, prefix, "red"), channel_of(spec, prefix, "green"),
                              channel_of(spec, prefix, "blue")};
    if (std::ranges::min(channels) < 0) return;
    if (layer) {
      ++layer->others;
      return;
    }
    layer = ColourLayer{.name = std::string(prefix.substr(0, prefix.rfind('.'))),
                        .channels = channels,
                        .alpha = channel_of(spec, prefix, "alpha")};
  };
  try_prefix("");
  for (const std::string_view name : spec.channelnames) {
    const std::string_view prefix = name.substr(0, name.rfind('.') + 1);
    // Each layer is found once, by its red channel.
    if (!prefix.empty() && is_called(last_part(name), "red")) try_prefix(prefix);
  }
  if (layer) return layer;
  const std::array xyz{channel_of(spec, "", "X"), channel_of(spec, "", "Y"),
                       channel_of(spec, "", "Z")};
  if (std::ranges::min(xyz) >= 0)
    return ColourLayer{.channels = xyz, .alpha = channel_of(spec, "", "alpha"), .is_xyz = true};
  return grey_layer(spec);
}

}  // namespace lucerna
