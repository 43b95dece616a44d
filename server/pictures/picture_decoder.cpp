#include "server/files/picture_decoder.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "lights/maths/rgb_primaries.h"
#include "lights/maths/stop_poll.h"
#include "proto/common/status_macros.h"
#include "server/pictures/image_file.h"
#include "server/pictures/picture_checks.h"
#include "server/pictures/picture_colours.h"

namespace lucerna {
namespace {

using Channels = std::array<int, 3>;

/// [IEC61966]
float linear_from_srgb(float coded) {
  const double c = coded;
  return static_cast<float>(c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4));
}

float decoded_texel(float coded, Encoding encoding) {
  if (encoding.gamma == kSrgb.gamma) return linear_from_srgb(coded);
  return encoding.gamma == kLinear.gamma
             ? coded
             : static_cast<float>(std::pow(double{coded}, encoding.gamma));
}

/// The value of a code.
template <typename Code>
float decoded_code(std::size_t code, Encoding encoding) {
  constexpr auto kMost = static_cast<float>(std::numeric_limits<Code>::max());
  return decoded_texel(static_cast<float>(code) / kMost, encoding);
}

/// The number of codes.
template <typename Code>
constexpr std::size_t kCodes = std::size_t{std::numeric_limits<Code>::max()} + 1;

/// The value of each code.  Integers have few different values, so each is decoded once.
template <typename Code>
std::vector<float> decoded_codes(Encoding encoding) {
  std::vector<float> decoded(kCodes<Code>);
  for (std::size_t i = 0; i < decoded.size(); ++i) decoded[i] = decoded_code<Code>(i, encoding);
  return decoded;
}

/// Whether a channel holds sRGB codes; nothing for unsupported types.
std::optional<bool> is_coded(const OIIO::TypeDesc& type) {
  if (type == OIIO::TypeDesc::UINT8 || type == OIIO::TypeDesc::UINT16) return true;
  if (type == OIIO::TypeDesc::HALF || type == OIIO::TypeDesc::FLOAT ||
      type == OIIO::TypeDesc::DOUBLE)
    return false;
  return std::nullopt;
}

/// The channels of the colours.  Fails if they are missing or of an unsupported type.
absl::StatusOr<Channels> channels_of(const AssetContent& content, const ImageFile& file) {
  const std::optional<ColourLayer> layer = file.colours();
  if (!layer) {
    std::string names;
    for (const std::string& n : file.spec().channelnames) names += " " + n;
    std::ranges::replace_if(
        names, [](char c) { return c < ' ' || c > '~'; }, '?');
    return bad_picture(content,
                       "channels" + names.substr(0, 200) +
                           ", allowed: R, G and B; X, Y and Z; or one besides alpha and depth");
  }
  for (const int c : layer->channels)
    if (!is_coded(file.spec().channelformat(c)))
      return bad_picture(
          content,
          fmt::format(
              "texels of type {}, allowed: unsigned 8- and 16-bit integers, half, float, double",
              file.spec().channelformat(c).c_str()));
  return layer->channels;
}

bool all_are(const ImageFile& file, const Channels& channels, OIIO::TypeDesc type) {
  return std::ranges::all_of(channels, [&](int c) { return file.spec().channelformat(c) == type; });
}

/// What the header says of floats.
struct FloatColours {
  std::optional<RgbConversion> conversion;
  double scale = 1;
};

/// Reads the texels of a picture as floats.
class FloatReader {
 public:
  FloatReader(ImageFile& file, const Channels& channels, const FloatColours& colours)
      : file_(file),
        encoding_(file.encoding()),
        colours_(colours),
        low_(std::ranges::min(channels)),
        high_(std::ranges::max(channels)) {
    for (std::size_t c = 0; c < 3; ++c) {
      offset_[c] = static_cast<std::size_t>(channels[c] - low_);
      coded_[c] = *is_coded(file.spec().channelformat(channels[c]));
    }
    texels_.reserve(file.texels());
  }

  template <typename Code>
  absl::Status read_codes(OIIO::TypeDesc type) {
    // A small picture has fewer values than a table of all codes.
    if (3 * file_.texels() < kCodes<Code>)
      return read_as<Code>(type, [this](Code c) { return decoded_code<Code>(c, encoding_); });
    const std::vector<float> decoded = decoded_codes<Code>(encoding_);
    return read_as<Code>(type, [&](Code c) { return decoded[c]; });
  }

