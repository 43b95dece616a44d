#include "server/formats/image_reader.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>

#include "proto/common/status_macros.h"

namespace lucerna {
namespace {

constexpr int kMaxChannels = 64;

absl::Status bad(const AssetContent& content, const std::string& what) {
  return absl::InvalidArgumentError(content.name + ": " + what);
}

/// The extension in lower case with its dot; empty for unknown formats.  OpenImageIO reads more
/// formats, such as films and archives, but a server should open only the formats that it needs.
std::string known_extension(const std::string& name) {
  std::string extension = std::filesystem::path(name).extension().string();
  std::ranges::transform(extension, extension.begin(), [](unsigned char c) {
    return static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  });
  constexpr std::array<std::string_view, 8> kKnown{".exr", ".hdr",  ".pfm", ".png",
                                                   ".tif", ".tiff", ".jpg", ".jpeg"};
  return std::ranges::find(kKnown, extension) != kKnown.end() ? extension : "";
}

/// Text from a file, made printable for messages.
std::string shown(std::string text) {
  std::ranges::replace_if(
      text, [](char c) { return c < ' ' || c > '~'; }, '?');
  return text.substr(0, 200);
}

/// The first line of a message of OpenImageIO.  Its messages name temporary files, quote their
/// content, and may be long.
std::string first_line(const std::string& text) { return shown(text.substr(0, text.find('\n'))); }

/// The error for an unreadable file, with OpenImageIO's message, which may be empty.
absl::Status unreadable(const AssetContent& content, const std::string& extension,
                        const std::string& why) {
  return bad(content, fmt::format("cannot be read as an image{}{}, allowed: a complete {} file",
                                  why.empty() ? "" : ": ", first_line(why), extension));
}

/// An unnamed file that holds `bytes`, for formats that OpenImageIO reads only by name.
class MemoryFile {
 public:
  explicit MemoryFile(const std::string& bytes) : fd_(::memfd_create("image", MFD_CLOEXEC)) {
    std::size_t done = 0;
    while (fd_ >= 0 && done < bytes.size()) {
      const ssize_t n = ::write(fd_, bytes.data() + done, bytes.size() - done);
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) break;
      done += static_cast<std::size_t>(n);
    }
    ok_ = fd_ >= 0 && done == bytes.size();
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  ~MemoryFile() {
    if (fd_ >= 0) ::close(fd_);
  }
  bool ok() const { return ok_; }
  std::string path() const { return fmt::format("/proc/self/fd/{}", fd_); }

