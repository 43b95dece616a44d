#include "server/gltf/document.h"

#include <absl/strings/escaping.h>
#include <absl/strings/match.h>
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <iterator>

#include "lights/maths/stop_poll.h"
#include "server/files/image_reader.h"
#include "server/gltf/compression.h"
#include "server/gltf/structure.h"

namespace lucerna::gltf {
namespace {

/// Limits of the JSON text.  Larger data belongs into buffers.
constexpr std::size_t kMostText = std::size_t{1} << 30;
constexpr std::size_t kMostValues = 8'000'000;
constexpr int kMostLevels = 64;

constexpr std::string_view kMagic = "glTF";

std::uint32_t number_at(std::string_view bytes, std::size_t at) {
  std::uint32_t value;  // little-endian, as all machines that we build for
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

/// "3:14" of a byte in a text.
std::string line_and_column(std::string_view text, std::size_t byte) {
  const std::string_view before = text.substr(0, std::min(byte, text.size()));
  const auto lines = std::count(before.begin(), before.end(), '\n');
  const std::size_t start = before.rfind('\n');
  const std::size_t column = before.size() - (start == std::string_view::npos ? 0 : start + 1);
  return fmt::format("{}:{}", lines + 1, std::max<std::size_t>(column, 1));
}

/// Counts the values and levels of a JSON text.  Json::parse has callbacks for this, but with them
/// its time grows with the square of the length of arrays.
class JsonLimits : public Json::json_sax_t {
 public:
  explicit JsonLimits(LoadState& context) : context_(context) {}

  bool null() override { return value(); }
  bool boolean(bool) override { return value(); }
  bool number_integer(number_integer_t) override { return value(); }
  bool number_unsigned(number_unsigned_t) override { return value(); }
  bool number_float(number_float_t, const string_t&) override { return value(); }
  bool string(string_t&) override { return value(); }
  bool binary(binary_t&) override { return value(); }
  bool key(string_t&) override { return value(); }
  bool start_object(std::size_t) override { return begin(); }
  bool end_object() override { return end(); }
  bool start_array(std::size_t) override { return begin(); }
  bool end_array() override { return end(); }
  /// Json::parse reports the error.
  bool parse_error(std::size_t, const std::string&, const Json::exception&) override {
    return false;
  }

 private:
  bool value() {
    if (++values_ > kMostValues)
      context_.fail("", absl::ResourceExhaustedError(
                            fmt::format("JSON text of more than {} values", kMostValues)));
    if (values_ % 4096 == 0) context_.poll();
    return true;
  }
  bool begin() {
    if (++level_ > kMostLevels)
      context_.fail("", absl::InvalidArgumentError(
                            fmt::format("JSON text of more than {} levels", kMostLevels)));
    return value();
  }
  bool end() {
    --level_;
    return true;
  }

  LoadState& context_;
  std::size_t values_ = 0;
  int level_ = 0;
};

/// A place in a text.  The parser calls nothing else that could poll.
struct PolledChar {
  using iterator_category = std::forward_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  const char& operator*() const { return *at; }
  PolledChar& operator++() {
    poll();
    ++at;
    return *this;
  }
  bool operator==(const PolledChar& other) const { return at == other.at; }

  const char* at;
  StopPoll poll{};
};

/// The message of an exception, without its number and its place.
std::string reason_of(const Json::exception& error) {
  const std::string_view what = error.what();
  const std::size_t place = what.find("column ");
  const std::size_t end = what.find(": ", place == std::string_view::npos ? 0 : place);
  return printable(end == std::string_view::npos ? what : what.substr(end + 2));
}

/// A URI without its percent escapes.  [RFC3986, 2.1]
std::string unescaped(std::string_view uri) {
  std::string result;
  StopPoll poll;
  for (std::size_t i = 0; i < uri.size(); ++i, poll()) {
    if (uri[i] == '%' && i + 2 < uri.size() &&
        std::isxdigit(static_cast<unsigned char>(uri[i + 1])) != 0 &&
        std::isxdigit(static_cast<unsigned char>(uri[i + 2])) != 0) {
      result += absl::HexStringToBytes(std::string(uri.substr(i + 1, 2)));
      i += 2;
    } else {
      result += uri[i];
    }
  }
  return result;
}

/// Whether the URI begins with a scheme, such as "https:".  [RFC3986, 3.1]
bool has_scheme(std::string_view uri) {
  const std::size_t colon = uri.find(':');
  if (colon == std::string_view::npos || colon == 0) return false;
  return std::all_of(uri.begin(), uri.begin() + static_cast<std::ptrdiff_t>(colon), [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '+' || c == '-' || c == '.';
  });
}

/// Whether the URI holds its data.  Schemes may be in capitals.  [RFC3986, 3.1]
bool is_data_uri(const std::string& uri) { return absl::StartsWithIgnoreCase(uri, "data:"); }

}  // namespace

Document::Document(LoadState& context) : context_(context) {
  absl::StatusOr<AssetContent> content = context.assets.read(context.file);
  if (!content.ok()) throw StatusError(content.status());
  const std::string_view text = split_container(content->bytes);
  parse(text, static_cast<std::size_t>(text.data() - content->bytes.data()));
  content->bytes = std::string();
  content->share.reset();
  root().require_object();
  check_extensions(root());
  check_structure(root());
  model_ = parse_model(root());
  read_buffers();
}

std::size_t Document::count(std::string_view key) const {
  const auto found = root().find(key);
  return found ? found->require_array().size() : 0;
}

View Document::texture_of(const View& info) const {
  return root().at("textures")[info.at("index").index(count("textures"), "texture")];
}

View Document::light_of(const char* extension, const View& use) const {
  const auto at_root = root().extension(extension);
  if (!at_root) use.fail(fmt::format("the file has no /extensions/{}", extension));
  const View lights = at_root->at("lights");
  return lights.require_array()[use.at("light").index(lights.size(), "light")];
}

std::string Document::picture_name(std::size_t index) const {
  const View place = root().at("images")[index];
  const std::string uri = place.text("uri", "");
  return uri.empty() || is_data_uri(uri) ? context_.location(place.pointer()).file.str() : uri;
}

/// The JSON text; sets the binary chunk.
std::string_view Document::split_container(std::string_view bytes) {
  if (!bytes.starts_with(kMagic)) return bytes;
  if (bytes.size() < 20) context_.fail("", "the file ends within its header of 20 bytes");
  if (number_at(bytes, 4) != 2)
    context_.fail("", fmt::format("container version {}, allowed: 2", number_at(bytes, 4)));
  const std::size_t length = number_at(bytes, 8);
  if (length > bytes.size() || length < 20)
    context_.fail(
        "", fmt::format("the header states {} bytes, but the file has {}", length, bytes.size()));
  constexpr std::uint32_t kJson = 0x4e4f534a, kBinary = 0x004e4942;
  const std::size_t text_length = number_at(bytes, 12);
  if (number_at(bytes, 16) != kJson) context_.fail("", "the first chunk is not JSON");
  if (text_length > length - 20)
    context_.fail("", fmt::format("the JSON chunk states {} bytes, but {} are left", text_length,
                                  length - 20));
  // Chunks begin at multiples of 4 bytes.
  for (std::size_t at = 20 + text_length; at + 8 <= length;) {
    const std::size_t chunk = number_at(bytes, at);
    if (chunk > length - at - 8)
      context_.fail("", fmt::format("the chunk at byte {} states {} bytes, but {} are left", at,
                                    chunk, length - at - 8));
    if (number_at(bytes, at + 4) == kBinary) {
      context_.claim_for_good("", chunk, 1);
      embedded_ = bytes.substr(at + 8, chunk);
      has_embedded_ = true;
      break;
    }
    at += 8 + chunk;
  }
  return bytes.substr(20, text_length);
}

void Document::parse(std::string_view text, std::size_t start) {
  if (text.size() > kMostText)
    context_.fail("", absl::ResourceExhaustedError(fmt::format("JSON text of {} bytes, allowed: {}",
                                                               text.size(), kMostText)));
  JsonLimits limits(context_);
  Json::sax_parse(text.begin(), text.end(), &limits);
  try {
    const char* const end = text.data() + text.size();
    json_ = Json::parse(PolledChar{text.data()}, PolledChar{end});
  } catch (const Json::parse_error& error) {
    if (start > 0)
      context_.fail(
          "", fmt::format("invalid JSON at byte {}: {}", start + error.byte, reason_of(error)));
    throw StatusError(absl::InvalidArgumentError(
        fmt::format("{}:{}: invalid JSON: {}", context_.file, line_and_column(text, error.byte),
                    reason_of(error))));
  } catch (const Json::exception& error) {  // a number beyond the range of a double
    context_.fail("", fmt::format("invalid JSON: {}", reason_of(error)));
  }
}

void Document::read_buffers() {
  buffers_.resize(count("buffers"));
  for (std::size_t i = 0; i < buffers_.size(); ++i) {
    context_.poll();
    const View buffer = root().at("buffers")[i];
    const auto uri = buffer.find("uri");
    const std::uint64_t needed = buffer.at("byteLength").integer(1, std::uint64_t{1} << 40);
    if (uri) {
      if (read_uri(*uri) == nullptr) continue;
      buffers_[i] = std::move(files_.extract(uri->pointer()).mapped());
    } else if (i == 0 && has_embedded_) {
      buffers_[i].bytes = std::move(embedded_);
    } else {
      continue;  // compressed views have their own buffer; others fail where they are used
    }
    if (buffers_[i].bytes.size() < needed)
      buffer.at("byteLength")
          .fail(fmt::format("found {}, but the buffer has {} bytes", needed,
                            buffers_[i].bytes.size()));
  }
}

const AssetContent* Document::read_uri(const View& uri) const {
  const auto known = files_.find(uri.pointer());
  if (known != files_.end()) return &known->second;
  const std::string& text = uri.text();
  AssetContent content;
  if (is_data_uri(text)) {
    const std::size_t comma = text.find(',');
    if (comma == std::string::npos)
      uri.fail("a data URI without data, allowed: data:TYPE;base64,DATA and data:TYPE,DATA");
    content.name = context_.location(uri.pointer()).file;
    context_.claim_for_good(uri.pointer(), text.size(), 1);
    // Without base64, the data are the bytes themselves with percent escapes.  [RFC2397]
    content.bytes = unescaped(std::string_view(text).substr(comma + 1));
    if (absl::EndsWithIgnoreCase(text.substr(0, comma), ";base64") &&
        !absl::Base64Unescape(std::string(content.bytes), &content.bytes))
      uri.fail("a data URI with invalid base64");
  } else {
    const std::string name = unescaped(text);
    if (has_scheme(text) || !is_printable(name))
      uri.fail(
          fmt::format("found \"{}\", allowed: a relative path or a data URI", printable(text)));
    absl::StatusOr<AssetContent> read = context_.assets.read(name, context_.file);
    if (absl::IsFailedPrecondition(read.status())) {
      if (missing_.ok())
        missing_ = absl::Status(read.status().code(),
                                fmt::format("{}: {}", context_.location(uri.pointer()).file.str(),
                                            std::string(read.status().message())));
      return nullptr;
    }
    if (!read.ok()) uri.fail(read.status());
    content = *std::move(read);
  }
  return &files_.emplace(uri.pointer(), std::move(content)).first->second;
}

std::string_view Document::view_bytes(std::size_t view, const std::string& pointer) const {
  const tinygltf::BufferView& v = model_.bufferViews[view];
  const View place = root().at("bufferViews")[view];
  if (const auto packed = place.extension("EXT_meshopt_compression")) {
    const auto known = unpacked_.find(view);
    if (known != unpacked_.end()) return known->second;
    const std::size_t buffer = packed->at("buffer").index(buffers_.size(), "buffer");
    const std::size_t offset = packed->integer("byteOffset", 0, 0, std::uint64_t{1} << 40);
    const std::size_t length = packed->at("byteLength").integer(1, std::uint64_t{1} << 40);
    const std::string_view all = buffers_[buffer].bytes;
    if (offset > all.size() || length > all.size() - offset)
      packed->fail(fmt::format("bytes {} to {} of buffer {}, which has {} bytes", offset,
                               offset + length, buffer, all.size()));
    return unpacked_.emplace(view, unpack_meshopt(*packed, all.substr(offset, length)))
        .first->second;
  }
  const std::string& buffer = buffers_[static_cast<std::size_t>(v.buffer)].bytes;
  if (v.byteOffset > buffer.size() || v.byteLength > buffer.size() - v.byteOffset)
    place.fail(fmt::format("bytes {} to {} of buffer {}, which has {} bytes (named by {})",
                           v.byteOffset, v.byteOffset + v.byteLength, v.buffer, buffer.size(),
                           printable(pointer)));
  return std::string_view(buffer).substr(v.byteOffset, v.byteLength);
}

const AssetContent* Document::read(const View& thing) const {
  thing.require_object();
  if (const auto uri = thing.find("uri")) return read_uri(*uri);
  const View given = thing.at("bufferView");
  const auto known = files_.find(given.pointer());
  if (known != files_.end()) return &known->second;
  // Buffers may be missing too.  Then the rest of the file is still read.
  const std::size_t view = given.index(model_.bufferViews.size(), "bufferView");
  if (!missing_.ok()) return nullptr;
  AssetContent content;
  content.bytes = view_bytes(view, given.pointer());
  content.name = context_.location(thing.pointer()).file.str();
  context_.claim_for_good(given.pointer(), content.bytes.size(), 1);
  return &files_.emplace(given.pointer(), std::move(content)).first->second;
}

void Document::remark_on(const View& place, const std::vector<ImageRemark>& remarks) const {
  for (const ImageRemark& r : remarks)
    if (!r.is_by_gltf) context_.remark(place.pointer(), r.what, r.instead);
}

bool Document::is_decoded(const View& place, const absl::Status& status,
                          const char* instead) const {
  if (status.ok()) return true;
  if (absl::IsCancelled(status)) throw StatusError(status);  // has no place
  if (!absl::IsInvalidArgument(status)) place.fail(status);
  context_.remark(place.pointer(), std::string(status.message()), instead);
  return false;
}

std::optional<std::size_t> Document::picture_of(const View& texture) const {
  const std::size_t images = count("images");
  if (const auto webp = texture.extension("EXT_texture_webp"))
    if (const auto source = webp->index("source", images, "image")) return source;
  if (const auto source = texture.index("source", images, "image")) return source;
  for (const char* name : {"EXT_texture_avif", "MSFT_texture_dds"})
    if (const auto other = texture.extension(name))
      if (const auto source = other->index("source", images, "image")) return source;
  return std::nullopt;
}

std::shared_ptr<const Image> Document::image(std::size_t index) const {
  std::shared_ptr<const Image>& image = images_[index];
  const auto key = std::pair(index, PictureKind::kColour);
  if (image != nullptr || unreadable_.contains(key)) return image;
  const View place = root().at("images")[index];
  const AssetContent* content = read(place);
  if (content == nullptr) return nullptr;
  context_.poll();
  auto decoded = decode_image(*content, context_.image_options(kSrgb));
  if (!is_decoded(place, decoded.status(), "the light is left out")) {
    unreadable_.insert(key);
    return nullptr;
  }
  remark_on(place, decoded->remarks);
  image = decoded->image;
  decoded->share.reset();
  // The tables from which lights draw points take up to as much as the picture.
  context_.claim_for_good(place.pointer(), image->bytes(), 2);
  return image;
}

/// The texels and the memory that they take until they are textures of the scene.
std::optional<Texels> Document::read_texels(const AssetContent& content, const View& place,
                                            PictureKind kind, LoadBudget::Share& share) const {
  if (kind == PictureKind::kAlpha) {
    auto alpha = decode_alpha(content, context_.image_options(kLinear));
    if (!is_decoded(place, alpha.status(), "only the factor of the alpha")) return std::nullopt;
    share = std::move(alpha->share);
    if (alpha->values.empty()) return Texels(1, 1, true, {}, {1.0F});
    const auto wrong =
        std::ranges::find_if(alpha->values, [](float a) { return !(a >= 0 && std::isfinite(a)); });
    if (wrong != alpha->values.end())
      place.fail(fmt::format("texel {} has an alpha of {}, allowed: finite and at least 0",
                             wrong - alpha->values.begin(), *wrong));
    return Texels::grey(alpha->width, alpha->height, std::move(alpha->values));
  }
  const bool is_colour = kind == PictureKind::kColour;
  auto picture = decode_surface(content, context_.image_options(is_colour ? kSrgb : kData));
  if (!is_decoded(place, picture.status(),
                  is_colour                      ? "grey 0.5 times the factor"
                  : kind == PictureKind::kNormal ? "no normal map"
                                                 : "only the factor"))
    return is_colour ? std::optional(Texels(1, 1, true, {}, {0.5F})) : std::nullopt;
  remark_on(place, picture->remarks);
  share = std::move(picture->share);
  if (picture->codes)
    return Texels(picture->codes->width, picture->codes->height, picture->codes->is_grey,
                  std::move(picture->codes->codes), std::move(picture->codes->values));
  // Texels have at most the bytes of the picture.
  LoadState::require(share.grow(picture->image->bytes()));
  return Texels(*picture->image);
}

std::shared_ptr<const Texels> Document::texels(std::size_t index, PictureKind kind) const {
  const auto key = std::pair(index, kind);
  std::shared_ptr<const Texels>& texels = texels_[key];
  if (texels != nullptr || unreadable_.contains(key)) return texels;
  const View place = root().at("images")[index];
  const AssetContent* content = read(place);
  if (content == nullptr) return nullptr;
  context_.poll();
  LoadBudget::Share share;
  std::optional<Texels> read = read_texels(*content, place, kind, share);
  if (!read) {
    unreadable_.insert(key);
    return nullptr;
  }
  texels = context_.scene.textures.picture(printable(picture_name(index)), *std::move(read),
                                           context_.stop);
  share.reset();
  context_.poll();
  return texels;
}

void Document::require_all_files() const {
  if (!missing_.ok()) throw StatusError(missing_);
}

}  // namespace lucerna::gltf