  absl::Status read_floats() {
    return for_each_texel<float>(OIIO::TypeDesc::FLOAT, [&](const float* texel) {
      const auto value = [&](std::size_t c) {
        const float v = texel[offset_[c]];
        return coded_[c] ? decoded_texel(v, encoding_) : v;
      };
      const Rgbf stored{value(0), value(1), value(2)};
      texels_.push_back(colours_.conversion ? converted(stored) : not_negative(stored));
    });
  }

  std::vector<Rgbf>& texels() { return texels_; }
  /// Texels with a value below 0, and those whose colours are outside of Rec. 709.
  std::size_t negative() const { return negative_; }
  std::size_t outside() const { return outside_; }

 private:
  /// NaN and infinities are kept, so that Image::create rejects them.
  Rgbf not_negative(const Rgbf& c) {
    const auto value = [](float v) { return !(v < 0) || std::isinf(v) ? v : 0.0F; };
    const Rgbf result{value(c.r), value(c.g), value(c.b)};
    negative_ += result.r > c.r || result.g > c.g || result.b > c.b;
    const auto scale = static_cast<float>(colours_.scale);
    return scale == 1 ? result : result * scale;
  }

  Rgbf converted(const Rgbf& c) {
    if (!is_finite(c)) return c;
    const Rgb rgb = (*colours_.conversion)(Rgb(c)) * colours_.scale;
    outside_ += is_outside_rec709(rgb);
    return Rgbf(at_edge_of_rec709(rgb));
  }

  template <typename Code, typename Decode>
  absl::Status read_as(OIIO::TypeDesc type, Decode&& decode) {
    return for_each_texel<Code>(type, [&](const Code* texel) {
      const auto value = [&](std::size_t c) { return decode(texel[offset_[c]]); };
      texels_.push_back({value(0), value(1), value(2)});
    });
  }

  template <typename Value, typename Use>
  absl::Status for_each_texel(OIIO::TypeDesc type, Use&& use) {
    const auto read = static_cast<std::size_t>(high_ - low_ + 1);
    return file_.for_each_band<Value>(low_, high_, type,
                                      [&](const Value* values, std::size_t count) {
                                        for (std::size_t i = 0; i < count; ++i)
                                          use(values + i * read);
                                        return absl::OkStatus();
                                      });
  }