 private:
  int fd_;
  bool ok_;
};

/// An open image and the objects that it needs.
struct OpenImage {
  std::unique_ptr<OIIO::Filesystem::IOMemReader> memory;
  std::unique_ptr<MemoryFile> file;
  std::unique_ptr<OIIO::ImageInput> input;  // last member: closed first
  OIIO::ImageSpec spec;
};

absl::StatusOr<OpenImage> open_image(const AssetContent& content) {
  const std::string extension = known_extension(content.name);
  if (extension.empty())
    return bad(content,
               "unknown kind of image, allowed: .exr .hdr .pfm .png .tif .tiff .jpg .jpeg");
  OpenImage open;
  const std::string name = "image" + extension;
  // Chosen only by the format: with a file name, OpenImageIO would look for that file.
  open.input = OIIO::ImageInput::create(extension.substr(1));
  if (!open.input) return absl::InternalError(content.name + ": " + first_line(OIIO::geterror()));
  OIIO::ImageSpec config;
  // Use the stored colours, not multiplied by alpha.
  config.attribute("oiio:UnassociatedAlpha", 1);
  bool ok;
  if (open.input->supports("ioproxy")) {
    // OpenImageIO 2.4 requires a pointer to non-const bytes, which it only reads.
    open.memory = std::make_unique<OIIO::Filesystem::IOMemReader>(
        const_cast<char*>(content.bytes.data()),  // NOLINT(cppcoreguidelines-pro-type-const-cast)
        content.bytes.size());
    OIIO::Filesystem::IOProxy* proxy = open.memory.get();
    config.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, static_cast<void*>(&proxy));
    ok = open.input->open(name, open.spec, config);
  } else {
    open.file = std::make_unique<MemoryFile>(content.bytes);
    if (!open.file->ok())
      return absl::ResourceExhaustedError(content.name + ": " + std::strerror(errno));
    ok = open.input->open(open.file->path(), open.spec, config);
  }
  if (!ok) return unreadable(content, extension, open.input->geterror());
  return open;
}

/// The channels of red, green and blue.
std::optional<std::array<int, 3>> colour_channels(const OIIO::ImageSpec& spec) {
  if (spec.nchannels <= 2) return std::array{0, 0, 0};
  std::array<int, 3> channels{};
  for (std::size_t c = 0; c < 3; ++c) {
    const auto& names = spec.channelnames;
    const auto found = std::ranges::find(names, std::string(1, "RGB"[c]));
    if (found == names.end()) return std::nullopt;
    channels[c] = static_cast<int>(found - names.begin());
  }
  return channels;
}

std::vector<ImageRemark> remarks_on(OpenImage& open, const std::string& name) {
  std::vector<ImageRemark> remarks;
  const OIIO::ImageSpec& spec = open.spec;
  const bool grey_alpha = spec.nchannels == 2;
  const bool alpha = grey_alpha || std::ranges::count(spec.channelnames, "A") > 0;
  if (alpha) remarks.push_back({name + " has an alpha channel", "alpha is ignored", true});
  const int used = spec.nchannels <= 2 ? 1 : 3;
  if (const int rest = spec.nchannels - used - (alpha ? 1 : 0); rest > 0)
    remarks.push_back(
        {fmt::format("{} has {} channels besides R, G, B and A", name, rest), "they are ignored"});
  if (spec.x != spec.full_x || spec.y != spec.full_y || spec.width != spec.full_width ||
      spec.height != spec.full_height)
    remarks.push_back({name + " has a data window that differs from its display window",
                       "the data window is used as the picture"});
  if (spec.get_int_attribute("Orientation", 1) != 1)
    remarks.push_back({name + " has an orientation flag", "the picture is used as stored"});
  std::array<float, 8> c{};
  constexpr std::array kRec709{0.64F, 0.33F, 0.30F, 0.60F, 0.15F, 0.06F, 0.3127F, 0.3290F};
  if (spec.getattribute("chromaticities", OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, 8), c.data()) &&
      !std::ranges::equal(c, kRec709, [](float a, float b) { return std::fabs(a - b) <= 2e-3F; }))
    remarks.push_back({name + " has primaries other than Rec. 709", "treated as Rec. 709"});
  if (open.input->seek_subimage(1, 0))
    remarks.push_back({name + " has several pictures", "the first one is used"});
  open.input->seek_subimage(0, 0);
  return remarks;
}

/// [IEC61966]
float linear_from_srgb(float coded) {
  const double c = coded;
  return static_cast<float>(c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4));
}

float decoded_texel(float coded, Encoding encoding) {
  if (encoding == kSrgb) return linear_from_srgb(coded);
  return encoding == kLinear ? coded : static_cast<float>(std::pow(double{coded}, encoding.gamma));
}

/// The channels `low` to `high` of the picture; nothing if it cannot be read.
template <typename Value>
std::optional<std::vector<Value>> channels_of(OpenImage& open, int low, int high,
                                              OIIO::TypeDesc type) {
  std::vector<Value> values(static_cast<std::size_t>(open.spec.width) *
                            static_cast<std::size_t>(open.spec.height) *
                            static_cast<std::size_t>(high - low + 1));
  if (!open.input->read_image(0, 0, low, high + 1, type, values.data())) return std::nullopt;
  return values;
}

absl::Status check_spec(const AssetContent& content, const OIIO::ImageSpec& spec,
                        std::uint64_t max_texels) {
  if (spec.width < 1 || spec.height < 1 || spec.depth > 1 || spec.nchannels < 1)
    return bad(content, fmt::format("{} x {} texels of {} channels, allowed: at least 1 x 1 of 1, "
                                    "in one plane",
                                    spec.width, spec.height, spec.nchannels));
  const auto texels =
      static_cast<std::uint64_t>(spec.width) * static_cast<std::uint64_t>(spec.height);
  if (texels > max_texels)
    return absl::ResourceExhaustedError(fmt::format("{}: {} x {} texels, allowed: {} in all",
                                                    content.name, spec.width, spec.height,
                                                    max_texels));
  if (spec.nchannels > kMaxChannels)
    return bad(content, fmt::format("{} channels, allowed: 1 to {}", spec.nchannels, kMaxChannels));
  return absl::OkStatus();
}

/// Whether a channel holds sRGB codes; nothing for unsupported types.
std::optional<bool> is_coded(const OIIO::TypeDesc& type) {
  if (type == OIIO::TypeDesc::UINT8 || type == OIIO::TypeDesc::UINT16) return true;
  if (type == OIIO::TypeDesc::HALF || type == OIIO::TypeDesc::FLOAT ||
      type == OIIO::TypeDesc::DOUBLE)
    return false;
  return std::nullopt;
}

}  // namespace