  ImageFile& file_;
  Encoding encoding_;
  FloatColours colours_;
  int low_, high_;
  std::array<std::size_t, 3> offset_{};
  std::array<bool, 3> coded_{};
  std::vector<Rgbf> texels_;
  std::size_t negative_ = 0, outside_ = 0;
};

/// Moves stored texels to their places in the picture.
template <typename Value>
absl::Status arrange(const ImageFile& file, const ImageOptions& options, std::size_t each,
                     std::vector<Value>& values, LoadBudget::Share& share) {
  if (file.arrangement().is_as_stored()) return absl::OkStatus();
  const std::uint64_t bytes = file.arrangement().texels() * each * sizeof(Value);
  LUCERNA_RETURN_IF_ERROR(share.grow(bytes));
  if (options.stop.stop_requested()) return absl::CancelledError("loading was cancelled");
  values = file.arrangement().arranged(values, each);
  return share.resize(bytes);
}

std::string count_of_texels(const AssetContent& content, std::size_t count, const char* with) {
  return fmt::format("{} has {} texel{} with {}", content.name, count, count == 1 ? "" : "s", with);
}

/// What the header says of floats.  Adds remarks on what is not applied.
FloatColours colours_of(const AssetContent& content, const ImageFile& file,
                        const ImageOptions& options, RgbConversion::White white,
                        std::vector<ImageRemark>& remarks) {
  using Meaning = Encoding::Meaning;
  FloatColours colours;
  const Meaning meaning = options.encoding.meaning;
  const auto primaries = stated_primaries(file.spec());
  if (primaries && meaning != Meaning::kData && !file.colours()->is_grey()) {
    colours.conversion = RgbConversion::to_rec709(*primaries, white);
    if (!colours.conversion)
      remarks.push_back(
          {content.name + " states primaries that span no colour space", "treated as Rec. 709"});
  }
  const auto white_cd_m2 = stated_white_cd_m2(file.spec());
  // Reflectances are shares of white.
  if (!white_cd_m2 || meaning == Meaning::kData || white == RgbConversion::White::kAdapted)
    return colours;
  const std::string what =
      fmt::format("{} states that RGB (1, 1, 1) is {:.6g} cd/m2", content.name, *white_cd_m2);
  if (meaning == Meaning::kLuminance) {
    colours.scale = *white_cd_m2;
    remarks.push_back({what, "its texels times this luminance; pbrt-v4 takes the texels"});
  } else {
    remarks.push_back({what, "a texel of 1 is the light's level"});
  }
  return colours;
}

absl::StatusOr<DecodedImage> read_image(const AssetContent& content, ImageFile& file,
                                        const Channels& channels, const ImageOptions& options,
                                        RgbConversion::White white) {
  DecodedImage decoded{nullptr, file.remarks(), LoadBudget::Share(options.budget)};
  LUCERNA_RETURN_IF_ERROR(decoded.share.resize(file.texels() * sizeof(Rgbf)));
  FloatReader reader(file, channels, colours_of(content, file, options, white, decoded.remarks));
  const absl::Status read = all_are(file, channels, OIIO::TypeDesc::UINT8)
                                ? reader.read_codes<std::uint8_t>(OIIO::TypeDesc::UINT8)
                            : all_are(file, channels, OIIO::TypeDesc::UINT16)
                                ? reader.read_codes<std::uint16_t>(OIIO::TypeDesc::UINT16)
                                : reader.read_floats();
  LUCERNA_RETURN_IF_ERROR(read);
  if (reader.negative() > 0)
    decoded.remarks.push_back(
        {count_of_texels(content, reader.negative(), "a value below 0"), "counted as 0"});
  if (reader.outside() > 0)
    decoded.remarks.push_back(
        {count_of_texels(content, reader.outside(), "a colour outside of Rec. 709"),
         "the colour at its edge with the same luminance"});
  LUCERNA_RETURN_IF_ERROR(arrange(file, options, 1, reader.texels(), decoded.share));
  auto image = Image::create(file.arrangement().width(), file.arrangement().height(),
                             std::move(reader.texels()));
  if (!image.ok()) return bad_picture(content, std::string(image.status().message()));
  decoded.image = *std::move(image);
  return decoded;
}

/// Reads the codes of a picture of 8 bits.  They are grey until a texel is not.
class CodeReader {
 public:
  CodeReader(ImageFile& file, const Channels& channels, CodedImage& to, LoadBudget::Share& share)
      : file_(file),
        low_(std::ranges::min(channels)),
        high_(std::ranges::max(channels)),
        to_(to),
        share_(share) {
    for (std::size_t c = 0; c < 3; ++c) offset_[c] = static_cast<std::size_t>(channels[c] - low_);
    to_.is_grey = true;
  }

  absl::Status read() {
    LUCERNA_RETURN_IF_ERROR(share_.resize(file_.texels()));
    to_.codes.reserve(file_.texels());
    return file_.for_each_band<std::uint8_t>(
        low_, high_, OIIO::TypeDesc::UINT8, [this](const std::uint8_t* band, std::size_t count) {
          const std::size_t grey = to_.is_grey ? append_grey(band, count) : 0;
          if (grey == count) return absl::OkStatus();
          if (to_.is_grey) LUCERNA_RETURN_IF_ERROR(to_colours());
          append_colours(band + grey * read_, count - grey);
          return absl::OkStatus();
        });
  }

 private:
  bool is_grey(const std::uint8_t* texel) const {
    const std::uint8_t r = texel[offset_[0]], g = texel[offset_[1]], b = texel[offset_[2]];
    // A high gamma gives several codes the same value.
    const std::vector<float>& values = to_.values;
    return (r == g && g == b) || (values[r] == values[g] && values[g] == values[b]);
  }

  /// Adds the texels before the first colour, and returns their number.
  std::size_t append_grey(const std::uint8_t* band, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint8_t* texel = band + i * read_;
      if (!is_grey(texel)) return i;
      to_.codes.push_back(texel[offset_[0]]);
    }
    return count;
  }

  void append_colours(const std::uint8_t* band, std::size_t count) {
    if (read_ == 3 && offset_ == std::array<std::size_t, 3>{0, 1, 2}) {
      to_.codes.insert(to_.codes.end(), band, band + 3 * count);
      return;
    }
    for (std::size_t i = 0; i < count; ++i)
      for (const std::size_t c : offset_) to_.codes.push_back(band[i * read_ + c]);
  }

  /// Three codes for each texel from now on.
  absl::Status to_colours() {
    LUCERNA_RETURN_IF_ERROR(share_.resize(3 * file_.texels() + to_.codes.size()));
    std::vector<std::uint8_t> codes;
    codes.reserve(3 * file_.texels());
    for (const std::uint8_t code : to_.codes) codes.insert(codes.end(), 3, code);
    to_.codes = std::move(codes);
    to_.is_grey = false;
    return share_.resize(3 * file_.texels());
  }

  ImageFile& file_;
  int low_, high_;
  std::size_t read_ = static_cast<std::size_t>(high_ - low_ + 1);
  std::array<std::size_t, 3> offset_{};
  CodedImage& to_;
  LoadBudget::Share& share_;
};

absl::StatusOr<DecodedImage> image_of(const AssetContent& content, const ImageOptions& options) {
  LUCERNA_ASSIGN_OR_RETURN(ImageFile file, ImageFile::open(content, options));
  LUCERNA_ASSIGN_OR_RETURN(const Channels channels, channels_of(content, file));
  return read_image(content, file, channels, options, RgbConversion::White::kKept);
}

absl::StatusOr<DecodedSurface> surface_of(const AssetContent& content,
                                          const ImageOptions& options) {
  LUCERNA_ASSIGN_OR_RETURN(ImageFile file, ImageFile::open(content, options));
  LUCERNA_ASSIGN_OR_RETURN(const Channels channels, channels_of(content, file));
  DecodedSurface decoded{{}, nullptr, {}, LoadBudget::Share(options.budget)};
  if (!all_are(file, channels, OIIO::TypeDesc::UINT8)) {
    LUCERNA_ASSIGN_OR_RETURN(DecodedImage image, read_image(content, file, channels, options,
                                                            RgbConversion::White::kAdapted));
    decoded.image = std::move(image.image);
    decoded.remarks = std::move(image.remarks);
    decoded.share = std::move(image.share);
    return decoded;
  }
  decoded.remarks = file.remarks();
  CodedImage& codes = decoded.codes.emplace();
  codes.width = file.arrangement().width();
  codes.height = file.arrangement().height();
  codes.values = decoded_codes<std::uint8_t>(file.encoding());
  LUCERNA_RETURN_IF_ERROR(CodeReader(file, channels, codes, decoded.share).read());
  LUCERNA_RETURN_IF_ERROR(
      arrange(file, options, codes.is_grey ? 1 : 3, codes.codes, decoded.share));
  return decoded;
}

absl::StatusOr<DecodedAlpha> alpha_of(const AssetContent& content, const ImageOptions& options) {
  LUCERNA_ASSIGN_OR_RETURN(ImageFile file, ImageFile::open(content, options));
  DecodedAlpha alpha{file.arrangement().width(),
                     file.arrangement().height(),
                     {},
                     LoadBudget::Share(options.budget)};
  const auto layer = file.colours();
  const int channel = layer ? layer->alpha : -1;
  if (channel < 0) return alpha;
  LUCERNA_RETURN_IF_ERROR(alpha.share.resize(file.texels() * sizeof(float)));
  alpha.values.reserve(file.texels());
  LUCERNA_RETURN_IF_ERROR(file.for_each_band<float>(
      channel, channel, OIIO::TypeDesc::FLOAT, [&](const float* band, std::size_t count) {
        alpha.values.insert(alpha.values.end(), band, band + count);
        return absl::OkStatus();
      }));
  LUCERNA_RETURN_IF_ERROR(arrange(file, options, 1, alpha.values, alpha.share));
  return alpha;
}

/// `decode`, whose loops end after a request to stop.  The library has a scope of its own.
template <auto decode>
auto stoppable(const AssetContent& content, const ImageOptions& options)
    -> decltype(decode(content, options)) {
  const StopScope scope(options.stop);
  try {
    return decode(content, options);
  } catch (const Stopped&) {
    return absl::CancelledError("loading was cancelled");
  }
}

}  // namespace

/// The library hides all its other names.
extern "C" [[gnu::visibility("default")]] const PictureDecoder lucerna_picture_decoder;
const PictureDecoder lucerna_picture_decoder{&stoppable<&image_of>, &stoppable<&surface_of>,
                                             &stoppable<&alpha_of>};

}  // namespace lucerna