absl::StatusOr<DecodedImage> decode_image(const AssetContent& content, std::uint64_t max_texels,
                                          Encoding encoding) {
  LUCERNA_ASSIGN_OR_RETURN(auto open, open_image(content));
  const OIIO::ImageSpec spec = open.spec;
  LUCERNA_RETURN_IF_ERROR(check_spec(content, spec, max_texels));
  const auto channels = colour_channels(spec);
  if (!channels) {
    std::string names;
    for (const std::string& n : spec.channelnames) names += " " + n;
    return bad(content, "channels" + shown(names) + ", allowed: one or two, or R, G and B");
  }
  for (const int c : *channels)
    if (!is_coded(spec.channelformat(c)))
      return bad(
          content,
          fmt::format(
              "texels of type {}, allowed: unsigned 8- and 16-bit integers, half, float, double",
              spec.channelformat(c).c_str()));
  DecodedImage decoded;
  decoded.remarks = remarks_on(open, content.name);

  const auto [low, high] = std::minmax({(*channels)[0], (*channels)[1], (*channels)[2]});
  const std::size_t count =
      static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height);
  std::vector<Rgb<float>> texels;
  std::size_t negative = 0;
  const auto all_are = [&](OIIO::TypeDesc type) {
    return std::ranges::all_of(*channels, [&](int c) { return spec.channelformat(c) == type; });
  };
  // Integers have few different values, so each is decoded once.
  const auto read_codes = [&]<typename Code>(Code, OIIO::TypeDesc type) {
    const auto values = channels_of<Code>(open, low, high, type);
    if (!values) return false;
    constexpr std::size_t kMost = std::numeric_limits<Code>::max();
    std::vector<float> decoded(kMost + 1);
    for (std::size_t i = 0; i <= kMost; ++i)
      decoded[i] = decoded_texel(static_cast<float>(i) / static_cast<float>(kMost), encoding);
    const std::size_t read = values->size() / count;
    texels.reserve(count);
    for (std::size_t i = 0; i < count; ++i) {
      const auto value = [&](std::size_t c) {
        return decoded[(*values)[i * read + static_cast<std::size_t>((*channels)[c] - low)]];
      };
      texels.push_back({value(0), value(1), value(2)});
    }
    return true;
  };
  const auto read_floats = [&] {
    const auto values = channels_of<float>(open, low, high, OIIO::TypeDesc::FLOAT);
    if (!values) return false;
    const std::size_t read = values->size() / count;
    texels.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      bool below = false;
      const auto value = [&](std::size_t c) {
        const int channel = (*channels)[c];
        const float v = (*values)[i * read + static_cast<std::size_t>(channel - low)];
        if (*is_coded(spec.channelformat(channel))) return decoded_texel(v, encoding);
        // NaN and -infinity are kept, so that Image::create rejects them.
        if (!(v < 0) || std::isinf(v)) return v;
        below = true;
        return 0.0F;
      };
      texels[i] = {value(0), value(1), value(2)};
      negative += below;
    }
    return true;
  };
  const bool is_read =
      all_are(OIIO::TypeDesc::UINT8)    ? read_codes(std::uint8_t{}, OIIO::TypeDesc::UINT8)
      : all_are(OIIO::TypeDesc::UINT16) ? read_codes(std::uint16_t{}, OIIO::TypeDesc::UINT16)
                                        : read_floats();
  if (!is_read) return unreadable(content, known_extension(content.name), open.input->geterror());
  if (negative > 0)
    decoded.remarks.push_back({fmt::format("{} has {} texel{} with a value below 0", content.name,
                                           negative, negative == 1 ? "" : "s"),
                               "counted as 0"});
  auto image = Image::create(spec.width, spec.height, std::move(texels));
  if (!image.ok()) return bad(content, std::string(image.status().message()));
  decoded.image = *std::move(image);
  return decoded;
}

absl::StatusOr<std::vector<float>> decode_alpha(const AssetContent& content,
                                                std::uint64_t max_texels) {
  LUCERNA_ASSIGN_OR_RETURN(auto open, open_image(content));
  const OIIO::ImageSpec& spec = open.spec;
  LUCERNA_RETURN_IF_ERROR(check_spec(content, spec, max_texels));
  const auto found = std::ranges::find(spec.channelnames, "A");
  if (found == spec.channelnames.end()) return std::vector<float>{};
  const int alpha = static_cast<int>(found - spec.channelnames.begin());
  std::vector<float> values(static_cast<std::size_t>(spec.width) *
                            static_cast<std::size_t>(spec.height));
  if (!open.input->read_image(0, 0, alpha, alpha + 1, OIIO::TypeDesc::FLOAT, values.data()))
    return unreadable(content, known_extension(content.name), open.input->geterror());
  return values;
}

}  // namespace lucerna
